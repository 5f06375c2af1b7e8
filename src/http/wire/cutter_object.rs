//! Cutters of all kinds, discriminated by `type`.

use crate::http::codes::RequestFault;
use crate::http::reading::{
    AddMembers, Choice, Components, Declared, Faulted, Faults, JsonPath, Kind, List, Member, Members, Object, Quantity, Whole, members,
};
use crate::milling::{Cutter, CutterError, CutterKind, MOST_ARCS, ProfileArc, ProfileError};
use crate::quantity::{Angle, Length, OutOfRange};
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

/// The kinds with their words.
pub(super) const KINDS: &[(&str, CutterKind)] = &[
    ("toroidal", CutterKind::Toroidal),
    ("bull_nose", CutterKind::Toroidal),
    ("ball_end", CutterKind::BallEnd),
    ("flat_end", CutterKind::FlatEnd),
    ("tapered_ball", CutterKind::TaperedBall),
    ("lens", CutterKind::Lens),
    ("oval", CutterKind::Oval),
    ("conical_barrel", CutterKind::ConicalBarrel),
    ("profile", CutterKind::Profile),
];

const TYPE: Member<Choice<CutterKind>> = Member::new(
    "type",
    "the kind of cutter: toroidal (bull_nose is the same), ball_end, flat_end, tapered_ball, lens, oval, conical_barrel or profile",
    Choice { name: None, words: KINDS },
);

/// The smallest and the largest taper in degrees.
const TAPERS: [f64; 2] = [0.01, 89.99];

const fn taper(example: f64) -> Quantity<Angle> {
    Quantity::new(|degrees| OutOfRange::check(degrees, TAPERS[0], TAPERS[1]).and_then(Angle::from_degrees), example)
}

const fn angle_deg(example: f64) -> Quantity<f64> {
    Quantity::new(|degrees| OutOfRange::check(degrees, 0.0, 90.0), example)
}

const fn offset(example: f64) -> Quantity<f64> {
    Quantity::new(|mm| OutOfRange::check(mm, -Length::LARGEST, Length::LARGEST), example)
}

