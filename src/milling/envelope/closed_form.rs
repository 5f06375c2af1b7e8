//! Heights and inverses with a closed form: on plane floors and walls, for ball-end cutters, and for sharp edges on
//! planes.

use super::Envelope;
use super::section::Pattern;
use crate::milling::CutterKind;
use crate::numerics::bracketed_root;
use std::convert::Infallible;
use std::f64::consts::FRAC_PI_2;

impl Envelope {
    /// h on a plane for marks of equal depth; `None` if it has no closed form.
    pub(super) fn closed_form(&self, s: f64, f: f64) -> Option<f64> {
        // Only the cylindrical side touches a wall. On a floor, the corners of the rectangle between two teeth of two
        // passes lie on the flat or on the corner's round.
        if let Some(disc) = self.disc() {
            return Some(disc.height((s * disc.shares[0]).hypot(f * disc.shares[1])));
        }
        let outer = self.cutter.outer_radius().mm();
        match self.cutter.kind() {
            CutterKind::BallEnd if self.ball_alone(s, f) => Some(circle_height(outer, s.hypot(f))),
            CutterKind::FlatEnd => Some(self.edge_height(s, f)),
            _ => None,
        }
    }

    /// Whether a ball-end cutter touches the ridge with its ball and not with its side.
    ///
    /// On the sphere the lowest rectangle is centred over the contact, R - h below the centre. Its highest corner is (s
    /// |sin(theta)| + f |cos(theta)|) / 2 up the slope and must be below the centre.
    pub(super) fn ball_alone(&self, s: f64, f: f64) -> bool {
        let (slope, theta, radius) = (self.contact().slope(), self.contact().theta(), self.cutter.outer_radius().mm());
        let half_diagonal = s.hypot(f) / 2.0;
        let up = f64::midpoint(s * theta.sin().abs(), f * theta.cos().abs());
        half_diagonal <= radius && ((radius - half_diagonal) * (radius + half_diagonal)).sqrt() * slope.cos() >= up * slope.sin()
    }

    /// h of a flat-end cutter between floor and wall.
    ///
    /// Seen from above, the section is the part of the disc of radius R that is nearer to the contact than a level line.
    /// With d' and f' the distances of passes and of marks seen from above, a chord of length f' at the offset y from
    /// the axis reaches least far if it begins on the circle, at the angle phi with R sin(phi) = y. The height at its
    /// end is then
    ///
    /// sin(S) (f' cos(alpha) + R (1 - cos(phi + alpha))).
    ///
    /// Chords at equal heights have phi + alpha = delta and -delta, and are d' = 2 R cos(alpha) sin(delta) apart. The
    /// chord at -delta is as long as f' only if |y| <= Y = sqrt(R^2 - f'^2/4). Otherwise that chord is at y = -Y, and
    /// the other one, at y = d' - Y, is higher. With R (1 - cos(epsilon)) = R + y, it is at delta = epsilon - (90 deg -
    /// alpha).
    fn edge_height(&self, s: f64, f: f64) -> f64 {
        let (outer, sin) = (self.cutter.outer_radius().mm(), self.contact().slope().sin());
        let (cos_alpha, sin_alpha) = (self.contact().alpha().cos().abs(), self.contact().alpha().sin().abs());
        let (across, along) = (s * self.spacing_ratio(), f * self.climb.cos());
        let half_width = ((outer - along / 2.0) * (outer + along / 2.0)).max(0.0).sqrt();
        // R - Y without cancellation.
        let beyond = along * along / (4.0 * (outer + half_width));
        let on_level_chord = across / (2.0 * outer * cos_alpha);
        let delta = on_level_chord.min(1.0).asin();
        let lower = delta + sin_alpha.atan2(cos_alpha);
        let delta = if on_level_chord <= 1.0 && lower <= FRAC_PI_2 && outer * lower.sin() <= half_width {
            delta
        } else {
            2.0 * ((across + beyond) / (2.0 * outer)).min(1.0).sqrt().asin() - cos_alpha.atan2(sin_alpha)
        };
        sin * (along * cos_alpha + 2.0 * outer * (delta / 2.0).sin().powi(2))
    }
}

/// The cutter on a plane floor or wall. On a floor its section at every height is a disc, of the flat and the round at
/// its rim; on a wall it is a strip.
#[derive(Debug, Clone, Copy)]
struct Disc {
    /// The radius of the flat.
    flat: f64,
    /// The radius of the round.
    round: f64,
    /// The factors from the distances of passes and of marks to those seen from above.
    shares: [f64; 2],
}

impl Disc {
    /// The radius at the height p.
    fn radius(&self, p: f64) -> f64 {
        let rise = p.clamp(0.0, self.round);
        self.flat + (rise * (2.0 * self.round - rise)).sqrt()
    }

    /// The height at which the diameter is `chord`.
    fn height(&self, chord: f64) -> f64 {
        let beyond_flat = chord - 2.0 * self.flat;
        if beyond_flat > 0.0 { circle_height(self.round, beyond_flat) } else { 0.0 }
    }

