//! Whole pushes without particles beside very many of them.

use anyhow::{Context, Result};
use filter::{GaussHermite, Unscented};
use models::{
    ContactGap, GpPushModel, Matching, ProcessKind, PushModel, RollOut, RollOutSettings,
    SlipMixture, Training,
};
use planar::Pose;
use rayon::ThreadPoolBuilder;

use super::benchmark::Benchmark;
use super::filter::{observations, push, square};
use super::timing::{Case, Row};

pub(super) const BENCHMARK: Benchmark = Benchmark {
    name: "matching",
    about: "a whole push of a Gaussian process of 400 steps, and of a mixture of three, without \
            particles, beside the same push by 10⁶ particles that read the model from tables (of the \
            mixture 10⁵), on one thread",
    rows: |_| rows(),
};

const GRID: GaussHermite = GaussHermite { order: 3 };
const MANY: usize = 1_000_000;
/// The probabilities of a mixture's ways are sums over all its training steps.
const FEWER: usize = 100_000;

const METHODS: [(&str, Matching<'_>, usize); 5] = [
    ("unscented", Matching::Points(&Unscented), 1),
    ("Gauss–Hermite, order 3", Matching::Points(&GRID), 1),
    ("exact", Matching::Exact(&GRID), 1),
    ("unscented, 4 Gaussians", Matching::Points(&Unscented), 4),
    ("exact, 4 Gaussians", Matching::Exact(&GRID), 4),
];

fn rows() -> Result<Vec<Row>> {
    let steps = observations(&square()?)?;
    let training = Training::with(ProcessKind::Gp);
    let process = GpPushModel::train(&steps, &training)?.0;
    let mixture = SlipMixture::train(&steps, &training)?;
    let pool = ThreadPoolBuilder::new().num_threads(1).build().context("cannot start a thread")?;
    pool.install(|| {
        let (table, tables) = (process.tabulated()?.0, mixture.tabulated()?);
        let mut rows = Vec::new();
        for (name, matching, n) in METHODS {
            rows.push(row(&format!("gp, {name}"), [&process, &table], (matching, n), MANY)?);
        }
        for (name, matching, n) in METHODS {
            let models: [&dyn PushModel; 2] = [&mixture, &tables];
            rows.push(row(&format!("mixture, {name}"), models, (matching, n), FEWER)?);
        }
        Ok(rows)
    })
}

/// Without particles through a model, or through its tables where that serves, beside them.
fn row(
    name: &str,
    [model, table]: [&dyn PushModel; 2],
    (matching, n): (Matching<'_>, usize),
    n_particles: usize,
) -> Result<Row> {
    let (pushed, (path, _)) = (square()?, push()?);
    let settings = RollOutSettings {
        n_particles,
        touching: true,
        gap: ContactGap { sd: 3e-5, ..ContactGap::default() },
        start_sd: [1e-4, 5e-3],
        ..RollOutSettings::default()
    };
    let by_points = matches!(matching, Matching::Points(_));
    let without = RollOut {
        model: if by_points { table } else { model },
        pushed: &pushed,
        settings: &settings,
    };
    let with = RollOut { model: table, ..without };
    let candidate = || without.matched(&Pose::default(), &path, matching, n);
    candidate()?;
    let case = Case { name, size: n_particles, threads: 1, rounds: 3, calls: 1 };
    Ok(case.compare(candidate, || with.run(&Pose::default(), &path, |_, _| {})))
}
