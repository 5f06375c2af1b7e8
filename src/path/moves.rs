//! The straight moves of a path.

/// How the tool gets from one point to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum MoveKind {
    /// It cuts, at the feed rate.
    Cut,
    /// It goes from one run to the next at the feed rate. It clears what it meets and may gouge like a cut.
    Link,
    /// It goes at the rapid rate through air. Whatever it meets is a collision; it counts for no material cleared.
    Rapid,
}

/// A straight move of the tip, the lowest point of the cutter on its axis. Coordinates in mm are finite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Move {
    /// Where the move begins.
    pub from: [f64; 3],
    /// Where it ends.
    pub to: [f64; 3],
    /// What the move is for.
    pub kind: MoveKind,
}
