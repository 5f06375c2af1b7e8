//! The check of an analytic answer against the envelope.

use super::answer;

answer! {
    /// The comparison of the analytic height with the envelope's.
    #[derive(Clone, Copy)]
    pub(crate) struct Check {
        /// The height by the cutter's exact shape (model `envelope`).
        pub(crate) envelope_scallop_height_mm: f64 [minimum = 0],
        /// (height - envelope) / envelope: negative if the model's height is less than the cutter leaves. Absent if the
        /// envelope's height is 0.
        pub(crate) deviation?: f64 [minimum = -1],
    }
}
