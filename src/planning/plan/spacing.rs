//! The largest spacing of neighbouring planes at a slope and direction, for one cutter and scallop height; and a candidate with
//! its tables, which do not depend on the direction.

use super::settings::{CandidateCutter, FeedRange, PlanSettings};
use super::tangent::{SlopePlace, Tangent, sines};
use super::workpiece::Workpiece;
use crate::milling::{Contact, Cutter, CuttingLimits, EvaluatedPass, Model, NoAnswer, Pass, Profile, Runout, SurfaceCurvature};
use crate::quantity::Length;
use rayon::prelude::*;

/// The number of intervals between a table's columns, which lie at cos(alpha) = 0, 1/24, ... 1.
const COLUMNS: usize = 24;

/// The largest spacing of a cutter on planes, as a function of slope and direction, and the feed that belongs to it.
///
/// A ball-end cutter, and any cutter in model `analytic` without tooth marks, have closed forms. For others a table of
/// squared spacings is interpolated, linearly in cos^2(alpha) and 1/sin(S), in which the squares of circles' chords are
/// linear. The result is reduced by [`CutterSpacing::MARGIN`], which is more than the error of the interpolation.
#[derive(Debug, Clone)]
pub(super) struct CutterSpacing {
    profile: Profile,
    /// 8 h, which turns a squared spacing into a curvature.
    eight_heights: f64,
    /// The square of the largest spacing: the diameter, and in model `analytic` at most that of a floor.
    widest_squared: f64,
    /// Whether the curvature of the surface changes the spacing, as it does in model `envelope`.
    on_curved: bool,
    law: Law,
}

#[derive(Debug, Clone)]
enum Law {
    /// The chord of a circle of the effective radius, 2 sqrt(2 P h - h^2).
    Circle { height: f64 },
    /// The same step-over along the surface everywhere.
    Constant { squared: f64 },
    /// Squared spacings seen from above, row by row.
    Table { squared: Vec<f64> },
}

/// The feed as a function of the spacing.
#[derive(Debug, Clone)]
pub(super) enum FeedLaw {
    /// One feed rate everywhere, in mm/s: the machine's, for a cutter without a drive.
    Constant { rate: f64 },
    /// Feeds from a table.
    Table(FeedTable),
}

/// Feeds at the best step-over, and the gain of smaller step-overs.
#[derive(Debug, Clone)]
pub(super) struct FeedTable {
    range: FeedRange,
    /// The feed per tooth, and the squared ratio of the best step-over to the one without tooth marks, row by row.
    nodes: Vec<[f64; 2]>,
}

/// The data from which the spacings and feeds of a cutter are computed.
#[derive(Clone, Copy)]
pub(super) struct SpacingInputs<'a> {
    pub(super) cutter: Cutter,
    /// The scallop height to keep, of step-over and tooth marks together if there are `feeds`.
    pub(super) height: Length,
    pub(super) model: Model,
    /// The feeds of the cutter's drive; `None` without a drive.
    pub(super) feeds: Option<FeedRange>,
    /// The machine's feed rate, in mm/s.
    pub(super) feed_rate: f64,
    /// Whether a row of a table is needed.
    pub(super) is_needed: &'a (dyn Fn(usize) -> bool + Sync),
}

/// The best step-over and feed at one contact.
#[derive(Debug, Clone, Copy)]
struct Best {
    /// Along the surface, in mm.
    step_over: f64,
    feed_per_tooth: f64,
}

impl CutterSpacing {
    /// The share by which interpolated values are reduced. Over random cutters, slopes and directions, linear
    /// interpolation exceeds the model's spacing by at most 0.5 %. It falls short of it by up to 2 %, and by up to 10 %
    /// at slopes under 3 deg; the check of a plan corrects that.
    pub(super) const MARGIN: f64 = 0.006;

    /// The share by which interpolated values are reduced where they count tooth marks. There the interpolation exceeds the model's spacing by at most 1.1 %: the area per
    /// time is flat around its maximum, so that step-over and feed are found only to half a per cent.
    pub(super) const MARGIN_WITH_FEEDS: f64 = 0.014;

