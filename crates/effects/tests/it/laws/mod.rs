//! Laws that every effect of the catalogue obeys.

mod recovery;
mod steps;
mod world;

use std::collections::BTreeSet;
use std::sync::Arc;

use effects::{
    Channel, Channels, Effect, EffectError, Off, PushPhysics, Role, StepInput, Surface, all, by_id,
    by_id_with,
};
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use world::World;

const SURFACES: [Surface; 2] = [Surface::Ellipsoid, Surface::UniformPatch];

/// Differences that count as a change of a channel: a millionth of a step's motion, force and gap.
const FLOOR: [f64; 7] = [1e-9, 1e-9, 1e-8, 1e-6, 1e-6, 1e-9, 1e-9];

/// Whether its numbers are those of the body's axes alone, or of the table's: no other axes have the same.
fn is_of_axes(effect: &dyn Effect, world: &World) -> bool {
    let has = |role| effect.info().parameters.iter().any(|parameter| parameter.role == role);
    has(Role::Cell) && (world.is_mirrored || world.body_turn != 0.0)
        || has(Role::Wave) && (world.is_mirrored || world.turn != 0.0)
}

fn predict(physics: &PushPhysics, steps: &[StepInput]) -> Vec<[f64; 7]> {
    let channels = physics.predict_all(steps).unwrap();
    channels.iter().map(Channels::to_array).collect()
}

/// The model with one effect of its typical size, in a world of its own units and axes.
fn with_typical(effect: &Arc<dyn Effect>, world: &World, surface: &Surface) -> PushPhysics {
    let rig = world.rig(surface.clone());
    let values =
        world.values(effect.as_ref(), &effect.info().typical(&World::PLAIN.rig(surface.clone())));
    PushPhysics::new(rig).with(effect, &values).unwrap()
}

#[test]
fn an_effect_that_is_off_equals_the_baseline_bit_for_bit() {
    for surface in SURFACES {
        let (rig, steps) = (World::PLAIN.rig(surface), World::PLAIN.steps());
        let baseline = predict(&PushPhysics::new(rig.clone()), &steps);
        let mut together = PushPhysics::new(rig.clone());
        for effect in all() {
            let off = effect.info().off(&rig);
            let alone = PushPhysics::new(rig.clone()).with(effect, &off).unwrap();
            assert_eq!(predict(&alone, &steps), baseline, "{}", effect.info().id);
            together = together.with(effect, &off).unwrap();
        }
        assert_eq!(predict(&together, &steps), baseline);
    }
}

#[test]
fn an_effect_reaches_the_channels_that_it_claims_and_no_other() {
    for surface in SURFACES {
        let steps = World::PLAIN.steps();
        let baseline = predict(&PushPhysics::new(World::PLAIN.rig(surface.clone())), &steps);
        for effect in all() {
            let about = effect.info();
            let with = predict(&with_typical(effect, &World::PLAIN, &surface), &steps);
            for channel in Channel::ALL {
                let changes = with.iter().zip(&baseline).any(|(a, b)| {
                    (0..7).any(|i| Channels::KINDS[i] == channel && (a[i] - b[i]).abs() > FLOOR[i])
                });
                assert_eq!(changes, about.reaches.contains(&channel), "{} {channel:?}", about.id);
            }
        }
    }
}

/// The same physics in another world: equal, up to rounding, once both are in the same units.
///
/// Where the exact surface of the patch takes part, its table in the body's axes limits the body's.
fn agree(name: &str, world: &World, tolerance: f64) {
    let (plain_steps, steps) = (World::PLAIN.steps(), world.steps());
    for surface in SURFACES {
        for effect in all() {
            let id = effect.info().id;
            if is_of_axes(effect.as_ref(), world) {
                continue;
            }
            let is_tabulated = surface_shape(&surface) != 0.0 || id == "limit-surface-shape";
            let is_limited = is_tabulated && world.body_turn != 0.0;
            let plain = predict(&with_typical(effect, &World::PLAIN, &surface), &plain_steps);
            let other = predict(&with_typical(effect, world, &surface), &steps);
            for (step, (a, b)) in plain.iter().zip(&other).enumerate() {
                let b = world.channels_back(b);
                let tolerance = match is_limited {
                    false => tolerance,
                    true if is_long(&plain_steps[step]) => 2e-2,
                    true => 1e-3,
                };
                for i in 0..7 {
                    let near = (a[i] - b[i]).abs() <= tolerance * FLOOR[i] * 1e6;
                    let channel = Channels::NAMES[i];
                    assert!(
                        near,
                        "{name} {surface:?} {id} step {step} {channel}: {} {}",
                        a[i], b[i]
                    );
                }
            }
        }
    }
}

/// On long outlines the table is coarser: ten times longer than wide.
fn is_long(step: &StepInput) -> bool {
    let shape = step.object.shape();
    shape.area() < 0.5 * shape.bounding_radius().powi(2)
}

fn surface_shape(surface: &Surface) -> f64 {
    World::PLAIN.rig(surface.clone()).surface_shape()
}

#[test]
fn every_parameter_has_the_unit_that_it_states() {
    agree("lengths", &World { length: 2.0, ..World::PLAIN }, 1e-6);
    agree("times", &World { time: 0.5, ..World::PLAIN }, 1e-6);
    agree("masses", &World { mass: 4.0, ..World::PLAIN }, 1e-6);
}

