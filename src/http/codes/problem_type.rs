//! The types of problems, each with its HTTP status.

use super::{FileFaultCode, NoAnswerCode, codes, joined_codes};

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