    /// The spacings and feeds of a cutter.
    pub(super) fn new(inputs: &SpacingInputs) -> (Self, FeedLaw) {
        let SpacingInputs { cutter, height, model, feeds, feed_rate, .. } = *inputs;
        let h = height.mm();
        // The diameter less a rounding error of single precision, so that passes still overlap.
        let diameter = 2.0 * cutter.outer_radius().mm() * (1.0 - 1e-6);
        let profile = cutter.profile();
        let is_ball = profile.arcs().len() == 1 && profile.arcs()[0].centre_offset == 0.0;
        let (law, feed_law) = match (is_ball, model, feeds) {
            (_, Model::Analytic, None) | (true, _, None) => (Law::Circle { height: h }, FeedLaw::Constant { rate: feed_rate }),
            (true, _, Some(range)) => {
                // A ball-end cutter leaves the same height at every slope and in every direction.
                let best = best_step_over(cutter, Contact::from_degrees(0.0, 0.0).ok(), model, height, Some(range.largest), diameter);
                let (step_over, feed) = best.map_or((0.0, range.largest), |best| (best.step_over, best.feed_per_tooth));
                (
                    Law::Constant { squared: step_over * step_over },
                    FeedLaw::Table(FeedTable { range, nodes: vec![[feed, share(step_over, cutter, h)]] }),
                )
            }
            _ => tabulated(inputs),
        };
        let on_curved = model == Model::Envelope;
        // Near a floor, where the circle is wider than the cutter, the published bound holds.
        let widest = if on_curved { diameter } else { diameter.min(cutter.step_over_on_floor(height).mm()) };
        (Self { profile, eight_heights: 8.0 * h, widest_squared: widest * widest, on_curved, law }, feed_law)
    }

    /// The squared spacing of vertical planes that a facet allows, seen from above, in mm^2; 0 if no spacing keeps the
    /// scallop height.
    #[inline]
    pub(super) fn squared(&self, tangent: &Tangent, cos_alpha: f64, sin_alpha: f64) -> f64 {
        let ratio_squared = tangent.ratio_squared(cos_alpha);
        let on_plane = match &self.law {
            Law::Constant { squared } => squared * ratio_squared,
            Law::Circle { height } => {
                let arc = self.profile.arc_at(tangent.slope);
                let (core, corner) = (arc.centre_offset, arc.radius);
                // R_eff = core cos^2(omega) / sin(S) + r with cos^2(omega) = cos^2(alpha) / ratio^2; infinite on a
                // floor.
                let bent = core * cos_alpha * cos_alpha / (tangent.sin * ratio_squared);
                let radius = if core == 0.0 { corner } else { bent + corner };
                if radius.is_nan() || radius > 1e12 {
                    self.widest_squared
                } else if radius >= *height {
                    4.0 * height * (2.0 * radius - height) * ratio_squared
                } else {
                    4.0 * radius * radius * ratio_squared
                }
            }
            Law::Table { squared } => interpolated(squared, tangent.place, cos_alpha),
        };
        let squared = if self.on_curved { self.on_curved_surface(on_plane, tangent, cos_alpha, sin_alpha) } else { on_plane };
        squared.min(self.widest_squared)
    }

