//! The codes of problems: of faults in a request's members, of faults of a file, of reasons why a valid request has no answer,
//! and the types of problems, each with its HTTP status.

use super::{codes, joined_codes, same_names};
use crate::file_fault::FileFaultKind;
use crate::milling::NoAnswer;
use crate::quantity::Length;

codes! {
    /// A reason why a contact or a surface has no answer.
    NoAnswerCode: UNPROCESSABLE_ENTITY {
        FlatFloor = "flat-floor": "The analytic model has no answer on a floor", "Use model \"envelope\", or a ball-end cutter.";
        StraightFlank = "straight-flank": "The analytic model has no answer at the slope of a cone", "Use model \"envelope\", or another slope.";
        SlopeTooSteep = "slope-too-steep": "The slope is steeper than the cutter cuts", "Use a cutter with a smaller taper, or tilt the tool; steepest_slope_deg is the steepest slope that it cuts.";
        PassesDoNotOverlap = "passes-do-not-overlap": "The passes do not overlap", "Reduce the step-over to at most largest_step_over_mm.";
        MarksDoNotOverlap = "marks-do-not-overlap": "The tooth marks do not overlap", "Reduce the feed per tooth.";
        Gouging = "gouging": "The cutter gouges", "Use a smaller cutter, another corner radius, or a tilted tool; smallest_radius_mm, if present, is the smallest concave radius that the cutter fits.";
        SharpEdge = "sharp-edge": "The model has no answer if a sharp edge makes the cut", "Use model \"envelope\", a cutter with a corner radius, or another feed direction.";
        PassesCoincideFromAbove = "passes-coincide-from-above": "Seen from above, the passes coincide", "State the step-over along the surface, step_over_mm.";
        ToleranceExceeded = "tolerance-exceeded": "The step-over alone uses up the tolerance", "Reduce the step-over to under max_step_over_mm, or allow more height.";
        ToleranceExceededByFeed = "tolerance-exceeded-by-feed": "The feed alone uses up the tolerance", "Reduce the feed per tooth or the runout, or allow more height than feed_height_mm.";
        ToleranceExceededByRunout = "tolerance-exceeded-by-runout": "Runout alone uses up the tolerance", "Reduce the runout or the step-over, or allow more height.";
        ToleranceSetsNoLimit = "tolerance-sets-no-limit": "The tolerance sets no limit", "State a lower tolerance; or max_feed_per_tooth_mm for a feed, and max_step_over_mm as well for cutting parameters.";
    }
}

/// A figure that a problem has as a member.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ProblemFigure {
    /// The member's name on the wire, with its unit.
    pub(crate) name: &'static str,
    pub(crate) about: &'static str,
}

const STEP_OVER_HEIGHT: ProblemFigure = figure("step_over_height_mm", "h1, the height that the step-over alone leaves");
const MAX_STEP_OVER: ProblemFigure = figure(
    "max_step_over_mm",
    "the step-over that alone leaves exactly the tolerance; a smaller one leaves room for tooth marks and runout",
);
const LARGEST_STEP_OVER: ProblemFigure = figure(
    "largest_step_over_mm",
    "the largest step-over at which the passes, and the tooth marks if there is a feed, meet; if the marks meet at no step-over, the largest one without them; on a curved surface up to 1 % less",
);
const LARGEST_OVERLAP: ProblemFigure = figure(
    LARGEST_STEP_OVER.name,
    "the largest step-over at which the passes, and the tooth marks if there is a feed, overlap; absent if it is the feed that has no limit",
);
const SMALLEST_RADIUS: ProblemFigure = figure(
    "smallest_radius_mm",
    "the smallest concave radius of the surface into which the cutter fits, if both principal curvatures are scaled alike; up to 1 % too large where the cutter gouges away from the contact; absent if it gouges at any radius",
);
const FEED_HEIGHT: ProblemFigure =
    figure("feed_height_mm", "the height that the tooth marks leave with the smallest step-over; at least the tolerance");

const STEEPEST_SLOPE: ProblemFigure = figure("steepest_slope_deg", "the steepest slope that the cutter cuts");

