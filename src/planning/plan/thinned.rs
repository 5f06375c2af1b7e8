//! Lines in part: a stretch of a line is left out where the lines beside it suffice and the path becomes shorter in time.
//!
//! Lines are as close as the worst place between them asks, and along most of their length the others ask for less. Which
//! stretches are needed follows from what each place allows; what the path then leaves is milled, and stretches come back beside
//! each place that is worse than before.

use super::cut_lines::{Columns, CutLines};
use super::family::{Family, Heading, Spread};
use super::judged::Judged;
use super::milled_plan::{CHORD_SHARE, MilledPlan, NoPlan, Planner, WORSE};
use super::runs::{Run, RunTip, target_under};
use super::spacing::Prepared;
use super::stations::Station;
use super::tour::{Order, Tour};
use super::workpiece::Workpiece;
use crate::numerics::vector::mixed;
use rayon::prelude::*;

/// The width of a column, in which a line is cut or not, in radii of the cutter.
const COLUMN_IN_RADII: f64 = 0.5;

/// The share of the spacing that a place allows by its slope and curvature up to which lines beside it suffice.
const SURE: f64 = 0.95;

/// The shortest gaps that are left in lines, in radii of the cutter: shorter ones spare more, and ask for more runs and links. With
/// the last, runs only end earlier.
const SHORTEST_GAPS: [f64; 4] = [1.5, 3.0, 6.0, f64::INFINITY];

/// The one of them that tells how much a draft's lines spare in part.
const DRAFT_GAP: f64 = 3.0;

/// The share of the time of whole lines that lines in part may take to be worth their own.
const WORTHWHILE: f64 = 0.97;

/// The most runs that are also ordered by their ends, for which each is compared with all others.
const MOST_BY_ENDS: usize = 5_000;

/// The rounds in which stretches come back.
const MOST_ROUNDS: usize = 4;

/// The share of the area up to which what is worse than before is finished by further runs.
const FEW: f64 = 0.01;

/// A place is worse than before if more is left there than this many times its limit.
const WORSE_BY: f64 = 1.05;

