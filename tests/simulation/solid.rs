//! A brute-force simulation of finish milling on an inclined plane. It uses only whether the cutter's solid covers a
//! point: no radii of curvature, profiles or formulas of marks.

/// A rotating cutter: a cylinder of radius R whose bottom edge has round pieces with straight ones between them. Its axis is the
/// Z axis, and its tip is at z = 0.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Solid {
    /// R in mm.
    pub(crate) outer_radius: f64,
    rounds: [Round; 2],
    /// The rise of the straight piece beyond the last round one, for each mm outwards.
    flank: f64,
}

/// A piece of a circle, in the plane of the axis.
#[derive(Debug, Clone, Copy)]
struct Round {
    centre: [f64; 2],
    radius: f64,
    /// The distances from the axis between which it lies.
    ends: [f64; 2],
}

impl Round {
    fn height(self, rho: f64) -> f64 {
        self.centre[1] - (self.radius.powi(2) - (rho - self.centre[0]).powi(2)).max(0.0).sqrt()
    }
}

impl Solid {
    /// A flat with the corner radius r: 0 for a sharp edge, R for a ball.
    pub(crate) fn torus(outer_radius: f64, corner_radius: f64) -> Self {
        let core = outer_radius - corner_radius;
        let corner = Round { centre: [core, corner_radius], radius: corner_radius, ends: [core, outer_radius] };
        Self { outer_radius, rounds: [corner; 2], flank: 0.0 }
    }

    /// A ball of radius r on a cone of the half angle `taper`, up to the shank.
    pub(crate) fn tapered_ball(radius: f64, taper: f64, shank_radius: f64) -> Self {
        let ball = Round { centre: [0.0, radius], radius, ends: [0.0, radius * taper.cos()] };
        Self { outer_radius: shank_radius, rounds: [ball; 2], flank: taper.tan().recip() }
    }

    /// Two circles that touch, the first on the axis: its centre, the second's and the joint are on one line, and the second ends at R
    /// with a tangent of the angle `taper` to the axis.
    pub(crate) fn two_rounds(outer_radius: f64, first: f64, second: f64, taper: f64) -> Self {
        let aside = outer_radius - second * taper.cos();
        let up = ((first - second).powi(2) - aside.powi(2)).sqrt().copysign(second - first);
        let joint = aside * first / (first - second);
        let tip = Round { centre: [0.0, first], radius: first, ends: [0.0, joint] };
        let side = Round { centre: [aside, first + up], radius: second, ends: [joint, outer_radius] };
        Self { outer_radius, rounds: [tip, side], flank: 0.0 }
    }

    /// The height of the body's lower side at the distance `rho <= R` from the axis.
    fn floor(self, rho: f64) -> f64 {
        let [first, last] = self.rounds;
        let [_, end] = last.ends;
        match rho {
            _ if rho < first.ends[0] => 0.0,
            _ if rho <= first.ends[1] => first.height(rho),
            _ if rho <= end => last.height(rho),
            _ => last.height(end) + self.flank * (rho - end),
        }
    }

    fn contains(self, [x, y, z]: [f64; 3]) -> bool {
        let rho = x.hypot(y);
        rho <= self.outer_radius && z >= self.floor(rho)
    }

    /// The distance rho at which a plane of the slope `slope` (rad) touches the body from below, and that plane's
    /// height over the axis' origin along its normal: the least of -rho sin + floor(rho) cos, found by ternary search.
    fn touch(self, slope: f64) -> (f64, f64) {
        let height = |rho: f64| self.floor(rho) * slope.cos() - rho * slope.sin();
        let (mut low, mut high) = (0.0, self.outer_radius);
        for _ in 0..200 {
            let (a, b) = ((2.0 * low + high) / 3.0, (low + 2.0 * high) / 3.0);
            if height(a) < height(b) { high = b } else { low = a }
        }
        (low, height(low))
    }
}

/// A plane to be milled and the feed on it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Setup {
    /// The cutter.
    pub solid: Solid,
    /// The slope in degrees.
    pub(crate) slope_deg: f64,
    /// The feed's angle to the steepest descent in the tangent plane, in degrees.
    pub(crate) omega_deg: f64,
    /// The distance of the passes along the surface, in mm.
    pub(crate) step_over: f64,
    /// The distance of the tooth marks along the feed, in mm.
    pub(crate) mark_spacing: f64,
}

/// The resolution of the simulation.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Grid {
    /// Points, and phases between neighbouring passes, in one distance of marks.
    pub(crate) along: usize,
    /// Points in one step-over.
    pub(crate) across: usize,
}

/// The number of passes on either side that can reach a point. With an oblique feed, a sharp edge cuts deepest beside
/// its contact, but by less than the distance of the marks. Passes more than two further away leave nothing lower than
/// those between.
fn passes(setup: Setup) -> i32 {
    #[expect(clippy::cast_possible_truncation, reason = "marks and step-overs are of one order")]
    let reach = (setup.mark_spacing / setup.step_over).ceil() as i32;
    reach + 2
}

/// Columns along the normal through points of the tangent plane.
struct Columns {
    solid: Solid,
    normal: [f64; 3],
    feed: [f64; 3],
    side: [f64; 3],
    touch: f64,
    /// The contact of body and plane relative to the axis, across the feed and along it.
    contact: (f64, f64),
}

