//! Toroidal, ball-end and flat-end cutters, discriminated by `type`.

use crate::http::codes::RequestFault;
use crate::http::reading::{
    AddMembers, Choice, Components, Faulted, Faults, JsonPath, Kind, Member, Members, Object, Quantity, Whole, members,
};
use crate::milling::{Cutter, CutterKind};
use crate::quantity::Length;
use serde_json::value::RawValue;
use utoipa::openapi::schema::{Discriminator, ObjectBuilder, OneOfBuilder, Type as SchemaKind};
use utoipa::openapi::{RefOr, Schema};

/// A cutter of a request, with its number of teeth.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StatedCutter {
    pub(crate) cutter: Cutter,
    /// z, the number of teeth, if stated.
    pub(crate) teeth: Option<u32>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Type {
    Toroidal,
    BallEnd,
    FlatEnd,
}

impl Type {
    /// The words of the types.
    pub(super) const WORDS: &[(&str, Self)] =
        &[("toroidal", Self::Toroidal), ("bull_nose", Self::Toroidal), ("ball_end", Self::BallEnd), ("flat_end", Self::FlatEnd)];

    pub(super) fn kind(self) -> CutterKind {
        match self {
            Self::Toroidal => CutterKind::Toroidal,
            Self::BallEnd => CutterKind::BallEnd,
            Self::FlatEnd => CutterKind::FlatEnd,
        }
    }
}

const TYPE: Member<Choice<Type>> = Member::new(
    "type",
    "the kind of cutter: toroidal (bull_nose is the same), ball_end or flat_end",
    Choice { name: None, words: Type::WORDS },
);

members! {
    /// The dimensions of a toroidal cutter.
    pub(crate) struct ToroidalDimensions for ToroidalCutter ("ToroidalDimensions", "The dimensions of a toroidal cutter: 0 < r < R") -> Cutter {
        diameter: required DIAMETER: Quantity<Length> = ("diameter_mm", Quantity::length(10.0), "cutting diameter 2R (ISO 13399: DC)"),
        corner_radius: required CORNER_RADIUS: Quantity<Length> = ("corner_radius_mm", Quantity::length(2.0),
            "corner radius r (ISO 13399: RE), under half the diameter"),
    }
}
members! {
    /// The dimension of a ball-end or flat-end cutter.
    pub(crate) struct DiameterOnly for BallEndCutter ("BallEndDimensions", "The dimension of a ball-end cutter") -> Cutter {
        diameter: required DIAMETER: Quantity<Length>,
    }
}
members! {
    /// The optional members of cutters of all kinds.
    pub(crate) struct AnyMembers {
        teeth: optional TEETH: Whole = ("teeth", Whole { minimum: 1, maximum: 100, example: 4 },
            "number of teeth z (ISO 13399: ZEFP); required for feed rates; with runout in model envelope, absent counts as 2, and with 1 all marks are alike"),
    }
}

impl ToroidalDimensions {
    fn build(self, path: &JsonPath<'_>, faults: &mut Faults) -> Result<Cutter, Faulted> {
        Cutter::toroidal(self.diameter?, self.corner_radius?)
            .map_err(|error| faults.add(&path.member(CORNER_RADIUS.name), RequestFault::CornerRadiusTooLarge, error))
    }
}

/// A cutter of any kind, discriminated by `type`.
pub(crate) struct AnyCutter;

impl Kind for AnyCutter {
    type Value = StatedCutter;

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<StatedCutter, Faulted> {
        let mut object = Object::open(raw, path, faults)?;
        let cutter = read_geometry(&mut object, faults);
        let teeth = AnyMembers::read(&mut object, faults).teeth;
        object.close(faults)?;
        Ok(StatedCutter { cutter: cutter?, teeth: teeth? })
    }

    fn schema(&self, about: &str, components: &mut Components) -> RefOr<Schema> {
        const ABOUT: &str = "A cutter, one of three kinds, discriminated by type";
        kinds_schema(["Cutter", "ToroidalCutter", "BallEndCutter", "FlatEndCutter"], ABOUT, &AnyMembers::describe, about, components)
    }
}

/// Reads type and dimensions of a cutter from `object`, which may have further members.
pub(super) fn read_geometry(object: &mut Object<'_, '_>, faults: &mut Faults) -> Result<Cutter, Faulted> {
    let path = object.path();
    match object.required(&TYPE, faults) {
        Ok(Type::Toroidal) => ToroidalDimensions::read(object, faults).build(&path, faults),
        Ok(Type::BallEnd) => DiameterOnly::read(object, faults).diameter.map(Cutter::ball_end),
        Ok(Type::FlatEnd) => DiameterOnly::read(object, faults).diameter.map(Cutter::flat_end),
        // Without a type, a corner radius can be neither missing nor unknown.
        Err(faulted) => {
            let _ = DiameterOnly::read(object, faults);
            object.optional(&CORNER_RADIUS, faults).and(Err(faulted))
        }
    }
}

/// The schema of an object with a cutter's type and dimensions and the members that `further` adds. `names` has the
/// name of the union, then those of its three kinds.
pub(super) fn kinds_schema(
    names: [&'static str; 4],
    of_union: &str,
    further: AddMembers<'_>,
    about: &str,
    components: &mut Components,
) -> RefOr<Schema> {
    let [union, toroidal, ball_end, flat_end] = names;
    components.refer(union, about, |components| {
        let kinds: [(_, _, _, AddMembers<'_>); 3] = [
            (Type::Toroidal, toroidal, "A toroidal (bull-nose, torus-end) cutter: 0 < r < R", &ToroidalDimensions::describe),
            (Type::BallEnd, ball_end, "A ball-end (ball-nose) cutter: r = R", &DiameterOnly::describe),
            (Type::FlatEnd, flat_end, "A flat-end cutter: r = 0", &DiameterOnly::describe),
        ];
        let mut any = OneOfBuilder::new().description(Some(of_union));
        let mut mapping = Vec::new();
        for (kind, name, about, dimensions) in kinds {
            let words: Vec<_> = TYPE.kind.words.iter().filter(|(_, of_word)| *of_word == kind).map(|(word, _)| *word).collect();
            mapping.extend(words.iter().map(|word| (*word, format!("#/components/schemas/{name}"))));
            let of_type: RefOr<Schema> =
                ObjectBuilder::new().schema_type(SchemaKind::String).description(Some(TYPE.about)).enum_values(Some(words)).into();
            let add: AddMembers<'_> = &|schema| further(dimensions(schema.required_property(TYPE.name, of_type.clone())));
            any = any.item(components.refer_object(name, "", about, add));
        }
        any.discriminator(Some(Discriminator::with_mapping(TYPE.name, mapping))).into()
    })
}

impl DiameterOnly {
    fn build(self, _: &JsonPath<'_>, _: &mut Faults) -> Result<Cutter, Faulted> {
        self.diameter.map(Cutter::ball_end)
    }
}
