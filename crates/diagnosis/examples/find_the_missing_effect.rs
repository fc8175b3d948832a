//! Finds the physical effect that the nominal model lacks, with one of one's own among the
//! candidates: `cargo run -p pushlab-diagnosis --example find_the_missing_effect -- fixtures/pushes`

use std::sync::Arc;

use dataset::{RecordingSet, ingest};
use diagnosis::{DiagnoseSettings, Observations, Verdict, diagnose, steady_ingest};
use effects::{Channel, Effect, EffectInfo, Nuisance, Origin, Parameter, Sliding, Stage};
use models::{Analytical, PushModel};

/// Friction that grows towards one place of the table.
#[derive(Debug)]
struct StickySpot;

static INFO: EffectInfo = EffectInfo {
    id: "sticky-spot",
    title: "Sticky spot",
    physics: "Friction is larger around the origin of the table's frame.",
    equation: "μ(x) = μs (1 + s exp(−|x|²/(2 r²))), r = 30 mm",
    source: "made up",
    stages: &[Stage::Local],
    origin: Origin::Table,
    reaches: &[Channel::Motion, Channel::Force],
    parameters: &[Parameter::number("surplus", "1", "At its middle", (0.0, 0.5), (0.0, 5.0))],
    confounders: &[],
    nuisance: Nuisance::No,
    shown_by: &[],
};

impl Effect for StickySpot {
    fn info(&self) -> &EffectInfo {
        &INFO
    }

    fn local_friction(&self, values: &[f64], sliding: &Sliding) -> f64 {
        values[0] * (-0.5 * sliding.place_w.norm_squared() / 0.03_f64.powi(2)).exp()
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("usage: find_the_missing_effect SET")?;
    let set = RecordingSet::open(path.as_ref())?;
    let (table, _) = ingest(&set, &steady_ingest())?;
    let observations = Observations::steady(&table, set.manifest())?;
    let model = Analytical::nominal(set.manifest().pusher.friction)?.describe()?;
    let settings =
        DiagnoseSettings { own: vec![Arc::new(StickySpot)], ..DiagnoseSettings::default() };
    let found = diagnose(&observations, &model, &settings)?;
    println!("{}", found.diagnosis.sentence);
    if found.diagnosis.verdict == Verdict::Identified {
        println!("the model with it: {:?}", found.description.effects);
    }
    for effect in found.diagnosis.effects.iter().filter(|effect| effect.id == INFO.id) {
        println!("{}: {:?}, p {:?} {}", effect.id, effect.grade, effect.p_adjusted, effect.why);
    }
    Ok(())
}
