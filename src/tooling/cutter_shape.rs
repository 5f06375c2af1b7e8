//! Conversion of a library's shape, diameter and corner radius to a finishing cutter.

use super::dimension::shown;
use super::library_fault::Flaw;
use crate::milling::Cutter;
use crate::quantity::Length;

/// The shapes that finish a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shape {
    Ball,
    BullNose,
    Flat,
}

/// A corner radius counts as half the diameter if the relative difference is at most this: libraries round inches to
/// four decimals.
const BALL_TOLERANCE: f64 = 1e-2;

impl Shape {
    /// The shape that a type's name in a library or catalogue states, in any case and with any separators; `None` for a
    /// tool that is not one of these.
    pub(super) fn named(kind: &str) -> Option<Self> {
        let words: Vec<String> = kind.split(|c: char| c.is_whitespace() || matches!(c, '_' | '-')).map(str::to_lowercase).collect();
        let name: String = words.concat().replace("nosed", "nose");
        // With or without "end mill" after it.
        let bare = ["endmill", "mill", "cutter"].iter().find_map(|suffix| name.strip_suffix(suffix)).unwrap_or(&name);
        match bare {
            "ball" | "ballend" | "ballnose" => Some(Self::Ball),
            "toroidal" | "toroid" | "torus" | "bull" | "bullend" | "bullnose" | "cornerradius" => Some(Self::BullNose),
            "flat" | "flatend" | "square" | "squareend" => Some(Self::Flat),
            "" if name == "endmill" => Some(Self::Flat),
            _ => None,
        }
    }

    /// The cutter of this shape. A ball-end cutter needs no corner radius. A bull-nose cutter with a corner radius of
    /// half the diameter is a ball-end cutter; one with a stated corner radius of 0 is a flat-end cutter.
    ///
    /// # Errors
    /// The corner radius is missing on a bull-nose cutter, not half the diameter on a ball, above 0 on a flat cutter,
    /// or larger than half the diameter.
    pub(super) fn cutter(self, diameter: Length, corner_radius: Option<Length>, is_stated: bool) -> Result<Cutter, Flaw> {
        let half = diameter.mm() / 2.0;
        let is_half = |radius: Length| (radius.mm() - half).abs() <= BALL_TOLERANCE * half;
        match (self, corner_radius) {
            (Self::Ball, Some(radius)) if !is_half(radius) => {
                Err(Flaw::out_of_range(format!("half the diameter of the ball, {}", shown(half)), shown(radius.mm())))
            }
            (Self::Ball, _) => Ok(Cutter::ball_end(diameter)),
            (Self::Flat, Some(radius)) => {
                Err(Flaw::out_of_range("0 or nothing on a flat end mill; a cutter with a corner is a bull nose", shown(radius.mm())))
            }
            (Self::BullNose, None) if !is_stated => Err(Flaw::missing("the corner radius of a bull nose end mill")),
            (Self::Flat | Self::BullNose, None) => Ok(Cutter::flat_end(diameter)),
            // A corner radius that is half the diameter within the tolerance.
            (Self::BullNose, Some(radius)) if (radius.mm() - half).abs() <= 1e-9 * half => Ok(Cutter::ball_end(diameter)),
            (Self::BullNose, Some(radius)) => Cutter::toroidal(diameter, radius).map_err(|_| {
                Flaw::out_of_range(format!("a corner radius of at most half the diameter, {}", shown(half)), shown(radius.mm()))
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_names_of_catalogues_and_programs_are_known() {
        for (shape, names) in [
            (Shape::Ball, "ball,Ball End,ball_end,ballnose,ball nose,Ball-Nose,ball nosed end mill,BALL END MILL,ballend,ball endmill"),
            (Shape::BullNose, "toroidal,torus,bull nose,bullnose,bull-nose end mill,Bullnose Endmill,corner radius,Corner Radius End Mill"),
            (Shape::Flat, "flat,flat end,flat_end,Flat End Mill,end mill,endmill,End-Mill,square,Square End,square end mill"),
        ] {
            for name in names.split(',') {
                assert_eq!(Shape::named(name), Some(shape), "{name}");
            }
        }
        for name in [
            "",
            "mill",
            "cutter",
            "drill",
            "tapered ball",
            "tapered ball nose",
            "chamfer mill",
            "face mill",
            "lollipop",
            "thread mill",
            "ball track",
        ] {
            assert_eq!(Shape::named(name), None, "{name}");
        }
    }
}