impl Columns {
    fn new(setup: Setup) -> Self {
        let (slope, omega) = (setup.slope_deg.to_radians(), setup.omega_deg.to_radians());
        let steepest = [slope.cos(), 0.0, -slope.sin()];
        let feed = [steepest[0] * omega.cos(), omega.sin(), steepest[2] * omega.cos()];
        let side = [-steepest[0] * omega.sin(), omega.cos(), -steepest[2] * omega.sin()];
        let (rho, touch) = setup.solid.touch(slope);
        let contact = [-rho, 0.0, setup.solid.floor(rho)];
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let (across, along) = (dot(contact, side), dot(contact, feed));
        Self { solid: setup.solid, normal: [slope.sin(), 0.0, slope.cos()], feed, side, touch, contact: (across, along) }
    }

    fn covers(&self, x: f64, y: f64, p: f64) -> bool {
        let (x, y, p) = (x + self.contact.1, y + self.contact.0, p + self.touch);
        self.solid.contains(std::array::from_fn(|i| self.feed[i] * x + self.side[i] * y + self.normal[i] * p))
    }

    /// The height of the material under the body at (x, y), infinite if the body is above `ceiling`. The search starts
    /// from `hint`.
    fn uncut(&self, x: f64, y: f64, hint: f64, ceiling: f64, resolution: f64) -> f64 {
        let mut inside = hint.min(ceiling);
        let mut step = resolution * 16.0;
        while !self.covers(x, y, inside) {
            if inside >= ceiling {
                return f64::INFINITY;
            }
            inside = (inside + step).min(ceiling);
            step *= 2.0;
        }
        // The surface touches the body, so the body covers nothing below it. The body is convex, so a column enters it
        // once.
        let mut step = resolution * 16.0;
        let mut outside = inside - step;
        while outside > 0.0 && self.covers(x, y, outside) {
            inside = outside;
            step *= 2.0;
            outside -= step;
        }
        outside = outside.max(-resolution);
        while inside - outside > resolution {
            let middle = f64::midpoint(inside, outside);
            if self.covers(x, y, middle) { inside = middle } else { outside = middle }
        }
        outside
    }
}

/// The height that one pass leaves at the grid's points, over the length of a mark and as many step-overs to either
/// side as the pass can reach.
struct Groove {
    along: usize,
    first_row: i32,
    rows: Vec<Vec<f64>>,
}

impl Groove {
    fn mill(setup: Setup, grid: Grid, ceiling: f64, resolution: f64) -> Self {
        let columns = Columns::new(setup);
        let per_pass = i32::try_from(grid.across).expect("a grid's size");
        let (first, last) = (-passes(setup) * per_pass, passes(setup) * per_pass);
        let mut rows = vec![Vec::new(); usize::try_from(last - first).expect("rows")];
        // Rows are visited outwards from the contact, so that each starts with the tooth that cut deepest in the row
        // before it.
        let mut sweep = |order: &mut dyn Iterator<Item = i32>| {
            let (mut tooth, mut hint) = (0.0, 0.0);
            for row in order {
                let y = f64::from(row) * setup.step_over / f64::from(per_pass);
                let (mut row_tooth, mut row_hint, mut found) = (tooth, hint, false);
                let cells = (0..grid.along).map(|cell| {
                    #[expect(clippy::cast_precision_loss, reason = "a grid has few cells")]
                    let x = setup.mark_spacing * cell as f64 / grid.along as f64;
                    let height = |tooth: f64, hint| columns.uncut(x - tooth * setup.mark_spacing, y, hint, ceiling, resolution);
                    let mut least = height(row_tooth, row_hint);
                    // The height under a convex body is convex, so descending from tooth to tooth ends at the deepest.
                    for direction in [-1.0, 1.0] {
                        loop {
                            let next = height(row_tooth + direction, if least.is_finite() { least } else { row_hint });
                            if next >= least {
                                break;
                            }
                            (row_tooth, least) = (row_tooth + direction, next);
                        }
                    }
                    if least.is_finite() {
                        row_hint = least;
                        if !found {
                            (tooth, hint, found) = (row_tooth, least, true);
                        }
                    }
                    least
                });
                rows[usize::try_from(row - first).expect("a row")] = cells.collect();
            }
        };
        sweep(&mut (0..last));
        sweep(&mut (first..0).rev());
        Self { along: grid.along, first_row: first, rows }
    }

    fn row(&self, row: i32) -> &[f64] {
        &self.rows[usize::try_from(row - self.first_row).expect("a row of the groove")]
    }
}

/// The largest height that neighbouring passes leave, over every phase of the grid between the teeth of one pass and
/// the next.
pub(crate) fn highest_uncut(setup: Setup, grid: Grid, ceiling: f64, resolution: f64) -> f64 {
    let groove = Groove::mill(setup, grid, ceiling, resolution);
    let per_pass = i32::try_from(grid.across).expect("a grid's size");
    let mut highest = 0.0_f64;
    for row in 0..per_pass {
        // The passes whose groove contains the row, from the furthest behind to the furthest ahead.
        let passes: Vec<&[f64]> = (-passes(setup)..passes(setup)).map(|ahead| groove.row(row + ahead * per_pass)).collect();
        for phase in 0..groove.along {
            for cell in 0..groove.along {
                let left = passes.iter().enumerate().map(|(pass, row)| row[(cell + pass * phase) % groove.along]);
                highest = highest.max(left.fold(f64::INFINITY, f64::min));
            }
        }
    }
    highest
}