    /// Half of the chord at the height p whose midpoint is `across` / 2 from the centre.
    fn half_chord(&self, p: f64, across: f64) -> Option<f64> {
        let radius = self.radius(p);
        (p >= 0.0 && radius >= across / 2.0).then(|| ((radius - across / 2.0) * (radius + across / 2.0)).sqrt())
    }
}

/// With runout, a chord ends in the section of a deep mark or of a shallow one, which is the section at the height p -
/// delta. All sections are centred over the contact. Therefore one of the two intervals, that of alternating marks and
/// that of deep marks alone, contains the other.
impl Envelope {
    fn disc(&self) -> Option<Disc> {
        let (slope, outer) = (self.contact().slope(), self.cutter.outer_radius().mm());
        if !self.pass.surface.is_plane() {
            None
        } else if slope.cos() == 0.0 {
            Some(Disc { flat: 0.0, round: outer, shares: [self.spacing_ratio(), self.climb.cos()] })
        } else if slope.sin() == 0.0 {
            Some(Disc { flat: self.cutter.core_radius().mm(), round: self.cutter.corner_radius().mm(), shares: [1.0; 2] })
        } else {
            None
        }
    }

    /// h on a plane floor or wall with runout.
    pub(super) fn level_on_floor_or_wall(&self, s: f64, pattern: &Pattern) -> Option<f64> {
        let disc = self.disc()?;
        let (across, along) = (s * disc.shares[0], pattern.spacing * disc.shares[1]);
        let by_deep = across.hypot(pattern.deep_spacing * disc.shares[1]);
        // The largest step-over and feed are on this limit, up to rounding.
        let by_deep = (by_deep <= 2.0 * (disc.flat + disc.round) * (1.0 + 8.0 * f64::EPSILON)).then(|| disc.height(by_deep));
        let (least, drop) = (disc.height(across.hypot(along)), pattern.drop);
        let alternating = if pattern.shallow_pairs {
            least + drop
        } else {
            let excess =
                |p: f64| disc.half_chord(p - drop, across).zip(disc.half_chord(p, across)).map_or(-1.0, |(a, b)| (a + b - along).max(-1.0));
            let Ok(level) = bracketed_root(least, least + drop, |p| Ok::<_, Infallible>(excess(p)));
            level
        };
        Some(by_deep.map_or(alternating, |by_deep| by_deep.min(alternating)))
    }

    /// The largest distance of marks that keeps the height p on a plane floor or wall in passes s apart; 0 if none does.
    pub(super) fn feed_on_floor_or_wall(&self, p: f64, s: f64) -> Option<f64> {
        let disc = self.disc()?;
        let across = s * disc.shares[0];
        let (deep, shallow) = (disc.half_chord(p, across), disc.half_chord(p - self.drop, across));
        let by_deep = deep.map_or(0.0, |deep| self.mark_spacing(at_share(2.0 * deep / self.teeth(), disc.shares[1])));
        let pairs = self.pass.has_shallow_pairs();
        let alternating = deep.zip(shallow).map_or(0.0, |(deep, shallow)| shallow + if pairs { shallow } else { deep });
        Some(by_deep.max(at_share(alternating, disc.shares[1])))
    }

    /// The largest step-over that keeps the height p on a plane floor or wall; 0 if none does.
    pub(super) fn step_over_on_floor_or_wall(&self, p: f64, pattern: &Pattern) -> Option<f64> {
        let disc = self.disc()?;
        let along = pattern.spacing * disc.shares[1];
        // Half-length and distance from the centre of a chord are interchangeable, so the same function serves for
        // both.
        let by_deep = disc.half_chord(p, pattern.deep_spacing * disc.shares[1]).unwrap_or(0.0);
        let alternating = if p < pattern.drop {
            0.0
        } else if pattern.shallow_pairs || pattern.is_even() {
            disc.half_chord(p - pattern.drop, along).unwrap_or(0.0)
        } else {
            // Two circles with centres one feed apart meet at this distance from the line of their centres, unless the
            // widest point of the smaller one is inside the other.
            let (deep, shallow) = (disc.radius(p), disc.radius(p - pattern.drop));
            let from_shallow = (along - (deep - shallow) * (deep + shallow) / along) / 2.0;
            if from_shallow <= 0.0 { shallow } else { ((shallow - from_shallow) * (shallow + from_shallow)).max(0.0).sqrt() }
        };
        Some(at_share(2.0 * by_deep.max(alternating), disc.shares[0]))
    }
}

/// `length` divided by `share`; 0 if `length` is 0.
fn at_share(length: f64, share: f64) -> f64 {
    if length > 0.0 { length / share } else { 0.0 }
}

/// P - sqrt(P^2 - c^2/4) without cancellation: the height between circles of radius P at the distance c <= 2P.
pub(super) fn circle_height(radius: f64, chord: f64) -> f64 {
    // Rounding may make c larger than 2P although the caller's comparison did not.
    let ratio = (chord / (2.0 * radius)).min(1.0);
    chord / 2.0 * ratio / (1.0 + ((1.0 - ratio) * (1.0 + ratio)).sqrt())
}
