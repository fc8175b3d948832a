//! Fits on sets of the simulator, whose truth no model knows.

use dataset::{Manifest, RecordingSet, Table, ingest};
use diagnosis::{
    DiagnosisError, Fit, FitSettings, NoiseModel, Observations, Undetermined, fit_with_noise,
    steady_ingest,
};
use models::{Analytical, Description, PushModel, SurfaceKind};
use plant::{Design, GenerateSettings, Scatter, generate};

fn made(hidden: &[&str], seed: u64, design: Design) -> (Table, Manifest) {
    let folder = tempfile::tempdir().unwrap();
    let settings = GenerateSettings {
        hidden: hidden.iter().map(|hidden| hidden.parse().unwrap()).collect(),
        design,
        // What differs from session to session is true of a set that has one.
        scatter: Scatter { session_share: 0.0, ..Scatter::default() },
        format: "csv".into(),
        seed,
        ..GenerateSettings::default()
    };
    generate(&settings, &folder.path().join("set")).unwrap();
    let set = RecordingSet::open(&folder.path().join("set")).unwrap();
    let (table, _) = ingest(&set, &steady_ingest()).unwrap();
    (table, set.manifest().clone())
}

/// The nominal model on the surface that the simulator's object stands on.
fn base(manifest: &Manifest) -> Description {
    let nominal = Analytical::nominal(manifest.pusher.friction).unwrap();
    nominal.with_surface(SurfaceKind::UniformPatch).unwrap().describe().unwrap()
}

fn fitted(observations: &Observations, model: &Description, free: &[&str]) -> Fit {
    let noise = NoiseModel::learn(model, &[], observations).unwrap();
    fit_with_noise(observations, model, free, &noise, &FitSettings::default()).unwrap()
}

fn rich() -> Design {
    Design { n_pushes: 60, repeat_share: 0.3, n_repeated: 4, ..Design::default() }
}

fn recovered(hidden: &str, seed: u64, effect: &str) -> Fit {
    let (table, manifest) = made(&[hidden], seed, rich());
    let observations = Observations::steady(&table, &manifest).unwrap();
    fitted(&observations, &base(&manifest), &[effect]).distinct().unwrap()
}

/// The truth of each parameter is within its 95 % interval.
fn assert_recovers(hidden: &str, seed: u64, effect: &str, truth: &[f64]) {
    let fit = recovered(hidden, seed, effect);
    for (parameter, truth) in fit.effects[0].parameters.iter().zip(truth) {
        let interval = parameter.interval.unwrap();
        let range = interval.low95..interval.high95;
        assert!(range.contains(truth), "{hidden}: {parameter:?}");
    }
    assert!(fit.whitened_rms[1] < fit.whitened_rms[0] && fit.whitened_rms[1] < 1.3, "{hidden}");
}

#[test]
fn a_grain_of_the_table_is_recovered() {
    let hidden = "table-anisotropy: ratio=1.3, direction_deg=34";
    assert_recovers(hidden, 11, "table-anisotropy", &[1.3, 34_f64.to_radians()]);
}

#[test]
fn a_load_that_leans_is_recovered() {
    let hidden = "friction-center-offset: x_mm=5, y_mm=-3";
    let fit = recovered(hidden, 21, "friction-center-offset");
    for (parameter, truth) in fit.effects[0].parameters.iter().zip([5e-3, -3e-3]) {
        assert!((parameter.value - truth).abs() <= 3.0 * parameter.se, "{parameter:?}");
    }
    assert!(fit.whitened_rms[1] < 1.15, "{:?}", fit.whitened_rms);
}

/// The effect moves all points of the support; the simulator's load gathers under the outline. What
/// that makes of 0.85 is 0.859 ± 0.009.
#[test]
fn a_load_that_gathers_is_recovered_to_two_percent() {
    let fit = recovered("pressure-radius: ratio=0.85", 22, "pressure-radius");
    let ratio = &fit.effects[0].parameters[0];
    assert!((ratio.value / 0.85 - 1.0).abs() < 0.02, "{ratio:?}");
    assert!(fit.whitened_rms[1] < 1.3, "{:?}", fit.whitened_rms);
}

#[test]
fn a_tilt_and_another_tip_are_recovered_together_in_any_order() {
    let hidden = ["table-tilt: x_m_s2=-0.25, y_m_s2=0.2", "pusher-friction: coefficient=0.35"];
    let (table, manifest) = made(&hidden, 13, rich());
    let observations = Observations::steady(&table, &manifest).unwrap();
    let one = fitted(&observations, &base(&manifest), &["table-tilt", "pusher-friction"]);
    let other = fitted(&observations, &base(&manifest), &["pusher-friction", "table-tilt"]);
    assert_eq!(one.effects, other.effects);
    assert_eq!(one.description, other.description);
    let found = one.distinct().unwrap();
    let parameters = found.effects.iter().flat_map(|effect| &effect.parameters);
    for (parameter, truth) in parameters.zip([-0.25, 0.2, 0.35]) {
        assert!((parameter.value - truth).abs() < 3.0 * parameter.se, "{parameter:?}");
    }
}

#[test]
fn what_is_not_there_is_refused() {
    let (table, manifest) = made(&[], 15, rich());
    let observations = Observations::steady(&table, &manifest).unwrap();
    let model = base(&manifest);
    let refused = fitted(&observations, &model, &["table-tilt"]).distinct();
    let why = |refused: Result<Fit, DiagnosisError>| match refused {
        Err(DiagnosisError::Undetermined { why, .. }) => why,
        other => panic!("{other:?}"),
    };
    assert!(matches!(why(refused), Undetermined::NotDistinct { .. }));
    // Without a force sensor nothing shows the friction of the table.
    let mut table = table;
    for row in &mut table.rows {
        row.force = None;
    }
    let observations = Observations::steady(&table, &manifest).unwrap();
    let refused = fitted(&observations, &model, &["support-friction"]).determined();
    assert!(matches!(why(refused), Undetermined::NoChannel { .. }));
}