impl Planner<'_> {
    /// The plan with its lines in part; `None` where that saves next to nothing, and for level curves.
    pub(super) fn thinned(&self, plan: &MilledPlan, stations: &[Station]) -> Result<Option<MilledPlan>, NoPlan> {
        let Family::Planes(heading) = plan.family else { return Ok(None) };
        let spread = Spread::new(self.workpiece, stations, self.prepared, &plan.family, self.settings.scallop_height.mm());
        let mut thinning = Thinning::new(heading, &plan.lines.at, &spread, self.prepared.profile.outer_radius());
        let Some(mut thinner) = self.fastest(&thinning, plan, &SHORTEST_GAPS) else { return Ok(None) };
        let limits = self.limits(plan, stations)?;
        for round in 1..=MOST_ROUNDS {
            let Thinner { gap, lines, runs, order, tour } = thinner;
            let in_part = self.judged_tour(stations, plan.family, lines, runs, order, tour)?;
            let worse = Worse::of(stations, &in_part.judged, &limits);
            if worse.share <= FEW || round == MOST_ROUNDS {
                let in_part = self.with_missed_places(stations, in_part, 0.0)?;
                if Worse::of(stations, &in_part.judged, &limits).share <= WORSE && is_worthwhile(&in_part.tour, plan) {
                    return Ok(Some(in_part));
                }
            }
            thinning.demand(&worse.places);
            if (self.stop)() {
                return Err(NoPlan::Stopped);
            }
            match self.fastest(&thinning, plan, &[gap]) {
                Some(next) => thinner = next,
                None => return Ok(None),
            }
        }
        Ok(None)
    }

    /// The share of a draft's time that its lines take in part, before stretches come back; 1 for level curves, and where that saves
    /// next to nothing. The spread is the draft's.
    pub(super) fn share_in_part(&self, draft: &MilledPlan, spread: &Spread) -> f64 {
        let Family::Planes(heading) = draft.family else { return 1.0 };
        let thinning = Thinning::new(heading, &draft.lines.at, spread, self.prepared.profile.outer_radius());
        let thinner = self.fastest(&thinning, draft, &[DRAFT_GAP]);
        thinner.map_or(1.0, |thinner| thinner.tour.figures.seconds / draft.tour.figures.seconds)
    }

    /// The lines in part with one of these gaps that take the least time; `None` if that is not worthwhile.
    fn fastest(&self, thinning: &Thinning<'_>, plan: &MilledPlan, gaps: &[f64]) -> Option<Thinner> {
        let Self { workpiece, prepared, settings, stop, .. } = *self;
        let chord_tolerance = CHORD_SHARE * settings.scallop_height.mm();
        let knife = Knife { workpiece, prepared, heading: thinning.columns.heading, chord_tolerance };
        let with_gaps = |&gap: &f64| (gap, thinning.lines(gap * prepared.profile.outer_radius()));
        let mut all: Vec<(f64, CutLines)> = gaps.iter().map(with_gaps).collect();
        all.dedup_by(|one, other| one.1 == other.1);
        let with_path = |(gap, lines): (f64, CutLines)| {
            let runs: Vec<Run> = plan.runs.par_iter().with_max_len(16).flat_map_iter(|run| knife.parts(run, &lines)).collect();
            let in_order = |order: Order| (order, Tour::of(workpiece, prepared, settings, &runs, order, chord_tolerance));
            let by_ends = (runs.len() <= MOST_BY_ENDS).then(|| in_order(Order::ByEnds));
            let (order, tour) = faster(in_order(Order::ByLines), by_ends, |(_, tour)| tour);
            Thinner { gap, lines, runs, order, tour }
        };
        let all = all.into_iter().take_while(|_| !stop()).map(with_path);
        let fastest = all.reduce(|best, other| faster(best, Some(other), |thinner| &thinner.tour));
        fastest.filter(|thinner| is_worthwhile(&thinner.tour, plan))
    }

    /// The height in mm up to which each station counts as no worse than in a plan.
    fn limits(&self, plan: &MilledPlan, stations: &[Station]) -> Result<Vec<f64>, NoPlan> {
        let height = self.settings.scallop_height.mm();
        let judged = self.judged(stations, &plan.family, &plan.tour.moves())?;
        Ok(stations.iter().zip(&judged).map(|(station, judged)| limit(judged.material(), station.lift, height)).collect())
    }
}

/// The greatest height in mm that is no worse than `left`, which a plan leaves: [`WORSE_BY`] times the greater of that and of the scallop
/// height, over the lift where the cutter cannot reach the place. Where it leaves a millimetre to a smaller cutter, micrometres more are
/// no reason for whole lines.
fn limit(left: f64, lift: f64, scallop_height: f64) -> f64 {
    let least = if lift > scallop_height { lift + scallop_height } else { scallop_height };
    WORSE_BY * left.max(least)
}

fn is_worthwhile(tour: &Tour, plan: &MilledPlan) -> bool {
    tour.figures.seconds <= WORTHWHILE * plan.tour.figures.seconds
}

/// The one whose path takes less time.
fn faster<T>(one: T, other: Option<T>, tour: impl Fn(&T) -> &Tour) -> T {
    match other {
        Some(other) if tour(&other).figures.seconds < tour(&one).figures.seconds => other,
        _ => one,
    }
}

/// Lines in part that leave out all gaps of at least `gap` radii of the cutter, and the path over them.
struct Thinner {
    gap: f64,
    lines: CutLines,
    runs: Vec<Run>,
    order: Order,
    tour: Tour,
}

/// The stations over their limits, and their share of the area.
struct Worse<'a> {
    places: Vec<&'a Station>,
    share: f64,
}

impl<'a> Worse<'a> {
    fn of(stations: &'a [Station], judged: &[Judged], limits: &[f64]) -> Self {
        let judged = judged.iter().zip(limits);
        let worse = stations.iter().zip(judged).filter(|(_, (judged, limit))| judged.material() > **limit);
        let places: Vec<&Station> = worse.map(|(station, _)| station).collect();
        let [area, of_worse] =
            [stations.iter().map(|station| station.place.area).sum(), places.iter().map(|station| station.place.area).sum::<f64>()];
        Self { places, share: if area > 0.0 { of_worse / area } else { 0.0 } }
    }
}