const fn figure(name: &'static str, about: &'static str) -> ProblemFigure {
    ProblemFigure { name, about }
}

impl NoAnswerCode {
    /// The figures of a problem of this type: those that are always present, and those that may be absent.
    pub(crate) fn figures(self) -> (&'static [ProblemFigure], &'static [ProblemFigure]) {
        match self {
            Self::ToleranceExceeded => (&[STEP_OVER_HEIGHT, MAX_STEP_OVER], &[]),
            Self::PassesDoNotOverlap => (&[LARGEST_STEP_OVER], &[]),
            Self::ToleranceSetsNoLimit => (&[], &[LARGEST_OVERLAP]),
            Self::Gouging => (&[], &[SMALLEST_RADIUS]),
            Self::ToleranceExceededByFeed => (&[FEED_HEIGHT], &[]),
            Self::SlopeTooSteep => (&[STEEPEST_SLOPE], &[]),
            Self::FlatFloor
            | Self::StraightFlank
            | Self::MarksDoNotOverlap
            | Self::SharpEdge
            | Self::PassesCoincideFromAbove
            | Self::ToleranceExceededByRunout => (&[], &[]),
        }
    }

    /// The code of `cause`, with its figures.
    pub(crate) fn of(cause: NoAnswer) -> (Self, Vec<(ProblemFigure, f64)>) {
        let one = |figure, length: Length| vec![(figure, length.mm())];
        match cause {
            NoAnswer::FlatFloor => (Self::FlatFloor, Vec::new()),
            NoAnswer::StraightFlank => (Self::StraightFlank, Vec::new()),
            NoAnswer::TooSteep { steepest } => (Self::SlopeTooSteep, vec![(STEEPEST_SLOPE, steepest.degrees())]),
            NoAnswer::PassesDoNotOverlap { largest_step_over } => (Self::PassesDoNotOverlap, one(LARGEST_STEP_OVER, largest_step_over)),
            NoAnswer::MarksDoNotOverlap { largest_mark_spacing: _ } => (Self::MarksDoNotOverlap, Vec::new()),
            NoAnswer::Gouges { smallest_radius } => {
                (Self::Gouging, smallest_radius.map_or(Vec::new(), |radius| one(SMALLEST_RADIUS, radius)))
            }
            NoAnswer::SharpEdge => (Self::SharpEdge, Vec::new()),
            NoAnswer::PassesCoincideFromAbove => (Self::PassesCoincideFromAbove, Vec::new()),
            NoAnswer::StepOverUsesUpTolerance { step_over_height, max_step_over } => {
                let figures = vec![(STEP_OVER_HEIGHT, step_over_height.mm()), (MAX_STEP_OVER, max_step_over.mm())];
                (Self::ToleranceExceeded, figures)
            }
            NoAnswer::FeedUsesUpTolerance { feed_height } => (Self::ToleranceExceededByFeed, one(FEED_HEIGHT, feed_height)),
            NoAnswer::RunoutUsesUpTolerance => (Self::ToleranceExceededByRunout, Vec::new()),
            NoAnswer::ToleranceLimitsNoStepOver { largest_step_over } => {
                (Self::ToleranceSetsNoLimit, one(LARGEST_OVERLAP, largest_step_over))
            }
            NoAnswer::ToleranceLimitsNoFeed { largest_feed_per_tooth: _ } => (Self::ToleranceSetsNoLimit, Vec::new()),
        }
    }
}

codes! {
    /// A fault of an uploaded file.
    FileFaultCode {
        UnknownFormat = "unknown-format" UNSUPPORTED_MEDIA_TYPE: "The file's format is not supported", "Send points in text or PCD, STL, OBJ, PLY or 3MF, and tool libraries of Fusion or FreeCAD or in CSV; give the file's name or media type.";
        Malformed = "malformed-file" BAD_REQUEST: "The file is malformed", "Correct the line or byte that the detail names, or export the file again.";
        Truncated = "truncated-file" BAD_REQUEST: "The file is cut off", "Send the whole file.";
        TooLarge = "file-too-large" PAYLOAD_TOO_LARGE: "The file exceeds a limit of its reader", "Reduce what the detail names.";
        Ambiguous = "ambiguous-file" UNPROCESSABLE_ENTITY: "The file can be read in two ways", "Write the file so that only one of the readings named in the detail fits.";
        OutOfRange = "out-of-range" UNPROCESSABLE_ENTITY: "A number in the file is out of range", "Check the line or byte that the detail names, and the unit.";
        Empty = "empty-file" UNPROCESSABLE_ENTITY: "The file contains no surface or tool", "Export the surface or the library again; check that it is selected.";
    }
}

