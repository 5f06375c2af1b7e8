//! How far to trust an answer, whatever the method.

/// How far to trust a recommendation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// The surface is of the kind for which the method was built.
    High,
    /// It departs from that kind so far that times and critical slope are estimates.
    Moderate,
    /// The recommendation may be wrong; simulate both candidates.
    Low,
}
