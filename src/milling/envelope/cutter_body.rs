//! The cutter's body, placed on the surface at contacts near the stated one, and its distance from a point over the stated
//! contact.

use crate::milling::{Contact, Profile, ProfileArc, SurfaceCurvature};
use crate::numerics::vector::{cross, dot};

type Space = [f64; 3];

/// The largest turn of a mark's normal, as a share of the turn at which the contact would leave its arc of the profile.
/// Beyond it the contact jumps along a straight piece, and at the floor to the cutter's other side.
const LARGEST_TURN: f64 = 0.7;

/// How far marks are from the stated contact, as a share of the cutter's radius, for which the turn is not yet limited.
const NEARBY: f64 = 0.05;

/// How steep the surface is at most at a mark, over the tangent plane of the stated contact: |K u|. What a contact tells of its
/// surface, the second order, holds for no more, and no mark lies beyond.
pub(super) const STEEPEST: f64 = 1.0;

/// The profile's arc at the contact, and the contact's place on it.
#[derive(Debug, Clone, Copy)]
struct Touching {
    index: usize,
    radius: f64,
    centre_offset: f64,
}

/// An arc of the profile, prepared for distances.
#[derive(Debug, Clone, Copy)]
struct Arc {
    radius: f64,
    offset: f64,
    height: f64,
    from: [f64; 2],
    to: [f64; 2],
}

/// A cutter at the contacts u = (x, c) of marks: x along the feed, c across it, from the stated contact in its tangent
/// plane.
///
/// The surface is the quadric -u'Ku/2 over that plane. The cutter that makes the mark touches it at u, with the surface's
/// own normal there; the tool axis does not turn. The point (0, 0, p) at the height p over the stated contact is left uncut
/// by the mark if its distance from the body is positive.
///
/// A mark's normal is (T, 1) with T = Ku, limited to a share of the turn that the arc at the contact allows. Contacts on
/// straight pieces allow none: all marks then have the stated normal, and the point's height over the tangent plane of a
/// mark is p + u'Ku/2, which is the second order of the surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct CutterBody {
    arcs: [Arc; crate::milling::MOST_ARCS],
    count: usize,
    touching: Touching,
    axis: Space,
    /// k_F, k_T and k_FT.
    bend: [f64; 3],
    /// The largest |T|; 0 if marks do not turn.
    turn_limit: f64,
    /// T / (K u) near the stated contact.
    turn_share: f64,
    outer_radius: f64,
    /// The size of K times the steepest direction, where the cutter's straight side comes closer to the surface further up.
    overhang: Option<f64>,
    stated: Frame,
}

/// The body's place at a mark: the directions outwards from the axis to the contact and level, and the normal.
#[derive(Debug, Clone, Copy)]
struct Frame {
    outwards: Space,
    level: Space,
    sin: f64,
    cos: f64,
}

/// The signed distance of the point from the body, negative inside, and its derivatives by the mark's contact and by the
/// point's height.
#[derive(Debug, Clone, Copy)]
pub(super) struct SignedDistance {
    pub(super) value: f64,
    pub(super) by_x: f64,
    pub(super) by_c: f64,
    pub(super) by_level: f64,
}

impl CutterBody {
    pub(super) fn new(profile: &Profile, contact: Contact, surface: SurfaceCurvature) -> Self {
        let slope = contact.slope();
        let (sin, cos) = (slope.sin(), slope.cos());
        let omega = contact.omega();
        // The feed is at omega from the uphill steepest line.
        let uphill = [omega.cos(), -omega.sin()];
        let axis = [sin * uphill[0], sin * uphill[1], cos];
        let outwards = [cos * uphill[0], cos * uphill[1], -sin];
        let stated = Frame { outwards, level: cross(axis, outwards), sin, cos };
        let arc = profile.arc_at(slope.radians());
        let index = profile.arcs().iter().position(|other| other == arc).unwrap_or(0);
        let prepare = |arc: &ProfileArc| {
            let unit = |angle: f64| if angle >= std::f64::consts::FRAC_PI_2 { [1.0, 0.0] } else { angle.sin_cos().into() };
            Arc { radius: arc.radius, offset: arc.centre_offset, height: arc.centre_height, from: unit(arc.from), to: unit(arc.to) }
        };
        let mut arcs = [prepare(arc); crate::milling::MOST_ARCS];
        for (prepared, arc) in arcs.iter_mut().zip(profile.arcs()) {
            *prepared = prepare(arc);
        }
        let bend = [surface.along_per_mm(), surface.across_per_mm(), surface.twist_per_mm()];
        let touching = &arcs[index];
        // The sines of the angles to the arc's ends. The other side of a round tip continues it.
        let is_tip = touching.offset == 0.0 && touching.from[0] == 0.0;
        // Turned marks of a ball differ from others in the fourth order alone, and depend on the slope.
        let is_ball = is_tip && profile.arcs().len() == 1;
        let before = if is_tip { f64::INFINITY } else { sin * touching.from[1] - cos * touching.from[0] };
        let after = touching.to[0] * cos - touching.to[1] * sin;
        // Marks of a sharp edge, whose contact is one circle, keep the stated normal.
        let turn_limit =
            if surface.is_plane() || is_ball || touching.radius == 0.0 { 0.0 } else { LARGEST_TURN * before.min(after).max(0.0) };
        let sharpest = surface.principal_per_mm().map(f64::abs);
        let near = sharpest[0].max(sharpest[1]) * NEARBY * profile.outer_radius() / turn_limit.max(f64::MIN_POSITIVE);
        let turn_share = (1.0 + near.powi(4)).sqrt().sqrt().recip();
        let overhang = overhang(axis, uphill, bend, profile.outer_radius());
        let touching = Touching { index, radius: arc.radius, centre_offset: arc.centre_offset };
        Self {
            arcs,
            count: profile.arcs().len(),
            touching,
            axis,
            bend,
            turn_limit,
            turn_share,
            outer_radius: profile.outer_radius(),
            overhang,
            stated,
        }
    }