same_names!(FileFaultKind => FileFaultCode: UnknownFormat, Malformed, Truncated, TooLarge, Ambiguous, OutOfRange, Empty);

codes! {
    /// A fault in a request's JSON, form or query.
    RequestFault: none {
        MissingField = "missing-field": "A required field is missing", "Add the field, which the detail describes.";
        UnknownField = "unknown-field": "A field is unknown", "Remove the field or correct its name; the detail has the name that was probably meant, or the known ones.";
        RepeatedField = "repeated-field": "A field is given more than once", "Give it once.";
        ConflictingFields = "conflicting-fields": "Mutually exclusive fields are given", "Give one of the forms that the detail names.";
        WrongType = "wrong-type": "A value has the wrong JSON type", "Send the type that the detail names; numbers are not quoted.";
        OutOfRange = "out-of-range": "A number is outside its bounds", "Choose a value within the bounds in the detail; check the unit.";
        NotFinite = "not-finite": "A number is NaN or infinite", "Omit the contact, or correct the computation of the number.";
        UnknownValue = "unknown-value": "A word is not one of those allowed", "Use one of the words in the detail.";
        WrongCount = "wrong-count": "An array has the wrong number of items", "Send as many items as the detail names.";
        TooManyFields = "too-many-fields": "An object has more fields than are read", "Remove the unknown fields.";
        TooManyItems = "too-many-items": "An array has more items than are accepted", "Split the request.";
        Unreadable = "unreadable": "A JSON value cannot be decoded", "Correct the value, for example a text with a lone surrogate.";
        FurtherFaults = "further-faults": "The request has more faults than are listed", "Correct the listed ones first.";
        NoDirection = "no-direction": "Vectors or angles do not describe a contact", "Give a normal that points out of the part and a feed that follows the surface.";
        CornerRadiusTooLarge = "corner-radius-too-large": "The corner radius does not fit into the cutter", "Give a corner radius under half the diameter, or a ball-end cutter.";
        DimensionsDoNotFit = "dimensions-do-not-fit": "The dimensions of a cutter do not fit each other", "Correct the dimension, for which the detail has the bound.";
        NotAProfile = "not-a-profile": "The arcs are not the profile of a convex cutter", "Correct the arc, or the one before it: arcs touch, or a straight piece with the normal of both joins them.";
        ScallopTooHigh = "scallop-too-high": "The scallop height exceeds what a cutter can leave", "Give a height of at most the corner radius and under the ball's radius.";
        HeightExceedsWidth = "height-exceeds-width": "The rectangle's side up the slope is its long side", "Give the long side, which is level, as the width.";
        FaultyProgram = "faulty-program": "A line of a program cannot be followed", "Correct the line that the detail names, or post-process the path as plain G0 to G3.";
        SizeOutOfRange = "size-out-of-range": "The surface's size or form is outside the method's bounds", "Check the surface's unit and its points.";
        TooFewPoints = "too-few-points": "The surface has too few points", "Send at least as many points as the detail names.";
        OnlyDegenerateFacets = "only-degenerate-facets": "No facet of the surface has an area", "Check the mesh and its unit.";
        AllPointsEqual = "all-points-equal": "All points of the surface are equal", "Check the file or the points.";
        Collinear = "collinear": "All points of the surface lie on a line", "Send points that spread over the surface.";
        NothingToMachine = "nothing-to-machine": "No facet of the surface is machined", "Check the selection, the largest slope and the orientation: Z is the tool axis.";
    }
}