    /// The squared spacing on the curved surface, computed from that on a plane. The relative curvature across the feed
    /// grows by the difference of the Schur complements, k_c - k_p. So 8 h / d^2 grows by this difference divided by
    /// the squared ratio of d to s.
    ///
    /// If the second order has no answer because the cutter gouges, the plane's spacing is kept: a hollow can only
    /// widen it.
    fn on_curved_surface(&self, on_plane: f64, tangent: &Tangent, cos_alpha: f64, sin_alpha: f64) -> f64 {
        let [steepest, twist, level] = tangent.curvature;
        if steepest == 0.0 && twist == 0.0 && level == 0.0 {
            return on_plane;
        }
        let arc = self.profile.arc_at(tangent.slope);
        let (core, corner) = (arc.centre_offset, arc.radius);
        // n/q = 1/((R - r)/sin(S) + r), the body's curvature along the level line; 1/r for a ball at every slope. All
        // quadratic forms are multiplied by q, so that a single division is needed.
        let (n, q) = if core == 0.0 { (1.0, corner) } else { (tangent.sin, core + corner * tangent.sin) };
        // Twice the quadratic forms of the body, and of body and surface, along the feed, multiplied by r q. The feed's
        // direction in the tangent plane is (cos(alpha)/cos(S), sin(alpha)); its squared length cancels with the ratio
        // of d to s, except for cos^2(S).
        let up = cos_alpha * tangent.per_cos;
        let body = up * up * q + corner * n * sin_alpha * sin_alpha;
        let both = body + corner * q * (steepest * up * up + 2.0 * twist * up * sin_alpha + level * sin_alpha * sin_alpha);
        let determinant = (1.0 + corner * steepest) * (n + level * q) - corner * twist * twist * q;
        if !(determinant > 0.0 && both > 0.0 && body > 0.0) {
            return on_plane;
        }
        // 8 h / (8 h / d^2 + determinant/both - n/body), the change divided by cos^2(S); numerator and denominator are
        // multiplied by d^2 both body.
        let (heights, product) = (self.eight_heights, both * body);
        let squared_per_cos = tangent.per_cos * tangent.per_cos;
        let rise = (determinant * body - n * both) * squared_per_cos;
        // Where a sharp corner runs along level lines the second order has far narrower spacings than the corner leaves: there the
        // curvature changes the spacing by the share by which it changes that of the second order.
        let of_second_order = heights * body / (n * squared_per_cos);
        let curvature = heights * product + rise * on_plane.min(of_second_order);
        if curvature > 0.0 { heights * on_plane * product / curvature } else { self.widest_squared }
    }
}

impl FeedLaw {
    /// The feed rate in mm/s on a facet, if the plan's squared spacing is the share `taken_of_allowed` of the squared
    /// spacing that the facet allows.
    ///
    /// The height of step-over and tooth marks together is approximated by a sum of squares, h (s/s0)^2 + b f^2, with s0
    /// the step-over without marks. The feed uses the part of h that s leaves.
    pub(super) fn rate(&self, tangent: &Tangent, cos_alpha: f64, taken_of_allowed: f64) -> f64 {
        match self {
            Self::Constant { rate } => *rate,
            Self::Table(table) => table.rate(tangent, cos_alpha, taken_of_allowed),
        }
    }
}

impl FeedLaw {
    /// The part of the scallop height that the step-over leaves; tooth marks leave the rest.
    pub(super) fn step_over_share(&self, tangent: &Tangent, cos_alpha: f64) -> f64 {
        match self {
            Self::Constant { .. } => 1.0,
            Self::Table(table) => table.node(tangent, cos_alpha)[1],
        }
    }
}

impl FeedTable {
    /// The feed per tooth at the best step-over, and the share of the scallop height that this step-over leaves.
    fn node(&self, tangent: &Tangent, cos_alpha: f64) -> [f64; 2] {
        if self.nodes.len() == 1 { self.nodes[0] } else { interpolated_pair(&self.nodes, tangent.place, cos_alpha) }
    }

    fn rate(&self, tangent: &Tangent, cos_alpha: f64, taken_of_allowed: f64) -> f64 {
        let [feed, share] = self.node(tangent, cos_alpha);
        let gain = ((1.0 - share * taken_of_allowed.min(1.0)) / (1.0 - share)).sqrt();
        self.range.rate((feed * gain).min(self.range.largest))
    }
}

