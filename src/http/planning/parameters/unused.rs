//! Warnings about members of a recommendation's request that have no effect.

use super::{
    AVOID, AnswerPart, CUTTERS, DIRECTIONS, INCLUDE, LIBRARY_FILTER, MAX_UNCUT_SHARE, Method, OPERATIONS, PATTERN, PROGRAM,
    ParameterMembers, REST_OF,
};
use crate::http::codes::WarningCode;
use crate::http::planning::library::Libraries;
use crate::http::wire::{
    CLEARANCE_HEIGHT, MACHINE, MAX_SPINDLE_SPEED, NamedCandidate, PATH_TOLERANCE, RAPID_RATE, SPINDLE_SPEED, TEETH, TOOL_CHANGE, Warning,
};
use crate::motion::Machine;
use crate::planning::plan::Pattern;
use std::fmt;

/// The most cutters that a detail names.
const MOST_NAMED: usize = 10;

/// The warning about a member without effect, with the reason.
pub(in crate::http::planning) fn unused(member: impl fmt::Display, reason: &str) -> Warning {
    Warning::new(WarningCode::MemberUnused, format!("{member} has no effect {reason}"))
}

/// The reason why a member of method `surface` has no effect.
pub(super) const IN_RECTANGLE: &str = "in method rectangle; use method \"surface\"";

/// The members that have no effect whatever the surface is. A member with a fault counts as absent.
pub(super) fn unused_members(members: &ParameterMembers, libraries: &Libraries) -> Vec<Warning> {
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
pub(in crate::http::planning) fn unused_on_rectangle(machine: &Machine) -> Vec<Warning> {
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
pub(super) fn unused_drives(candidates: &[NamedCandidate], machine: &Machine) -> Vec<Warning> {
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