/// What cuts runs into parts.
struct Knife<'a> {
    workpiece: &'a Workpiece,
    prepared: &'a Prepared,
    heading: Heading,
    chord_tolerance: f64,
}

impl Knife<'_> {
    /// The parts of a run over the stretches of its line that are cut.
    fn parts(&self, run: &Run, lines: &CutLines) -> Vec<Run> {
        let Some(line) = run.line else { return vec![run.clone()] };
        let along = |tip: &RunTip| self.heading.of_point([tip.tip[0], tip.tip[1]])[0];
        let mut parts = Vec::new();
        for [from, to] in lines.stretches(line) {
            let mut tips: Vec<RunTip> = Vec::new();
            for (index, tip) in run.tips.iter().enumerate() {
                let at = along(tip);
                if let Some(before) = index.checked_sub(1).map(|before| &run.tips[before]) {
                    let start = along(before);
                    let ends = [from, to].into_iter().filter(|end| start < *end && *end < at);
                    tips.extend(ends.map(|end| self.tip_between(before, tip, (end - start) / (at - start))));
                }
                if (from..=to).contains(&at) {
                    tips.push(*tip);
                }
            }
            if tips.len() > 1 {
                parts.push(Run::along_curve(run.line, tips, false));
            }
        }
        parts
    }

    /// The tip at a share of the way from one tip to another.
    fn tip_between(&self, from: &RunTip, to: &RunTip, share: f64) -> RunTip {
        let tip = mixed(from.tip, to.tip, share);
        let axis = [tip[0], tip[1]];
        let touch = self.workpiece.drop.drop(&self.prepared.profile, axis[0], axis[1], None);
        let target = touch.as_ref().and_then(|touch| target_under(self.workpiece, self.prepared, axis, touch, self.chord_tolerance));
        RunTip { tip, target, contact: touch.map_or(to.contact, |touch| touch.contact.into()) }
    }
}

/// Which lines each column needs.
struct Thinning<'a> {
    lines: &'a [f64],
    columns: Columns,
    needs: Vec<Needs>,
}

/// What a column needs.
#[derive(Debug, Clone)]
struct Needs {
    /// Where its places and those of the columns beside it are across, and the spacing that each allows, in order.
    places: Vec<[f64; 2]>,
    /// The strips that need both of their lines, each by the line after it.
    strips: Vec<bool>,
}

impl<'a> Thinning<'a> {
    fn new(heading: Heading, lines: &'a [f64], spread: &Spread, radius: f64) -> Self {
        let columns = Columns::over(heading, spread.seen.iter().map(|seen| seen.along), COLUMN_IN_RADII * radius, lines.len());
        let mut needs = vec![Needs { places: Vec::new(), strips: vec![false; lines.len() + 1] }; columns.count];
        // The spread is in order across the lines.
        for seen in &spread.seen {
            for column in columns.around(columns.at(seen.along)) {
                needs[column].places.push([seen.across, SURE * seen.squared.sqrt()]);
            }
        }
        Self { lines, columns, needs }
    }

    /// From now on both lines beside these places are needed there.
    fn demand(&mut self, stations: &[&Station]) {
        for station in stations {
            let [along, across] = self.columns.heading.of_point(station.axis);
            let strip = self.lines.partition_point(|line| *line <= across);
            for column in self.columns.around(self.columns.at(along)) {
                self.needs[column].strips[strip] = true;
            }
        }
    }

    /// The lines where they are needed; gaps under `shortest` mm are cut too.
    fn lines(&self, shortest: f64) -> CutLines {
        let is_cut = self.needs.iter().map(|needs| needs.lines(self.lines)).collect();
        CutLines::in_part(self.lines.to_vec(), self.columns, is_cut, shortest)
    }
}

