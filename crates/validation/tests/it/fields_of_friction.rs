//! A field of friction that the simulator hides, found again by its places.

use dataset::{Manifest, RecordingSet, Table, ingest};
use diagnosis::{
    FitSettings, Footprints, NoiseModel, Observations, fit_with_noise, split, steady_ingest,
};
use effects::{Effect, FrictionField};
use models::{Analytical, ChannelModel, Description, PushModel, SurfaceKind};
use nalgebra::Vector2;
use plant::{Design, GenerateSettings, Truth, friction_over_table, generate};

const SEED: u64 = 12;

fn made() -> (Table, Manifest) {
    let folder = tempfile::tempdir().unwrap();
    let settings = GenerateSettings {
        hidden: vec!["friction-field".parse().unwrap()],
        design: Design { n_pushes: 80, ..Design::default() },
        format: "csv".into(),
        seed: SEED,
        ..GenerateSettings::default()
    };
    generate(&settings, &folder.path().join("set")).unwrap();
    let set = RecordingSet::open(&folder.path().join("set")).unwrap();
    let (table, _) = ingest(&set, &steady_ingest()).unwrap();
    (table, set.manifest().clone())
}

/// The table's friction as the simulator has it: its textures have the set's seed.
fn truth() -> impl Fn(&Vector2<f64>) -> f64 {
    let (mut truth, mut design) = (Truth::default(), Design::default());
    let hidden = plant::HiddenEffect::typical("friction-field").unwrap();
    hidden.apply(&mut truth, &mut design).unwrap();
    truth.texture_seed = SEED;
    friction_over_table(&truth)
}

/// Of the logarithms of friction, over places 1 cm apart that objects lay on.
fn correlation(values: &[f64], footprints: &Footprints) -> f64 {
    let truth = truth();
    let [low, high] = footprints.bounds().unwrap();
    let mut pairs = Vec::new();
    for k in 0..60 * 60 {
        let place = low + 0.01 * Vector2::new((k % 60) as f64, (k / 60) as f64);
        if place < high && footprints.n_pushes_over(&place) > 0 {
            pairs.push([truth(&place).ln(), FrictionField::log_ratio(values, &place)]);
        }
    }
    let mean =
        |of: &dyn Fn(&[f64; 2]) -> f64| pairs.iter().map(of).sum::<f64>() / pairs.len() as f64;
    let middle = [mean(&|pair| pair[0]), mean(&|pair| pair[1])];
    let product = |a: usize, b: usize| mean(&|pair| (pair[a] - middle[a]) * (pair[b] - middle[b]));
    product(0, 1) / (product(0, 0) * product(1, 1)).sqrt()
}

/// Root mean square of what a model misses of the turns, in rad.
fn missed(model: &Description, observations: &Observations, manifest: &Manifest) -> f64 {
    let model = ChannelModel::new(model, manifest.support, &[]).unwrap();
    let steps = observations.steps();
    let predicted = model.predict(steps.iter().map(|step| &step.input)).unwrap();
    let of = |(step, at): (&models::ChannelObservation, &effects::Channels)| {
        (step.observed[2].unwrap() - at.dtheta).powi(2)
    };
    let squares: f64 = steps.iter().zip(&predicted).map(of).sum();
    (squares / steps.len() as f64).sqrt()
}

/// A fit's correlation with the truth, and what its held-out pushes miss without the field and with it.
fn found(table: &Table, manifest: &Manifest) -> (f64, [f64; 2]) {
    let all = Observations::steady(table, manifest).unwrap();
    let parts = split(&all, 7).unwrap();
    let (train, held_out) = (all.part(&parts.fit).unwrap(), all.part(&parts.confirm).unwrap());
    let nominal = Analytical::nominal(manifest.pusher.friction).unwrap();
    let nominal = nominal.with_surface(SurfaceKind::UniformPatch).unwrap().describe().unwrap();
    let noise = NoiseModel::learn(&nominal, &[], &train).unwrap();
    let settings = FitSettings { resemblances: false, ..FitSettings::default() };
    let field = [FrictionField.info().id];
    let fit = fit_with_noise(&train, &nominal, &field, &noise, &settings).unwrap();
    let fit = fit.distinct().unwrap();
    let values: Vec<f64> = fit.effects[0].parameters.iter().map(|one| one.value).collect();
    let regions = fit.field.unwrap().regions;
    let (known, unknown) = (regions[0], regions[regions.len() - 1]);
    assert!(known.n_pushes == 2 && known.se < 0.7 * known.prior_sd, "{known:?}");
    assert!(unknown.n_pushes == 0 && unknown.se > 1.2 * known.se, "{unknown:?}");
    let missed = [&nominal, &fit.description].map(|model| missed(model, &held_out, manifest));
    (correlation(&values, &Footprints::of(&train)), missed)
}

#[test]
fn a_field_is_like_the_truth_where_pushes_were_and_foretells_others() {
    let (table, manifest) = made();
    let (correlation, [before, after]) = found(&table, &manifest);
    assert!(correlation > 0.6, "{correlation}");
    assert!(after < 0.9 * before, "{before} {after}");
}
