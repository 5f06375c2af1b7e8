//! The codes in answers: of warnings, of reasons that lower the confidence in a recommendation, and of reasons why a cutter is
//! not ranked.

use super::{codes, same_names};
use crate::planning::plan::NotRankedReason;
use crate::planning::{SurfaceWeakness, Weakness};

codes! {
    /// The warning, as a code for programs; docs/codes.md lists meanings and remedies.
    WarningCode: none {
        RunoutNotSmall = "runout-not-small": "Runout is not small compared with the feed per tooth", "Measure the runout, or raise the feed per tooth; feed_height_mm may be too low.";
        StepOverWide = "step-over-wide": "The step-over is wide compared with the model's circle", "Use model \"envelope\".";
        FeedPerToothLong = "feed-per-tooth-long": "The feed per tooth is long compared with the model's circle", "Use model \"envelope\".";
        EffectiveRadiusBeyondCutter = "effective-radius-beyond-cutter": "The model's circle is wider than the cutter", "Use model \"envelope\": the scallop can be far higher.";
        SharpMarks = "sharp-marks": "A flat-end cutter leaves sharp marks", "Use a cutter with a small corner radius.";
        CurvatureApproximate = "curvature-approximate": "The surface's normal turns so much between the marks that the actual height can be larger than stated", "Keep a margin to the tolerance.";
        HeightNotABound = "height-not-a-bound": "The surface's normal turns so far between the marks that the height is no bound", "State contacts farther from level ground and from walls, or let /v1/path-check mill the path.";
        NearGouging = "near-gouging": "The cutter's radius is nearly that of the hollow; a second-order surface is then not accurate enough", "Use a smaller cutter, or keep a margin to the tolerance.";
        OutsideAnalyticRange = "outside-analytic-range": "The analytic height is far below what the cutter leaves", "Use model \"envelope\".";
        DegenerateFacets = "degenerate-facets": "Facets without area were left out", "None is needed; many of them indicate a damaged mesh.";
        FacetsLeftOut = "facets-left-out": "Facets that face another way were left out", "Set facing to \"any\" to use all facets.";
        TurnedOver = "turned-over": "The surface was assumed to be upside down", "Check the orientation of the facets.";
        WallsOnly = "walls-only": "All facets are vertical", "Check the file's axes: Z is the tool axis.";
        FurtherColumns = "further-columns": "Columns other than x, y and z were left out", "Check that the first three columns are the coordinates.";
        PointFarOutside = "point-far-outside": "A coordinate is far outside of all others", "Look at the line; a number such as -9999 stands for a missing measurement, and its point must be left out.";
        VolumesLeftOut = "volumes-left-out": "Volumes that a slicer's settings exclude from the part were left out", "None is needed; if a volume belongs to the part, export the part as STL.";
        DuplicateFacets = "duplicate-facets": "Facets that occur more than once were counted once", "Check whether a body is in the file twice.";
        UnitUnlikely = "unit-unlikely": "The size of the part suggests another unit", "State unit.";
        TrailingBytes = "trailing-bytes": "Bytes after the end of the data were left out", "Check that the file's count is right.";
        OtherElements = "other-elements": "Elements other than vertices and faces were left out", "None is needed.";
        MissingPoints = "missing-points": "Points without coordinates were left out", "None is needed; scanners write them for measurements without an echo.";
        CrossedPolygons = "crossed-polygons": "Polygons cross themselves", "Check the mesh; their area is uncertain.";
        FacetsMerged = "facets-merged": "Facets were merged on a raster", "Send fewer facets; details smaller than a raster cell are lost.";
        FlutesTooShort = "flutes-too-short": "The flutes are shorter than the surface is deep", "Check the clearance of shank and holder.";
        OtherTools = "other-tools": "Some tools of a library are not finishing cutters", "None is needed. The detail counts them by type; it also counts tool files that no .fctl list names.";
        FaultyTools = "faulty-tools": "Finishing cutters of a library cannot be used", "Correct the tools that not_ranked names with faulty-tool; one of them may be the fastest.";
        PassesLeftOut = "passes-left-out": "The path is too long for the passes or the program in an answer", "Ask for the program alone, which may have more points; select a part of the surface, or allow more height.";
        SpindleSpeedLimited = "spindle-speed-limited": "A spindle speed is over the machine's largest, which is used instead", "Check the speed and the feed that follows from it.";
        MemberUnused = "member-unused": "A member of the request has no effect", "Do what the detail says, or leave the member out.";
        FigureAbsent = "figure-absent": "A figure is null for contacts that have an answer", "Do what the detail says, or read the null as absent.";
        AnglesLikeRadians = "angles-like-radians": "The slopes of a batch look like radians", "Send degrees.";
        MissingEnd = "missing-end": "The file ends inside a solid", "Check that the file is whole.";
    }
}

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
        OperationsNotPlanned = "operations-not-planned": "Several operations may be faster; computing stopped before they were planned", "State fewer cutters, or select a part of the surface.";
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
        PathMisplaced = "path-misplaced": "The path cuts into most of the area, or misses it", "Check the path's zero point (origin_mm), the units, the cutter and tip; select the facets that the path is for.";
        CornersNotTimed = "corners-not-timed": "The machine has no path tolerance: corners of up to 45° take no time", "State path_tolerance_mm of the machine.";
        Gouge = "gouge": "The path cuts into the part", "Look at the passes near the deepest cut; export the surface with a finer tolerance.";
    }
}

same_names! {
    SurfaceWeakness => ConfidenceCode:
    NotMilled, OperationsNotPlanned, AssumedFeed, SmallLead, CoarseTessellation, SteepArea, HiddenArea, SeveralPieces, InconsistentOrientation, NotClosed,
    OverTolerance, Gouge, SharpCorners, AssumedPathFeed, PathMisplaced, CornersNotTimed,
}

same_names! {
    Weakness => ConfidenceCode:
    DirectionsNotPerpendicular, FormFactorNearOne, NoPrincipalDirection, SlopeNearZero, NotFlat, SlopeNearCritical, TimesNearlyEqual,
    MeanSlopeDisagrees, ShortPasses, LongSteps, SmallSurface, FewPasses, MeanSlopeFarFromPlane, AreaFarFromSize,
    SeveralPieces, SimulationDisagrees, SimulationPrefersOther,
}

codes! {
    /// Why a cutter is not ranked, as a code for programs; docs/codes.md lists meanings and remedies.
    NotRankedCode: none {
        CannotReach = "cannot-reach": "The cutter leaves too much of the surface uncut", "Use a smaller cutter, select the facets that it reaches, or raise max_uncut_share.";
        NoStepOver = "no-step-over": "No step-over keeps the scallop height", "Allow more height, or use another cutter.";
        FaultyTool = "faulty-tool": "The tool's entry in its library has faults", "Correct the members that the detail names; the other tools of the library are used.";
    }
}

impl From<NotRankedReason> for NotRankedCode {
    fn from(reason: NotRankedReason) -> Self {
        match reason {
            NotRankedReason::CannotReach { .. } => Self::CannotReach,
            NotRankedReason::NoStepOver => Self::NoStepOver,
        }
    }
}
