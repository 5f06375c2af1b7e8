//! The parameters of a recommendation, without the surface: cutters, scallop height, machine, and settings of the plan; and the
//! warnings about those that have no effect.

use super::library::Libraries;
use super::program::{ProgramOptions, ProgramOptionsKind};
use crate::http::codes::{RequestFault, WarningCode};
use crate::http::reading::{Choice, Faulted, Faults, JsonPath, List, Members, Object, Quantity, Renamed, Whole, members};
use crate::http::wire::{
    AnyCutter, CLEARANCE_HEIGHT, CandidateKind, LibraryFilter, LibraryFilterKind, MACHINE, MAX_SPINDLE_SPEED, MOST_CUTTERS, MachineKind,
    NamedCandidate, PATH_TOLERANCE, PLAN_MODEL, RAPID_RATE, ROUGHNESS, RoughnessKind, SCALLOP_HEIGHT, SPINDLE_SPEED, SelectKind,
    StatedSurface, SurfaceWithSource, TEETH, TOOL_CHANGE, UNIT, Warning, plan_tolerance,
};
use crate::milling::{Cutter, Model};
use crate::motion::{self, Machine};
use crate::planning::plan::{Directions, Pattern, PlanSettings};
use crate::quantity::{Angle, Length, OutOfRange};
use crate::surface::mesh::Selection;
use crate::surface::{Facing, Shape, Unit};
use crate::tooling::FaultyTool;
use serde::Serialize;
use std::fmt;
use utoipa::ToSchema;

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
            "a second surface, in the same unit and position: never machined and never cut, such as clamps, or the walls beside the faces to finish"),
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

/// The most operations that a request can allow.
const MOST_OPERATIONS: u32 = 3;

members! {
    /// The members of the settings of operations.
    pub(super) struct OperationsMembers for OperationsKind ("Operations", "How many operations a plan may have, in method surface") -> usize {
        most: required MOST: Whole = ("max", Whole { minimum: 1, maximum: MOST_OPERATIONS, example: 3 },
            "the most operations: the surface divided by slope, each part with its cutter and lines, and a smaller cutter for what they cannot reach"),
    }
}

impl OperationsMembers {
    fn build(self, _: &JsonPath<'_>, _: &mut Faults) -> Result<usize, Faulted> {
        self.most.map(|most| most as usize)
    }
}

members! {
    /// The members of a rest.
    pub(super) struct RestOfMembers for RestOfKind ("RestOf", "A cutter that has machined everything before") -> Cutter {
        cutter: required REST_CUTTER: AnyCutter = ("cutter", AnyCutter, "the cutter"),
    }
}

impl RestOfMembers {
    fn build(self, _: &JsonPath<'_>, _: &mut Faults) -> Result<Cutter, Faulted> {
        self.cutter.map(|stated| stated.cutter)
    }
}

/// The most cutters that a detail names.
const MOST_NAMED: usize = 10;

/// The warning about a member without effect, with the reason.
pub(super) fn unused(member: impl fmt::Display, reason: &str) -> Warning {
    Warning::new(WarningCode::MemberUnused, format!("{member} has no effect {reason}"))
}

/// The reason why a member of method `surface` has no effect.
const IN_RECTANGLE: &str = "in method rectangle; use method \"surface\"";

