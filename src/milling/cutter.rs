//! The cutter, described as the solid that it sweeps when it rotates.

use super::profile::{Profile, ProfileArc, ProfileError};
use crate::numerics::bracketed_root;
use crate::quantity::{Angle, Length};
use std::convert::Infallible;
use std::f64::consts::FRAC_PI_2;
use std::fmt;

/// A cutter for finishing: any convex solid of revolution, given by its lower profile.
///
/// The constructors take the dimensions by which catalogues describe the shapes (ISO 13399: cutting diameter DC = 2R,
/// corner radius RE = r). Everything but names and texts follows from the profile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cutter {
    kind: CutterKind,
    profile: Profile,
}

/// The shapes by their names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CutterKind {
    /// Bull-nose or torus-end: a flat and a corner radius r, 0 < r < R.
    Toroidal,
    /// Ball-end or ball-nose.
    BallEnd,
    /// Flat-end, with a sharp corner.
    FlatEnd,
    /// A ball, then a cone up to the shank.
    TaperedBall,
    /// A flat bottom of a large radius, then a corner radius.
    Lens,
    /// A ball tip, then a side of a large radius: a barrel.
    Oval,
    /// A ball tip, then an inclined side of a large radius.
    ConicalBarrel,
    /// Any other profile.
    Profile,
}

/// The reason why dimensions are not those of a cutter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CutterError {
    /// The corner radius of a toroidal or lens cutter is not under half its diameter.
    CornerTooLarge {
        /// Half the diameter, the upper bound of the corner radius.
        outer_radius: Length,
    },
    /// A taper is not between 0 and 90 deg.
    Taper,
    /// The shank of a tapered cutter is narrower than the end of its ball.
    ShankTooNarrow {
        /// The smallest shank diameter.
        smallest_diameter: Length,
    },
    /// The tip radius of an oval cutter or conical barrel is so large that the tip is wider than the diameter.
    TipTooLarge {
        /// The largest tip radius.
        largest_radius: Length,
    },
    /// The radius of a lens or of a barrel's side is smaller than the radius of a ball with that diameter.
    LargeRadiusTooSmall {
        /// The smallest radius.
        smallest_radius: Length,
    },
    /// The arcs are not a profile.
    Profile(ProfileError),
}

