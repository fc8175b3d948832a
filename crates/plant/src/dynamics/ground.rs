//! Table and bottom of a plant, where they are uneven.

use libm::exp;
use nalgebra::{Vector2, Vector3};
use planar::Shape;

use crate::dynamics::pads::Pads;
use crate::dynamics::relief::{Part, Relief};
use crate::dynamics::stand::{Bottom, Stand};
use crate::dynamics::state::{State, rotation};
use crate::truth::{Burr, Truth};

/// Share of the tip's friction that no texture takes away.
const LEAST_FRICTION: f64 = 0.1;

/// Friction of a truth's table over that of its support, as a function of the place in m, frame W: 0 or more,
/// and without what objects or speeds make of it.
///
/// Its texture is of the truth's `texture_seed`, as a set of recordings has it.
pub fn friction_over_table(truth: &Truth) -> impl Fn(&Vector2<f64>) -> f64 + use<> {
    let texture = Relief::new(&truth.friction_map.texture, truth.texture_seed, Part::TableFriction);
    let map = truth.friction_map;
    move |place_w| map.factor(place_w) * rubbing(&texture, place_w)
}

/// What a texture of friction does to it at a place; never negative.
fn rubbing(texture: &Relief, place_w: &Vector2<f64>) -> f64 {
    (1.0 + texture.at(place_w)).max(0.0)
}

/// What varies from place to place.
#[derive(Clone, Debug)]
pub(crate) struct Ground {
    heights: Relief,
    frictions: Relief,
    /// Along the object's sides.
    sides: Relief,
    /// Vertices with a burr, in m, frame B.
    burrs: Vec<Vector2<f64>>,
    burr: Burr,
    /// The pads that bear the weight by where they stand.
    bottom: Option<Uneven>,
}

#[derive(Clone, Debug)]
struct Uneven {
    bottom: Bottom,
    /// How far each pad stands out of the bottom, in m.
    bumps: Vec<f64>,
    /// Length of 1 in the bottom's units, in m.
    radius: f64,
    /// How high the tip pushes over the weight, in m/N.
    lever: f64,
}

/// What the ground does to each pad.
#[derive(Clone, Debug)]
pub(crate) struct Footprint {
    /// State in which it was found: place (m and rad) and what the table's friction met (N), world frame.
    pub(crate) place: Vector3<f64>,
    pub(crate) rubbed: Vector2<f64>,
    /// Load of each pad over what it is on an even table.
    pub(crate) loads: Vec<f64>,
    /// The same for its friction.
    pub(crate) frictions: Vec<f64>,
    stand: Option<Stand>,
}

impl Footprint {
    /// Friction under the object over that on an even table, with the loads (N) that its pads have there.
    pub(crate) fn mean_friction(&self, loads: &[f64]) -> f64 {
        let rubbed: f64 = self.frictions.iter().zip(loads).map(|(own, load)| own * load).sum();
        rubbed / loads.iter().sum::<f64>()
    }
}

impl Ground {
    /// - `pads`: with a uniform load; - `center_of_mass`: in m, frame B; - `weight`: in N.
    pub(crate) fn new(
        truth: &Truth,
        shape: &Shape,
        pads: &Pads,
        center_of_mass: &Vector2<f64>,
        weight: f64,
    ) -> Self {
        let radius = shape.bounding_radius();
        let seed = truth.texture_seed;
        let underside = &truth.underside;
        let bottom = (underside.stiffness > 0.0).then(|| {
            let relief = Relief::new(&underside.texture, seed, Part::Underside);
            let place = |k: usize| Vector2::new(pads.x[k], pads.y[k]);
            let bump = |k: usize| {
                let out = place(k) / radius;
                let twist = underside.twist * out.x * out.y;
                underside.hollow * out.norm_squared() + twist + relief.at(&place(k))
            };
            let n = pads.share.len();
            let bottom = Bottom {
                places: (0..n).map(|k| (place(k) - center_of_mass) / radius).collect(),
                shares: pads.share.clone(),
                depth: weight / underside.stiffness,
            };
            let lever = truth.tip.height / weight;
            Uneven { bottom, bumps: (0..n).map(bump).collect(), radius, lever }
        });
        Self {
            heights: Relief::new(&truth.height_map.texture, seed, Part::TableHeight),
            frictions: Relief::new(&truth.friction_map.texture, seed, Part::TableFriction),
            sides: Relief::new(&truth.tip_friction.texture, seed, Part::Side),
            burrs: match shape {
                Shape::Polygon(polygon) => {
                    let rough = polygon.vertices().iter().take(truth.wear.burr.n_vertices);
                    rough.copied().collect()
                }
                Shape::Ellipse(_) => Vec::new(),
            },
            burr: truth.wear.burr,
            bottom,
        }
    }

    /// Friction of the tip at a place of the outline (m, frame B), of so much on an even side.
    pub(crate) fn tip_friction(&self, even: f64, place_b: &Vector2<f64>) -> f64 {
        let caught = |vertex: &Vector2<f64>| {
            let away = (place_b - vertex) / self.burr.reach;
            self.burr.friction * exp(-away.dot(&away))
        };
        let friction = even * (1.0 + self.sides.at(place_b)).max(LEAST_FRICTION);
        self.burrs.iter().fold(friction, |sum, vertex| sum + caught(vertex))
    }

    /// Whether every place under the object is like every other.
    pub(crate) fn is_even(&self) -> bool {
        self.bottom.is_none() && self.frictions.is_flat()
    }

    /// What it does to the pads.
    ///
    /// - `places_w`: where they stand in a state, in m; - `last`: what it did a little before.
    ///
    /// # Errors
    /// If the object tips over.
    pub(crate) fn footprint(
        &self,
        places_w: &[Vector2<f64>],
        state: &State,
        last: Option<&Footprint>,
    ) -> Result<Footprint, &'static str> {
        let mut loads = vec![1.0; places_w.len()];
        let mut stand = None;
        if let Some(uneven) = &self.bottom {
            let bumps: Vec<f64> = uneven
                .bumps
                .iter()
                .zip(places_w)
                .map(|(bump, place)| bump + self.heights.at(place))
                .collect();
            let force_b = rotation(state.place.z).transpose() * state.rubbed;
            let center = uneven.lever / uneven.radius * force_b;
            let last = last.and_then(|last| last.stand.as_ref());
            let found = uneven.bottom.stand(&bumps, &center, last)?;
            let shares = found.loads.iter().zip(&uneven.bottom.shares);
            for (load, (own, even)) in loads.iter_mut().zip(shares) {
                // Places that only fill a group bear nothing.
                *load = if *even > 0.0 { own / even } else { 1.0 };
            }
            stand = Some(found);
        }
        let rub = |(load, place): (&f64, &Vector2<f64>)| load * rubbing(&self.frictions, place);
        let frictions = loads.iter().zip(places_w).map(rub).collect();
        Ok(Footprint { place: state.place, rubbed: state.rubbed, loads, frictions, stand })
    }
}