joined_codes! {
    /// The fault, as a code for programs; docs/codes.md lists meanings and remedies.
    FaultCode { RequestFault, FileFaultCode, NoAnswerCode }
}

codes! {
    /// A problem of the request as a whole, or of the service.
    ServiceProblem {
        InvalidRequest = "invalid-request" UNPROCESSABLE_ENTITY: "The request cannot be answered", "Correct the faults listed in errors.";
        MalformedJson = "malformed-json" BAD_REQUEST: "The body is not JSON", "Correct the syntax at the line and column in the detail; JSON has neither comments nor trailing commas.";
        MalformedForm = "malformed-form" BAD_REQUEST: "The form is malformed", "Send multipart/form-data as RFC 7578 describes it.";
        MalformedRequest = "malformed-request" BAD_REQUEST: "The request is malformed", "Correct the request.";
        UnreadableBody = "unreadable-body" BAD_REQUEST: "The body could not be read", "Send the body again; if it is compressed, check that it is valid gzip.";
        NotFound = "not-found" NOT_FOUND: "The path does not exist", "Correct the path; /docs lists all paths.";
        MethodNotAllowed = "method-not-allowed" METHOD_NOT_ALLOWED: "The method is not allowed here", "Use a method that the header Allow lists.";
        Timeout = "timeout" REQUEST_TIMEOUT: "The request took too long", "Send the body faster, or a smaller request.";
        TooLarge = "too-large" PAYLOAD_TOO_LARGE: "The body is too large", "Send less, or raise the server's limit.";
        UnsupportedMediaType = "unsupported-media-type" UNSUPPORTED_MEDIA_TYPE: "The media type is not supported", "Send application/json, or multipart/form-data for an upload.";
        UnsupportedEncoding = "unsupported-encoding" UNSUPPORTED_MEDIA_TYPE: "The content encoding is not supported", "Send the body plain or with gzip.";
        NoCutterFits = "no-cutter-fits" UNPROCESSABLE_ENTITY: "No cutter can be ranked", "See not_ranked for each cutter's reason; send other cutters.";
        Internal = "internal" INTERNAL_SERVER_ERROR: "The server failed", "Report the request id to the server's operator.";
        Overloaded = "overloaded" SERVICE_UNAVAILABLE: "The server is busy", "Try again after the time in the header Retry-After.";
        Failed = "failed" none: "The request failed", "See the HTTP status.";
    }
}

joined_codes! {
    /// The problem, as a code for programs; docs/codes.md lists meanings and remedies.
    ProblemType { ServiceProblem, FileFaultCode, NoAnswerCode }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::Angle;

    #[test]
    fn every_cause_carries_the_figures_that_its_code_documents() {
        let length = Length::from_mm(1.0).unwrap();
        for cause in [
            NoAnswer::FlatFloor,
            NoAnswer::StraightFlank,
            NoAnswer::TooSteep { steepest: Angle::RIGHT },
            NoAnswer::PassesDoNotOverlap { largest_step_over: length },
            NoAnswer::MarksDoNotOverlap { largest_mark_spacing: length },
            NoAnswer::Gouges { smallest_radius: Some(length) },
            NoAnswer::Gouges { smallest_radius: None },
            NoAnswer::SharpEdge,
            NoAnswer::PassesCoincideFromAbove,
            NoAnswer::StepOverUsesUpTolerance { step_over_height: length, max_step_over: length },
            NoAnswer::FeedUsesUpTolerance { feed_height: length },
            NoAnswer::RunoutUsesUpTolerance,
            NoAnswer::ToleranceLimitsNoStepOver { largest_step_over: length },
            NoAnswer::ToleranceLimitsNoFeed { largest_feed_per_tooth: length },
        ] {
            let (code, figures) = NoAnswerCode::of(cause);
            let (always, sometimes) = code.figures();
            let has = |figure: &ProblemFigure| figures.iter().any(|(found, _)| found == figure);
            assert!(always.iter().all(has), "{cause:?}");
            assert!(figures.iter().all(|(figure, _)| always.contains(figure) || sometimes.contains(figure)), "{cause:?}");
        }
    }
}
