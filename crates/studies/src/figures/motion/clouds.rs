//! Figure 6.1: particles on recorded pushes, and what the thesis' weights do to them.

use anyhow::Result;
use filter::{PlanarSummary, Weights, all_resamplers};
use models::{RecordedPush, RollOut, RollOutSettings, StepErrors};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use report::{Axis, Claim, Color, Figure, LegendPlace, Line, Panel, Table};

use super::scene::{Rolled, Scene, place_of};
use super::view::{cloud, outline, pusher, shade, table, way};
use crate::figures::claims::judged;
use crate::figures::inputs::{Inputs, SEED};
use crate::figures::sketch::Sketch;

/// What this figure settles.
pub(crate) const CLAIMS: [&str; 2] = [
    "11. Particle error falls as 1/√M.",
    "12. Low-variance resampling: O(M); equal weights return the same set; a particle of weight above \
     1/M survives.",
];
/// Place and angle of the pushes that are drawn.
const WANTED: [[f64; 2]; 3] = [[0.5, 0.0], [0.3, -0.7], [0.75, 0.5]];
const N_DRAWN: usize = 500;
const N_COUNTED: usize = 200;
const N_LEVELS: usize = 51;

pub(crate) fn draw(inputs: &Inputs) -> Result<Sketch> {
    let scene = inputs.scene()?;
    let held = scene.held(N_DRAWN);
    let mut figure = Figure::new(2, 2).panel_size(400.0, 330.0);
    for wanted in WANTED {
        let push = scene.nearest(wanted)?;
        let rolled = Rolled::of(scene.gp.model.as_ref(), push, &held)?;
        figure = figure.with(panel(push, &rolled));
    }
    let counted = RollOutSettings { n_particles: N_COUNTED, ..held };
    let independent = RollOutSettings { errors: StepErrors::Independent, ..counted.clone() };
    let curves = [
        ("held, as measured", Color::BLUE, levels(scene, &counted, false)?),
        ("independent steps", Color::ORANGE, levels(scene, &independent, false)?),
        ("the thesis' weights", Color::VERMILION, levels(scene, &independent, true)?),
    ];
    let grid: Vec<f64> = (0..N_LEVELS).map(|k| k as f64 / (N_LEVELS - 1) as f64).collect();
    let mut data = Table::new().column("level", &grid);
    let mut coverage = Panel::new(Axis::new("level of the region"), Axis::new("share of the ends"))
        .title("ends of held-out pushes")
        .legend(LegendPlace::Below)
        .with(Line::new(&[0.0, 1.0], &[0.0, 1.0]).color(Color::GRAY).width(1.0));
    let mut told = Vec::new();
    for (name, color, levels) in &curves {
        let share = |level: f64| {
            levels.iter().filter(|reached| **reached <= level).count() as f64 / levels.len() as f64
        };
        let shares: Vec<f64> = grid.iter().map(|level| share(*level)).collect();
        data = data.column(name, &shares);
        coverage = coverage.with(Line::new(&grid, &shares).color(*color).label(name));
        told.push(format!("{name} {:.0} %", 100.0 * share(0.95)));
    }
    let caption = format!(
        "Three recorded pushes by a Gaussian process that has not seen them: {N_DRAWN} particles from \
         dark to light as time passes, measured way in black. Last: how many of the ends of {} \
         held-out pushes lie within regions of the particles. The thesis weighs each particle by the \
         density of its own draw, which counts that density twice. Held by 95 % regions: {}.",
        scene.test.len(),
        told.join(", ")
    );
    let alt = "Clouds of particles along three pushes, and coverage curves of three ways to draw.";
    let sketch = Sketch::new(figure.with(coverage), data, &caption, alt);
    Ok(sketch.claim(convergence(scene)?).claim(resampling()))
}

fn panel(push: &RecordedPush, rolled: &Rolled) -> Panel {
    let n = rolled.moments.len();
    let shape = &push.pushed.shape;
    let mut panel = table(&place_of(push))
        .with(outline(shape, &push.poses_wb[0], shade(0, n)).label("object at the start"))
        .with(outline(shape, &push.poses_wb[n - 1], shade(n - 1, n)).label("at the end, measured"));
    for k in (1..n).rev() {
        panel = panel.with(cloud(&rolled.places(k), shade(k, n)));
    }
    panel
        .with(pusher(&push.path))
        .with(way(push.poses_wb.iter().map(|p| p.position), Color::INK).label("object, measured"))
}

