//! Steps of particles beside what their arithmetic costs at least, and steps of other filters.

mod follow;

use std::path::Path;
use std::process::Command;
use std::sync::Arc;

use anyhow::{Context, Result};
use filter::ParticleFilter;
use gp_core::{SquaredExponential, cross};
use models::{
    Analytical, GpPushModel, Noise, PathStep, ProcessKind, PushModel, PushPath, Pushed, RollOut,
    RollOutSettings, StepInput, StepObservation, Training,
};
use nalgebra::{Vector2, Vector3};
use planar::{Pose, Shape};
use rayon::ThreadPoolBuilder;

use super::benchmark::Benchmark;
use super::floor::Floor;
use super::timing::{Case, Row};
use fixtures::surface::surface;
use fixtures::workspace_root;

pub(super) const BENCHMARK: Benchmark = Benchmark {
    name: "filter",
    about: "one step of 10⁴ particles, three outputs with variance, beside its floor: for a kernel its \
            exponentials at the rate of a cross matrix, and the M² products a particle and output at \
            the rate of faer's matrix product, beside the full variance and a table of it; the \
            analytical model beside its mean alone, on one thread; a step and a measured pose by filters \
            of each kind beside 500 particles, on the same table; NumPy in \
            crates/benchmarks/peers/filter.py, where there is Python, as a reference by itself",
    rows: |_| rows(),
};

const N_PARTICLES: usize = 10_000;
const N_STEPS: usize = 400;
const N_OUTPUTS: f64 = 3.0;
const SIDE: f64 = 0.09;
/// The pusher's way in a step, in m.
const WAY: f64 = 0.004;
const RADIUS: f64 = 0.005;

/// A learnt kind, its size M and whether its floor counts exponentials.
const KINDS: [(&str, ProcessKind, usize); 3] = [
    ("gp, N = 400", ProcessKind::Gp, N_STEPS),
    ("spgp, M = 80", ProcessKind::Spgp, 80),
    ("rff, 100 features", ProcessKind::Rff, 100),
];

fn rows() -> Result<Vec<Row>> {
    let pushed = square()?;
    let steps = observations(&pushed)?;
    let mut rows = Vec::new();
    for threads in [1, 2] {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.with_context(|| format!("cannot start {threads} threads"))?;
        pool.install(|| -> Result<()> {
            rows.push(analytical(&pushed, threads)?);
            for (name, kind, size) in KINDS {
                rows.extend(learnt(&pushed, &steps, (name, kind, size), threads)?);
            }
            Ok(())
        })?;
    }
    let pool = ThreadPoolBuilder::new().num_threads(1).build().context("cannot start a thread")?;
    rows.extend(pool.install(|| follow::rows(&pushed, &steps))?);
    rows.extend(peer()?);
    Ok(rows)
}

/// What is pushed.
pub(super) fn square() -> Result<Pushed> {
    Ok(Pushed { shape: Arc::new(Shape::square(SIDE)?), pusher_radius: RADIUS, object: None })
}

/// Steps of one face as the analytical model has them.
pub(super) fn observations(pushed: &Pushed) -> Result<Vec<StepObservation>> {
    let model = Analytical::nominal(0.25)?;
    let step = |k: usize| {
        let (p, beta) = ((k as f64 * 0.618).fract(), -0.7 + 1.4 * (k as f64 * 0.414).fract());
        let input = StepInput::on_edge(pushed.shape.clone(), RADIUS, 1, p, beta, WAY)?;
        let mean = model.predict(std::slice::from_ref(&input), Noise::Excluded)?[0].mean;
        let noise = 2e-5 * ((k * 7919 % 17) as f64 - 8.0) / 8.0;
        let outputs = mean + Vector3::new(noise, -noise, 30.0 * noise);
        Ok(StepObservation { input, outputs })
    };
    (0..N_STEPS).map(step).collect()
}

/// Steps of one push, all as long as those that were learnt from.
pub(super) fn push() -> Result<(PushPath, Vec<PathStep>)> {
    let start = Vector2::new(-0.5 * SIDE - RADIUS, 0.01);
    let path = PushPath::straight(start, start + Vector2::new(0.016, 0.004), 0.02)?;
    let steps = path.steps(WAY)?;
    Ok((path, steps))
}

/// A row of whole pushes, as one of a step.
fn a_step_of(n_steps: usize, row: Row) -> Row {
    let n = n_steps as f64;
    let (median_seconds, reference_seconds) = (row.median_seconds / n, row.reference_seconds / n);
    Row { median_seconds, reference_seconds, ..row }
}

