//! The parameters of a recommendation, without the surface: cutters, scallop height, machine, and settings of the plan.

mod unused;

use super::library::Libraries;
use super::operations_members::{OperationsKind, RestOfKind};
use super::program::{ProgramOptions, ProgramOptionsKind};
use crate::http::codes::RequestFault;
use crate::http::reading::{Choice, Faulted, Faults, JsonPath, List, Members, Object, Quantity, Renamed, members};
use crate::http::wire::{
    CandidateKind, LibraryFilter, LibraryFilterKind, MACHINE, MOST_CUTTERS, MachineKind, NamedCandidate, PLAN_MODEL, ROUGHNESS,
    RoughnessKind, SCALLOP_HEIGHT, SelectKind, StatedSurface, SurfaceWithSource, UNIT, Warning, plan_tolerance,
};
use crate::milling::{Cutter, Model};
use crate::motion;
use crate::planning::plan::{Directions, Pattern, PlanSettings};
use crate::quantity::{Angle, Length, OutOfRange};
use crate::surface::mesh::Selection;
use crate::surface::{Facing, Shape, Unit};
use crate::tooling::FaultyTool;
use serde::Serialize;
use unused::{unused_drives, unused_members};
use utoipa::ToSchema;

pub(super) use unused::{unused, unused_on_rectangle};

// The member `method` describes the two.
/// The method of planning.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = MethodUsed)]
pub(super) enum Method {
    #[default]
    Surface,
    Rectangle,
}

/// The optional parts of an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum AnswerPart {
    Map,
    Maps,
    Passes,
    Program,
}

/// The direction of a line, which repeats after half a turn.
fn direction(degrees: f64) -> Result<Angle, OutOfRange> {
    Angle::from_degrees(OutOfRange::check(degrees, -360.0, 360.0)?.rem_euclid(180.0))
}

fn share(value: f64) -> Result<f64, OutOfRange> {
    OutOfRange::check(value, 0.0, 1.0)
}

/// The default of the largest slope, in deg.
pub(super) const DEFAULT_MAX_SLOPE: f64 = 85.0;

members! {
    /// The parameters besides the surface.
    pub(super) struct ParameterMembers {
        cutters: optional CUTTERS: List<CandidateKind> = ("cutters", List { item: CandidateKind, about_item: "", fewest: 1, most: MOST_CUTTERS },
            "the cutters to choose from, in any mix of kinds; answers refer to each by its position"),
        roughness: optional ROUGHNESS: RoughnessKind,
        tolerance: optional TOLERANCE: Quantity<Length> = ("scallop_tolerance_mm", Quantity::length(0.01),
            "the scallop height that must not be exceeded: by step-over and tooth marks for cutters with teeth and spindle speed, by the step-over alone for others"),
        scallop_height: optional SCALLOP_HEIGHT: Renamed<Length>,
        machine: required MACHINE: MachineKind,
        pattern: optional PATTERN: Choice<Pattern> = ("pattern", Choice { name: Some("Pattern"), words: &[("zigzag", Pattern::Zigzag), ("one_way", Pattern::OneWay)] },
            "zigzag (default): passes alternate in direction; one_way: all passes have the same direction, and the cutter returns at the rapid rate at the clearance height"),
        library_filter: optional LIBRARY_FILTER: LibraryFilterKind = ("library_filter", LibraryFilterKind,
            "which cutters of tool libraries join cutters; absent = all"),
        max_slope: optional MAX_SLOPE: Quantity<Angle> = ("max_slope_deg", Quantity::slope(DEFAULT_MAX_SLOPE),
            "the largest slope of facets that limit the step-over; steeper facets count as steep; absent = 85"),
        method: optional METHOD: Choice<Method> = ("method", Choice { name: Some("Method"), words: &[("surface", Method::Surface), ("rectangle", Method::Rectangle)] },
            "surface (default): zigzag passes simulated on the surface; rectangle: the published method, by an inclined rectangle equivalent to the surface"),
        model: optional PLAN_MODEL: Choice<Model>,
        directions: optional DIRECTIONS: List<Quantity<Angle>> = ("directions_deg",
            List { item: Quantity::new(direction, 90.0), about_item: "a direction from +X, counter-clockwise", fewest: 1, most: 360 },
            "the directions of passes to try, in method surface; absent = all"),
        unit: optional UNIT: Choice<Unit>,
        facing: optional FACING: Choice<Facing> = ("facing", Choice { name: Some("Facing"), words: &[("up", Facing::Up), ("any", Facing::Any)] },
            "which facets determine the shape: up (default), those whose normal points up; any, all of them; no effect on points and patches"),
        max_uncut_share: optional MAX_UNCUT_SHARE: Quantity<f64> = ("max_uncut_share", Quantity::new(share, 0.005),
            "the largest share of the area that a ranked cutter may leave uncut; absent = 0.005"),
        select: optional SELECT: SelectKind = ("select", SelectKind,
            "only facets that meet all stated conditions are machined; the cutter must not gouge the others, which still hide what is below them"),
        avoid: optional AVOID: StatedSurface = ("avoid", StatedSurface,
            "a second surface, in the same unit and position: never machined and never cut, such as the walls beside the faces to finish"),
        include: optional INCLUDE: List<Choice<AnswerPart>> = ("include",
            List { item: Choice { name: None, words: &[("map", AnswerPart::Map), ("maps", AnswerPart::Maps), ("passes", AnswerPart::Passes), ("program", AnswerPart::Program)] }, about_item: "a part of the answer", fewest: 0, most: 4 },
            "optional parts of the answer, in method surface: map, a raster for drawing; maps, it and where every other cutter does not fit, ranked or not; passes, the recommended plan point by point; program, the same as G-code"),
        operations: optional OPERATIONS: OperationsKind = ("operations", OperationsKind, "how many operations a plan may have; absent = one"),
        rest_of: optional REST_OF: RestOfKind = ("rest_of", RestOfKind, "a cutter that has machined everything before, in method surface: only what it could not reach is machined, and all figures are over that"),
        program: optional PROGRAM: ProgramOptionsKind = ("program", ProgramOptionsKind, "how the program of include is written"),
    }
}

