//! The levels of confidence in a recommendation, common to both methods.

/// The reliability of a recommendation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// The surface is of the kind for which the method is intended.
    High,
    /// The surface differs from that kind so much that times and critical slope are estimates.
    Moderate,
    /// The recommendation may be wrong; simulate both candidates.
    Low,
}
