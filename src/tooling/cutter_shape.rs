//! Conversion of a library's shape, diameter and corner radius to a finishing cutter.

use super::dimension::shown;
use crate::file_fault::Flaw;
use crate::milling::{Cutter, CutterError};
use crate::quantity::{Angle, Length};

/// The shapes that finish a surface, as libraries state them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LibraryShape {
    Ball,
    BullNose,
    Flat,
    /// By the ball's diameter.
    TaperedBall,
    Lens,
    Oval,
    ConicalBarrel,
    /// Fusion's tapered mill, by the diameter of the cone at the height of the tip; its tip is a ball, or flat with or without
    /// a corner radius.
    TaperedMill,
    /// Fusion's lens, whose lower radius is that of the lens.
    SegmentLens,
    /// Fusion's conical barrel: lower and upper radius touch a cone of the taper, and the side touches both.
    SegmentTaper,
}

/// A dimension other than the diameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Dimension {
    CornerRadius,
    Taper,
    ShankDiameter,
    LensRadius,
    TipRadius,
    SideRadius,
    UpperRadius,
}

/// What a library states about a cutter.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Dimensions {
    pub(super) corner_radius: Option<Length>,
    /// Whether the corner radius is stated, if only by 0.
    pub(super) is_corner_stated: bool,
    /// Half the angle of the cone, in degrees.
    pub(super) taper_deg: Option<f64>,
    pub(super) shank_diameter: Option<Length>,
    pub(super) lens_radius: Option<Length>,
    pub(super) tip_radius: Option<Length>,
    pub(super) side_radius: Option<Length>,
    pub(super) upper_radius: Option<Length>,
    pub(super) flute_length: Option<Length>,
}

/// A corner radius counts as half the diameter if the relative difference is at most this: libraries round inches to
/// four decimals.
const BALL_TOLERANCE: f64 = 1e-2;

type Fault = (Dimension, Flaw);

impl LibraryShape {
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
            "taperedball" | "taperedballend" | "taperedballnose" => Some(Self::TaperedBall),
            "lens" => Some(Self::Lens),
            "oval" | "circlesegmentoval" => Some(Self::Oval),
            "conicalbarrel" => Some(Self::ConicalBarrel),
            "tapered" if name == "taperedmill" => Some(Self::TaperedMill),
            "circlesegmentlens" => Some(Self::SegmentLens),
            "circlesegmenttaper" => Some(Self::SegmentTaper),
            _ => None,
        }
    }

    /// The cutter of this shape. A ball-end cutter needs no corner radius. A bull-nose cutter with a corner radius of
    /// half the diameter is a ball-end cutter; one with a stated corner radius of 0 is a flat-end cutter.
    ///
    /// # Errors
    /// A dimension that the shape needs is missing, or does not fit the others: the corner radius is not half the diameter on a
    /// ball, above 0 on a flat cutter, or larger than half the diameter.
    pub(super) fn cutter(self, diameter: Length, stated: &Dimensions) -> Result<Cutter, Fault> {
        let tip = || needed(stated.tip_radius, Dimension::TipRadius, "the radius of the tip");
        let side = || needed(stated.side_radius, Dimension::SideRadius, "the radius of the side");
        match self {
            Self::Ball | Self::BullNose | Self::Flat => {
                self.straight(diameter, stated.corner_radius, stated.is_corner_stated).map_err(|flaw| (Dimension::CornerRadius, flaw))
            }
            Self::TaperedBall => {
                let taper = stated.taper()?;
                // The cone begins where the ball's normal is the cone's.
                let (sin, cos, radius) = (taper.sin(), taper.cos(), diameter.mm() / 2.0);
                let shank = stated.shank(|flutes| 2.0 * (radius * cos + (flutes - radius * (1.0 - sin)) * sin / cos))?;
                Cutter::tapered_ball(diameter, taper, shank).map_err(|error| fault_of(&error, Dimension::ShankDiameter))
            }
            Self::Lens | Self::SegmentLens => {
                let lens = if self == Self::Lens { stated.lens_radius } else { stated.tip_radius };
                let lens = needed(lens, Dimension::LensRadius, "the radius of the lens")?;
                let corner = needed(stated.corner_radius, Dimension::CornerRadius, "the corner radius of a lens")?;
                Cutter::lens(diameter, lens, corner).map_err(|error| fault_of(&error, Dimension::LensRadius))
            }
            Self::Oval => Cutter::oval(diameter, tip()?, side()?).map_err(|error| fault_of(&error, Dimension::SideRadius)),
            Self::ConicalBarrel => {
                let taper = stated.taper()?;
                Cutter::conical_barrel(diameter, tip()?, side()?, taper).map_err(|error| fault_of(&error, Dimension::SideRadius))
            }
            Self::SegmentTaper => {
                let taper = stated.taper()?;
                let upper = needed(stated.upper_radius, Dimension::UpperRadius, "the radius above the side")?;
                Cutter::blended_barrel(diameter, tip()?, side()?, upper, taper).map_err(|error| fault_of(&error, Dimension::SideRadius))
            }
            Self::TaperedMill => {
                let taper = stated.taper()?;
                let shank = stated.shank(|flutes| diameter.mm() + 2.0 * flutes * taper.sin() / taper.cos())?;
                let corner = stated.corner_radius.map_or(0.0, Length::mm);
                // The corner of a ball would have its centre on the axis.
                let ball = diameter.mm() / 2.0 * taper.cos() / (1.0 - taper.sin());
                if (corner - ball).abs() <= BALL_TOLERANCE * ball {
                    let ball = Length::from_mm(2.0 * ball).map_err(|_| fault_of_ball(ball))?;
                    return Cutter::tapered_ball(ball, taper, shank).map_err(|error| fault_of(&error, Dimension::ShankDiameter));
                }
                if corner > ball {
                    return Err(fault_of_ball(ball));
                }
                Cutter::tapered_torus(diameter, corner, taper, shank).map_err(|error| fault_of(&error, Dimension::ShankDiameter))
            }
        }
    }

    fn straight(self, diameter: Length, corner_radius: Option<Length>, is_stated: bool) -> Result<Cutter, Flaw> {
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
            (_, None) => Ok(Cutter::flat_end(diameter)),
            // A corner radius that is half the diameter within the tolerance.
            (_, Some(radius)) if (radius.mm() - half).abs() <= 1e-9 * half => Ok(Cutter::ball_end(diameter)),
            (_, Some(radius)) => Cutter::toroidal(diameter, radius).map_err(|_| {
                Flaw::out_of_range(format!("a corner radius of at most half the diameter, {}", shown(half)), shown(radius.mm()))
            }),
        }
    }
}

