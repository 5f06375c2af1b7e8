//! A contact of a batch, with its own parameters.

use super::contact_object::{self, StatedContact};
use super::contact_parameters::{ContactParameters, StatedParameters};
use crate::http::reading::{Components, Faulted, Faults, Object};
use utoipa::openapi::{RefOr, Schema};

/// A contact and its own parameters.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BatchContact {
    pub(crate) contact: StatedContact,
    pub(crate) parameters: ContactParameters,
}

impl BatchContact {
    /// Reads a contact whose own parameters override `defaults`. `faults` has no faults but those of this contact.
    pub(super) fn read(mut object: Object<'_, '_>, defaults: &ContactParameters, faults: &mut Faults) -> Result<Self, Faulted> {
        let path = object.path();
        let contact = contact_object::read(&mut object, faults);
        let parameters = ContactParameters::read(&mut object, defaults.stated, faults).or(defaults);
        object.close(faults)?;
        parameters.step_over(&path, faults)?;
        // The faults of the defaults are recorded with the request. A contact fails because of them only if it uses
        // them.
        if faults.is_empty() { Ok(Self { contact: contact?, parameters }) } else { Err(Faulted) }
    }
}

/// The schema of a contact with the parameters that `stated` allows.
pub(super) fn batch_contact_schemas(stated: StatedParameters, components: &mut Components) -> RefOr<Schema> {
    let names = ["AngleContact", "VectorContact"].map(|form| stated.name(form));
    contact_object::forms(names.each_ref().map(String::as_str), "A contact with its own parameters", components, &|schema| {
        schema.with_members(stated.members())
    })
}