impl Needs {
    /// Whether each line is needed: from one needed line to the next, as many as possible are left out.
    fn lines(&self, lines: &[f64]) -> Vec<bool> {
        let mut needed = vec![false; lines.len()];
        let mut last: Option<usize> = None;
        // The places from the last needed line on.
        let mut places = &self.places[..];
        for line in 0..=lines.len() {
            // Without the line before this one, or before the border, everything since the last needed one has to suffice.
            let next = Some(line).filter(|line| *line < lines.len());
            let first = last.map_or(0, |last| last + 1);
            let between = &places[..next.map_or(places.len(), |next| places.partition_point(|[across, _]| *across < lines[next]))];
            let suffices = !self.strips[first..=line].contains(&true) && between.iter().all(|place| is_finished(place, last, next, lines));
            if line > first && !suffices {
                let needed_line = line - 1;
                needed[needed_line] = true;
                last = Some(needed_line);
                places = &places[places.partition_point(|[across, _]| *across < lines[needed_line])..];
            }
        }
        needed
    }
}

/// Whether two lines finish a place between them, or one a place beyond it.
fn is_finished([across, spacing]: &[f64; 2], before: Option<usize>, after: Option<usize>, lines: &[f64]) -> bool {
    match (before, after) {
        (Some(before), Some(after)) => lines[after] - lines[before] <= *spacing,
        (Some(line), None) | (None, Some(line)) => 2.0 * (lines[line] - across).abs() <= *spacing,
        (None, None) => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn needs(places: &[[f64; 2]], lines: usize, demanded: &[usize]) -> Needs {
        let mut places = places.to_vec();
        places.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
        Needs { places, strips: (0..=lines).map(|strip| demanded.contains(&strip)).collect() }
    }

    #[test]
    fn lines_are_left_out_where_all_places_between_the_others_allow_it() {
        let lines: Vec<f64> = (0..9).map(f64::from).collect();
        let needed = |places: &[[f64; 2]], demanded: &[usize]| -> Vec<usize> {
            let needed = needs(places, lines.len(), demanded).lines(&lines);
            (0..lines.len()).filter(|line| needed[*line]).collect()
        };
        let level: Vec<[f64; 2]> = (0..81).map(|place| [0.1 * f64::from(place), 4.0]).collect();
        // Half a spacing from the borders, and a spacing apart.
        assert_eq!(needed(&level, &[]), [2, 6]);
        // A place between the lines 4 and 5 that needs both, and a strip that does.
        let with_ridge = [&level[..], &[[4.5, 1.0]]].concat();
        assert_eq!(needed(&with_ridge, &[]), [2, 4, 5, 8]);
        assert_eq!(needed(&level, &[5]), [2, 4, 5, 8]);
        // Without places, without lines.
        assert_eq!(needed(&[], &[]), [0_usize; 0]);
    }

    #[test]
    fn a_place_is_worse_where_a_twentieth_more_is_left() {
        let [shallow, high, within_lift, beside_wall, never_cut] =
            [(0.004, 0.002), (0.03, 0.0), (0.5, 1.0), (1.2, 1.0), (f64::INFINITY, 3.0)].map(|(left, lift)| limit(left, lift, 0.01));
        for (limit, expected) in [(shallow, 0.0105), (high, 0.0315), (within_lift, 1.0605), (beside_wall, 1.26)] {
            assert!((limit - expected).abs() < 1e-12, "{limit} in place of {expected}");
        }
        assert!(never_cut.is_infinite());
    }

    proptest! {
        /// Where all lines finish all places, so do those that are needed.
        #[test]
        fn needed_lines_finish_all_places(
            places in proptest::collection::vec((0.0..20.0_f64, 1.0..9.0_f64), 0..40),
            demanded in proptest::collection::vec(0_usize..=20, 0..3),
        ) {
            let lines: Vec<f64> = (0..20).map(|line| f64::from(line) + 0.5).collect();
            let places: Vec<[f64; 2]> = places.into_iter().map(|(across, spacing)| [across, spacing]).collect();
            let needed = needs(&places, lines.len(), &demanded).lines(&lines);
            for place in &places {
                let next = lines.partition_point(|line| *line <= place[0]);
                let (before, after) = ((0..next).rev().find(|line| needed[*line]), (next..lines.len()).find(|line| needed[*line]));
                prop_assert!(is_finished(place, before, after, &lines), "{place:?} between {before:?} and {after:?}");
            }
            for strip in demanded {
                prop_assert!([strip.checked_sub(1), Some(strip)].into_iter().flatten().filter(|line| *line < 20).all(|line| needed[line]));
            }
        }
    }
}
