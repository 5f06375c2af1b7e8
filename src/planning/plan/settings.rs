//! The settings of a ranking, the same for all candidates: scallop height, machine, pattern and directions.

use crate::milling::{Cutter, Model};
use crate::motion::Machine;
use crate::quantity::{Angle, Length};
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
