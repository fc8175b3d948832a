//! Simulated pushes of the plant.

use anyhow::Result;
use dataset::ObjectSpec;
use planar::Pose;
use plant::{Numerics, PlannedPush, Plant, TipPath, Truth, Variation};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use super::benchmark::Benchmark;
use super::timing::{Case, Row};

pub(super) const BENCHMARK: Benchmark = Benchmark {
    name: "plant",
    about: "16 pushes of 50 mm, beside half the time steps on twice the pads; \
            pushes a second = 16 / median",
    rows: |_| rows(),
};

const N_PUSHES: usize = 16;
const PUSHER_RADIUS: f64 = 0.00475;
const GRAVITY: f64 = 9.81;

fn rows() -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for (name, object, speed) in [
        ("square at 20 mm/s", "rect1", 0.02),
        ("square at 400 mm/s", "rect1", 0.4),
        ("butterfly at 20 mm/s", "butter", 0.02),
    ] {
        for threads in [1, 2] {
            rows.push(row(name, &ObjectSpec::mit(object)?, speed, threads)?);
        }
    }
    Ok(rows)
}

fn row(name: &str, object: &ObjectSpec, speed: f64, threads: usize) -> Result<Row> {
    let numerics = Numerics::default();
    let finer = Numerics {
        n_pads: 2 * numerics.n_pads,
        tolerance: 0.25 * numerics.tolerance,
        longest_step: 0.5 * numerics.longest_step,
        ..numerics
    };
    let plant = |numerics| Plant::new(object, &Truth::default(), GRAVITY, numerics);
    let (plant, fine) = (plant(&numerics)?, plant(&finer)?);
    let paths = paths(object, speed);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let case = Case { name, size: N_PUSHES, threads, rounds: 5, calls: 1 };
    Ok(case
        .compare(|| pool.install(|| run(&plant, &paths)), || pool.install(|| run(&fine, &paths))))
}

fn run(plant: &Plant, paths: &[TipPath]) -> Result<Vec<Pose>> {
    let variation = Variation::default();
    let push = |path: &TipPath| Ok(plant.push(&Pose::default(), path, &variation)?.end_pose());
    paths.par_iter().map(push).collect()
}

/// Pushes spread over places, angles and edges.
fn paths(object: &ObjectSpec, speed: f64) -> Vec<TipPath> {
    let path = |index: usize| {
        let share = index as f64 / (N_PUSHES - 1) as f64;
        let push = PlannedPush {
            edge: index % object.shape.n_edges(),
            p: 0.1 + 0.8 * share,
            angle: 0.7 * (4.0 * share).sin(),
            speed,
            travel: 0.05,
            place: [0.0; 3],
            session: 0,
            repeat: String::new(),
        };
        push.path(&object.shape, PUSHER_RADIUS, 10.0, [0.2, 0.3])
    };
    (0..N_PUSHES).map(path).collect()
}

#[cfg(test)]
mod tests {
    use dataset::ObjectSpec;
    use plant::{Numerics, Plant, Truth};

    use super::{GRAVITY, N_PUSHES, paths, run};

    #[test]
    fn every_push_of_the_benchmark_moves_the_object() {
        let object = ObjectSpec::mit("rect1").unwrap();
        let plant = Plant::new(&object, &Truth::default(), GRAVITY, &Numerics::default()).unwrap();
        let ends = run(&plant, &paths(&object, 0.4)).unwrap();
        assert_eq!(ends.len(), N_PUSHES);
        assert!(ends.iter().all(|pose| pose.position.norm() > 1e-3));
    }
}
