//! Where the height of the body over the surface, H, can change between rising and falling on a line from the contact.

use super::Body;

/// Where H can change from rising to falling on a line from the contact.
#[derive(Debug, Clone, Copy)]
pub(super) struct Turn {
    /// The share of the line.
    pub(super) at: f64,
    /// Whether H is highest there, on the flat.
    pub(super) is_top: bool,
}

impl Body {
    /// Where on the line from the contact through a point H can change from rising to falling, as a share of the line
    /// up to the point: where the parabola of H on the flat is highest, or, if the line misses the flat, nearest to the
    /// axis. `None` if there is no such point.
    pub(super) fn turn(&self, direction: [f64; 2]) -> Option<Turn> {
        let (steep, level) = self.in_slope(direction[0], direction[1]);
        let [enters, leaves, top, nearest] = self.turns_by_kind(steep, level, self.surface_bend(direction))?;
        Some(if enters < leaves {
            Turn { at: top.clamp(enters, leaves), is_top: top > enters && top < leaves }
        } else {
            Turn { at: nearest, is_top: false }
        })
    }

    /// The distances from the contact, in rising order, at which H can change between rising and falling along a
    /// direction, stated by its components and the surface's curvature along it. They are the points at which the line
    /// enters and leaves the flat, is nearest to the axis, and reaches the maximum of the parabola of H on the flat. Points
    /// that do not exist are 0.
    ///
    /// The flat is the disc of radius a, shortened by cos(S) along the steepest line. On it H = tan(S) u_s + r (1 -
    /// 1/cos(S)) + 1/2 u'Ku.
    pub(super) fn turns_along(&self, steep: f64, level: f64, bend: f64) -> [f64; 4] {
        let Some([enters, leaves, top, nearest]) = self.turns_by_kind(steep, level, bend) else { return [0.0; 4] };
        let mut turns = if enters < leaves { [enters, leaves, nearest, top.clamp(enters, leaves)] } else { [nearest, 0.0, 0.0, 0.0] };
        turns.sort_unstable_by(f64::total_cmp);
        turns
    }

    /// u'Ku for a direction u along the feed and to its side.
    pub(super) fn surface_bend(&self, direction: [f64; 2]) -> f64 {
        self.surface.along_per_mm() * direction[0] * direction[0]
            + 2.0 * self.surface.twist_per_mm() * direction[0] * direction[1]
            + self.surface.across_per_mm() * direction[1] * direction[1]
    }

    /// The points of [`Body::turns_along`]: where the line enters and leaves the flat, both 0 if it misses the flat, where the
    /// parabola is highest, and where the line is nearest to the axis.
    fn turns_by_kind(&self, steep: f64, level: f64, bend: f64) -> Option<[f64; 4]> {
        let (sin, cos) = (self.slope.sin(), self.slope.cos());
        if bend >= 0.0 || self.core == 0.0 || cos <= 0.0 {
            return None;
        }
        let centre = self.axis * cos + self.corner * (1.0 - cos) * sin;
        let (square, half) = ((steep / cos).powi(2) + level * level, centre * steep / (cos * cos));
        let nearest = half / square;
        let discriminant = half * half - square * ((centre / cos).powi(2) - self.core * self.core);
        let root = discriminant.max(0.0).sqrt();
        let (enters, leaves) = if root > 0.0 { ((half - root) / square, (half + root) / square) } else { (0.0, 0.0) };
        Some([enters, leaves, -sin / cos * steep / bend, nearest])
    }
}
