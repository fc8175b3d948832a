//! Long pushes of eleven shapes: where the object ends up.

use std::{collections::BTreeMap, path::Path, sync::Arc};

use anyhow::{Context, Result};
use models::{Analytical, StepInput};
use nalgebra::Vector2;
use planar::{Pose, Shape, mit_object, wrap_angle};
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};
use serde::Deserialize;
use serde_json::{Map, json};

use super::Section;
use super::row::{Reference, Row};

const PUSHER_FRICTION: f64 = 0.25;
const PUSHER_RADIUS: f64 = 0.00475;
/// Of a published toolbox with an ellipsoid, averaged over shapes.
const PUBLISHED_MM: f64 = 3.73;
const PUBLISHED_DEG: f64 = 4.12;

/// One push, as published: poses in m and rad, world frame.
#[derive(Deserialize)]
struct EndPoint {
    shape: String,
    obj_x0: f64,
    obj_y0: f64,
    obj_th0: f64,
    obj_x1: f64,
    obj_y1: f64,
    obj_th1: f64,
    tip_x0: f64,
    tip_y0: f64,
    tip_x1: f64,
    tip_y1: f64,
}

/// Sums over the pushes of one shape.
#[derive(Clone, Copy, Default)]
struct Errors {
    n: usize,
    position: f64,
    angle: f64,
}

pub(super) fn run(path: &Path) -> Result<Section> {
    let context = || format!("cannot read {}", path.display());
    let mut reader = csv::Reader::from_path(path).with_context(context)?;
    let pushes: Vec<EndPoint> =
        reader.deserialize().collect::<csv::Result<_>>().with_context(context)?;
    let mut shapes = BTreeMap::new();
    for push in &pushes {
        if !shapes.contains_key(&push.shape) {
            shapes.insert(push.shape.clone(), Arc::new(mit_object(&push.shape)?.shape));
        }
    }
    let model = Analytical::nominal(PUSHER_FRICTION)?;
    let errors: Vec<(f64, f64)> = pushes
        .par_iter()
        .enumerate()
        .map(|(i, push)| {
            push.error(&model, &shapes[&push.shape])
                .with_context(|| format!("{}:{}", path.display(), i + 2))
        })
        .collect::<Result<_>>()?;
    let mut by_shape: BTreeMap<&str, Errors> = BTreeMap::new();
    for (push, (position, angle)) in pushes.iter().zip(errors) {
        let sums = by_shape.entry(&push.shape).or_default();
        *sums =
            Errors { n: sums.n + 1, position: sums.position + position, angle: sums.angle + angle };
    }
    Ok(summary(&by_shape))
}

impl EndPoint {
    /// Distance in m and angle in rad between the predicted and the measured end.
    fn error(&self, model: &Analytical, shape: &Arc<Shape>) -> Result<(f64, f64)> {
        let start = Pose::new(self.obj_x0, self.obj_y0, self.obj_th0);
        let tip_start = Vector2::new(self.tip_x0, self.tip_y0);
        let tip_end = Vector2::new(self.tip_x1, self.tip_y1);
        let step = StepInput::between(shape.clone(), PUSHER_RADIUS, &start, &tip_start, &tip_end)?;
        let end = start * model.motion(&step)?;
        let position = (end.position - Vector2::new(self.obj_x1, self.obj_y1)).norm();
        Ok((position, wrap_angle(end.angle - self.obj_th1).abs()))
    }
}

fn summary(by_shape: &BTreeMap<&str, Errors>) -> Section {
    let (mut rows, mut json_shapes) = (Vec::new(), Map::new());
    let (mut mean_mm, mut mean_deg, mut n_pushes) = (0.0, 0.0, 0);
    for (shape, sums) in by_shape {
        let mm = 1e3 * sums.position / sums.n as f64;
        let deg = (sums.angle / sums.n as f64).to_degrees();
        rows.push(Row::new(format!("end points, {shape}: error in mm"), mm, Reference::None));
        rows.push(Row::new(format!("end points, {shape}: error in deg"), deg, Reference::None));
        let entry = json!({ "pushes": sums.n, "mean_error_mm": mm, "mean_error_deg": deg });
        json_shapes.insert((*shape).to_owned(), entry);
        mean_mm += mm / by_shape.len() as f64;
        mean_deg += deg / by_shape.len() as f64;
        n_pushes += sums.n;
    }
    for (name, mean, published) in [
        ("end points, mean of shapes: error in mm", mean_mm, PUBLISHED_MM),
        ("end points, mean of shapes: error in deg", mean_deg, PUBLISHED_DEG),
    ] {
        rows.push(Row::new(name, mean, Reference::Published(published)));
    }
    let json = Map::from_iter([(
        "endpoints".to_owned(),
        json!({
            "pushes": n_pushes, "by_shape": json_shapes,
            "mean_error_mm": mean_mm, "mean_error_deg": mean_deg,
            "published_mean_error_mm": PUBLISHED_MM, "published_mean_error_deg": PUBLISHED_DEG,
        }),
    )]);
    Section { json, rows }
}
