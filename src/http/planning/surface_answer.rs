//! The surface in an answer: its shape and facets; its faults; and doubt about the unit of a file that states none.

use super::candidates::line_degrees;
use super::parameters::{AVOID, SELECT};
use crate::http::codes::{RequestFault, WarningCode};
use crate::http::reading::{Faulted, Faults, JsonPath};
use crate::http::wire::{FACETS_NAME, PIECES_NAME, Source, SurfaceWithSource, UNIT, Warning, answer};
use crate::planning::machined_surface::{MachinedSurface, NoMachinedSurface, Stop};
use crate::quantity::{Angle, Area};
use crate::surface::{Basis, Facing, Mesh, MeshError, Shape, Unit};

answer! {
    /// The shape of a surface. Directions are lines seen from above, from +X counter-clockwise, in [0, 180).
    #[schema(as = SurfaceShape)]
    pub(super) struct SurfaceAnswer of (shape: &Shape, source: Source, machined: Option<&MachinedSurface>) {
        /// The form in which the surface was sent; for a file, the format detected by its content.
        source: Source = source,
        /// The number of points from which the shape was computed; 0 if it was computed from facets.
        points: u64 = if shape.basis == Basis::Points { shape.elements } else { 0 },
        /// The number of facets from which the shape was computed; for points or a patch, the number of facets formed from
        /// them.
        facets: u64 = facets(shape, machined),
        /// The angle between the best-fit plane and the horizontal.
        slope_deg: f64 [minimum = 0, maximum = 90] = shape.slope.degrees(),
        /// The mean of the slopes of all facets or samples; for points, of the facets formed from them. Absent in method
        /// rectangle for points that span no facets.
        mean_slope_deg?: f64 [minimum = 0, maximum = 90] = mean_slope(shape, machined).map(Angle::degrees),
        /// mu, the long side over the short side of the equivalent rectangle, which has the same variances.
        form_factor: f64 [minimum = 1] = shape.form_factor.ratio(),
        /// chi, the area of the equivalent rectangle.
        characteristic_size_mm2: f64 [minimum = 0] = shape.characteristic_size.mm2(),
        /// The direction along which the surface extends most. Absent if it extends equally in every direction, or most
        /// along the vertical.
        principal_direction_deg?: f64 [minimum = 0, exclusive_maximum = 180] = shape.principal_direction.map(line_degrees),
        /// The steepest direction of the best-fit plane. Absent if that plane is level.
        steepest_direction_deg?: f64 [minimum = 0, exclusive_maximum = 180] = shape.steepest_direction.map(line_degrees),
        /// The angle between these two directions, which the published method assumes to be 90. Absent if one of them is
        /// absent.
        direction_gap_deg?: f64 [minimum = 0, maximum = 90] = shape.direction_gap.map(Angle::degrees),
        /// sqrt(l3/l1) of the eigenvalues: 0 for a plane.
        flatness: f64 [minimum = 0, maximum = 1] = shape.flatness,
        /// The covariance matrix of the coordinates, in rows: of the points or samples, or integrated over the facets.
        covariance_mm2: [[f64; 3]; 3] [min_items = 3, max_items = 3] = shape.covariance,
        /// The unit eigenvectors e1, e2 and e3 of the covariance matrix. e3 is the normal of the best-fit plane and points up,
        /// e1 points to the half plane y > 0, and e2 = e3 x e1.
        eigenvectors: [[f64; 3]; 3] [min_items = 3, max_items = 3] = shape.eigenvectors,
        /// The eigenvalues l1 >= l2 >= l3 of the covariance matrix.
        eigenvalues_mm2: [f64; 3] [min_items = 3, max_items = 3] = shape.eigenvalues.map(Area::mm2),
        /// The centroid [x, y, z].
        centroid_mm: [f64; 3] [min_items = 3, max_items = 3] = shape.centroid,
        /// The box around the points or facets from which the shape was computed.
        bounds_mm: BoundsAnswer = BoundsAnswer { min: shape.bounds.min, max: shape.bounds.max },
        /// The area. Absent in method rectangle for points that span no facets.
        area_mm2?: f64 [minimum = 0] = shape.area.map(Area::mm2).or(machined.map(|machined| machined.facets.visibility.area())),
        /// The share of the area of all facets that is seen from above.
        visible_area_share?: f64 [minimum = 0, maximum = 1] = machined.map(|machined| machined.facets.visible_area_share()),
        /// The share of the area of all facets that is seen from above and steeper than `max_slope_deg`, walls included.
        steep_area_share?: f64 [minimum = 0, maximum = 1] = machined.map(|machined| machined.facets.visibility.shares().steep),
        /// The number of connected pieces of the surface.
        pieces?: u32 [minimum = 1] = machined.map(|machined| machined.facets.pieces.count()),
    }

    /// A box with sides along the axes.
    #[schema(as = Bounds)]
    struct BoundsAnswer {
        /// The smallest x, y and z.
        min: [f64; 3] [min_items = 3, max_items = 3],
        /// The largest x, y and z.
        max: [f64; 3] [min_items = 3, max_items = 3],
    }
}