/// The levels of the regions on whose borders the measured ends lie.
fn levels(scene: &Scene, settings: &RollOutSettings, weighted: bool) -> Result<Vec<f64>> {
    let model = scene.gp.model.as_ref();
    let level = |push: &RecordedPush| {
        let settings = RollOutSettings { start_sd: push.pose_sd[0], ..settings.clone() };
        let roll_out = RollOut { model, pushed: &push.pushed, settings: &settings };
        let mut filter = roll_out.start(&push.poses_wb[0], &push.path)?;
        for step in push.path.steps(settings.step)? {
            if weighted {
                filter.predict_weighted_by_density(&roll_out.motion(&step)?)?;
            } else {
                filter.predict(&roll_out.motion(&step)?)?;
            }
        }
        let (particles, weights) = (filter.particles(), filter.weights());
        let end = push.poses_wb[push.poses_wb.len() - 1];
        let measured = [end.position.x, end.position.y, end.angle];
        let summary = PlanarSummary::of(particles, weights)?;
        Ok(summary.level(particles, weights, measured, push.pose_sd[1])?)
    };
    scene.test.par_iter().map(level).collect()
}

/// The error of the mean angle at the end of a push, over many seeds, for more and more particles.
fn convergence(scene: &Scene) -> Result<Claim> {
    const SIZES: [usize; 4] = [25, 100, 400, 1600];
    const SEEDS: u64 = 48;
    let push = scene.nearest(WANTED[1])?;
    let end = |n_particles: usize, seed: u64| {
        // Of heavy tails few seeds do not tell the size of an error.
        let errors = StepErrors::Independent;
        let settings = RollOutSettings { seed, errors, ..scene.held(n_particles) };
        let rolled = Rolled::of(scene.gp.model.as_ref(), push, &settings)?;
        Ok::<f64, anyhow::Error>(rolled.moments[rolled.last()].pose_wb.mean.z)
    };
    let truth = end(20_000, SEED + 1000)?;
    let mut errors = Vec::new();
    for size in SIZES {
        let seeds: Vec<u64> = (0..SEEDS).collect();
        let squares: Vec<f64> = seeds
            .par_iter()
            .map(|seed| Ok((end(size, SEED + seed)? - truth).powi(2)))
            .collect::<Result<_>>()?;
        errors.push((squares.iter().sum::<f64>() / SEEDS as f64).sqrt());
    }
    let logs: Vec<[f64; 2]> =
        SIZES.iter().zip(&errors).map(|(size, error)| [(*size as f64).ln(), error.ln()]).collect();
    let mean = |k: usize| logs.iter().map(|log| log[k]).sum::<f64>() / logs.len() as f64;
    let (x, y) = (mean(0), mean(1));
    let slope = logs.iter().map(|log| (log[0] - x) * (log[1] - y)).sum::<f64>()
        / logs.iter().map(|log| (log[0] - x).powi(2)).sum::<f64>();
    let listed = SIZES.iter().zip(&errors);
    let listed = listed.map(|(size, error)| format!("{:.3}° ({size})", error.to_degrees()));
    let value = format!(
        "error of the mean end angle {}; power of M {slope:.2}",
        listed.collect::<Vec<_>>().join(", ")
    );
    let reason =
        "a power within 0.1 of −0.5 over 25 to 1600 particles, 48 seeds, independent steps";
    Ok(judged(CLAIMS[0], value, (slope + 0.5).abs() < 0.1, reason))
}

/// What low-variance resampling promises, tried on weights.
fn resampling() -> Claim {
    let systematic = all_resamplers()[0];
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let n = 1000;
    let equal = systematic.ancestors(&vec![1.0 / n as f64; n], n, &mut random);
    let same = equal.iter().copied().eq(0..n);
    let logs: Vec<f64> = (0..n).map(|k| -3.0 * (k as f64 * 0.618).fract()).collect();
    let weights = Weights::from_logs(logs).map(|(weights, _)| weights);
    let survive = weights.is_some_and(|weights| {
        let weights = weights.as_slice();
        let drawn = systematic.ancestors(weights, n, &mut random);
        let heavy = (0..n).filter(|k| weights[*k] > 1.0 / n as f64);
        heavy.clone().count() > 100 && heavy.clone().all(|k| drawn.contains(&k))
    });
    let mut words = |n: usize| {
        let before = random.get_word_pos();
        systematic.ancestors(&vec![1.0 / n as f64; n], n, &mut random);
        random.get_word_pos() - before
    };
    // One number however many particles: the rest is one pass over weights and particles.
    let is_linear = words(10) == words(100_000);
    let yes = |is_so: bool| if is_so { "yes" } else { "no" };
    let value = format!(
        "equal weights return the same set: {}; heavier than 1/M survive: {}; one random number for any M: {}",
        yes(same),
        yes(survive),
        yes(is_linear)
    );
    let reason = "tried on 1000 particles; 10 and 100 000 draw the same count of random words, and the \
                  weights are passed once";
    judged(CLAIMS[1], value, same && survive && is_linear, reason)
}