/// The tables of spacings and feeds for the rows that are needed.
fn tabulated(inputs: &SpacingInputs) -> (Law, FeedLaw) {
    let SpacingInputs { cutter, height, model, feeds, feed_rate, is_needed } = *inputs;
    let diameter = 2.0 * cutter.outer_radius().mm();
    // What is steeper than the cone at its end touches the edge above it, which is as sharp as a flat end's.
    let (steepest, edge) = (cutter.profile().steepest_cut().to_degrees(), Cutter::flat_end(Length::computed(diameter)));
    let limit = feeds.map(|range| range.largest);
    let row_of = |(row, &sin): (usize, &f64)| -> Vec<([f64; 2], f64)> {
        // A contact on a wall has no alpha, so the last row is slightly less steep.
        let slope = sin.asin().to_degrees().min(89.9);
        let cutter = if slope > steepest { edge } else { cutter };
        let node = |column: usize| {
            #[expect(clippy::cast_precision_loss, reason = "under 25")]
            let alpha = (column as f64 / COLUMNS as f64).acos().to_degrees();
            let contact = Contact::from_degrees(slope, alpha).ok();
            let ratio = contact.map_or(1.0, Contact::spacing_ratio);
            let best = best_step_over(cutter, contact, model, height, limit, diameter / ratio);
            let Some(best) = best else { return ([limit.unwrap_or(0.0), 0.0], 0.0) };
            let seen_from_above = best.step_over * ratio;
            let share = if limit.is_some() {
                let alone =
                    best_step_over(cutter, contact, model, height, None, diameter / ratio).map_or(f64::INFINITY, |best| best.step_over);
                (best.step_over / alone).powi(2).min(0.999)
            } else {
                0.0
            };
            ([best.feed_per_tooth, share], seen_from_above * seen_from_above)
        };
        if is_needed(row) { (0..=COLUMNS).map(node).collect() } else { vec![([limit.unwrap_or(0.0), 0.0], 0.0); COLUMNS + 1] }
    };
    let nodes: Vec<([f64; 2], f64)> = sines().par_iter().enumerate().flat_map_iter(row_of).collect();
    let kept = 1.0 - if feeds.is_some() { CutterSpacing::MARGIN_WITH_FEEDS } else { CutterSpacing::MARGIN };
    let squared = nodes.iter().map(|&(_, squared)| kept * kept * squared).collect();
    let feed_law = match feeds {
        None => FeedLaw::Constant { rate: feed_rate },
        Some(range) => FeedLaw::Table(FeedTable { range, nodes: nodes.into_iter().map(|(pair, _)| pair).collect() }),
    };
    (Law::Table { squared }, feed_law)
}

/// The squared ratio of a ball-end cutter's step-over to the one without tooth marks, 2 sqrt(2 R h - h^2).
fn share(step_over: f64, ball: Cutter, height: f64) -> f64 {
    let squared = 4.0 * height * (2.0 * ball.outer_radius().mm() - height);
    if squared > 0.0 { (step_over * step_over / squared).min(0.999) } else { 0.0 }
}

/// The step-over, at most `widest`, and feed that finish the most area per time within the scallop height. With a
/// largest feed, that is the maximum of s f_z; without tooth marks, the largest step-over. `None` if the model has no
/// step-over.
fn best_step_over(
    cutter: Cutter,
    contact: Option<Contact>,
    model: Model,
    height: Length,
    largest_feed: Option<f64>,
    widest: f64,
) -> Option<Best> {
    let pass = Pass { cutter, contact: contact?, surface: SurfaceCurvature::PLANE, runout: Runout::NONE, teeth: None };
    let widest = widest.min(Length::LARGEST);
    let evaluated = match EvaluatedPass::new(model, pass) {
        Ok(evaluated) => evaluated,
        // The circle's radius is infinite: only the cutter's width limits the step-over.
        Err(NoAnswer::FlatFloor) => return Some(Best { step_over: widest, feed_per_tooth: largest_feed.unwrap_or(0.0) }),
        Err(_) => return None,
    };
    let step_over = |feed: Option<f64>| match evaluated.max_step_over(height, feed.map(Length::computed)) {
        Ok(step_over) => step_over.mm().min(widest),
        Err(NoAnswer::ToleranceLimitsNoStepOver { largest_step_over }) => largest_step_over.mm().min(widest),
        Err(_) => 0.0,
    };
    let Some(largest) = largest_feed else {
        let step_over = step_over(None);
        return (step_over > 0.0).then_some(Best { step_over, feed_per_tooth: 0.0 });
    };
    let at = |feed: f64| Best { step_over: step_over(Some(feed)), feed_per_tooth: feed };
    let rate = |best: &Best| best.step_over * best.feed_per_tooth;
    let at_largest = at(largest);
    if rate(&at_largest) > 0.0 && rate(&at_largest) >= rate(&at(0.97 * largest)) {
        return Some(at_largest);
    }
    // A smaller feed may allow a step-over that more than makes up for it, so the best pair is searched.
    let limits = CuttingLimits::new(Some(Length::computed(largest)), None, Some(Length::computed(widest))).ok()?;
    let best = evaluated.fastest(height, &limits).ok()?;
    Some(Best { step_over: best.step_over.mm(), feed_per_tooth: best.feed_per_tooth.mm() })
}