    /// A body that has the stated normal at all marks.
    pub(super) fn without_turns(self) -> Self {
        Self { turn_limit: 0.0, ..self }
    }

    /// Whether the cutter is a ball.
    pub(super) fn is_ball(&self) -> bool {
        self.count == 1 && self.touching.centre_offset == 0.0
    }

    /// Whether marks have normals of their own.
    pub(super) fn turns(&self) -> bool {
        self.turn_limit > 0.0
    }

    /// The curvature of the cutter relative to the surface in the axes of the feed: along, across and twist, in 1/mm.
    pub(super) fn relative_curvature(&self, contact: Contact) -> [f64; 3] {
        let Touching { radius, centre_offset, .. } = self.touching;
        let (steep, level) = (radius.recip().min(1e9), self.stated.sin / (centre_offset + radius * self.stated.sin).max(1e-9));
        let level = if centre_offset == 0.0 { steep } else { level };
        let (cos, sin) = (contact.omega().cos(), contact.omega().sin());
        let [along, across, twist] = self.bend;
        [steep * cos * cos + level * sin * sin + along, steep * sin * sin + level * cos * cos + across, (level - steep) * sin * cos + twist]
    }

    /// The distance of the point at the height p over the stated contact from the body of the mark at (x, c).
    pub(super) fn gap(&self, x: f64, c: f64, p: f64) -> SignedDistance {
        let [first, second] = self.faces(x, c, p);
        if self.is_sharp() && second.value > first.value { second } else { first }
    }

    /// The distances from both faces of the sharp edge at the contact, of which the greater is the distance; otherwise the first one
    /// alone. The distance from a sharp edge itself has no derivative where it is 0; those from its faces do, and are greater
    /// than 0 at the same points.
    pub(super) fn faces(&self, x: f64, c: f64, p: f64) -> [SignedDistance; 2] {
        let [along, across, twist] = self.bend;
        let fall = [along * x + twist * c, twist * x + across * c];
        let faces = self.faces_at(x, c, p, fall);
        let square = fall[0] * fall[0] + fall[1] * fall[1];
        if square <= STEEPEST * STEEPEST {
            return faces;
        }
        let (steepness, size) = (square.sqrt(), along.hypot(twist).max(twist.hypot(across)));
        let by = |column: [f64; 2]| (fall[0] * column[0] + fall[1] * column[1]) / (steepness * size);
        let beyond =
            SignedDistance { value: (steepness - STEEPEST) / size, by_x: by([along, twist]), by_c: by([twist, across]), by_level: 0.0 };
        faces.map(|face| if beyond.value > face.value { beyond } else { face })
    }