impl Dimensions {
    fn taper(&self) -> Result<Angle, Fault> {
        let degrees = self.taper_deg.filter(|taper| *taper != 0.0);
        let degrees = degrees.ok_or_else(|| (Dimension::Taper, Flaw::missing("the taper, half the angle of the cone")))?;
        let checked = Angle::from_degrees(degrees).ok().filter(|_| degrees > 0.0 && degrees < 90.0);
        checked.ok_or_else(|| (Dimension::Taper, Flaw::out_of_range("a taper over 0 and under 90 deg", degrees.to_string())))
    }

    /// The stated diameter of the shank, or that at the end of the flutes.
    fn shank(&self, at_end: impl Fn(f64) -> f64) -> Result<Length, Fault> {
        let of_flutes = self.flute_length.and_then(|flutes| Length::from_mm(at_end(flutes.mm())).ok());
        needed(self.shank_diameter.or(of_flutes), Dimension::ShankDiameter, "the diameter of the shank")
    }
}

fn needed(value: Option<Length>, dimension: Dimension, what: &'static str) -> Result<Length, Fault> {
    value.ok_or_else(|| (dimension, Flaw::missing(what)))
}

fn fault_of_ball(ball: f64) -> Fault {
    let expected = format!("a corner radius of at most that of the ball that fits the cone, {}", shown(ball));
    (Dimension::CornerRadius, Flaw::out_of_range(expected, "a larger one"))
}

/// The fault of a dimension that does not fit the others; `large` is the one of lens, side or shank.
fn fault_of(error: &CutterError, large: Dimension) -> Fault {
    let dimension = match error {
        CutterError::CornerTooLarge { .. } => Dimension::CornerRadius,
        CutterError::Taper => Dimension::Taper,
        CutterError::ShankTooNarrow { .. } => Dimension::ShankDiameter,
        CutterError::TipTooLarge { .. } => Dimension::TipRadius,
        CutterError::LargeRadiusTooSmall { .. } | CutterError::Profile(_) => large,
    };
    (dimension, Flaw::out_of_range(error.to_string(), "another one"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_names_of_catalogues_and_programs_are_known() {
        for (shape, names) in [
            (
                LibraryShape::Ball,
                "ball,Ball End,ball_end,ballnose,ball nose,Ball-Nose,ball nosed end mill,BALL END MILL,ballend,ball endmill",
            ),
            (
                LibraryShape::BullNose,
                "toroidal,torus,bull nose,bullnose,bull-nose end mill,Bullnose Endmill,corner radius,Corner Radius End Mill",
            ),
            (LibraryShape::TaperedBall, "tapered ball,tapered ball nose,TaperedBallNose,Tapered Ball End Mill,tapered_ball"),
            (LibraryShape::Oval, "oval,Oval Cutter,circle segment oval"),
            (LibraryShape::ConicalBarrel, "conical barrel,conical_barrel"),
            (LibraryShape::Lens, "lens,Lens Mill"),
            (LibraryShape::TaperedMill, "tapered mill,Tapered Mill"),
            (LibraryShape::SegmentLens, "circle segment lens"),
            (LibraryShape::SegmentTaper, "circle segment taper"),
            (LibraryShape::Flat, "flat,flat end,flat_end,Flat End Mill,end mill,endmill,End-Mill,square,Square End,square end mill"),
        ] {
            for name in names.split(',') {
                assert_eq!(LibraryShape::named(name), Some(shape), "{name}");
            }
        }
        for name in [
            "",
            "mill",
            "cutter",
            "drill",
            "tapered",
            "tapered end mill",
            "circle segment barrel",
            "chamfer mill",
            "face mill",
            "lollipop",
            "thread mill",
            "ball track",
        ] {
            assert_eq!(LibraryShape::named(name), None, "{name}");
        }
    }
}