/// The columns on both sides of cos(alpha) and the weight of the second.
fn column_of(cos_alpha: f64) -> (usize, f64) {
    #[expect(clippy::cast_precision_loss, reason = "24")]
    let columns = COLUMNS as f64;
    let at = cos_alpha.abs() * columns;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 24")]
    let column = (at as u32 as usize).min(COLUMNS - 1);
    #[expect(clippy::cast_precision_loss, reason = "under 24")]
    let low = column as f64;
    (column, ((at * at - low * low) / (2.0 * low + 1.0)).min(1.0))
}

fn interpolated(nodes: &[f64], place: SlopePlace, cos_alpha: f64) -> f64 {
    let (column, weight) = column_of(cos_alpha);
    let row = |row: usize| {
        let at = row * (COLUMNS + 1) + column;
        nodes[at] + weight * (nodes[at + 1] - nodes[at])
    };
    let (low, high) = (row(place.row as usize), row(place.row as usize + 1));
    low + place.weight * (high - low)
}

fn interpolated_pair(nodes: &[[f64; 2]], place: SlopePlace, cos_alpha: f64) -> [f64; 2] {
    let (column, weight) = column_of(cos_alpha);
    [0, 1].map(|of| {
        let row = |row: usize| {
            let at = row * (COLUMNS + 1) + column;
            nodes[at][of] + weight * (nodes[at + 1][of] - nodes[at][of])
        };
        let (low, high) = (row(place.row as usize), row(place.row as usize + 1));
        low + place.weight * (high - low)
    })
}

/// A candidate with its spacings and feeds.
#[derive(Debug, Clone)]
pub(super) struct Prepared {
    pub(super) index: usize,
    pub(super) candidate: CandidateCutter,
    pub(super) profile: Profile,
    pub(super) spacing: CutterSpacing,
    pub(super) feeds: FeedLaw,
    pub(super) range: Option<FeedRange>,
    /// The feed rate of links on the surface and of plunges, in mm/s.
    pub(super) link_rate: f64,
}

