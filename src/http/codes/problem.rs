//! The types of problems, each with its HTTP status.

use super::{FileFault, NoAnswerCode, codes, joined_codes};
use axum::http::StatusCode;

codes! {
    /// A problem of the request as a whole, or of the service.
    ServiceProblem {
        InvalidRequest = "invalid-request": "The request cannot be answered", "Correct the faults listed in errors.";
        MalformedJson = "malformed-json": "The body is not JSON", "Correct the syntax at the line and column in the detail; JSON has neither comments nor trailing commas.";
        MalformedForm = "malformed-form": "The form is malformed", "Send multipart/form-data as RFC 7578 describes it.";
        MalformedRequest = "malformed-request": "The request is malformed", "Correct the request.";
        UnreadableBody = "unreadable-body": "The body could not be read", "Send the body again; if it is compressed, check that it is valid gzip.";
        NotFound = "not-found": "The path does not exist", "Correct the path; /docs lists all paths.";
        MethodNotAllowed = "method-not-allowed": "The method is not allowed here", "Use a method that the header Allow lists.";
        Timeout = "timeout": "The request took too long", "Send the body faster, or a smaller request.";
        TooLarge = "too-large": "The body is too large", "Send less, or raise the server's limit.";
        UnsupportedMediaType = "unsupported-media-type": "The media type is not supported", "Send application/json, or multipart/form-data for an upload.";
        UnsupportedEncoding = "unsupported-encoding": "The content encoding is not supported", "Send the body plain or with gzip.";
        NoCutterFits = "no-cutter-fits": "No cutter can be ranked", "See not_ranked for each cutter's reason; send other cutters.";
        Internal = "internal": "The server failed", "Report the request id to the server's operator.";
        Overloaded = "overloaded": "The server is busy", "Try again after the time in the header Retry-After.";
        Failed = "failed": "The request failed", "See the HTTP status.";
    }
}

impl ServiceProblem {
    /// The status of such a problem; `None` if the framework's status applies.
    pub(crate) fn status(self) -> Option<StatusCode> {
        Some(match self {
            Self::InvalidRequest | Self::NoCutterFits => StatusCode::UNPROCESSABLE_ENTITY,
            Self::MalformedJson | Self::MalformedForm | Self::MalformedRequest | Self::UnreadableBody => StatusCode::BAD_REQUEST,
            Self::NotFound => StatusCode::NOT_FOUND,
            Self::MethodNotAllowed => StatusCode::METHOD_NOT_ALLOWED,
            Self::Timeout => StatusCode::REQUEST_TIMEOUT,
            Self::TooLarge => StatusCode::PAYLOAD_TOO_LARGE,
            Self::UnsupportedMediaType | Self::UnsupportedEncoding => StatusCode::UNSUPPORTED_MEDIA_TYPE,
            Self::Internal => StatusCode::INTERNAL_SERVER_ERROR,
            Self::Overloaded => StatusCode::SERVICE_UNAVAILABLE,
            Self::Failed => return None,
        })
    }
}

joined_codes! {
    /// The problem, as a code for programs; docs/codes.md lists meanings and remedies.
    ProblemType { ServiceProblem, FileFault, NoAnswerCode }
}
