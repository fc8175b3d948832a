//! Figure 6.4: paths of the pusher that nobody has recorded.

use std::f64::consts::PI;

use anyhow::{Result, ensure};
use models::{Moment, PushParticle, PushPath, Pushed, RollOut, RollOutSettings};
use nalgebra::Vector2;
use planar::Pose;
use report::{Color, Figure, Panel, Table};

use super::scene::{Rolled, Scene};
use super::view::{cloud, mean_pose, outline, pusher, shade, table};
use crate::figures::inputs::{Inputs, STEP_WAY};
use crate::figures::sketch::Sketch;
use crate::held_out::quantile;

const N_PARTICLES: usize = 500;
const N_OUTLINES: usize = 7;
/// Free way before the touch, in m.
const FREE: f64 = 0.008;

pub(crate) fn draw(inputs: &Inputs) -> Result<Sketch> {
    let scene = inputs.scene()?;
    let pushed = &scene.test[0].pushed;
    let settings = RollOutSettings {
        touching: false,
        step: STEP_WAY,
        n_particles: N_PARTICLES,
        ..scene.held(N_PARTICLES)
    };
    let mut figure = Figure::new(2, 2).panel_size(380.0, 330.0);
    let (mut names, mut columns) = (Vec::new(), vec![Vec::new(); 7]);
    let speed = usual_speed(scene)?;
    for (name, path) in paths(pushed, speed)? {
        let (mut moments, mut particles) = (Vec::new(), Vec::new());
        let roll_out = RollOut { model: scene.gp.model.as_ref(), pushed, settings: &settings };
        let watch = |moment: &Moment, now: &[PushParticle]| {
            moments.push(moment.clone());
            particles.push(now.to_vec());
        };
        roll_out.run(&Pose::default(), &path, watch)?;
        let rolled = Rolled { moments, particles };
        let row = end_of(&rolled);
        columns.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
        names.push(name);
        figure = figure.with(panel(name, pushed, &path, &rolled));
    }
    let told: Vec<String> = (0..names.len())
        .map(|k| {
            format!(
                "{}: end ± {:.1} mm and {:.1}°, {:.0} % of the steps beyond what the model has seen, \
                 contact lost {:.1} times a particle",
                names[k],
                1e3 * columns[3][k],
                columns[4][k].to_degrees(),
                100.0 * columns[5][k],
                columns[6][k]
            )
        })
        .collect();
    let caption = format!(
        "Four paths at {:.0} mm/s, the usual speed of the straight pushes from which a Gaussian process \
         has learnt: the object from dark to light, and {N_PARTICLES} particles at the end, with errors \
         held as in recorded pushes. {}.",
        1e3 * speed,
        told.join("; ")
    );
    let alt = "An object carried along a straight, a round, a curved and a cornered path.";
    let keys = ["x_m", "y_m", "angle_rad", "place_sd_m", "angle_sd_rad", "unseen", "lost"];
    let data = keys
        .iter()
        .zip(&columns)
        .fold(Table::new().names("path", &names), |data, (key, column)| data.column(key, column));
    Ok(Sketch::new(figure, data, &caption, alt))
}

/// Mean pose, spread of place and angle, share of the steps that nobody has seen, and losses of contact
/// a particle.
fn end_of(rolled: &Rolled) -> [f64; 7] {
    let events =
        |count: fn(&Moment) -> usize| rolled.moments.iter().map(count).sum::<usize>() as f64;
    let end = rolled.moments[rolled.last()].pose_wb;
    let sd = |k: usize| end.covariance[(k, k)].max(0.0).sqrt();
    [
        end.mean.x,
        end.mean.y,
        end.mean.z,
        sd(0).hypot(sd(1)),
        sd(2),
        events(|moment| moment.events.unseen) / events(|moment| moment.events.pushed).max(1.0),
        events(|moment| moment.events.lost) / N_PARTICLES as f64,
    ]
}

/// The median speed of the recorded pushes, in m/s.
fn usual_speed(scene: &Scene) -> Result<f64> {
    let ways = scene.test.iter().map(|push| push.path.length() / push.path.duration());
    let speeds: Vec<f64> = ways.collect();
    ensure!(!speeds.is_empty(), "there are pushes to test");
    Ok(quantile(speeds, 0.5))
}

/// Paths that begin at the left of an object in the origin.
fn paths(pushed: &Pushed, speed: f64) -> Result<[(&'static str, PushPath); 4]> {
    let far = -3.0 * pushed.shape.bounding_radius();
    let start = |y: f64| {
        let center = Vector2::new(far, y);
        let gap = pushed.shape.contact(&center, pushed.pusher_radius).gap;
        center + Vector2::new(gap - FREE, 0.0)
    };
    let size = pushed.shape.bounding_radius();
    let (middle, above) = (start(0.0), start(0.2 * size));
    let at = |x: f64, y: f64| middle + size * Vector2::new(x, y);
    Ok([
        ("straight, off center", PushPath::straight(above, above + size * Vector2::x(), speed)?),
        ("arc", PushPath::arc(middle, at(0.0, 2.0), 0.25 * PI, speed)?),
        (
            "spline",
            PushPath::spline(&[middle, at(0.5, 0.05), at(1.1, -0.1), at(1.7, 0.15)], speed)?,
        ),
        (
            "corners",
            PushPath::polyline(&[middle, at(0.7, 0.0), at(1.1, 0.22), at(1.6, 0.0)], speed)?,
        ),
    ])
}

fn panel(name: &str, pushed: &Pushed, path: &PushPath, rolled: &Rolled) -> Panel {
    let last = rolled.last();
    let mut panel = table(name);
    for k in 0..N_OUTLINES {
        let moment = &rolled.moments[k * last / (N_OUTLINES - 1)];
        let drawn = outline(&pushed.shape, &mean_pose(moment), shade(k, N_OUTLINES));
        panel = panel.with(if k == 0 { drawn.label("object, mean pose") } else { drawn });
    }
    panel
        .with(cloud(&rolled.places(last), Color::BLUE).label("particles at the end"))
        .with(pusher(path))
}
