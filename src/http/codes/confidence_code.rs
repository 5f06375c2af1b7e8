//! The codes of the reasons that lower the confidence in a recommendation.

use super::{codes, same_names};
use crate::planning::{SurfaceWeakness, Weakness};

codes! {
    /// The weakness, as a code for programs; docs/codes.md lists meanings and remedies.
    ConfidenceCode: none {
        DirectionsNotPerpendicular = "directions-not-perpendicular": "Steepest and principal direction are not perpendicular", "Simulate both candidates: the model's rectangle has its long side level.";
        FormFactorNearOne = "form-factor-near-one": "The surface is nearly as wide as it is long", "Choose the ball-end cutter's direction freely.";
        NoPrincipalDirection = "no-principal-direction": "The surface has no principal direction", "Choose the ball-end cutter's direction freely.";
        SlopeNearZero = "slope-near-zero": "The surface is almost level", "Use model \"envelope\"; choose the direction freely.";
        NotFlat = "not-flat": "The surface is not flat", "Divide the surface, or simulate both candidates.";
        SlopeNearCritical = "slope-near-critical": "The slope is near the critical slope", "Simulate both candidates.";
        TimesNearlyEqual = "times-nearly-equal": "Both candidates take nearly the same time", "Decide by other reasons, such as tool wear.";
        MeanSlopeDisagrees = "mean-slope-disagrees": "The mean slope and the best-fit plane's slope are on opposite sides of the critical slope", "Simulate both candidates.";
        ShortPasses = "short-passes": "Passes are too short to reach the feed rate", "Treat the times as estimates.";
        LongSteps = "long-steps": "Steps between passes are not limited by the jerk alone", "Treat the times as estimates.";
        SmallSurface = "small-surface": "The surface is smaller than those that validate the method", "Treat the critical slope as an estimate.";
        FewPasses = "few-passes": "There are few passes", "Count whole passes: the method does not round their number.";
        MeanSlopeFarFromPlane = "mean-slope-far-from-plane": "The mean slope is far from the best-fit plane's slope", "Use method \"surface\".";
        AreaFarFromSize = "area-far-from-size": "The area is far from the characteristic size", "Use method \"surface\".";
        SeveralPieces = "several-pieces": "The surface is in several pieces", "Send or select one piece at a time.";
        SimulationDisagrees = "simulation-disagrees": "The simulation on the surface gives another time", "Use method \"surface\".";
        SimulationPrefersOther = "simulation-prefers-other": "The simulation on the surface prefers another cutter", "Use method \"surface\".";
        NotMilled = "not-milled": "Paths are too long to be milled, and their times are estimates", "Select a part of the surface, or allow more height.";
        AssumedFeed = "assumed-feed": "The fastest cutter's feed is assumed, those of others are stated", "State teeth, spindle speed and largest feed per tooth of each cutter.";
        SmallLead = "small-lead": "The fastest cutter is hardly faster than the next", "Decide by other reasons, such as tool wear.";
        CoarseTessellation = "coarse-tessellation": "The facets are wide compared with the step-over", "Export the surface with a finer tolerance.";
        SteepArea = "steep-area": "Part of the area is too steep for the spacing of passes", "Finish the walls in a separate operation.";
        HiddenArea = "hidden-area": "Part of the selected area is hidden from above (undersides of closed solids are not counted)", "Machine it in another set-up.";
        InconsistentOrientation = "inconsistent-orientation": "Part of the facets face the other way than the rest", "Repair the mesh: unify the orientation of its facets.";
        NotClosed = "not-closed": "A solid lacks facets, or some are turned", "Repair the mesh: close its holes.";
        UnitUnlikely = "unit-unlikely": "The size of the part suggests that its file is in another unit", "State unit.";
        OverTolerance = "over-tolerance": "Part of the area that the cutter reaches is left over the scallop height", "Look at the map of scallop heights; finish that part in a second operation.";
        SharpCorners = "sharp-corners": "The plan's time counts no stops in the sharp corners of its runs", "State path_tolerance_mm of the machine.";
        AssumedPathFeed = "assumed-path-feed": "Part of the path states no feed rate", "State the feed rates of the path.";
        CornersNotTimed = "corners-not-timed": "The machine has no path tolerance: corners of up to 45° take no time", "State path_tolerance_mm of the machine.";
        Gouge = "gouge": "The path cuts into the part", "Look at the passes near the deepest cut; export the surface with a finer tolerance.";
    }
}

same_names! {
    SurfaceWeakness => ConfidenceCode:
    NotMilled, AssumedFeed, SmallLead, CoarseTessellation, SteepArea, HiddenArea, SeveralPieces, InconsistentOrientation, NotClosed, OverTolerance,
    Gouge, SharpCorners, AssumedPathFeed, CornersNotTimed,
}

same_names! {
    Weakness => ConfidenceCode:
    DirectionsNotPerpendicular, FormFactorNearOne, NoPrincipalDirection, SlopeNearZero, NotFlat, SlopeNearCritical, TimesNearlyEqual,
    MeanSlopeDisagrees, ShortPasses, LongSteps, SmallSurface, FewPasses, MeanSlopeFarFromPlane, AreaFarFromSize,
    SeveralPieces, SimulationDisagrees, SimulationPrefersOther,
}
