//! The runout of the cutter: the deviation of its teeth from their common circle.

use crate::http::codes::RequestFault;
use crate::http::reading::{Faulted, Faults, JsonPath, Quantity, members};
use crate::milling::Runout;

members! {
    /// The members of a runout.
    pub(crate) struct RunoutMembers for RunoutObject ("Runout", "The deviation of the teeth from their common circle") -> Runout {
        radial: optional RADIAL: Quantity<f64> = ("radial_mm", Quantity::new(|mm| Runout::NONE.with_radial_mm(mm).map(|_| mm), 0.005),
            "radial runout: how much further one tooth protrudes than the next; absent = 0"),
        axial: optional AXIAL: Quantity<f64> = ("axial_mm", Quantity::new(|mm| Runout::NONE.with_axial_mm(mm).map(|_| mm), 0.002),
            "axial runout: how much lower one tooth is than the next; if the feed climbs, a positive value shortens the distance between tooth marks and a negative one lengthens it; a feed down the slope is treated like a feed up the slope; absent = 0"),
    }
}

impl RunoutMembers {
    fn build(self, path: &JsonPath<'_>, faults: &mut Faults) -> Result<Runout, Faulted> {
        let (radial, axial) = (self.radial?.unwrap_or(0.0), self.axial?.unwrap_or(0.0));
        let runout = Runout::NONE.with_radial_mm(radial).and_then(|runout| runout.with_axial_mm(axial));
        runout.map_err(|bounds| faults.add(path, RequestFault::OutOfRange, bounds))
    }
}