/// Particles already spread a little, so that every one has a contact of its own.
fn settings() -> RollOutSettings {
    RollOutSettings { n_particles: N_PARTICLES, start_sd: [1e-4, 5e-3], ..Default::default() }
}

fn learnt(
    pushed: &Pushed,
    steps: &[StepObservation],
    (name, kind, size): (&str, ProcessKind, usize),
    threads: usize,
) -> Result<[Row; 2]> {
    let training = Training { n_pseudo_inputs: size, n_features: size, ..Training::with(kind) };
    let model = GpPushModel::train(steps, &training)?.0;
    let (path, steps) = push()?;
    let settings = RollOutSettings { touching: true, ..settings() };
    let mut products = Floor::new(N_OUTPUTS * N_PARTICLES as f64 * (size * size) as f64, threads);
    let (x, _) = surface(N_PARTICLES, 7);
    let (z, _) = surface(size, 8);
    let kernel = SquaredExponential::new(&[0.5, 0.7], 1.0)?;
    // A feature's cosine costs no less than an exponential.
    let exponentials = || -> f64 {
        let matrix = |_| cross(&kernel, x.as_ref(), z.as_ref());
        (0..N_OUTPUTS as usize).filter_map(|k| Some(matrix(k).ok()?[(0, 0)])).sum()
    };
    let mut row = |name: &str, model: &GpPushModel| -> Result<Row> {
        let roll_out = RollOut { model, pushed, settings: &settings };
        let start = roll_out.start(&Pose::default(), &path)?;
        let candidate = || moved(&start, &roll_out, &steps);
        candidate()?;
        let case = Case { name, size: N_PARTICLES, threads, rounds: 5, calls: 1 };
        let floor = || steps.iter().map(|_| products.multiply(1) + exponentials()).sum::<f64>();
        Ok(a_step_of(steps.len(), case.compare(candidate, floor)))
    };
    let (table, _) = model.tabulated()?;
    Ok([row(name, &model)?, row(&format!("{name}, table"), &table)?])
}

/// Particles after all steps.
fn moved(
    start: &ParticleFilter<'static, models::PushParticle>,
    roll_out: &RollOut<'_>,
    steps: &[PathStep],
) -> Result<ParticleFilter<'static, models::PushParticle>> {
    let mut filter = start.clone();
    for step in steps {
        filter.predict(&roll_out.motion(step)?)?;
    }
    Ok(filter)
}

fn analytical(pushed: &Pushed, threads: usize) -> Result<Row> {
    let model = Analytical::nominal(0.25)?;
    let (path, steps) = push()?;
    let settings = RollOutSettings { touching: true, ..settings() };
    let roll_out = RollOut { model: &model, pushed, settings: &settings };
    let start: ParticleFilter<'_, _> = roll_out.start(&Pose::default(), &path)?;
    let step = steps[0];
    let input = |particle: &models::PushParticle| {
        let shape = pushed.shape.clone();
        StepInput::between(shape, RADIUS, &particle.pose_wb, &step.start_w, &step.end_w)
    };
    let inputs = start.particles().iter().map(input).collect::<Result<Vec<_>, _>>()?;
    let candidate = || moved(&start, &roll_out, &steps);
    candidate()?;
    let means = || -> f64 {
        let all = || model.parts(&inputs).ok()?.first().map(|parts| parts.physics.z);
        steps.iter().filter_map(|_| all()).sum()
    };
    let case = Case { name: "analytical", size: N_PARTICLES, threads, rounds: 5, calls: 1 };
    Ok(a_step_of(steps.len(), case.compare(candidate, means)))
}

/// The same step of a sparse process in NumPy; nothing without Python.
fn peer() -> Result<Option<Row>> {
    let script = workspace_root().join("crates/benchmarks/peers/filter.py");
    let run = |script: &Path| Command::new("python3").arg(script).output();
    let Ok(output) = run(&script) else { return Ok(None) };
    if !output.status.success() {
        println!("no NumPy here: the peer is left out");
        return Ok(None);
    }
    let text = String::from_utf8_lossy(&output.stdout);
    let seconds: f64 = text.trim().parse().context("the peer prints seconds")?;
    Ok(Some(Row {
        name: "NumPy, M = 80".to_owned(),
        size: N_PARTICLES,
        threads: 1,
        median_seconds: seconds,
        reference_seconds: seconds,
        ratio: 1.0,
        peak_memory_mb: None,
    }))
}
