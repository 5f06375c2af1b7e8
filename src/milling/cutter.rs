//! The cutter, described as the solid that it sweeps when it rotates.

use super::profile::Profile;
use crate::quantity::Length;
use std::fmt;

/// A cutter for finishing, described by the catalogue dimensions of ISO 13399: cutting diameter DC = 2R and corner
/// radius RE = r.
///
/// Every kind is the same body, a torus of major radius R - r and minor radius r: the ball-end cutter has R - r = 0,
/// the flat-end cutter r = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cutter {
    kind: CutterKind,
    outer_radius: f64,
    corner_radius: f64,
}

/// The three kinds of finishing cutter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CutterKind {
    /// Bull-nose or torus-end: 0 < r < R.
    Toroidal,
    /// Ball-end or ball-nose: r = R.
    BallEnd,
    /// Flat-end: r = 0.
    FlatEnd,
}

/// The corner radius of a toroidal cutter does not fit into its diameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CornerTooLarge {
    /// Half the diameter, the upper bound of the corner radius.
    pub outer_radius: Length,
}

impl fmt::Display for CornerTooLarge {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "the corner radius of a toroidal cutter must be under half its diameter, {} mm; if both are equal, the cutter is a ball-end",
            self.outer_radius.mm()
        )
    }
}

impl std::error::Error for CornerTooLarge {}

impl Cutter {
    /// A toroidal cutter of diameter DC = 2R and corner radius RE = r, 0 < r < R.
    ///
    /// # Errors
    /// [`CornerTooLarge`] when r >= R.
    pub fn toroidal(diameter: Length, corner_radius: Length) -> Result<Self, CornerTooLarge> {
        let outer_radius = diameter.mm() / 2.0;
        if corner_radius.mm() >= outer_radius {
            return Err(CornerTooLarge { outer_radius: Length::computed(outer_radius) });
        }
        Ok(Self { kind: CutterKind::Toroidal, outer_radius, corner_radius: corner_radius.mm() })
    }

    /// A ball-end cutter of diameter DC = 2R.
    #[must_use]
    pub fn ball_end(diameter: Length) -> Self {
        let radius = diameter.mm() / 2.0;
        Self { kind: CutterKind::BallEnd, outer_radius: radius, corner_radius: radius }
    }

    /// A flat-end cutter of diameter DC = 2R, with a sharp corner.
    #[must_use]
    pub fn flat_end(diameter: Length) -> Self {
        Self { kind: CutterKind::FlatEnd, outer_radius: diameter.mm() / 2.0, corner_radius: 0.0 }
    }

    /// The kind of the cutter.
    #[must_use]
    pub fn kind(self) -> CutterKind {
        self.kind
    }

    /// R, the outer radius, in mm.
    #[must_use]
    pub fn outer_radius(self) -> Length {
        Length::computed(self.outer_radius)
    }

    /// r, the corner radius, in mm: R for a ball-end, 0 for a flat-end cutter.
    #[must_use]
    pub fn corner_radius(self) -> Length {
        Length::computed(self.corner_radius)
    }

    /// R - r, the radius of the circle of the corner's centre, in mm.
    #[must_use]
    pub fn core_radius(self) -> Length {
        Length::computed(self.outer_radius - self.corner_radius)
    }

    /// The lower profile.
    #[must_use]
    pub fn profile(self) -> Profile {
        Profile::torus(self.outer_radius, self.corner_radius)
    }

    /// The same cutter with its outer radius larger by `extra`, as radial runout makes it [Segonds 2017, after eq. 15].
    /// A toroidal and a flat-end cutter keep their corner; a ball-end cutter stays a ball, of radius R + extra.
    #[must_use]
    pub fn widened(self, extra: Length) -> Self {
        let corner_radius = match self.kind {
            CutterKind::BallEnd => self.corner_radius + extra.mm(),
            CutterKind::Toroidal | CutterKind::FlatEnd => self.corner_radius,
        };
        Self { outer_radius: self.outer_radius + extra.mm(), corner_radius, ..self }
    }
}