/// The parameters besides the surface.
#[derive(Debug)]
pub(super) struct Parameters {
    pub(super) candidates: Vec<NamedCandidate>,
    /// The finishing cutters of the libraries that cannot be used. Their positions follow those of the candidates.
    pub(super) faulty_tools: Vec<FaultyTool>,
    pub(super) scallop_height: Length,
    pub(super) machine: motion::Machine,
    pub(super) pattern: Pattern,
    pub(super) max_slope: Angle,
    pub(super) method: Method,
    model: Option<Model>,
    pub(super) directions: Option<Vec<Angle>>,
    pub(super) unit: Option<Unit>,
    pub(super) facing: Facing,
    pub(super) max_uncut_share: Option<f64>,
    pub(super) selection: Selection,
    pub(super) avoid: Option<SurfaceWithSource>,
    pub(super) include: Vec<AnswerPart>,
    pub(super) most_operations: usize,
    pub(super) rest_of: Option<Cutter>,
    pub(super) program: ProgramOptions,
    /// The members that have no effect.
    pub(super) unused: Vec<Warning>,
    /// Whether the request states `facing`, and `select` or `max_slope_deg`, which have no effect without facets.
    pub(super) states_facing: bool,
    pub(super) states_facets: bool,
}

impl Parameters {
    /// Reads the parameters from `object`, which may also have the surface. The cutters of tool libraries follow those
    /// of the request.
    pub(super) fn read(object: &mut Object<'_, '_>, libraries: Libraries, faults: &mut Faults) -> Result<Self, Faulted> {
        let checked = libraries.check(faults);
        let members = ParameterMembers::read(object, faults);
        let path = object.path();
        let mut unused = unused_members(&members, &libraries);
        let states_facing = matches!(members.facing, Ok(Some(_)));
        let states_facets = matches!(members.select, Ok(Some(_))) || matches!(members.max_slope, Ok(Some(_)));
        let tolerance = plan_tolerance(members.tolerance, members.scallop_height, members.roughness, &TOLERANCE, &path, faults);
        let filter = members.library_filter.map(Option::unwrap_or_default);
        let candidates = members.cutters.and_then(|own| {
            // All cutters may have been in a refused library.
            checked?;
            all_candidates(own.unwrap_or_default(), libraries, &filter?, &path, faults)
        });
        let (candidates, faulty_tools) = candidates?;
        let machine = members.machine?;
        unused.extend(unused_drives(&candidates, &machine));
        Ok(Self {
            candidates,
            faulty_tools,
            scallop_height: tolerance?.height,
            machine,
            pattern: members.pattern?.unwrap_or_default(),
            max_slope: members.max_slope?.unwrap_or_else(|| Angle::from_radians(DEFAULT_MAX_SLOPE.to_radians())),
            method: members.method?.unwrap_or_default(),
            model: members.model?,
            directions: members.directions?,
            unit: members.unit?,
            facing: members.facing?.unwrap_or_default(),
            max_uncut_share: members.max_uncut_share?,
            selection: members.select?.unwrap_or_default(),
            avoid: members.avoid?,
            include: members.include?.unwrap_or_default(),
            rest_of: members.rest_of?,
            most_operations: members.operations?.unwrap_or(1),
            program: members.program?.unwrap_or_default(),
            unused,
            states_facing,
            states_facets,
        })
    }

