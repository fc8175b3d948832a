//! Noise and screen on sets of the simulator, whose truth no model knows.

use dataset::{RecordingSet, ingest};
use diagnosis::{
    FloorSource, NoiseModel, Observations, Reason, Screen, ScreenSettings, ScreenedEffect, screen,
    steady_ingest,
};
use models::{Analytical, Description, PushModel, SurfaceKind};
use plant::{Design, GenerateSettings, Scatter, Sensor, Sensors, generate};

/// A set whose sessions do not differ, as recorded, with the model of its own surface.
fn made(settings: &GenerateSettings) -> (Observations, Description) {
    let folder = tempfile::tempdir().unwrap();
    generate(settings, &folder.path().join("set")).unwrap();
    let set = RecordingSet::open(&folder.path().join("set")).unwrap();
    let (table, _) = ingest(&set, &steady_ingest()).unwrap();
    let observations = Observations::steady(&table, set.manifest()).unwrap();
    let nominal = Analytical::nominal(set.manifest().pusher.friction).unwrap();
    let model = nominal.with_surface(SurfaceKind::UniformPatch).unwrap().describe().unwrap();
    (observations, model)
}

fn settings(n_pushes: usize, hidden: &[&str], seed: u64) -> GenerateSettings {
    GenerateSettings {
        hidden: hidden.iter().map(|hidden| hidden.parse().unwrap()).collect(),
        design: Design { n_pushes, repeat_share: 0.3, ..Design::default() },
        scatter: Scatter { session_share: 0.0, ..Scatter::default() },
        format: "csv".into(),
        seed,
        ..GenerateSettings::default()
    }
}

fn screened(settings: &GenerateSettings) -> (Screen, NoiseModel) {
    let (observations, model) = made(settings);
    let noise = NoiseModel::learn(&model, &[], &observations).unwrap();
    let found = screen(&model, &[], &observations, &noise, &ScreenSettings::default()).unwrap();
    (found, noise)
}

fn effect<'a>(found: &'a Screen, id: &str) -> &'a ScreenedEffect {
    found.effects.iter().find(|effect| effect.id == id).unwrap()
}

#[test]
fn repeats_tell_what_differs_from_push_to_push_and_whiten_the_rest() {
    let (found, noise) = screened(&settings(100, &[], 31));
    assert_eq!((noise.source, noise.n_cells), (FloorSource::Repeats, 3));
    // As the simulator's usual scatter has them, friction times its nominal value.
    let truth = [5e-3, 5e-3, 1e-2, 2e-4, 1e-4, 1e-2];
    let of_push = noise.sources.iter().filter(|source| source.of_push);
    for (source, truth) in of_push.zip(truth) {
        // Intervals of 95 % of six sources: wider by half, all hold.
        let held = source.low95 / 1.5 < truth && truth < 1.5 * source.high95;
        assert!(held, "{source:?} {truth}");
    }
    // The gap that ends a step follows from the others, and steps that go on have no other gap of their own.
    let [own, .., first_gap, last_gap] = found.whitened_rms.map(|rms| rms.is_some());
    assert!(own && first_gap && !last_gap, "{:?}", found.whitened_rms);
    for rms in found.whitened_rms.iter().take(6) {
        assert!((0.7..1.3).contains(&rms.unwrap()), "{:?}", found.whitened_rms);
    }
    for correlation in found.step_correlation.iter().take(5) {
        assert!(correlation.unwrap().abs() < 0.35, "{:?}", found.step_correlation);
    }
}

#[test]
fn what_is_hidden_comes_out_on_top() {
    for (hidden, seed) in [
        ("table-anisotropy: ratio=1.15, direction_deg=34", 41),
        ("friction-center-offset: x_mm=3, y_mm=-2", 42),
        ("pusher-friction: coefficient=0.32", 43),
        ("robot-offset: x_mm=0.3, y_mm=-0.2", 45),
    ] {
        let (found, _) = screened(&settings(60, &[hidden], seed));
        let id = hidden.split(':').next().unwrap();
        let (first, known) = (&found.effects[0], effect(&found, id));
        assert_eq!(first.id, id, "{:?}", &found.effects[..3]);
        assert!(known.p_adjusted <= 0.01 && known.statistic > 100.0, "{known:?}");
    }
}

/// A score is of one step: friction with the pusher promises more here than it would keep, and a
/// refit of the first few has to tell.
#[test]
fn a_bias_of_the_contact_is_among_the_first_three() {
    let (found, _) = screened(&settings(60, &["contact-bias: offset_mm=1.5"], 44));
    let place = found.effects.iter().position(|effect| effect.id == "contact-bias").unwrap();
    assert!(place < 3 && found.effects[place].p_adjusted <= 0.01, "{:?}", &found.effects[..4]);
}

#[test]
fn without_force_only_what_moves_the_object_can_be_tested() {
    let mut settings = settings(40, &[], 51);
    settings.sensors =
        Sensors { force: Sensor { rate: 0.0, ..Sensor::default() }, ..settings.sensors };
    let (found, _) = screened(&settings);
    for id in ["support-friction", "friction-drift", "force-bias"] {
        let why = effect(&found, id).not_testable.as_ref().unwrap();
        assert!(why.measure.contains("the contact force"), "{id} {why:?}");
        assert!(matches!(why.reason, Reason::NoChannel | Reason::Weak), "{id} {why:?}");
    }
    for id in ["table-anisotropy", "friction-center-offset", "pusher-friction", "pose-offset"] {
        assert_eq!(effect(&found, id).not_testable, None, "{id}");
    }
    assert_eq!(found.whitened_rms[3], None);
}

/// Estimates of what is not there scatter over sets as their standard errors say.
#[test]
fn standard_errors_are_those_of_the_scatter_over_sets() {
    const COORDINATES: [(&str, usize); 6] = [
        ("support-friction", 0),
        ("friction-center-offset", 0),
        ("friction-center-offset", 1),
        ("table-anisotropy", 0),
        ("table-anisotropy", 1),
        ("pressure-radius", 0),
    ];
    let sets: Vec<Screen> = (0..10).map(|seed| screened(&settings(40, &[], 60 + seed)).0).collect();
    // About their mean: the simulator's object has a mass and stands on points, not on a patch.
    let variance = |id: &str, k: usize| {
        let of = |found: &Screen| {
            let coordinate = effect(found, id).coordinates[k];
            coordinate.change / coordinate.se
        };
        let ratios: Vec<f64> = sets.iter().map(of).collect();
        let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
        let squares = ratios.iter().map(|ratio| (ratio - mean).powi(2)).sum::<f64>();
        squares / (ratios.len() - 1) as f64
    };
    let all = COORDINATES.map(|(id, k)| variance(id, k));
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    // Six coordinates of ten sets: a mean of 54 squares, which scatters by 0.19.
    assert!((0.5..1.6).contains(&mean), "{all:?}");
}
