//! Evaluation of one facet by the models of `milling`: its contact, its curvature in the axes of the feed, heights and
//! feeds.

use crate::milling::{Contact, ContactError, CurvatureOutOfRange, Cutter, EvaluatedPass, Model, NoAnswer, Pass, Runout, SurfaceCurvature};
use crate::surface::FinishFacet;

/// The reason why a facet has no height or feed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum NoContact {
    Contact(ContactError),
    Curvature(CurvatureOutOfRange),
    Model(NoAnswer),
    /// The cutter does not fit the surface.
    Gouges,
}

/// The contact at a facet for one direction of passes, with the facet's curvature in the axes of the feed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FacetContact {
    pub(super) contact: Contact,
    /// Curvature along the feed, across it and the mixed one, in 1/mm.
    pub(super) curvature: [f64; 3],
}

impl FacetContact {
    pub(super) fn new(facet: &FinishFacet, e: [f64; 2]) -> Result<Self, NoContact> {
        let n = facet.normal;
        let climb = -(n[0] * e[0] + n[1] * e[1]) / n[2];
        let length = climb.hypot(1.0);
        let feed = [e[0] / length, e[1] / length, climb / length];
        let across = [n[1] * feed[2] - n[2] * feed[1], n[2] * feed[0] - n[0] * feed[2], n[0] * feed[1] - n[1] * feed[0]];
        let contact = Contact::from_vectors(n, feed, None).map_err(NoContact::Contact)?;
        let curvature =
            [facet.curvature_between(feed, feed), facet.curvature_between(across, across), facet.curvature_between(feed, across)];
        Ok(Self { contact, curvature })
    }

    /// Whether the facet is one of a plane.
    pub(super) fn is_plane(&self) -> bool {
        self.curvature.iter().all(|&curvature| curvature == 0.0)
    }

    /// The step-over along the surface of planes `spacing` apart seen from above, in mm.
    pub(super) fn step_over(&self, spacing: f64) -> f64 {
        spacing / self.contact.spacing_ratio()
    }

    pub(super) fn evaluated(&self, cutter: Cutter, model: Model) -> Result<EvaluatedPass, NoContact> {
        let [along, across, twist] = self.curvature;
        let surface = SurfaceCurvature::from_components_per_mm(along, across, twist).map_err(NoContact::Curvature)?;
        let pass = Pass { cutter, contact: self.contact, surface, runout: Runout::NONE, teeth: None };
        EvaluatedPass::fitting(model, pass).map_err(NoContact::Model)?.ok_or(NoContact::Gouges)
    }
}