    /// The model of the plan. The default is `envelope` for method `surface`, and the published `analytic` for method
    /// `rectangle`.
    pub(super) fn model(&self) -> Model {
        self.model.unwrap_or(match self.method {
            Method::Surface => Model::Envelope,
            Method::Rectangle => Model::Analytic,
        })
    }

    pub(super) fn includes(&self, part: AnswerPart) -> bool {
        self.include.contains(&part)
    }

    /// The settings of the simulation on a surface of this shape.
    pub(super) fn settings(&self, shape: &Shape, model: Model) -> PlanSettings {
        let usual = PlanSettings::new(self.scallop_height, self.machine);
        let beside = [shape.principal_direction, shape.steepest_direction].into_iter().flatten().collect();
        PlanSettings {
            pattern: self.pattern,
            model,
            max_slope: self.max_slope,
            directions: self.directions.clone().map_or(Directions::All { beside }, Directions::Only),
            max_uncut_share: self.max_uncut_share.unwrap_or(usual.max_uncut_share),
            rest_of: self.rest_of,
            most_operations: self.most_operations,
            shape: Some(*shape),
            ..usual
        }
    }
}

/// The cutters of the request and those of its libraries, and the faulty tools.
fn all_candidates(
    own: Vec<NamedCandidate>,
    libraries: Libraries,
    filter: &LibraryFilter,
    path: &JsonPath<'_>,
    faults: &mut Faults,
) -> Result<(Vec<NamedCandidate>, Vec<FaultyTool>), Faulted> {
    if own.is_empty() && !libraries.have_cutters() {
        // If there are only faulty tools, their faults are the reason.
        libraries.report_faulty(faults)?;
        return Err(match libraries.left_out() {
            Some(left_out) => faults.add(
                &path.member(CUTTERS.name),
                RequestFault::MissingField,
                format_args!("no library has a finishing cutter; {left_out}"),
            ),
            None => {
                faults.add(&path.member(CUTTERS.name), RequestFault::MissingField, format_args!("the field is missing: {}", CUTTERS.about))
            }
        });
    }
    let (of_libraries, faulty_tools) = libraries.into_candidates(filter);
    if own.is_empty() && of_libraries.is_empty() {
        let detail = format_args!("none of the finishing cutters of the libraries meets all conditions of {}", LIBRARY_FILTER.name);
        return Err(faults.add(&path.member(CUTTERS.name), RequestFault::MissingField, detail));
    }
    let candidates: Vec<_> = own.into_iter().chain(of_libraries).collect();
    if candidates.len() > MOST_CUTTERS {
        let detail = format_args!(
            "at most {MOST_CUTTERS} cutters, those of libraries included; there are {}; {} chooses from libraries by diameter, type or number",
            candidates.len(),
            LIBRARY_FILTER.name
        );
        return Err(faults.add(&path.member(CUTTERS.name), RequestFault::TooManyItems, detail));
    }
    Ok((candidates, faulty_tools))
}
