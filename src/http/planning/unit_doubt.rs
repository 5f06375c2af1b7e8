//! Doubt about the unit of a file that states none: a part that is smaller than every cutter or than most milled
//! parts, or larger than any machine, is probably in another unit than was assumed.

use crate::http::codes::WarningCode;
use crate::http::wire::{UNIT, Warning};
use crate::surface::{Shape, Unit};

/// The sides of parts that are usually milled, in mm.
const SMALLEST_USUAL: f64 = 10.0;
const LARGEST_USUAL: f64 = 2000.0;

/// A part with a longer side fits hardly any machine.
const LARGEST: f64 = 10_000.0;

/// The size of a part that suggests another unit.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct UnitDoubt {
    /// The longer side of the part seen from above, in mm.
    pub(super) side_mm: f64,
    /// The bound that it exceeds or falls below, in mm.
    pub(super) bound_mm: f64,
    pub(super) detail: String,
}

impl UnitDoubt {
    /// The doubt about a part of this shape that was read in `unit`, if the diameter of the smallest cutter is
    /// `smallest_mm`.
    pub(super) fn about(shape: &Shape, unit: Unit, smallest_mm: f64) -> Option<Self> {
        let [min, max] = [shape.bounds.min, shape.bounds.max];
        let side_mm = (max[0] - min[0]).max(max[1] - min[1]);
        let (bound_mm, reason) = if side_mm < smallest_mm {
            (smallest_mm, format!("smaller than the smallest cutter, {} mm", rounded(smallest_mm)))
        } else if side_mm < SMALLEST_USUAL {
            (SMALLEST_USUAL, "smaller than most milled parts".to_owned())
        } else if side_mm > LARGEST {
            (LARGEST, "larger than most machines".to_owned())
        } else {
            return None;
        };
        let in_unit = |other: Unit| side_mm / unit.mm() * other.mm();
        let likely: Vec<String> = [Unit::Metre, Unit::Inch, Unit::Centimetre, Unit::Millimetre, Unit::Micrometre]
            .into_iter()
            .filter(|other| *other != unit && (SMALLEST_USUAL.max(smallest_mm)..=LARGEST_USUAL).contains(&in_unit(*other)))
            .map(|other| format!("\"{}\" ({} mm)", UNIT.kind.word(&other), rounded(in_unit(other))))
            .collect();
        let remedy = if likely.is_empty() {
            "state `unit`".to_owned()
        } else {
            format!("if the file is in another unit, state it: {}", likely.join(" or "))
        };
        let read_in = UNIT.kind.word(&unit);
        let detail = format!("read in {read_in}, the part is {} mm wide, {reason}; {remedy}", rounded(side_mm));
        Some(Self { side_mm, bound_mm, detail })
    }

    /// The warning.
    pub(super) fn warning(&self) -> Warning {
        Warning::new(WarningCode::UnitUnlikely, self.detail.clone())
    }
}

/// A length with four significant digits.
fn rounded(mm: f64) -> f64 {
    let scale = 10_f64.powf(3.0 - mm.abs().max(1e-9).log10().floor());
    (mm * scale).round() / scale
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::{Facing, SampledSurface, Sink};

    /// The doubt about a square of this side, in the file's unit.
    fn doubt(side: f64, unit: Unit, smallest_mm: f64) -> Option<String> {
        let mut surface = SampledSurface::new();
        surface.facet([[0.0; 3], [side, 0.0, 0.0], [side, side, 0.1 * side]]);
        let shape = surface.shape(unit, Facing::Up).unwrap();
        UnitDoubt::about(&shape, unit, smallest_mm).map(|doubt| doubt.detail)
    }

    #[test]
    fn a_part_smaller_than_the_cutter_names_the_likely_unit() {
        let metres = "read in mm, the part is 0.06 mm wide, smaller than the smallest cutter, 6 mm; if the file is in another unit, state it: \"m\" (60 mm)";
        assert_eq!(doubt(0.06, Unit::Millimetre, 6.0).as_deref(), Some(metres));
        for (side, unit, smallest, likely) in [
            (0.3, Unit::Millimetre, 2.0, "\"m\" (300 mm)"),
            (1.5, Unit::Millimetre, 6.0, "\"m\" (1500 mm) or \"inch\" (38.1 mm) or \"cm\" (15 mm)"),
            (4.0, Unit::Millimetre, 6.0, "\"inch\" (101.6 mm) or \"cm\" (40 mm)"),
            (
                4.0,
                Unit::Millimetre,
                1.0,
                "smaller than most milled parts; if the file is in another unit, state it: \"inch\" (101.6 mm) or \"cm\" (40 mm)",
            ),
            (0.0002, Unit::Metre, 1.0, "state `unit`"),
            (0.05, Unit::Inch, 3.0, "\"m\" (50 mm)"),
        ] {
            let detail = doubt(side, unit, smallest).unwrap();
            assert!(detail.ends_with(likely), "{detail}");
        }
    }

    #[test]
    fn a_part_larger_than_a_machine_names_the_likely_unit() {
        for (side, unit, likely) in
            [(60_000.0, Unit::Millimetre, "\"um\" (60 mm)"), (80.0, Unit::Metre, "\"mm\" (80 mm)"), (900.0, Unit::Inch, "\"mm\" (900 mm)")]
        {
            let detail = doubt(side, unit, 6.0).unwrap();
            assert!(detail.contains("larger than most machines") && detail.contains(likely), "{detail}");
        }
    }

    #[test]
    fn usual_parts_raise_no_doubt() {
        for (side, smallest) in [(10.0, 6.0), (20.0, 20.0), (60.0, 6.0), (2000.0, 20.0), (9000.0, 20.0)] {
            assert_eq!(doubt(side, Unit::Millimetre, smallest), None, "{side}");
        }
    }
}
