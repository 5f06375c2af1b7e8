//! The codes of warnings: what is answered but must be looked at.

use super::codes;

codes! {
    /// Which warning: a code for programs to decide by, listed with meanings and remedies in docs/codes.md.
    WarningCode {
        RunoutNotSmall = "runout-not-small": "Runout is not small against the feed per tooth", "Measure the runout, or raise the feed per tooth; the feed's share is no bound.";
        StepOverWide = "step-over-wide": "The step-over is wide against the model's circle", "Use model \"envelope\".";
        FeedPerToothLong = "feed-per-tooth-long": "The feed per tooth is long against the model's circle", "Use model \"envelope\".";
        EffectiveRadiusBeyondCutter = "effective-radius-beyond-cutter": "The model's circle is wider than the cutter", "Use model \"envelope\": the scallop can be far higher.";
        SharpMarks = "sharp-marks": "A flat-end cutter leaves sharp marks", "Use a cutter with a small corner radius.";
        CurvatureApproximate = "curvature-approximate": "The surface's normal turns so much between the marks that the height can be exceeded", "Keep a margin to the tolerance.";
        NearGouging = "near-gouging": "The cutter nearly fills the hollow, and the second order of the surface is not enough", "Use a smaller cutter, or keep a margin to the tolerance.";
        OutsideAnalyticRange = "outside-analytic-range": "The analytic height is far under what the cutter leaves", "Use model \"envelope\".";
        StepOverExceedsCutter = "step-over-exceeds-cutter": "The step-over is wider than the cutter", "Use model \"envelope\".";
        DegenerateFacets = "degenerate-facets": "Facets without area were left out", "None is needed; many of them hint at a damaged mesh.";
        FacetsLeftOut = "facets-left-out": "Facets that face another way were left out", "Set facing to \"any\" to use all facets.";
        TurnedOver = "turned-over": "The surface was taken for turned over", "Check the orientation of the facets.";
        WallsOnly = "walls-only": "All facets are vertical", "Check the file's axes: Z is the tool axis.";
        FurtherColumns = "further-columns": "Columns beside x, y and z were left out", "Check that the first three columns are the coordinates.";
        TrailingBytes = "trailing-bytes": "Bytes after the end of the data were left out", "Check that the file's count is right.";
        OtherElements = "other-elements": "Elements other than vertices and faces were left out", "None is needed.";
        MissingPoints = "missing-points": "Points without coordinates were left out", "None is needed; scanners write them where they saw nothing.";
        CrossedPolygons = "crossed-polygons": "Polygons cross themselves", "Check the mesh; their area is uncertain.";
        FacetsMerged = "facets-merged": "The surface was merged on a raster", "Send fewer facets; details under the raster's cell are lost.";
        FlutesTooShort = "flutes-too-short": "The flutes are shorter than the surface is deep", "Check the clearance of shank and holder.";
        OtherTools = "other-tools": "Tools of a library are no finishing cutters", "None is needed; the detail counts them by type.";
        PassesLeftOut = "passes-left-out": "The passes have too many points for an answer", "Select a part of the surface, or allow more height.";
        MissingEnd = "missing-end": "The file ends inside a solid", "Check that the file is whole.";
    }
}
