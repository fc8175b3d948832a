//! What a model was made for: object, pusher and table, as its data stated them.

use dataset::{ObjectChoice, PusherSpec, SupportSpec};
use planar::Shape;
use serde::{Deserialize, Serialize};

/// Two statements of one thing differ by less than this share of it: a mass of 0.837 kg is that of 0.8374 kg.
const SAME: f64 = 2e-3;

/// Object, pusher and table that a model was made for; in SI units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MadeFor {
    /// Name of the set or the table.
    pub set: String,
    /// Radius of the pusher, in m.
    pub pusher_radius_m: f64,
    /// Nominal friction between pusher and object.
    pub pusher_friction: f64,
    /// Nominal friction between object and table.
    pub support_friction: f64,
    /// The object; none where each recording names its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub object: Option<MadeForObject>,
}

/// The object that a model was made for, in SI units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MadeForObject {
    /// Name of its shape.
    pub shape: String,
    /// Extents of the outline along x and y of the body frame, in m.
    pub size_m: [f64; 2],
    /// Area within the outline, in m².
    pub area_m2: f64,
    /// Mass, in kg.
    pub mass_kg: f64,
}

/// A quantity in which two rigs differ.
#[derive(Clone, Debug, PartialEq)]
pub struct RigDifference {
    /// What it is, for people.
    pub what: &'static str,
    /// Its SI unit; `1` for none.
    pub unit: &'static str,
    /// The one's and the other's: a number, or one along each axis.
    pub values: [Vec<f64>; 2],
}

impl MadeFor {
    /// What a set or a table states.
    #[must_use]
    pub fn new(set: &str, object: &ObjectChoice, pusher: PusherSpec, support: SupportSpec) -> Self {
        let object = match object {
            ObjectChoice::Fixed(spec) => Some(MadeForObject {
                shape: spec.name.clone(),
                size_m: size(&spec.shape).map(rounded),
                area_m2: rounded(spec.shape.area()),
                mass_kg: spec.mass,
            }),
            ObjectChoice::ByFileName => None,
        };
        Self {
            set: set.to_owned(),
            pusher_radius_m: pusher.radius,
            pusher_friction: pusher.friction,
            support_friction: support.friction,
            object,
        }
    }

    /// In what another rig differs, by more than two statements of one thing do; objects are compared where
    /// both have one. The same in both directions but for the order of the values.
    #[must_use]
    pub fn differences(&self, other: &Self) -> Vec<RigDifference> {
        let mut found = Vec::new();
        let mut compare = |what, unit, one: &[f64], another: &[f64]| {
            let is_same = one.iter().zip(another).all(|(a, b)| {
                let scale = a.abs().max(b.abs());
                (a - b).abs() <= SAME * scale
            });
            if !is_same {
                let values = [one.to_vec(), another.to_vec()];
                found.push(RigDifference { what, unit, values });
            }
            is_same
        };
        if let (Some(one), Some(another)) = (&self.object, &other.object) {
            // An area tells of outlines of one size alone.
            if compare("outline", "m", &one.size_m, &another.size_m) {
                compare("area of the outline", "m²", &[one.area_m2], &[another.area_m2]);
            }
            compare("mass", "kg", &[one.mass_kg], &[another.mass_kg]);
        }
        let numbers = |of: &Self| [of.pusher_radius_m, of.pusher_friction, of.support_friction];
        let named = [("pusher radius", "m"), ("pusher friction", "1"), ("table friction", "1")];
        for ((what, unit), (one, another)) in
            named.into_iter().zip(numbers(self).into_iter().zip(numbers(other)))
        {
            compare(what, unit, &[one], &[another]);
        }
        found
    }

    /// The key whose number no rig has, and what it may be.
    pub(super) fn problem(&self) -> Option<(&'static str, String)> {
        let positive = |key, value: f64| {
            (!(value > 0.0 && value.is_finite()))
                .then(|| (key, format!("must be positive and finite, got {value:?}")))
        };
        let not_negative = |key, value: f64| {
            (!(value >= 0.0 && value.is_finite()))
                .then(|| (key, format!("must be finite and not negative, got {value:?}")))
        };
        let of_object = |object: &MadeForObject| {
            let [width, height] = object.size_m;
            positive("made_for.object.size_m", width)
                .or_else(|| positive("made_for.object.size_m", height))
                .or_else(|| positive("made_for.object.area_m2", object.area_m2))
                .or_else(|| positive("made_for.object.mass_kg", object.mass_kg))
        };
        not_negative("made_for.pusher_radius_m", self.pusher_radius_m)
            .or_else(|| not_negative("made_for.pusher_friction", self.pusher_friction))
            .or_else(|| not_negative("made_for.support_friction", self.support_friction))
            .or_else(|| self.object.as_ref().and_then(of_object))
    }
}

/// Extents along x and y, in m.
fn size(shape: &Shape) -> [f64; 2] {
    match shape {
        Shape::Polygon(polygon) => [0, 1].map(|axis| {
            let along = polygon.vertices().iter().map(|vertex| vertex[axis]);
            let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
                (low.min(x), high.max(x))
            });
            high - low
        }),
        Shape::Ellipse(ellipse) => {
            let (x, y) = ellipse.semi_axes();
            [2.0 * x, 2.0 * y]
        }
    }
}

/// Without the digits that sums leave behind, which nobody wants to read in a file.
fn rounded(value: f64) -> f64 {
    const DIGITS: f64 = 1e9;
    (DIGITS * value).round() / DIGITS
}

#[cfg(test)]
mod tests {
    use dataset::{ObjectChoice, ObjectSpec, PusherSpec, SupportSpec};

    use super::MadeFor;

    fn of(shape: &str) -> MadeFor {
        let object = ObjectChoice::Fixed(Box::new(ObjectSpec::mit(shape).unwrap()));
        let (pusher, support) = (
            PusherSpec { radius: 0.005, friction: 0.25 },
            SupportSpec { friction: 0.3, gravity: 9.81 },
        );
        MadeFor::new("a set", &object, pusher, support)
    }

    #[test]
    fn a_rig_differs_from_itself_in_nothing_and_from_another_in_what_is_changed() {
        let rig = of("rect1");
        assert_eq!(rig.differences(&MadeFor { set: "another".into(), ..rig.clone() }), []);
        let mut other = MadeFor { pusher_radius_m: 0.006, ..rig.clone() };
        other.object.as_mut().unwrap().mass_kg *= 1.001;
        let found = rig.differences(&other);
        assert_eq!(found.len(), 1, "a mass rounded to three digits is the same: {found:?}");
        assert_eq!((found[0].what, found[0].unit), ("pusher radius", "m"));
        assert_eq!(found[0].values, [vec![0.005], vec![0.006]]);
        let back = other.differences(&rig);
        assert_eq!(back[0].values, [vec![0.006], vec![0.005]]);
        let unknown = MadeFor { object: None, ..other };
        assert_eq!(rig.differences(&unknown), found, "no object is no other object");
    }

    #[test]
    fn outlines_of_one_size_are_told_apart_by_their_area() {
        let (rig, mut other) = (of("rect1"), of("rect1"));
        let object = other.object.as_mut().unwrap();
        object.area_m2 *= std::f64::consts::FRAC_PI_4;
        assert_eq!(rig.differences(&other)[0].what, "area of the outline");
        let whats: Vec<_> =
            of("rect1").differences(&of("hex")).into_iter().map(|d| d.what).collect();
        assert_eq!(whats, ["outline", "mass"]);
    }
}
