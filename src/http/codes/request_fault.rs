//! The codes of faults in a request's members.

use super::{FileFaultCode, NoAnswerCode, codes, joined_codes};

codes! {
    /// A fault in a request's JSON, form or query.
    RequestFault: none {
        MissingField = "missing-field": "A required field is missing", "Add the field, which the detail describes.";
        UnknownField = "unknown-field": "A field is unknown", "Remove the field or correct its name; the detail lists the known names.";
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