    /// The faces of a mark where the surface has fallen by K u.
    fn faces_at(&self, x: f64, c: f64, p: f64, fall: [f64; 2]) -> [SignedDistance; 2] {
        let [along, across, twist] = self.bend;
        let sag = f64::midpoint(fall[0] * x, fall[1] * c);
        if self.turn_limit == 0.0 {
            let faces = self.nearest(&self.stated, [-x, -c, p - sag], p - sag).map(|nearest| {
                let [by_feed, by_side, by_level] = nearest.normal;
                SignedDistance {
                    value: nearest.distance,
                    by_x: -by_level * fall[0] - by_feed,
                    by_c: -by_level * fall[1] - by_side,
                    by_level,
                }
            });
            let [first, second] = faces;
            let gap = |face| self.or_overhang(face, [x, c], fall, [along, twist], [twist, across]);
            return if self.is_sharp() { [first, gap(second)] } else { [gap(first), SignedDistance::NONE] };
        }
        // T = K u / (1 + |K u / limit|^4)^(1/4).
        let limit = self.turn_limit / self.turn_share;
        let square = (fall[0] * fall[0] + fall[1] * fall[1]) / (limit * limit);
        let root = (1.0 + square * square).sqrt();
        let share = self.turn_share / root.sqrt();
        let turn = fall.map(|fall| share * fall);
        // The derivative of the share by the square of |K u / limit|.
        let share_by_square = -share * square / (2.0 * root * root);
        let length = (1.0 + turn[0] * turn[0] + turn[1] * turn[1]).sqrt().recip();
        let normal = [turn[0] * length, turn[1] * length, length];
        let cos = dot(normal, self.axis);
        let horizontal: Space = std::array::from_fn(|i| normal[i] - cos * self.axis[i]);
        let sin = dot(horizontal, horizontal).sqrt();
        let per_sin = if sin > 0.0 { sin.recip() } else { 0.0 };
        let outwards = if sin > 0.0 { horizontal.map(|part| -part * per_sin) } else { self.stated.outwards };
        let frame = Frame { outwards, level: cross(self.axis, outwards), sin, cos };
        // From the mark's contact to the point. For T = K u the contact lies on the quadric; for less it is raised so that
        // the point stays as high over its tangent plane.
        let to_point = [-x, -c, p - sag + x * turn[0] + c * turn[1]];
        let [nearest, _] = self.nearest(&frame, to_point, (p - sag) * length);

        let m = nearest.normal;
        let (facing, aside) = (dot(m, normal), dot(m, frame.level));
        // How the centre of the arc's circle moves as the normal turns, times the body's normal.
        let Touching { radius, centre_offset, .. } = self.touching;
        let turn_by = |fall_by: [f64; 2]| -> [f64; 2] {
            let by_square = 2.0 * (fall[0] * fall_by[0] + fall[1] * fall_by[1]) / (limit * limit) * share_by_square;
            std::array::from_fn(|i| share * fall_by[i] + by_square * fall[i])
        };
        let moves = |by: [f64; 2], own: usize| {
            let along_normal = normal[0] * by[0] + normal[1] * by[1];
            let to_normal = (m[0] * by[0] + m[1] * by[1] - facing * along_normal) * length;
            let around = (frame.level[0] * by[0] + frame.level[1] * by[1] - dot(frame.level, normal) * along_normal) * length;
            let rises = turn[own] + x * by[0] + c * by[1] - fall[own];
            m[2] * rises - m[own] - radius * to_normal - centre_offset * aside * around * per_sin
        };
        let (by_x, by_c) = (turn_by([along, twist]), turn_by([twist, across]));
        let gap = SignedDistance { value: nearest.distance, by_x: moves(by_x, 0), by_c: moves(by_c, 1), by_level: m[2] };
        let less = |one: [f64; 2], other: [f64; 2]| [one[0] - other[0], one[1] - other[1]];
        [self.or_overhang(gap, [x, c], less(fall, turn), less([along, twist], by_x), less([twist, across], by_c)), SignedDistance::NONE]
    }

    /// The distance uphill of the mark's level line and beyond the line up to which the point rises along the cutter's straight
    /// side, if that is greater.
    /// `bent` = K u - T is what the surface turns from the mark to the point beyond the mark's own turn: with (bent, -1) . axis
    /// > 0 the surface overhangs, and the height over it falls without bound.
    fn or_overhang(&self, gap: SignedDistance, mark: [f64; 2], bent: [f64; 2], by_x: [f64; 2], by_c: [f64; 2]) -> SignedDistance {
        let Some(size) = self.overhang else { return gap };
        let [feed, side, up] = self.axis;
        let along = |bent: [f64; 2]| (bent[0] * feed + bent[1] * side) / size;
        let beyond = SignedDistance { value: along(bent) - up / size, by_x: along(by_x), by_c: along(by_c), by_level: 0.0 };
        let level = feed.hypot(side);
        let uphill =
            SignedDistance { value: -(mark[0] * feed + mark[1] * side) / level, by_x: -feed / level, by_c: -side / level, by_level: 0.0 };
        let nearer = if uphill.value < beyond.value { uphill } else { beyond };
        if nearer.value > gap.value { nearer } else { gap }
    }

    /// A distance that rounding may change.
    pub(super) fn rounding(&self) -> f64 {
        2e-17 * self.outer_radius
    }

    /// The turn of the normal at a mark, as a share of that at which the contact would leave its arc; for a body that turns.
    pub(super) fn turn(&self, x: f64, c: f64) -> f64 {
        let [along, across, twist] = self.bend;
        (along * x + twist * c).hypot(twist * x + across * c) * LARGEST_TURN / self.turn_limit
    }

