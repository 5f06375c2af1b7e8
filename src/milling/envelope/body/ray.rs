//! Lines from the contact over the surface, on which the section's outline is searched. Along a line the surface falls
//! like a parabola, so that the distance to the body is a function of one length.

use super::{Body, OVERHANG};

/// A line from the contact: its components and the surface's curvature along it.
#[derive(Debug, Clone, Copy)]
pub(in crate::milling::envelope) struct Ray<'a> {
    body: &'a Body,
    steep: f64,
    level: f64,
    /// The curvature of the surface along the line.
    bend: f64,
    /// The derivative of the overhang's distance along the line, and that distance at the contact, as in
    /// [`Body::overhang`]; `None` if the line does not lead uphill or the surface has no overhang.
    overhang: Option<[f64; 2]>,
}

impl<'a> Ray<'a> {
    /// The line in a direction of unit length, along the feed and to its side.
    pub(in crate::milling::envelope) fn new(body: &'a Body, direction: [f64; 2]) -> Self {
        let (steep, level) = body.in_slope(direction[0], direction[1]);
        let (sin, cos) = (body.slope.sin(), body.slope.cos());
        let overhang = body.concave.filter(|overhang| overhang.length > 0.0 && steep < 0.0).map(|overhang| {
            let gradient = sin * (overhang.bend * steep + overhang.twist * level);
            [gradient / overhang.length, -(cos + OVERHANG) / overhang.length]
        });
        Self { body, steep, level, bend: body.surface_bend(direction), overhang }
    }

    /// The distances from the contact at which H can change between rising and falling, in rising order; 0 where there
    /// is none. See [`Body::turns_along`].
    pub(in crate::milling::envelope) fn turns(&self) -> [f64; 4] {
        self.body.turns_along(self.steep, self.level, self.bend)
    }

    /// The distance to the body of the point `length` from the contact, at the height p over the surface, and its
    /// derivative along the line. It is [`Body::distance`] without the derivatives that the outline does not need.
    pub(in crate::milling::envelope) fn distance(&self, length: f64, p: f64) -> [f64; 2] {
        let solid = self.solid(length, p);
        if let Some([slope, at_contact]) = self.overhang {
            let beyond_line = slope * length + at_contact;
            let uphill = -self.steep * length;
            let [value, by_length] = if beyond_line < uphill { [beyond_line, slope] } else { [uphill, -self.steep] };
            if value > 0.0 && value > solid[0] {
                return [value, by_length];
            }
        }
        solid
    }

    /// The same without the overhang.
    fn solid(&self, length: f64, p: f64) -> [f64; 2] {
        let Body { corner: r, slope, axis, .. } = self.body;
        let (sin, cos, r) = (slope.sin(), slope.cos(), *r);
        let p = p - 0.5 * self.bend * length * length;
        let p_by_length = -self.bend * length;
        let (steep, level) = (self.steep * length, self.level * length);
        let (d, e) = (p * sin + steep * cos, p * cos - steep * sin);
        let (d_by_length, e_by_length) = (p_by_length * sin + self.steep * cos, p_by_length * cos - self.steep * sin);
        let b = axis - d;
        let radius = (b * b + level * level).sqrt();
        // One division for two quotients, as in the distance itself.
        let (excess, per_radius) = if b > 0.0 {
            let per_both = (radius * (radius + b)).recip();
            (level * level * per_both * radius, per_both * (radius + b))
        } else {
            (radius - b, radius.recip())
        };
        let grown = excess - d;
        let (outside, below) = (r * sin + grown, r * cos - e);
        // On the axis the core's floor is nearer than its side.
        let out_by_length = if radius > 0.0 { (level * self.level - b * d_by_length) * per_radius } else { 0.0 };
        if outside > 0.0 && below > 0.0 {
            let to_core = (outside * outside + below * below).sqrt();
            let per_both = (to_core * (to_core + r)).recip();
            let value = (2.0 * r * (sin * excess - p) + grown * grown + e * e) * (per_both * to_core);
            [value, (outside * out_by_length - below * e_by_length) * (per_both * (to_core + r))]
        } else if outside > below {
            [grown - r * (1.0 - sin), out_by_length]
        } else {
            [-e - r * (1.0 - cos), -e_by_length]
        }
    }
}
