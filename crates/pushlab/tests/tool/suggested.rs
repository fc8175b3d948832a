//! `pushlab suggest`: the suggested pushes, made on the simulated rig, tell rivals apart.

use dataset::{Manifest, RecordingSet, StepRow, Table, ingest};
use diagnosis::{
    Aim, FitSettings, NoiseModel, Observations, Separation, SuggestSettings, SuggestedPush,
    fit_with_noise, steady_ingest, suggest,
};
use models::{Analytical, Base, Description, SurfaceKind};
use plant::{Design, GenerateSettings, Layout, PlannedPush, generate};

const RIVALS: [&str; 2] = ["table-anisotropy", "body-anisotropy"];
/// Hidden: the first of the rivals.
const HIDDEN: &str = "table-anisotropy: ratio=1.01, direction_deg=20";

/// Steps of some pushes on the table with the hidden effect, on a rig without force sensor.
fn made(design: Design, seed: u64) -> (Table, Manifest) {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("set");
    let hidden = vec![HIDDEN.parse().unwrap()];
    let settings = GenerateSettings { design, hidden, seed, ..GenerateSettings::default() };
    generate(&settings, &out).unwrap();
    let set = RecordingSet::open(&out).unwrap();
    let (mut table, _) = ingest(&set, &steady_ingest()).unwrap();
    table.rows.iter_mut().for_each(|row| row.force = None);
    (table, set.manifest().clone())
}

/// The pushes so far with further ones.
fn together(so_far: &(Table, Manifest), further: &[SuggestedPush]) -> Observations {
    let (mut all, manifest) = so_far.clone();
    let (further, _) = made(list(further), 6);
    all.rows.extend(further.rows.into_iter().map(|row| {
        let recording = format!("further-{}", row.recording).into();
        StepRow { recording, ..row }
    }));
    Observations::steady(&all, &manifest).unwrap()
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
    let settings = FitSettings { intervals: false, resemblances: false, ..FitSettings::default() };
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
    let narrow = Design { layout, n_pushes: 20, ..Design::default() };
    let so_far = made(narrow, 5);
    let before = Observations::steady(&so_far.0, &so_far.1).unwrap();
    let aim = Aim::Rivals(vec![RIVALS.map(str::to_owned).to_vec()]);
    let settings = SuggestSettings { n_candidates: 150, ..SuggestSettings::default() };
    let found = suggest(&before, &model(), &[], &aim, &settings).unwrap();
    let Separation { now, expected, with_random, .. } = found.separations[0].clone();
    let stride = found.feasible.len() / 4;
    let random = found.feasible.iter().step_by(stride).take(4);
    let random: Vec<_> = random.flat_map(|push| vec![push.clone(); 5]).collect();
    assert_eq!((found.pushes.len(), random.len()), (20, 20));
    let before = ratio(&before);
    let [suggested, random] =
        [&found.pushes, &random].map(|further| ratio(&together(&so_far, further)));
    eprintln!(
        "2Δ log L: {before:.0} so far, {suggested:.0} with suggested, {random:.0} with random"
    );
    eprintln!("in sd, as told: {now:.1}, {expected:.1}, {with_random:.1}");
    assert!(suggested > 6.0 && suggested > random, "{before} {suggested} {random}");
    assert!(expected > with_random && with_random > now, "{now} {expected} {with_random}");
}
