//! The unit of a surface's coordinates.

use crate::http::reading::{Choice, Member};
use crate::surface::Unit;

/// The member `unit` of a recommendation.
pub(crate) const UNIT: Member<Choice<Unit>> = Member::new(
    "unit",
    "the unit of the surface's coordinates; absent = the one that the file states, otherwise mm",
    Choice {
        name: Some("Unit"),
        words: &[
            ("mm", Unit::Millimetre),
            ("cm", Unit::Centimetre),
            ("m", Unit::Metre),
            ("inch", Unit::Inch),
            ("um", Unit::Micrometre),
            ("foot", Unit::Foot),
        ],
    },
);