impl Prepared {
    /// The candidate with spacings at the rows of slopes that `rows` marks. Once `stop` returns true, it ends early
    /// with spacings that must be discarded.
    pub(super) fn new(
        index: usize,
        candidate: &CandidateCutter,
        settings: &PlanSettings,
        rows: &[bool],
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Self {
        let feed_rate = settings.machine.limits.feed_rate.mm_s();
        let range = candidate.drive.map(|drive| FeedRange::of(drive, &settings.machine));
        let (spacing, feeds) = CutterSpacing::new(&SpacingInputs {
            cutter: candidate.cutter,
            height: settings.scallop_height,
            model: settings.model,
            feeds: range,
            feed_rate,
            is_needed: &|row| rows[row] && !stop(),
        });
        let link_rate = range.map_or(feed_rate, |range| range.rate(range.largest));
        Self { index, candidate: *candidate, profile: candidate.cutter.profile(), spacing, feeds, range, link_rate }
    }
}

/// For each row of the tables, whether a slope of the workpiece needs it.
pub(super) fn rows_of(workpiece: &Workpiece) -> Vec<bool> {
    let mut rows = vec![false; sines().len()];
    for tangent in &workpiece.tangents {
        let row = tangent.place.row as usize;
        rows[row] = true;
        rows[row + 1] = true;
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planning::plan::tangent::place_of;

    /// Pseudo-random numbers, the same in each run.
    fn random(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        f64::from(u32::try_from(*state >> 33).unwrap()) / f64::from(1_u32 << 31)
    }

    fn tangent(slope: f64) -> Tangent {
        let (sin, cos) = slope.to_radians().sin_cos();
        Tangent {
            down_hill: [1.0, 0.0],
            slope: slope.to_radians(),
            sin,
            cos,
            per_cos: cos.recip(),
            curvature: [0.0; 3],
            place: place_of(sin),
        }
    }

    /// The least and the largest ratio of the interpolated spacing to the model's, for random cutters, heights, slopes
    /// and directions.
    fn compared(model: Model, feeds: Option<FeedRange>, slopes: impl Fn(f64) -> f64) -> [f64; 2] {
        let mut state = 7;
        let mut range = [f64::INFINITY, 0.0_f64];
        for _ in 0..10 {
            let diameter = 2.0 + 14.0 * random(&mut state);
            let corner = (0.02 + 0.9 * random(&mut state)) * diameter / 2.0;
            let cutter = Cutter::toroidal(Length::computed(diameter), Length::computed(corner)).unwrap();
            let height = Length::computed(0.002 * 15.0_f64.powf(random(&mut state)));
            let (spacing, _) = CutterSpacing::new(&SpacingInputs { cutter, height, model, feeds, feed_rate: 80.0, is_needed: &|_| true });
            for _ in 0..100 {
                let (slope, alpha) = (slopes(random(&mut state)), 90.0 * random(&mut state));
                let contact = Contact::from_degrees(slope, alpha).unwrap();
                let limit = feeds.map(|feeds| feeds.largest);
                let best = best_step_over(cutter, Some(contact), model, height, limit, diameter / contact.spacing_ratio()).unwrap();
                let exact = best.step_over * contact.spacing_ratio();
                let (sin, cos) = alpha.to_radians().sin_cos();
                let on_floor = if model == Model::Analytic { cutter.step_over_on_floor(height).mm() } else { diameter };
                let ratio = spacing.squared(&tangent(slope), cos, sin).sqrt() / exact.min(diameter).min(on_floor);
                range = [range[0].min(ratio), range[1].max(ratio)];
            }
        }
        println!("{model:?} {feeds:?}: {range:?}");
        range
    }

    #[test]
    fn the_circles_closed_form_is_that_of_the_model() {
        let [least, most] = compared(Model::Analytic, None, |unit| 85.0 * unit);
        // The square root of a squared cosine has an error of some units of 2e-16, which ratios of 100 enlarge.
        approx::assert_relative_eq!(least, 1.0, max_relative = 1e-9);
        approx::assert_relative_eq!(most, 1.0, max_relative = 1e-9);
    }

    #[test]
    fn tables_never_exceed_the_envelope_and_stay_near_it() {
        let feeds = Some(FeedRange { largest: 0.1, teeth_per_second: 300.0 });
        for feeds in [None, feeds] {
            let [least, most] = compared(Model::Envelope, feeds, |unit| 3.0 + 82.0 * unit);
            assert!(most <= 1.0 && least > 0.96, "{least} {most}");
            // Near the floor, the flat takes over from the corner in making the groove.
            let [least, most] = compared(Model::Envelope, feeds, |unit| 0.01 * 300.0_f64.powf(unit));
            assert!(most <= 1.0 && least > 0.88, "{least} {most}");
        }
    }

    #[test]
    fn a_ball_on_a_curved_facet_has_the_step_over_of_the_envelope_level_ones_included() {
        let height = Length::computed(0.01);
        let ball = Cutter::ball_end(Length::computed(8.0));
        let model = Model::Envelope;
        let inputs = SpacingInputs { cutter: ball, height, model, feeds: None, feed_rate: 80.0, is_needed: &|_| true };
        let (spacing, _) = CutterSpacing::new(&inputs);
        for slope in [0.0, 1e-6, 2.0, 30.0] {
            for level in [0.0, 1.0 / 20.0, -1.0 / 20.0, 1.0 / 100.0] {
                let tangent = Tangent { curvature: [0.01, 0.0, level], ..tangent(slope) };
                let found = spacing.squared(&tangent, 1.0, 0.0).sqrt();
                let surface = SurfaceCurvature::from_components_per_mm(0.01, level, 0.0).unwrap();
                let contact = Contact::from_degrees(slope, 0.0).unwrap();
                let pass = Pass { cutter: ball, contact, surface, runout: Runout::NONE, teeth: None };
                let step_over = EvaluatedPass::new(model, pass).unwrap().max_step_over(height, None).unwrap();
                // The spacing is of the second order: h/(2 R) = 0.1 %, and the turning of the marks' normals.
                approx::assert_relative_eq!(found, step_over.mm() * contact.spacing_ratio(), max_relative = 0.005);
            }
        }
    }
}