members! {
    /// The dimensions of a toroidal cutter.
    pub(crate) struct ToroidalDimensions for ToroidalCutter ("ToroidalDimensions", "The dimensions of a toroidal cutter: 0 < r < R") -> Cutter {
        diameter: required DIAMETER: Quantity<Length> = ("diameter_mm", Quantity::length(10.0),
            "cutting diameter 2R (ISO 13399: DC); of a tapered ball that of the ball, of a conical barrel that where its side arc ends"),
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
    /// The dimensions of a tapered ball.
    struct TaperedBallDimensions {
        diameter: required DIAMETER: Quantity<Length>,
        taper: required TAPER: Quantity<Angle> = ("taper_deg", taper(5.0), "half the angle of the cone: that of its flank to the axis"),
        shank_diameter: required SHANK_DIAMETER: Quantity<Length> = ("shank_diameter_mm", Quantity::length(6.0),
            "the diameter at which the cone ends"),
    }
}
members! {
    /// The dimensions of a lens.
    struct LensDimensions {
        diameter: required DIAMETER: Quantity<Length>,
        lens_radius: required LENS_RADIUS: Quantity<Length> = ("lens_radius_mm", Quantity::length(40.0),
            "the radius of the bottom, which is centred on the axis; at least half the diameter"),
        corner_radius: required CORNER_RADIUS: Quantity<Length>,
    }
}
members! {
    /// The dimensions of a barrel with a ball tip.
    struct OvalDimensions {
        diameter: required DIAMETER: Quantity<Length>,
        tip_radius: required TIP_RADIUS: Quantity<Length> = ("tip_radius_mm", Quantity::length(2.0), "the radius of the ball tip"),
        side_radius: required SIDE_RADIUS: Quantity<Length> = ("side_radius_mm", Quantity::length(80.0),
            "the radius of the side arc, which touches the tip"),
    }
}
members! {
    /// The dimensions of a conical barrel.
    struct ConicalBarrelDimensions {
        diameter: required DIAMETER: Quantity<Length>,
        tip_radius: required TIP_RADIUS: Quantity<Length>,
        side_radius: required SIDE_RADIUS: Quantity<Length>,
        taper: required TAPER: Quantity<Angle>,
    }
}
members! {
    /// The members of an arc.
    struct ArcMembers for ArcObject ("ProfileArc", "An arc of a cutter's lower profile, or a corner if its radius is 0") -> ProfileArc {
        radius: required ARC_RADIUS: Quantity<f64> = ("radius_mm", Quantity::new(|mm| OutOfRange::check(mm, 0.0, Length::LARGEST), 2.0),
            "the radius"),
        centre_offset: required CENTRE_OFFSET: Quantity<f64> = ("centre_offset_mm", offset(3.0),
            "the distance of the centre from the axis; negative beyond the axis"),
        centre_height: required CENTRE_HEIGHT: Quantity<f64> = ("centre_height_mm", offset(2.0),
            "the height of the centre over the cutter's tip"),
        from: required FROM: Quantity<f64> = ("from_deg", angle_deg(0.0),
            "the angle of the outward normal where the arc begins, nearer to the axis: 0 is straight down, 90 horizontal"),
        to: required TO: Quantity<f64> = ("to_deg", angle_deg(90.0), "the angle of the outward normal where the arc ends"),
    }
}
members! {
    /// The arcs of a profile.
    struct ProfileDimensions {
        arcs: required ARCS: List<ArcObject> = ("arcs",
            List { item: ArcObject, about_item: "an arc", fewest: 1, most: MOST_ARCS },
            "the arcs of the lower profile from the axis outwards; where two do not touch, a flat or a cone with the normal of both joins them, and above the last one the cutter is a cylinder"),
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
        checked(Cutter::toroidal(self.diameter?, self.corner_radius?), path, CORNER_RADIUS.name, faults)
    }
}

impl DiameterOnly {
    fn build(self, _: &JsonPath<'_>, _: &mut Faults) -> Result<Cutter, Faulted> {
        self.diameter.map(Cutter::ball_end)
    }
}

impl ArcMembers {
    fn build(self, _: &JsonPath<'_>, _: &mut Faults) -> Result<ProfileArc, Faulted> {
        let (radius, centre_offset, centre_height) = (self.radius?, self.centre_offset?, self.centre_height?);
        Ok(ProfileArc { radius, centre_offset, centre_height, from: self.from?.to_radians(), to: self.to?.to_radians() })
    }
}

/// The cutter, or the fault at the member whose dimension does not fit the others. `large_radius` names the radius of lens or
/// side.
fn checked(cutter: Result<Cutter, CutterError>, path: &JsonPath<'_>, large_radius: &str, faults: &mut Faults) -> Result<Cutter, Faulted> {
    cutter.map_err(|error| {
        let member = match error {
            CutterError::CornerTooLarge { .. } => {
                return faults.add(&path.member(CORNER_RADIUS.name), RequestFault::CornerRadiusTooLarge, error);
            }
            CutterError::Profile(of_profile) => {
                let arcs = path.member(ARCS.name);
                return match of_profile {
                    ProfileError::Arc { index } | ProfileError::Join { index } => {
                        faults.add(&arcs.item(index), RequestFault::NotAProfile, error)
                    }
                    ProfileError::NumberOfArcs | ProfileError::TipNotAtZero | ProfileError::NoWidth => {
                        faults.add(&arcs, RequestFault::NotAProfile, error)
                    }
                };
            }
            CutterError::Taper => TAPER.name,
            CutterError::ShankTooNarrow { .. } => SHANK_DIAMETER.name,
            CutterError::TipTooLarge { .. } => TIP_RADIUS.name,
            CutterError::LargeRadiusTooSmall { .. } => large_radius,
        };
        faults.add(&path.member(member), RequestFault::DimensionsDoNotFit, error)
    })
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
        const ABOUT: &str = "A cutter, one of eight kinds, discriminated by type";
        kinds_schema(("Cutter", ABOUT), |shape| shape.names[0], &AnyMembers::describe, about, components)
    }
}

/// Reads type and dimensions of a cutter from `object`, which may have further members.
pub(super) fn read_geometry(object: &mut Object<'_, '_>, faults: &mut Faults) -> Result<Cutter, Faulted> {
    let path = object.path();
    match object.required(&TYPE, faults) {
        Ok(CutterKind::Toroidal) => ToroidalDimensions::read(object, faults).build(&path, faults),
        Ok(CutterKind::BallEnd) => DiameterOnly::read(object, faults).diameter.map(Cutter::ball_end),
        Ok(CutterKind::FlatEnd) => DiameterOnly::read(object, faults).diameter.map(Cutter::flat_end),
        Ok(CutterKind::TaperedBall) => {
            let TaperedBallDimensions { diameter, taper, shank_diameter } = TaperedBallDimensions::read(object, faults);
            checked(Cutter::tapered_ball(diameter?, taper?, shank_diameter?), &path, SHANK_DIAMETER.name, faults)
        }
        Ok(CutterKind::Lens) => {
            let LensDimensions { diameter, lens_radius, corner_radius } = LensDimensions::read(object, faults);
            checked(Cutter::lens(diameter?, lens_radius?, corner_radius?), &path, LENS_RADIUS.name, faults)
        }
        Ok(CutterKind::Oval) => {
            let OvalDimensions { diameter, tip_radius, side_radius } = OvalDimensions::read(object, faults);
            checked(Cutter::oval(diameter?, tip_radius?, side_radius?), &path, SIDE_RADIUS.name, faults)
        }
        Ok(CutterKind::ConicalBarrel) => {
            let ConicalBarrelDimensions { diameter, tip_radius, side_radius, taper } = ConicalBarrelDimensions::read(object, faults);
            checked(Cutter::conical_barrel(diameter?, tip_radius?, side_radius?, taper?), &path, SIDE_RADIUS.name, faults)
        }
        Ok(CutterKind::Profile) => {
            let arcs = ProfileDimensions::read(object, faults).arcs?;
            checked(Cutter::from_arcs(&arcs), &path, ARCS.name, faults)
        }
        // Without a type, a dimension can be neither missing nor unknown, but for the diameter, which all but one have.
        Err(faulted) => {
            if !object.has(ARCS.name) {
                let _ = DiameterOnly::read(object, faults);
            }
            let others = SHAPES.iter().flat_map(|shape| shape.declared).filter(|declared| declared.member.name() != DIAMETER.name);
            others.for_each(|declared| object.check(declared.member, faults));
            Err(faulted)
        }
    }
}

