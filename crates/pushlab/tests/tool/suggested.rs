//! `pushlab suggest`: the suggested pushes, made on the simulated rig, tell rivals apart.

use std::path::Path;

use dataset::{RecordingSet, ingest};
use diagnosis::{
    Aim, FitSettings, NoiseModel, Observations, SuggestSettings, SuggestedPush, Suggestion,
    fit_with_noise, steady_ingest, suggest,
};
use models::{Analytical, Base, Description, SurfaceKind};
use plant::{Design, GenerateSettings, Layout, PlannedPush, generate};

const RIVALS: [&str; 2] = ["table-anisotropy", "body-anisotropy"];
/// Hidden: the first of the rivals.
const HIDDEN: &str = "table-anisotropy: ratio=1.02, direction_deg=20";

/// A set of some pushes on the table with the hidden effect.
fn observed(design: Design, seed: u64) -> Observations {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("set");
    let hidden = vec![HIDDEN.parse().unwrap()];
    let settings = GenerateSettings { design, hidden, seed, ..GenerateSettings::default() };
    generate(&settings, &out).unwrap();
    observations(&out)
}

fn observations(set: &Path) -> Observations {
    let set = RecordingSet::open(set).unwrap();
    let (table, _) = ingest(&set, &steady_ingest()).unwrap();
    Observations::steady(&table, set.manifest()).unwrap()
}

fn planned(push: &SuggestedPush) -> PlannedPush {
    let SuggestedPush { edge, p, angle, speed, travel, pose_wb, repeat, .. } = push.clone();
    let place = [pose_wb.position.x, pose_wb.position.y, pose_wb.angle];
    PlannedPush { edge, p, angle, speed, travel, place, session: 0, repeat }
}

fn list(pushes: &[SuggestedPush]) -> Design {
    let layout = Layout::List(pushes.iter().map(planned).collect());
    Design { layout, n_pushes: 0, ..Design::default() }
}

fn model() -> Description {
    let analytical = Analytical::nominal(0.25).unwrap().with_surface(SurfaceKind::UniformPatch);
    Description { base: Base::Analytical(analytical.unwrap()), effects: vec![], weights: None }
}

/// By how much twice the log likelihood of the true rival is larger, both fitted to these pushes.
fn ratio(observations: &Observations) -> f64 {
    let settings = FitSettings { intervals: false, ..FitSettings::default() };
    let noise = NoiseModel::learn(&model(), &[], observations).unwrap();
    let misfit = RIVALS.map(|rival| {
        let fit = fit_with_noise(observations, &model(), &[rival], &noise, &settings).unwrap();
        let whitening = noise.whitening(&fit.with_nuisances, &[], observations).unwrap();
        fit.whitened_rms[1].powi(2) * whitening.n_numbers() as f64 + whitening.log_determinant()
    });
    misfit[1] - misfit[0]
}

#[test]
fn suggested_pushes_tell_rivals_apart_better_than_random_ones() {
    let layout = Layout::Narrow { edge: 0 };
    let narrow = Design { layout, n_pushes: 24, ..Design::default() };
    let so_far = observed(narrow, 5);
    let aim = Aim::Rivals(vec![RIVALS.map(str::to_owned).to_vec()]);
    let settings = SuggestSettings { n_candidates: 150, ..SuggestSettings::default() };
    let found: Suggestion = suggest(&so_far, &model(), &[], &aim, &settings).unwrap();
    let separation = &found.separations[0];
    eprintln!("{separation:?}, {} feasible", found.feasible.len());
    let before = ratio(&so_far);
    let suggested = ratio(&observed(list(&found.pushes), 6));
    let stride = found.feasible.len() / 20;
    let random: Vec<_> = found.feasible.iter().step_by(stride).take(20).cloned().collect();
    let random = ratio(&observed(list(&random), 6));
    eprintln!("2Δ log L: {before:.1} so far, {suggested:.1} suggested, {random:.1} random");
    assert!(suggested > 6.0 && suggested > random, "{before} {suggested} {random}");
}