/// The members that have no effect whatever the surface is. A member with a fault counts as absent.
fn unused_members(members: &ParameterMembers, libraries: &Libraries) -> Vec<Warning> {
    let rectangle = matches!(members.method, Ok(Some(Method::Rectangle)));
    let one_way = matches!(members.pattern, Ok(Some(Pattern::OneWay)));
    let included = |part| matches!(&members.include, Ok(Some(parts)) if parts.contains(&part));
    let mut warnings = Vec::new();
    let mut warn = |is_unused: bool, member: &dyn fmt::Display, reason: &str| {
        if is_unused {
            warnings.push(unused(member, reason));
        }
    };
    if rectangle {
        warn(matches!(members.avoid, Ok(Some(_))), &AVOID.name, IN_RECTANGLE);
        warn(matches!(&members.include, Ok(Some(parts)) if !parts.is_empty()), &INCLUDE.name, IN_RECTANGLE);
        warn(matches!(members.directions, Ok(Some(_))), &DIRECTIONS.name, IN_RECTANGLE);
        warn(matches!(members.max_uncut_share, Ok(Some(_))), &MAX_UNCUT_SHARE.name, IN_RECTANGLE);
        warn(matches!(members.operations, Ok(Some(_))), &OPERATIONS.name, IN_RECTANGLE);
        warn(matches!(members.rest_of, Ok(Some(_))), &REST_OF.name, IN_RECTANGLE);
    }
    let several = matches!(members.operations, Ok(Some(most)) if most > 1) && !rectangle;
    let rest = matches!(members.rest_of, Ok(Some(_)));
    warn(several && rest, &OPERATIONS.name, &format!("beside {}", REST_OF.name));
    let writes_program = included(AnswerPart::Program) && !rectangle;
    warn(matches!(members.program, Ok(Some(_))) && !writes_program, &PROGRAM.name, "unless include names program, in method surface");
    let filters_nothing = matches!(members.library_filter, Ok(Some(_))) && libraries.is_empty();
    warn(filters_nothing, &LIBRARY_FILTER.name, "without a library; send the request with parts library to the upload");
    if let Ok(machine) = members.machine {
        let usual = Machine::from(machine.limits);
        let of_machine = |name: &str| format!("{}.{name}", MACHINE.name);
        warn(rectangle && machine.path_tolerance.is_some(), &of_machine(PATH_TOLERANCE.name), IN_RECTANGLE);
        let reason = format!("in method rectangle with {} zigzag, which has no rapid moves", PATTERN.name);
        warn(rectangle && !one_way && machine.rapid_rate != usual.rapid_rate, &of_machine(RAPID_RATE.name), &reason);
        let reason_of_change = format!("unless {} allows several", OPERATIONS.name);
        warn(machine.tool_change != usual.tool_change && (!several || rest), &of_machine(TOOL_CHANGE.name), &reason_of_change);
        warn(rectangle && !one_way && machine.clearance_height != usual.clearance_height, &of_machine(CLEARANCE_HEIGHT.name), &reason);
    }
    warnings
}

/// The members of the machine that have no effect on the zigzag of an inclined rectangle, which has neither rapid moves nor tool
/// changes and stops at its corners.
pub(super) fn unused_on_rectangle(machine: &Machine) -> Vec<Warning> {
    let usual = Machine::from(machine.limits);
    let stated = [
        (RAPID_RATE.name, machine.rapid_rate != usual.rapid_rate),
        (MAX_SPINDLE_SPEED.name, machine.max_spindle_speed.is_some()),
        (CLEARANCE_HEIGHT.name, machine.clearance_height != usual.clearance_height),
        (PATH_TOLERANCE.name, machine.path_tolerance.is_some()),
        (TOOL_CHANGE.name, machine.tool_change != usual.tool_change),
    ];
    let unused = |name| unused(format_args!("{}.{name}", MACHINE.name), "on the inclined rectangle");
    stated.into_iter().filter(|(_, is_stated)| *is_stated).map(|(name, _)| unused(name)).collect()
}

/// The members of cutters and machine that have no effect without others.
fn unused_drives(candidates: &[NamedCandidate], machine: &Machine) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let mut names: Vec<&'static str> = candidates.iter().flat_map(|named| named.idle.iter().copied()).collect();
    names.sort_unstable();
    names.dedup();
    for name in names {
        let idle = candidates.iter().enumerate().filter(|(_, named)| named.idle.contains(&name)).map(|(place, _)| place);
        let places: Vec<usize> = idle.collect();
        let listed: Vec<String> = places.iter().take(MOST_NAMED).map(usize::to_string).collect();
        let more = places.len().saturating_sub(MOST_NAMED);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        let without = match name {
            _ if name == TEETH.name => SPINDLE_SPEED.name.to_owned(),
            _ if name == SPINDLE_SPEED.name => TEETH.name.to_owned(),
            _ => format!("both {} and {}", TEETH.name, SPINDLE_SPEED.name),
        };
        warnings.push(unused(format_args!("{name} of {} {}{more}", CUTTERS.name, listed.join(", ")), &format!("without {without}")));
    }
    if machine.max_spindle_speed.is_some() && candidates.iter().all(|named| named.candidate.drive.is_none()) {
        let member = format_args!("{}.{}", MACHINE.name, MAX_SPINDLE_SPEED.name);
        warnings.push(unused(member, "unless a cutter has teeth and spindle_speed_rpm"));
    }
    warnings
}
