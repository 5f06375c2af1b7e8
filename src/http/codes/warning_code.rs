//! The codes of warnings, which accompany answers.

use super::codes;

codes! {
    /// The warning, as a code for programs; docs/codes.md lists meanings and remedies.
    WarningCode: none {
        RunoutNotSmall = "runout-not-small": "Runout is not small compared with the feed per tooth", "Measure the runout, or raise the feed per tooth; feed_height_mm may be too low.";
        StepOverWide = "step-over-wide": "The step-over is wide compared with the model's circle", "Use model \"envelope\".";
        FeedPerToothLong = "feed-per-tooth-long": "The feed per tooth is long compared with the model's circle", "Use model \"envelope\".";
        EffectiveRadiusBeyondCutter = "effective-radius-beyond-cutter": "The model's circle is wider than the cutter", "Use model \"envelope\": the scallop can be far higher.";
        SharpMarks = "sharp-marks": "A flat-end cutter leaves sharp marks", "Use a cutter with a small corner radius.";
        CurvatureApproximate = "curvature-approximate": "The surface's normal turns so much between the marks that the actual height can be larger than stated", "Keep a margin to the tolerance.";
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
        PassesLeftOut = "passes-left-out": "The passes have too many points for an answer", "Select a part of the surface, or allow more height.";
        SpindleSpeedLimited = "spindle-speed-limited": "A spindle speed is over the machine's largest, which is used instead", "Check the speed and the feed that follows from it.";
        MemberUnused = "member-unused": "A member of the request has no effect", "Do what the detail says, or leave the member out.";
        FigureAbsent = "figure-absent": "A figure is null for contacts that have an answer", "Do what the detail says, or read the null as absent.";
        AnglesLikeRadians = "angles-like-radians": "The slopes of a batch look like radians", "Send degrees.";
        MissingEnd = "missing-end": "The file ends inside a solid", "Check that the file is whole.";
    }
}