/// A kind in the OpenAPI document.
pub(super) struct ShapeSchema {
    kind: CutterKind,
    /// The names of its schema, as a cutter and as a candidate.
    pub(super) names: [&'static str; 2],
    about: &'static str,
    declared: &'static [Declared],
}

const SHAPES: [ShapeSchema; 8] = [
    ShapeSchema {
        kind: CutterKind::Toroidal,
        names: ["ToroidalCutter", "ToroidalCandidate"],
        about: "A toroidal (bull-nose, torus-end) cutter: 0 < r < R",
        declared: ToroidalDimensions::DECLARED,
    },
    ShapeSchema {
        kind: CutterKind::BallEnd,
        names: ["BallEndCutter", "BallEndCandidate"],
        about: "A ball-end (ball-nose) cutter: r = R",
        declared: DiameterOnly::DECLARED,
    },
    ShapeSchema {
        kind: CutterKind::FlatEnd,
        names: ["FlatEndCutter", "FlatEndCandidate"],
        about: "A flat-end cutter: r = 0",
        declared: DiameterOnly::DECLARED,
    },
    ShapeSchema {
        kind: CutterKind::TaperedBall,
        names: ["TaperedBallCutter", "TaperedBallCandidate"],
        about: "A tapered ball: a ball, then a cone that touches it, up to the shank",
        declared: TaperedBallDimensions::DECLARED,
    },
    ShapeSchema {
        kind: CutterKind::Lens,
        names: ["LensCutter", "LensCandidate"],
        about: "A lens: a bottom of a large radius, centred on the axis, and a corner radius that touches it and ends at the diameter",
        declared: LensDimensions::DECLARED,
    },
    ShapeSchema {
        kind: CutterKind::Oval,
        names: ["OvalCutter", "OvalCandidate"],
        about: "An oval: a ball tip, and a side of a large radius that touches it and is upright at the diameter; a barrel with a ball tip",
        declared: OvalDimensions::DECLARED,
    },
    ShapeSchema {
        kind: CutterKind::ConicalBarrel,
        names: ["ConicalBarrelCutter", "ConicalBarrelCandidate"],
        about: "A conical barrel: a ball tip, and a side of a large radius that touches it and ends at the diameter, where its tangent has the taper to the axis",
        declared: ConicalBarrelDimensions::DECLARED,
    },
    ShapeSchema {
        kind: CutterKind::Profile,
        names: ["ProfileCutter", "ProfileCandidate"],
        about: "Any convex cutter of revolution, by its lower profile: arcs and straight pieces from the tip outwards",
        declared: ProfileDimensions::DECLARED,
    },
];

/// The schema of an object with a cutter's type and dimensions and the members that `further` adds. `union` has the name and the
/// description of the union, `name` chooses those of its kinds.
pub(super) fn kinds_schema(
    union: (&'static str, &str),
    name: fn(&ShapeSchema) -> &'static str,
    further: AddMembers<'_>,
    about: &str,
    components: &mut Components,
) -> RefOr<Schema> {
    components.refer(union.0, about, |components| {
        let mut any = OneOfBuilder::new().description(Some(union.1));
        let mut mapping = Vec::new();
        for shape in &SHAPES {
            let name = name(shape);
            let words: Vec<_> = KINDS.iter().filter(|(_, of_word)| *of_word == shape.kind).map(|(word, _)| *word).collect();
            mapping.extend(words.iter().map(|word| (*word, format!("#/components/schemas/{name}"))));
            let of_type: RefOr<Schema> =
                ObjectBuilder::new().schema_type(SchemaKind::String).description(Some(TYPE.about)).enum_values(Some(words)).into();
            let add: AddMembers<'_> = &|schema| further(schema.required_property(TYPE.name, of_type.clone()).with_members(shape.declared));
            any = any.item(components.refer_object(name, "", shape.about, add));
        }
        any.discriminator(Some(Discriminator::with_mapping(TYPE.name, mapping))).into()
    })
}
