//! The units in which files give coordinates.

/// The unit of a surface's coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Unit {
    /// 1 mm
    #[default]
    Millimetre,
    /// 10 mm
    Centimetre,
    /// 1000 mm
    Metre,
    /// 25.4 mm
    Inch,
    /// 0.001 mm
    Micrometre,
    /// 304.8 mm
    Foot,
}

impl Unit {
    /// The unit in mm.
    #[must_use]
    pub fn mm(self) -> f64 {
        match self {
            Self::Millimetre => 1.0,
            Self::Centimetre => 10.0,
            Self::Metre => 1000.0,
            Self::Inch => 25.4,
            Self::Micrometre => 1e-3,
            Self::Foot => 304.8,
        }
    }
}