/// The mean slope of the elements of the shape or, without such, of the facets that were made of the points.
fn mean_slope(shape: &Shape, machined: Option<&MachinedSurface>) -> Option<Angle> {
    shape.mean_slope.or_else(|| machined.map(|machined| machined.workpiece.figures().mean_slope))
}

/// The number of facets from which the shape was computed or, without such, of those that were made of the points.
fn facets(shape: &Shape, machined: Option<&MachinedSurface>) -> u64 {
    let made = machined.map_or(0, |machined| machined.facets.mesh.triangles().len() as u64);
    if shape.basis == Basis::Points || shape.elements == 0 { made } else { shape.elements }
}

/// Records the fault of the surface at `path`.
pub(super) fn report(reason: NoMachinedSurface, path: &JsonPath<'_>, faults: &mut Faults) -> Faulted {
    match reason {
        NoMachinedSurface::Mesh(error) => faults.add(path, mesh_code(error), error),
        NoMachinedSurface::Selection(error) => {
            let select = JsonPath::Root.member(SELECT.name);
            let member = if error.is_about_facets() { FACETS_NAME } else { PIECES_NAME };
            faults.add(&select.member(member), RequestFault::OutOfRange, error)
        }
        NoMachinedSurface::NothingToMachine => {
            let detail = "no facet is selected, seen from above and at most as steep as max_slope_deg";
            faults.add(path, RequestFault::NothingToMachine, detail)
        }
    }
}

/// The facets of a surface to avoid; `requested` is the unit of the request. Its warnings name it.
pub(super) fn avoided_mesh(
    avoid: SurfaceWithSource,
    requested: Option<Unit>,
    warnings: &mut Vec<Warning>,
    faults: &mut Faults,
    stop: Stop,
) -> Result<Mesh, Faulted> {
    let unit = avoid.unit_of(requested, faults)?;
    let shape = avoid.surface.sampled.shape(unit, Facing::Any);
    let of_file = shape.map_or_else(|_| Vec::new(), |shape| avoid.warnings(&shape));
    let mesh = avoid.surface.mesh.finish(unit, Facing::Any, stop);
    let mesh = mesh.map_err(|error| faults.add(&JsonPath::Root.member(AVOID.name), mesh_code(error), error))?;
    let all = of_file.into_iter().chain(merged(&mesh));
    warnings.extend(all.map(|warning| Warning { detail: format!("{}: {}", AVOID.name, warning.detail), ..warning }));
    Ok(mesh)
}

/// The warning about a mesh that was merged because it is too large.
pub(super) fn merged(mesh: &Mesh) -> Option<Warning> {
    let cell = mesh.merged_cell()?;
    let detail =
        format!("the surface has more facets or points than the service stores; it was merged on a raster with cells of {cell:.6} mm");
    Some(Warning::new(WarningCode::FacetsMerged, detail))
}

fn mesh_code(error: MeshError) -> RequestFault {
    match error {
        MeshError::CoordinateOutOfRange | MeshError::IndexOutOfRange { .. } | MeshError::PointOutOfRange { .. } => RequestFault::OutOfRange,
        MeshError::OnlyDegenerateFacets { .. } => RequestFault::OnlyDegenerateFacets,
        MeshError::NoTriangulation { .. } => RequestFault::Collinear,
        MeshError::NothingFromAbove => RequestFault::NothingToMachine,
    }
}

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