#[test]
fn a_mirrored_world_gives_mirrored_channels() {
    agree("mirror", &World { is_mirrored: true, ..World::PLAIN }, 1e-7);
}

#[test]
fn the_axes_of_the_world_do_not_matter() {
    agree("world axes", &World { turn: 0.9, ..World::PLAIN }, 1e-7);
}

#[test]
fn the_axes_of_the_body_do_not_matter() {
    agree("body axes", &World { body_turn: -1.3, ..World::PLAIN }, 1e-7);
}

#[test]
fn the_same_set_of_effects_in_any_order_gives_the_same_bits() {
    let (mut random, steps) = (ChaCha8Rng::seed_from_u64(5), World::PLAIN.steps());
    for round in 0..8 {
        let surface = SURFACES[round % 2].clone();
        let rig = World::PLAIN.rig(surface);
        let mut chosen: Vec<_> =
            all().iter().filter(|_| random.random_bool(0.8)).cloned().collect();
        let built = |order: &[Arc<dyn Effect>]| {
            let add = |model: PushPhysics, effect: &Arc<dyn Effect>| {
                model.with(effect, &effect.info().typical(&rig)).unwrap()
            };
            predict(&order.iter().fold(PushPhysics::new(rig.clone()), add), &steps)
        };
        let first = built(&chosen);
        chosen.shuffle(&mut random);
        assert_eq!(built(&chosen), first, "{chosen:?}");
    }
}

#[test]
fn settings_bring_a_model_back() {
    let rig = World::PLAIN.rig(Surface::Ellipsoid);
    let add = |model: PushPhysics, effect: &Arc<dyn Effect>| {
        model.with(effect, &effect.info().typical(&rig)).unwrap()
    };
    let model = all().iter().fold(PushPhysics::new(rig.clone()), add);
    let text = serde_json::to_string(&model.settings()).unwrap();
    let settings: Vec<effects::Setting> = serde_json::from_str(&text).unwrap();
    let back = PushPhysics::from_settings(rig, &settings, &[]).unwrap();
    assert_eq!(back.settings(), model.settings());
    let steps = World::PLAIN.steps();
    assert_eq!(predict(&back, &steps), predict(&model, &steps));
}

#[test]
fn values_out_of_range_are_named() {
    let rig = World::PLAIN.rig(Surface::Ellipsoid);
    for effect in all() {
        let about = effect.info();
        for (index, parameter) in about.parameters.iter().enumerate() {
            for bad in [parameter.range.1 + 1.0, parameter.range.0 - 1.0, f64::NAN, f64::INFINITY] {
                let mut values = about.typical(&rig);
                values[index] = bad;
                let error = PushPhysics::new(rig.clone()).with(effect, &values).unwrap_err();
                let text = error.to_string();
                assert!(text.contains(about.id) && text.contains(parameter.name), "{text}");
                assert!(text.contains(&bad.to_string()), "{text}");
            }
        }
        let mut too_many = about.typical(&rig);
        too_many.push(0.0);
        let error = PushPhysics::new(rig.clone()).with(effect, &too_many).unwrap_err();
        assert!(matches!(error, EffectError::WrongCount { got, .. } if got == too_many.len()));
        let once = PushPhysics::new(rig.clone()).with(effect, &about.off(&rig)).unwrap();
        let twice = once.with(effect, &about.off(&rig)).unwrap_err();
        assert_eq!(twice, EffectError::DuplicateEffect { effect: about.id.to_owned() });
    }
    assert!(matches!(by_id("friction"), Err(EffectError::UnknownEffect { .. })));
}

#[test]
fn the_catalogue_is_consistent() {
    let rig = World::PLAIN.rig(Surface::Ellipsoid);
    let ids: BTreeSet<_> = all().iter().map(|effect| effect.info().id).collect();
    assert_eq!(ids.len(), all().len());
    for effect in all() {
        let about = effect.info();
        assert_eq!(by_id_with(about.id, &[]).unwrap().info().id, about.id);
        for confounder in about.confounders {
            let other = by_id(confounder.id).unwrap().info();
            assert_ne!(other.id, about.id);
        }
        about.check(&about.off(&rig)).unwrap();
        about.check(&about.typical(&rig)).unwrap();
        for (index, parameter) in about.parameters.iter().enumerate() {
            let pairs = match parameter.role {
                Role::X(frame) => Some(Role::Y(frame)),
                Role::Ratio(frame) => Some(Role::Direction(frame)),
                _ => None,
            };
            let next = about.parameters.get(index + 1).map(|next| next.role);
            assert!(pairs.is_none() || pairs == next, "{} {}", about.id, parameter.name);
            assert!(parameter.off == Off::Undefined || parameter.on(&rig) != parameter.off(&rig));
        }
        let values = about.typical(&rig);
        let back = about.from_coordinates(&about.to_coordinates(&values));
        assert!(values.iter().zip(&back).all(|(a, b)| (a - b).abs() < 1e-14), "{}", about.id);
        assert_eq!(about.coordinates(&rig).len(), values.len());
    }
}
