//! The wire form of a cutter.

use crate::http::codes::RequestFault;
use crate::http::reading::member::{Choice, StatedLength, Whole};
use crate::http::reading::{Faulted, Faults, Kind, Member, Object, ObjectSchema, Place};
use crate::milling::Cutter;
use crate::quantity::Length;
use serde_json::value::RawValue;
use utoipa::openapi::schema::{Discriminator, OneOfBuilder};
use utoipa::openapi::{Ref, RefOr, Schema};

/// A cutter as requests state it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StatedCutter {
    pub(crate) cutter: Cutter,
    /// z, the number of teeth, where stated.
    pub(crate) teeth: Option<u32>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Type {
    Toroidal,
    BallEnd,
    FlatEnd,
}

const TYPE: Member<Choice<Type>> = Member {
    name: "type",
    about: "the kind of cutter: toroidal (bull_nose is the same), ball_end or flat_end",
    kind: Choice {
        words: &[("toroidal", Type::Toroidal), ("bull_nose", Type::Toroidal), ("ball_end", Type::BallEnd), ("flat_end", Type::FlatEnd)],
    },
};
const DIAMETER: Member<StatedLength> =
    Member { name: "diameter_mm", about: "cutting diameter DC = 2R (ISO 13399)", kind: StatedLength { example: 10.0 } };
const CORNER_RADIUS: Member<StatedLength> = Member {
    name: "corner_radius_mm",
    about: "corner radius RE = r (ISO 13399), under half the diameter",
    kind: StatedLength { example: 2.0 },
};
const TEETH: Member<Whole> = Member {
    name: "teeth",
    about: "number of teeth z (ZEFP of ISO 13399); feed rates need it",
    kind: Whole { minimum: 1, maximum: 100, example: 4 },
};

/// The member `cutter` of the calculations.
pub(super) const CUTTER: Member<AnyCutter> =
    Member { name: "cutter", about: "the cutter, one of three kinds told apart by type", kind: AnyCutter };

/// The member `toroidal` where the name says the kind.
pub(crate) const TOROIDAL: Member<ToroidalCutter> =
    Member { name: "toroidal", about: "the toroidal cutter to compare", kind: ToroidalCutter };

/// The member `ball_end` where the name says the kind.
pub(crate) const BALL_END: Member<BallEndCutter> =
    Member { name: "ball_end", about: "the ball-end cutter to compare", kind: BallEndCutter };

/// A cutter of any kind, told apart by `type`.
pub(crate) struct AnyCutter;

impl Kind for AnyCutter {
    type Value = StatedCutter;

    fn read(&self, raw: &RawValue, place: Place<'_>, faults: &mut Faults) -> Result<StatedCutter, Faulted> {
        let mut object = Object::open(raw, place, faults)?;
        let kind = object.required(&TYPE, faults);
        let diameter = object.required(&DIAMETER, faults);
        // Without a kind nobody knows whether a corner radius belongs there, so none is asked for or called unknown.
        let cutter = match kind {
            Ok(Type::Toroidal) => toroidal(&mut object, diameter, faults),
            Ok(Type::BallEnd) => diameter.map(Cutter::ball_end),
            Ok(Type::FlatEnd) => diameter.map(Cutter::flat_end),
            Err(faulted) => object.optional(&CORNER_RADIUS, faults).and(Err(faulted)),
        };
        let teeth = object.optional(&TEETH, faults);
        object.close(faults)?;
        Ok(StatedCutter { cutter: cutter?, teeth: teeth? })
    }

    fn schema(&self, _: &str) -> RefOr<Schema> {
        RefOr::Ref(Ref::from_schema_name("Cutter"))
    }
}

/// A toroidal cutter without `type`.
pub(crate) struct ToroidalCutter;

impl Kind for ToroidalCutter {
    type Value = Cutter;

    fn read(&self, raw: &RawValue, place: Place<'_>, faults: &mut Faults) -> Result<Cutter, Faulted> {
        let mut object = Object::open(raw, place, faults)?;
        let diameter = object.required(&DIAMETER, faults);
        let cutter = toroidal(&mut object, diameter, faults);
        object.close(faults)?;
        cutter
    }

    fn schema(&self, about: &str) -> RefOr<Schema> {
        ObjectSchema::new(about).required(&DIAMETER).required(&CORNER_RADIUS).build()
    }
}

/// A ball-end cutter without `type`.
pub(crate) struct BallEndCutter;

impl Kind for BallEndCutter {
    type Value = Cutter;

    fn read(&self, raw: &RawValue, place: Place<'_>, faults: &mut Faults) -> Result<Cutter, Faulted> {
        let mut object = Object::open(raw, place, faults)?;
        let diameter = object.required(&DIAMETER, faults);
        object.close(faults)?;
        diameter.map(Cutter::ball_end)
    }

    fn schema(&self, about: &str) -> RefOr<Schema> {
        ObjectSchema::new(about).required(&DIAMETER).build()
    }
}

fn toroidal(object: &mut Object<'_, '_>, diameter: Result<Length, Faulted>, faults: &mut Faults) -> Result<Cutter, Faulted> {
    let corner_radius = object.required(&CORNER_RADIUS, faults);
    Cutter::toroidal(diameter?, corner_radius?)
        .map_err(|error| faults.add(&object.place().member(CORNER_RADIUS.name), RequestFault::CornerRadiusTooLarge, error))
}

/// The schemas of the cutters, by name.
pub(super) fn schemas() -> Vec<(String, RefOr<Schema>)> {
    const TORUS: Choice<Type> = Choice { words: &[("toroidal", Type::Toroidal), ("bull_nose", Type::Toroidal)] };
    const BALL: Choice<Type> = Choice { words: &[("ball_end", Type::BallEnd)] };
    const FLAT: Choice<Type> = Choice { words: &[("flat_end", Type::FlatEnd)] };
    let kinds = [
        ("ToroidalCutter", "toroidal (bull-nose, torus-end) cutter: 0 < r < R", TORUS),
        ("BallEndCutter", "ball-end (ball-nose) cutter: r = R", BALL),
        ("FlatEndCutter", "flat-end cutter: r = 0", FLAT),
    ];
    let mut any = OneOfBuilder::new().description(Some("a cutter, one of three kinds told apart by type"));
    let mut discriminator = Vec::new();
    let mut schemas = Vec::new();
    for (name, about, choice) in kinds {
        let words = choice.words;
        let kind = Member { name: TYPE.name, about: TYPE.about, kind: choice };
        let schema = ObjectSchema::new(about).required(&kind).required(&DIAMETER);
        let schema = if name == "ToroidalCutter" { schema.required(&CORNER_RADIUS) } else { schema };
        schemas.push((name.to_owned(), schema.optional(&TEETH).build()));
        any = any.item(Ref::from_schema_name(name));
        discriminator.extend(words.iter().map(|(word, _)| (*word, format!("#/components/schemas/{name}"))));
    }
    let any = any.discriminator(Some(Discriminator::with_mapping(TYPE.name, discriminator)));
    schemas.push(("Cutter".to_owned(), Schema::OneOf(any.build()).into()));
    schemas
}
