//! The codes of faults of an uploaded file. Each is also the type of a problem.

use super::{codes, same_names};
use crate::file_fault::FileFaultKind;

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
