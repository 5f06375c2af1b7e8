//! What a ranking is asked: scallop height, machine, pattern and directions, the same for all candidates; and the candidate
//! cutters with their drives (teeth, spindle speed, feed limit).

use crate::milling::{Cutter, Model};
use crate::motion::Machine;
use crate::quantity::{Angle, Length, SpindleSpeed};
use crate::surface::Shape;

/// The pattern of passes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Pattern {
    /// Passes alternate in direction.
    #[default]
    Zigzag,
    /// All passes have the same direction; the cutter returns at the rapid rate at the clearance height.
    OneWay,
}

/// The settings of a ranking.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanSettings {
    /// The scallop height to keep: of step-over and tooth marks together for cutters with a drive, of the step-over
    /// alone for others.
    pub scallop_height: Length,
    /// The machine.
    pub machine: Machine,
    /// The pattern of the passes.
    pub pattern: Pattern,
    /// The model by which passes are spaced.
    pub model: Model,
    /// The slope up to which facets set spacings. Steeper facets set none and count as steep.
    pub max_slope: Angle,
    /// The directions of passes.
    pub directions: Directions,
    /// The share of a strip's area that may allow less than the strip's spacing, so that a single bad facet does not
    /// determine the spacing.
    pub left_out_share: f64,
    /// The largest share of the area that a ranked cutter may leave uncut.
    pub max_uncut_share: f64,
    /// A cutter that has machined everything before: only what it could not reach is machined. `None` for everything.
    pub rest_of: Option<Cutter>,
    /// The most operations of a plan.
    pub most_operations: usize,
    /// The shape of the surface, for the comparison with the published method; `None` omits the comparison.
    pub shape: Option<Shape>,
}

impl PlanSettings {
    /// Zigzag in all directions, spaced by model `envelope`, with the usual limits: slopes up to 85 deg, a thousandth
    /// of each strip left out, half a per cent of the area uncut, one operation.
    #[must_use]
    pub fn new(scallop_height: Length, machine: Machine) -> Self {
        Self {
            scallop_height,
            machine,
            pattern: Pattern::Zigzag,
            model: Model::Envelope,
            max_slope: Angle::from_radians(85.0_f64.to_radians()),
            directions: Directions::All { beside: Vec::new() },
            left_out_share: 0.001,
            max_uncut_share: 0.005,
            rest_of: None,
            most_operations: 1,
            shape: None,
        }
    }
}

/// The directions that are simulated.
#[derive(Debug, Clone, PartialEq)]
pub enum Directions {
    /// Every 5 deg and the directions in `beside`; then around the best, in steps down to 0.5 deg.
    All {
        /// Further directions, such as the principal and the steepest one.
        beside: Vec<Angle>,
    },
    /// Only these directions.
    Only(Vec<Angle>),
}

/// A candidate of the ranking.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CandidateCutter {
    /// The cutter.
    pub cutter: Cutter,
    /// Teeth and spindle speed; `None` if they are not stated. The scallop height is then that of the step-over alone,
    /// and the cutter runs at the machine's feed rate.
    pub drive: Option<Drive>,
    /// The length of the flutes.
    pub flute_length: Option<Length>,
}

impl CandidateCutter {
    /// A cutter without drive and flute length.
    #[must_use]
    pub fn new(cutter: Cutter) -> Self {
        Self { cutter, drive: None, flute_length: None }
    }
}

/// The drive of a cutter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive {
    /// z, the number of teeth, at least 1.
    pub teeth: u32,
    /// n, the spindle speed; the machine may limit it.
    pub spindle_speed: SpindleSpeed,
    /// The cutter maker's limit on the feed per tooth.
    pub max_feed_per_tooth: Option<Length>,
}

/// The feeds that a drive allows on a machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::planning) struct FeedRange {
    /// The largest feed per tooth, in mm: the cutter maker's limit or the machine's feed rate over the teeth per
    /// second, the lower one.
    pub(in crate::planning) largest: f64,
    /// z n, the teeth that pass in a second.
    pub(in crate::planning) teeth_per_second: f64,
}

impl FeedRange {
    pub(in crate::planning) fn of(drive: Drive, machine: &Machine) -> Self {
        let rpm = machine.max_spindle_speed.map_or(drive.spindle_speed.rpm(), |limit| drive.spindle_speed.rpm().min(limit.rpm()));
        let teeth_per_second = f64::from(drive.teeth.max(1)) * rpm / 60.0;
        let by_machine = machine.limits.feed_rate.mm_s() / teeth_per_second;
        let largest = drive.max_feed_per_tooth.map_or(by_machine, |limit| limit.mm().min(by_machine));
        Self { largest: largest.clamp(Length::SMALLEST, Length::LARGEST), teeth_per_second }
    }

    /// The feed rate of a feed per tooth, in mm/s.
    pub(in crate::planning) fn rate(&self, feed_per_tooth: f64) -> f64 {
        feed_per_tooth * self.teeth_per_second
    }
}