impl fmt::Display for CutterError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::CornerTooLarge { outer_radius } => write!(
                f,
                "the corner radius of the cutter must be under half its diameter, {} mm; if both are equal, the cutter is a ball-end",
                outer_radius.mm()
            ),
            Self::Taper => f.write_str("the taper, half the angle of the cone, must be over 0 and under 90 deg"),
            Self::ShankTooNarrow { smallest_diameter } => {
                write!(f, "the shank must be wider than the end of the ball, whose diameter is {} mm", smallest_diameter.mm())
            }
            Self::TipTooLarge { largest_radius } => {
                write!(f, "the tip radius must be at most {} mm, or the tip is wider than the diameter", largest_radius.mm())
            }
            Self::LargeRadiusTooSmall { smallest_radius } => {
                write!(f, "the radius of lens or side must be at least {} mm, that of a ball of this diameter", smallest_radius.mm())
            }
            Self::Profile(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for CutterError {}

impl Cutter {
    /// A ball-end cutter of diameter DC = 2R.
    #[must_use]
    pub fn ball_end(diameter: Length) -> Self {
        let radius = diameter.mm() / 2.0;
        Self { kind: CutterKind::BallEnd, profile: Profile::torus(radius, radius) }
    }

    /// A toroidal cutter of diameter DC = 2R and corner radius RE = r, 0 < r < R.
    ///
    /// # Errors
    /// [`CutterError::CornerTooLarge`] when r >= R.
    pub fn toroidal(diameter: Length, corner_radius: Length) -> Result<Self, CutterError> {
        let outer_radius = checked_corner(diameter, corner_radius)?;
        Ok(Self { kind: CutterKind::Toroidal, profile: Profile::torus(outer_radius, corner_radius.mm()) })
    }

    /// A flat-end cutter of diameter DC = 2R, with a sharp corner.
    #[must_use]
    pub fn flat_end(diameter: Length) -> Self {
        Self { kind: CutterKind::FlatEnd, profile: Profile::torus(diameter.mm() / 2.0, 0.0) }
    }

    /// A ball of the diameter `ball_diameter`, then a cone that touches it, up to the shank. `taper` is half the angle of
    /// the cone.
    ///
    /// # Errors
    /// [`CutterError::Taper`]; [`CutterError::ShankTooNarrow`] if the cone would begin beyond the shank.
    pub fn tapered_ball(ball_diameter: Length, taper: Angle, shank_diameter: Length) -> Result<Self, CutterError> {
        let (radius, shank) = (ball_diameter.mm() / 2.0, shank_diameter.mm() / 2.0);
        let side = checked_side(taper)?;
        let end = radius * taper.cos();
        if shank < end {
            return Err(CutterError::ShankTooNarrow { smallest_diameter: Length::computed(2.0 * end) });
        }
        let ball = ProfileArc { radius, centre_offset: 0.0, centre_height: radius, from: 0.0, to: side };
        let height = radius - radius * taper.sin() + (shank - end) / taper.sin() * taper.cos();
        Ok(Self { kind: CutterKind::TaperedBall, profile: Profile::of_valid_arcs(&[ball, corner(shank, height, side)]) })
    }

    /// A bottom of the radius `lens_radius`, centred on the axis, then a corner radius that touches it and ends at the
    /// diameter.
    ///
    /// # Errors
    /// [`CutterError::CornerTooLarge`]; [`CutterError::LargeRadiusTooSmall`] for a lens radius under half the diameter.
    pub fn lens(diameter: Length, lens_radius: Length, corner_radius: Length) -> Result<Self, CutterError> {
        let outer = checked_corner(diameter, corner_radius)?;
        let (lens, radius) = (lens_radius.mm(), corner_radius.mm());
        if lens < outer {
            return Err(CutterError::LargeRadiusTooSmall { smallest_radius: Length::computed(outer) });
        }
        let core = outer - radius;
        let sin = core / (lens - radius);
        let (end, cos) = (sin.asin(), ((1.0 - sin) * (1.0 + sin)).sqrt());
        let bottom = ProfileArc { radius: lens, centre_offset: 0.0, centre_height: lens, from: 0.0, to: end };
        let height = lens - (lens - radius) * cos;
        let corner = ProfileArc { radius, centre_offset: core, centre_height: height, from: end, to: FRAC_PI_2 };
        Ok(Self { kind: CutterKind::Lens, profile: Profile::of_valid_arcs(&[bottom, corner]) })
    }

    /// A ball tip, then a side of the radius `side_radius` that touches it and ends at the diameter with a vertical
    /// tangent: a barrel.
    ///
    /// # Errors
    /// [`CutterError::TipTooLarge`], [`CutterError::LargeRadiusTooSmall`].
    pub fn oval(diameter: Length, tip_radius: Length, side_radius: Length) -> Result<Self, CutterError> {
        Ok(Self { kind: CutterKind::Oval, profile: barrel(diameter, tip_radius, side_radius, Angle::ZERO)? })
    }

    /// A ball tip, then a side of the radius `side_radius` that touches it and ends at the diameter, where its tangent has
    /// the angle `taper` to the axis. The cone that follows in most catalogues cuts nothing and is left out: above the
    /// diameter the solid is a cylinder.
    ///
    /// # Errors
    /// [`CutterError::Taper`], [`CutterError::TipTooLarge`], [`CutterError::LargeRadiusTooSmall`].
    pub fn conical_barrel(diameter: Length, tip_radius: Length, side_radius: Length, taper: Angle) -> Result<Self, CutterError> {
        checked_side(taper)?;
        Ok(Self { kind: CutterKind::ConicalBarrel, profile: barrel(diameter, tip_radius, side_radius, taper)? })
    }

    /// A ball tip, a side of the radius `side_radius` that touches it, and an arc of the radius `upper_radius` that touches the
    /// side and ends upright at the diameter. Tip and upper arc touch a cone whose half angle is `taper`: Fusion's circle segment
    /// taper.
    ///
    /// # Errors
    /// [`CutterError::Taper`]; [`CutterError::TipTooLarge`] if the cone would not widen from the tip to the upper arc;
    /// [`CutterError::LargeRadiusTooSmall`] for a side that cannot touch both.
    pub fn blended_barrel(
        diameter: Length,
        tip_radius: Length,
        side_radius: Length,
        upper_radius: Length,
        taper: Angle,
    ) -> Result<Self, CutterError> {
        checked_side(taper)?;
        let (outer, tip, side, upper) = (diameter.mm() / 2.0, tip_radius.mm(), side_radius.mm(), upper_radius.mm());
        let (sin, cos) = (taper.sin(), taper.cos());
        let core = outer - upper;
        // The centres are tip over the tip on the axis, and at (core, height): both circles touch the cone.
        let height = tip + (core * cos + upper - tip) / sin;
        let (apart_out, apart_up) = (core, height - tip);
        let apart = apart_out.hypot(apart_up);
        if upper > outer || apart_up <= 0.0 || apart <= (upper - tip).abs() {
            return Err(CutterError::TipTooLarge { largest_radius: Length::computed(outer) });
        }
        // The side's centre is at the distances side - tip and side - upper from the other two, beyond the axis.
        let (from_tip, from_upper) = (side - tip, side - upper);
        let along = (from_tip * from_tip - from_upper * from_upper + apart * apart) / (2.0 * apart);
        let beside = from_tip * from_tip - along * along;
        if from_tip <= 0.0 || from_upper <= 0.0 || beside < 0.0 {
            let smallest = f64::midpoint(tip + upper, apart);
            return Err(CutterError::LargeRadiusTooSmall { smallest_radius: Length::computed(smallest) });
        }
        let beside = beside.sqrt();
        let (unit_out, unit_up) = (apart_out / apart, apart_up / apart);
        let (centre_out, centre_up) = (along * unit_out - beside * unit_up, tip + along * unit_up + beside * unit_out);
        // The normals at the joints point from the side's centre to the other centres.
        let first = (-centre_out).atan2(centre_up - tip);
        let second = (core - centre_out).atan2(centre_up - height);
        let arcs = [
            ProfileArc { radius: tip, centre_offset: 0.0, centre_height: tip, from: 0.0, to: first },
            ProfileArc { radius: side, centre_offset: centre_out, centre_height: centre_up, from: first, to: second },
            ProfileArc { radius: upper, centre_offset: core, centre_height: height, from: second, to: FRAC_PI_2 },
        ];
        Ok(Self { kind: CutterKind::ConicalBarrel, ..Self::from_arcs(&arcs)? })
    }

    /// A flat with the corner radius `corner_radius` in mm, which may be 0, then a cone that touches it, up to the shank. At the
    /// height of the tip the cone, continued, has the diameter `tip_diameter`.
    ///
    /// # Errors
    /// [`CutterError::Taper`]; [`CutterError::ShankTooNarrow`]; [`CutterError::Profile`] if the corner is larger than a ball.
    pub fn tapered_torus(tip_diameter: Length, corner_radius: f64, taper: Angle, shank_diameter: Length) -> Result<Self, CutterError> {
        let side = checked_side(taper)?;
        let (sin, cos, shank) = (taper.sin(), taper.cos(), shank_diameter.mm() / 2.0);
        let core = tip_diameter.mm() / 2.0 - corner_radius * (1.0 - sin) / cos;
        let round = ProfileArc { radius: corner_radius, centre_offset: core, centre_height: corner_radius, from: 0.0, to: side };
        let (end, height) = round.point(side);
        if shank < end {
            return Err(CutterError::ShankTooNarrow { smallest_diameter: Length::computed(2.0 * end) });
        }
        Self::from_arcs(&[round, corner(shank, height + (shank - end) / sin * cos, side)])
    }

    /// Any convex profile of arcs and straight pieces.
    ///
    /// # Errors
    /// [`CutterError::Profile`].
    pub fn from_arcs(arcs: &[ProfileArc]) -> Result<Self, CutterError> {
        let profile = Profile::of_arcs(arcs).map_err(CutterError::Profile)?;
        Ok(Self { kind: CutterKind::Profile, profile })
    }

    /// The kind of the cutter, for names and texts.
    #[must_use]
    pub fn kind(self) -> CutterKind {
        self.kind
    }

    /// The lower profile.
    #[must_use]
    pub fn profile(self) -> Profile {
        self.profile
    }

    /// R, the outer radius, in mm.
    #[must_use]
    pub fn outer_radius(self) -> Length {
        Length::computed(self.profile.outer_radius())
    }

    /// r, the radius of the profile's first arc, in mm: the corner radius of a toroidal cutter, R of a ball-end, 0 of a
    /// flat-end cutter, and of the other shapes the radius of the tip.
    #[must_use]
    pub fn corner_radius(self) -> Length {
        Length::computed(self.profile.arcs()[0].radius)
    }

    /// The distance of the first arc's centre from the axis, in mm: R - r of a toroidal cutter, R of a flat-end cutter, and
    /// 0 where the tip is a ball.
    #[must_use]
    pub fn core_radius(self) -> Length {
        Length::computed(self.profile.arcs()[0].centre_offset)
    }

    /// The step-over that leaves `height` on a floor: twice the distance from the axis at which the bottom is that high. For a
    /// torus it is 2 (R - r) + 2 sqrt(2 r h - h^2) [Herraz et al. 2020, section 4.1.1, the bound at s = 0], and the diameter for
    /// a height above the rim.
    ///
    /// It bounds the analytic step-over near a floor, where the effective radius exceeds every bound but the cutter does not.
    #[must_use]
    pub fn step_over_on_floor(self, height: Length) -> Length {
        let outer = self.profile.outer_radius();
        let above = |rho: f64| self.profile.low(rho) - height.mm();
        if above(outer) <= 0.0 {
            return Length::computed(2.0 * outer);
        }
        let first = self.profile.arcs()[0];
        if height.mm() <= first.point(first.to).1 {
            let chord = (height.mm() * (2.0 * first.radius - height.mm())).sqrt();
            return Length::computed(2.0 * (first.centre_offset + chord));
        }
        let Ok(rho) = bracketed_root(0.0, outer, |rho| Ok::<_, Infallible>(above(rho)));
        Length::computed(2.0 * rho)
    }

    /// The same cutter with its outer radius larger by `extra`, as radial runout makes it [Segonds 2017, after eq. 15]. A
    /// flat becomes wider, and all else stays; a cutter with a round tip becomes larger by `extra` in every direction.
    #[must_use]
    pub fn widened(self, extra: Length) -> Self {
        Self { profile: self.profile.widened(extra.mm()), ..self }
    }
}

/// Half the diameter, if the corner radius is smaller.
fn checked_corner(diameter: Length, corner_radius: Length) -> Result<f64, CutterError> {
    let outer_radius = diameter.mm() / 2.0;
    if corner_radius.mm() >= outer_radius {
        return Err(CutterError::CornerTooLarge { outer_radius: Length::computed(outer_radius) });
    }
    Ok(outer_radius)
}

/// The angle of a cone's normal to straight down, pi/2 - taper.
fn checked_side(taper: Angle) -> Result<f64, CutterError> {
    if taper.radians() > 0.0 && taper.radians() < FRAC_PI_2 { Ok(FRAC_PI_2 - taper.radians()) } else { Err(CutterError::Taper) }
}

fn corner(offset: f64, height: f64, from: f64) -> ProfileArc {
    ProfileArc { radius: 0.0, centre_offset: offset, centre_height: height, from, to: FRAC_PI_2 }
}

/// The ball tip of radius r_t and the side of radius R_s, whose tangent at the diameter D has the angle t to the axis:
/// its centre is e = D/2 - R_s cos(t) from the axis, and both touch where the normal is at p, sin(p) = -e / (R_s - r_t).
fn barrel(diameter: Length, tip_radius: Length, side_radius: Length, taper: Angle) -> Result<Profile, CutterError> {
    let (outer, tip, side, cos) = (diameter.mm() / 2.0, tip_radius.mm(), side_radius.mm(), taper.cos());
    if tip * cos > outer {
        return Err(CutterError::TipTooLarge { largest_radius: Length::computed(outer / cos) });
    }
    if side * cos < outer {
        return Err(CutterError::LargeRadiusTooSmall { smallest_radius: Length::computed(outer / cos) });
    }
    let (beyond, end) = (side * cos - outer, FRAC_PI_2 - taper.radians());
    let sin = if side > tip { (beyond / (side - tip)).min(1.0) } else { 0.0 };
    let joint = sin.asin().min(end);
    let ball = ProfileArc { radius: tip, centre_offset: 0.0, centre_height: tip, from: 0.0, to: joint };
    let height = tip + (side - tip) * ((1.0 - sin) * (1.0 + sin)).sqrt();
    let flank = ProfileArc { radius: side, centre_offset: -beyond, centre_height: height, from: joint, to: end };
    let top = corner(outer, height - side * taper.sin(), end);
    // Arcs without a length are left out.
    let arcs = [ball, flank, top];
    let first = usize::from(joint <= 0.0);
    let last = if taper.radians() > 0.0 { 3 } else { 2 };
    Ok(Profile::of_valid_arcs(&arcs[first..last]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn mm(value: f64) -> Length {
        Length::from_mm(value).unwrap()
    }

    fn degrees(value: f64) -> Angle {
        Angle::from_degrees(value).unwrap()
    }

    /// Every profile is accepted as a stated one, ends at its radius, and is convex.
    #[test]
    fn the_shapes_are_profiles_without_steps() {
        for (cutter, outer) in [
            (Cutter::tapered_ball(mm(2.0), degrees(5.0), mm(6.0)).unwrap(), 3.0),
            (Cutter::lens(mm(16.0), mm(40.0), mm(1.0)).unwrap(), 8.0),
            (Cutter::oval(mm(10.0), mm(2.0), mm(80.0)).unwrap(), 5.0),
            (Cutter::conical_barrel(mm(10.0), mm(2.0), mm(250.0), degrees(20.0)).unwrap(), 5.0),
        ] {
            let profile = cutter.profile();
            assert_relative_eq!(cutter.outer_radius().mm(), outer, max_relative = 1e-15);
            assert_eq!(Profile::of_arcs(profile.arcs()), Ok(profile));
            let slopes: Vec<f64> = (1..1000).map(|step| profile.derivatives(outer * f64::from(step) / 1000.0).unwrap()[1]).collect();
            assert!(slopes.is_sorted(), "{:?}", cutter.kind());
            for pair in profile.arcs().windows(2) {
                let ((rho0, z0), (rho1, z1)) = (pair[0].point(pair[0].to), pair[1].point(pair[1].from));
                let (sin, cos) = pair[0].to.sin_cos();
                // Rounding of heights of up to 250 mm.
                assert!(((rho1 - rho0) * sin - (z1 - z0) * cos).abs() < 1e-12, "{:?}", cutter.kind());
            }
        }
    }

    /// Fusion's own figures: its conical barrel of 16 mm with radii of 4, 500 and 8 mm and a taper of 20 deg has flutes of
    /// 15.69 mm, up to the centre of the upper arc; a tapered mill with a ball of 1 mm and 3.8 deg has a diameter of 1.872 mm.
    #[test]
    fn the_shapes_of_fusion_have_its_figures() {
        let barrel = Cutter::blended_barrel(mm(16.0), mm(4.0), mm(500.0), mm(8.0), degrees(20.0)).unwrap();
        let profile = barrel.profile();
        let [tip, side, upper] = profile.arcs() else { panic!("{barrel:?}") };
        assert_relative_eq!(upper.centre_height, 15.69, epsilon = 0.01);
        assert_eq!((barrel.kind(), barrel.outer_radius().mm()), (CutterKind::ConicalBarrel, 8.0));
        for (arc, next) in [(tip, side), (side, upper)] {
            let ((rho0, z0), (rho1, z1)) = (arc.point(arc.to), next.point(next.from));
            // Rounding of 500 mm.
            assert!((rho0 - rho1).abs() < 1e-11 && (z0 - z1).abs() < 1e-11);
        }
        let ball = Cutter::tapered_ball(mm(2.0), degrees(3.8), mm(6.0)).unwrap();
        let torus = Cutter::tapered_torus(mm(1.872), 1.0, degrees(3.8), mm(6.0)).unwrap();
        for step in 1..=30 {
            let rho = f64::from(step) / 10.0;
            // The printed diameter is rounded to 0.0005 mm, which the cone magnifies by 1/tan(3.8 deg) = 15.
            assert_relative_eq!(torus.profile().low(rho), ball.profile().low(rho), epsilon = 0.008);
        }
    }

    #[test]
    fn the_step_over_on_a_floor_ends_where_the_bottom_is_at_the_height() {
        let on_floor = |cutter: Cutter, height: f64| cutter.step_over_on_floor(mm(height)).mm();
        // 2 (5 - 2) + 2 sqrt(0.04 - 0.0001), the 6.4 mm of Herraz et al. 2020, section 4.1.1.
        let torus = Cutter::toroidal(mm(10.0), mm(2.0)).unwrap();
        assert_relative_eq!(on_floor(torus, 0.01), 6.0 + 2.0 * (0.04_f64 - 0.0001).sqrt(), max_relative = 1e-15);
        assert_relative_eq!(on_floor(Cutter::ball_end(mm(10.0)), 0.01), 2.0 * (0.1_f64 - 0.0001).sqrt(), max_relative = 1e-15);
        assert_eq!((on_floor(torus, 2.5), on_floor(Cutter::flat_end(mm(6.0)), 0.001)), (10.0, 6.0));
        // 0.3 mm is on the lens' first arc, which is 0.62 mm high, 0.9 mm on its corner.
        let lens = Cutter::lens(mm(16.0), mm(40.0), mm(1.0)).unwrap();
        for (cutter, height) in [(lens, 0.3), (lens, 0.9), (Cutter::oval(mm(10.0), mm(2.0), mm(80.0)).unwrap(), 5.0)] {
            assert_relative_eq!(cutter.profile().low(on_floor(cutter, height) / 2.0), height, max_relative = 1e-12);
        }
    }

    #[test]
    fn limits_of_the_shapes_are_balls() {
        let ball = Cutter::ball_end(mm(10.0));
        for cutter in [
            Cutter::oval(mm(10.0), mm(5.0), mm(5.0)).unwrap(),
            Cutter::oval(mm(10.0), mm(5.0), mm(50.0)).unwrap(),
            Cutter::lens(mm(10.0), mm(5.0), mm(4.0)).unwrap(),
        ] {
            for step in 0..=100 {
                let rho = f64::from(step) / 20.0;
                assert_relative_eq!(cutter.profile().low(rho), ball.profile().low(rho), epsilon = 1e-7);
            }
        }
    }

    #[test]
    fn wrong_dimensions_are_refused_with_their_bounds() {
        assert_eq!(Cutter::toroidal(mm(10.0), mm(5.0)), Err(CutterError::CornerTooLarge { outer_radius: mm(5.0) }));
        assert_eq!(Cutter::lens(mm(10.0), mm(4.0), mm(1.0)), Err(CutterError::LargeRadiusTooSmall { smallest_radius: mm(5.0) }));
        assert_eq!(Cutter::oval(mm(10.0), mm(6.0), mm(80.0)), Err(CutterError::TipTooLarge { largest_radius: mm(5.0) }));
        assert_eq!(Cutter::tapered_ball(mm(2.0), degrees(0.0), mm(6.0)), Err(CutterError::Taper));
        let narrow = Cutter::tapered_ball(mm(2.0), degrees(60.0), mm(0.5));
        assert!(matches!(narrow, Err(CutterError::ShankTooNarrow { smallest_diameter }) if (smallest_diameter.mm() - 1.0).abs() < 1e-12));
    }
}