    /// The nearest place of the body to a point, from the contact; `over_plane` is the point's height over the tangent plane
    /// of the mark.
    #[inline]
    fn nearest(&self, frame: &Frame, to_point: Space, over_plane: f64) -> [Nearest; 2] {
        let Frame { outwards, level, sin, cos } = frame;
        let touching = &self.arcs[self.touching.index];
        let (out, aside, up) = (dot(to_point, *outwards), dot(to_point, *level), dot(to_point, self.axis));
        let contact_radius = touching.offset + touching.radius * sin;
        let b = contact_radius + out;
        let rho = (b * b + aside * aside).sqrt();
        // rho - b without cancellation.
        let excess = if b > 0.0 { aside * aside / (rho + b) } else { rho - b };
        let grown = out + excess;
        let mut found = [(f64::NEG_INFINITY, [0.0, 1.0]); 2];
        for (index, arc) in self.arcs[..self.count].iter().enumerate() {
            // From the arc's centre to the point, outwards and down.
            let is_touching = index == self.touching.index;
            let (beyond, below) = if is_touching {
                (arc.radius * sin + grown, arc.radius * cos - up)
            } else {
                (rho - arc.offset, arc.height - (touching.height - touching.radius * cos + up))
            };
            let after_from = beyond * arc.from[1] - below * arc.from[0];
            let before_to = below * arc.to[0] - beyond * arc.to[1];
            let is_round = arc.radius > 0.0;
            if is_round && after_from >= 0.0 && before_to >= 0.0 && (beyond > 0.0 || below > 0.0) {
                let length = (beyond * beyond + below * below).sqrt();
                let distance = if is_touching {
                    // |centre to point|^2 - r^2 over the sum of both: the contact is at the distance r.
                    (2.0 * arc.radius * (sin * excess - over_plane) + grown * grown + up * up) / (length + arc.radius)
                } else {
                    length - arc.radius
                };
                let normal = if length > 0.0 { [beyond / length, below / length] } else { arc.from };
                further(&mut found[0], (distance, normal));
                continue;
            }
            let at = |end: [f64; 2]| {
                let distance = if is_touching {
                    // 1 - cos(angle between) of the contact's normal and the end's, without cancellation.
                    let chord = [end[0] - sin, end[1] - cos];
                    grown * end[0] - up * end[1] - arc.radius * (chord[0] * chord[0] + chord[1] * chord[1]) / 2.0
                } else {
                    beyond * end[0] + below * end[1] - arc.radius
                };
                (distance, end)
            };
            // Both faces of a sharp edge at the contact are told apart.
            let second = usize::from(self.is_sharp() && index >= self.touching.index);
            further(&mut found[second * usize::from(!is_touching)], at(arc.from));
            further(&mut found[second], at(arc.to));
        }
        let (radial, around) = if rho > 0.0 { (b / rho, aside / rho) } else { (1.0, 0.0) };
        found.map(|(distance, [sideways, down])| Nearest {
            distance,
            normal: std::array::from_fn(|i| sideways * (radial * outwards[i] + around * level[i]) - down * self.axis[i]),
        })
    }

    /// Whether the contact is on a sharp edge.
    pub(super) fn is_sharp(&self) -> bool {
        self.touching.radius == 0.0
    }
}

fn further(found: &mut (f64, [f64; 2]), other: (f64, [f64; 2])) {
    if other.0 > found.0 {
        *found = other;
    }
}

/// The size of K times the steepest direction if the cutter's straight side, a cylinder of the radius R, comes closer to the
/// surface further up: unless [[k_ss, k_sl], [k_sl, 1/R + k_ll]] has no negative eigenvalue.
fn overhang(axis: Space, uphill: [f64; 2], [along, across, twist]: [f64; 3], outer: f64) -> Option<f64> {
    let rises = [along * uphill[0] + twist * uphill[1], twist * uphill[0] + across * uphill[1]];
    let level = [-uphill[1], uphill[0]];
    let (steep, both) = (rises[0] * uphill[0] + rises[1] * uphill[1], rises[0] * level[0] + rises[1] * level[1]);
    let aside = outer.recip() + along + across - steep;
    let size = rises[0].hypot(rises[1]) * axis[0].hypot(axis[1]);
    // Components that are exactly 0 become rounding errors of the largest one when the curvature is turned.
    let rounding = 1e-12 * (along.abs() + across.abs() + twist.abs());
    (size > 0.0 && (steep < -rounding || both.abs() > rounding && steep * aside < both * both)).then_some(size)
}

/// The signed distance of a point from the body and the body's normal towards it.
#[derive(Debug, Clone, Copy)]
struct Nearest {
    distance: f64,
    normal: Space,
}

impl SignedDistance {
    pub(super) const NONE: Self = Self { value: 0.0, by_x: 0.0, by_c: 0.0, by_level: 0.0 };
}
