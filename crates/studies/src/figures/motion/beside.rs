//! Figure 6.3: the analytical model and the learnt one on whole pushes.

use anyhow::{Context, Result};
use models::{RecordedPush, RollOutSettings, StepErrors};
use report::{Color, Figure, Panel, Table};

use super::scene::{Rolled, place_of};
use super::view::{cloud, mean_pose, outline, pusher, table, way};
use crate::figures::inputs::Inputs;
use crate::figures::sketch::Sketch;
use crate::held_out::quantile;

const N_PARTICLES: usize = 300;
const N_DRAWN: usize = 2;

pub(crate) fn draw(inputs: &Inputs) -> Result<Sketch> {
    let scene = inputs.scene()?;
    let means = RollOutSettings { errors: StepErrors::None, ..scene.held(1) };
    let physics = scene.all(scene.analytical.model.as_ref(), &means)?;
    let learnt = scene.all(scene.gp.model.as_ref(), &means)?;
    let errors = |all: &[Rolled]| -> Vec<f64> {
        let ends = all.iter().zip(&scene.test);
        ends.map(|(rolled, push)| end_error(rolled, push)).collect()
    };
    let (of_physics, of_learnt) = (errors(&physics), errors(&learnt));
    let gain = |k: &usize| of_learnt[*k] - of_physics[*k];
    let mut order: Vec<usize> = (0..scene.test.len()).collect();
    order.sort_by(|a, b| gain(a).total_cmp(&gain(b)));
    let mut figure = Figure::new(1, N_DRAWN).panel_size(420.0, 380.0);
    for k in order.iter().take(N_DRAWN) {
        let push = &scene.test[*k];
        let particles = Rolled::of(scene.gp.model.as_ref(), push, &scene.held(N_PARTICLES))?;
        figure = figure.with(panel(push, &particles, &learnt[*k], &physics[*k]));
    }
    let n_nearer = of_physics.iter().zip(&of_learnt).filter(|(a, b)| b < a).count();
    let median = |errors: &[f64]| 1e3 * quantile(errors.to_vec(), 0.5);
    let caption = format!(
        "The two held-out pushes at which the Gaussian process gains most on the fitted analytical \
         model, with its particles at the end. Over all {} the process ends nearer in {n_nearer}; \
         median distance from the measured end {:.2} mm, of the analytical model {:.2} mm.",
        scene.test.len(),
        median(&of_learnt),
        median(&of_physics)
    );
    let alt = "Measured ways of an object beside those of two models.";
    let names: Vec<&str> = scene.test.iter().map(|push| push.name.as_str()).collect();
    let data = Table::new()
        .names("push", &names)
        .column("analytical_end_error_m", &of_physics)
        .column("gp_end_error_m", &of_learnt);
    order.first().context("there are pushes to test")?;
    Ok(Sketch::new(figure, data, &caption, alt))
}

/// Distance of the last mean place from the measured one, in m.
fn end_error(rolled: &Rolled, push: &RecordedPush) -> f64 {
    let end = mean_pose(&rolled.moments[rolled.last()]);
    (end.position - push.poses_wb[push.poses_wb.len() - 1].position).norm()
}

fn panel(push: &RecordedPush, particles: &Rolled, learnt: &Rolled, physics: &Rolled) -> Panel {
    let shape = &push.pushed.shape;
    let end = |rolled: &Rolled| mean_pose(&rolled.moments[rolled.last()]);
    let mean_way = |rolled: &Rolled, color: Color| {
        way(rolled.moments.iter().map(|moment| mean_pose(moment).position), color)
    };
    let measured = push.poses_wb[push.poses_wb.len() - 1];
    table(&place_of(push))
        .with(cloud(&particles.places(particles.last()), Color::SKY).label("particles at the end"))
        .with(outline(shape, &measured, Color::INK))
        .with(outline(shape, &end(physics), Color::GREEN))
        .with(outline(shape, &end(learnt), Color::BLUE))
        .with(pusher(&push.path))
        .with(mean_way(physics, Color::GREEN).label("analytical"))
        .with(mean_way(learnt, Color::BLUE).label("Gaussian process"))
        .with(way(push.poses_wb.iter().map(|pose| pose.position), Color::INK).label("measured"))
}
