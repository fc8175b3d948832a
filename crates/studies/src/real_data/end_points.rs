//! Long pushes of eleven shapes: where the object ends up, by kind of limit surface.

use std::{collections::BTreeMap, path::Path};

use anyhow::{Context, Result, bail};
use dataset::{ReadLimits, WholePush, read_end_points};
use mechanics::{
    Ellipsoid, LimitSurface, Patch, PathSettings, Pusher, Slider, StraightPath, push_along,
};
use nalgebra::Vector2;
use planar::{Pose, Shape, mit_object, wrap_angle};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use serde_json::{Map, Value, json};

use super::Section;
use super::limit_surface_fits::ObjectFits;
use super::row::{Reference, Row};

const PUSHER: Pusher = Pusher { radius: 0.00475, friction: 0.25 };
/// A tenth of a micrometer in a step: far below the scatter of the pushes.
const SETTINGS: PathSettings = PathSettings { tolerance: 1e-7, max_travel: 5e-3 };
/// The general solver is slow: it is asked for every fifth push.
const QUARTIC_STRIDE: usize = 5;

/// The kinds of surface, every how many pushes they are asked for, and a published toolbox's errors in
/// mm and degrees, averaged over shapes.
const KINDS: [Kind; 4] = [
    Kind { name: "uniform ellipsoid", stride: 1, published: None },
    Kind { name: "ellipsoid through loads", stride: 1, published: None },
    Kind { name: "fitted ellipsoid", stride: 1, published: Some((3.73, 4.12)) },
    Kind { name: "fitted quartic", stride: QUARTIC_STRIDE, published: Some((3.36, 3.54)) },
];

#[derive(Clone, Copy)]
struct Kind {
    name: &'static str,
    stride: usize,
    published: Option<(f64, f64)>,
}

/// Mean errors over the pushes of one shape, or over the shapes.
#[derive(Clone, Copy, Default)]
struct Errors {
    pushes: usize,
    mm: f64,
    degrees: f64,
}

/// Predicts the end points in the file with surfaces of each kind; the last two from `fits`.
pub(super) fn run(path: &Path, fits: &[ObjectFits]) -> Result<Section> {
    let mut by_shape: BTreeMap<String, Vec<WholePush>> = BTreeMap::new();
    for set in read_end_points(path, &ReadLimits::default())?.sets {
        let shape = set.shape.with_context(|| format!("{}: no column shape", path.display()))?;
        by_shape.entry(shape).or_default().extend(set.pushes);
    }
    let mut errors: BTreeMap<&str, Vec<Errors>> = BTreeMap::new();
    for (name, pushes) in &by_shape {
        let fit = fits.iter().find(|fit| fit.name == *name);
        let fit = fit.with_context(|| format!("no wrench-twist pairs of `{name}`"))?;
        let shape = mit_object(name)?.shape;
        let surfaces: [&dyn LimitSurface; 4] = [
            &Ellipsoid::uniform(&shape, 1.0)?,
            &Ellipsoid::through_loads(&Patch::uniform(&shape, 1.0)?)?,
            &fit.ellipsoid.surface,
            &fit.quartic.surface,
        ];
        let row = surfaces.iter().zip(KINDS).map(|(surface, kind)| {
            mean_errors(&shape, *surface, pushes, kind.stride)
                .with_context(|| format!("{}: {name}, {}", path.display(), kind.name))
        });
        errors.insert(name, row.collect::<Result<_>>()?);
    }
    Ok(summary(&errors))
}

fn mean_errors(
    shape: &Shape,
    surface: &dyn LimitSurface,
    pushes: &[WholePush],
    stride: usize,
) -> Result<Errors> {
    let chosen: Vec<&WholePush> = pushes.iter().step_by(stride).collect();
    let each = chosen.par_iter().map(|push| error(shape, surface, push));
    let each: Vec<(f64, f64)> = each.collect::<Result<_>>()?;
    let n = each.len() as f64;
    let (position, angle) = each.iter().fold((0.0, 0.0), |sum, e| (sum.0 + e.0, sum.1 + e.1));
    Ok(Errors { pushes: each.len(), mm: 1e3 * position / n, degrees: (angle / n).to_degrees() })
}

/// Distance in m and angle in rad between the predicted and the measured end.
fn error(shape: &Shape, surface: &dyn LimitSurface, push: &WholePush) -> Result<(f64, f64)> {
    // All surfaces are in the frame of the tracked body.
    let slider = Slider { shape, surface, pose_bs: Pose::default() };
    let [(_, tip_start), .., (_, tip_end)] = push.tip[..] else { bail!("no way of the pusher") };
    let travel: Vector2<f64> = tip_end - tip_start;
    // Quasi-static motion does not know time: the pusher moves at 1 m/s.
    let path = StraightPath {
        start_w: tip_start,
        velocity_w: travel.try_normalize(0.0).context("the pusher does not move")?,
        duration: travel.norm(),
    };
    let end = push_along(&slider, &PUSHER, &path, &push.object_start, &SETTINGS)
        .with_context(|| format!("push {}", push.push))?
        .pose_wb;
    let position = (end.position - push.object_end.position).norm();
    Ok((position, wrap_angle(end.angle - push.object_end.angle).abs()))
}

fn summary(errors: &BTreeMap<&str, Vec<Errors>>) -> Section {
    let (mut rows, mut kinds) = (Vec::new(), Map::new());
    for (index, kind) in KINDS.iter().enumerate() {
        let (mut mean, mut by_shape) = (Errors::default(), Map::new());
        for (shape, errors) in errors {
            let Errors { pushes, mm, degrees } = errors[index];
            let name = format!("end points, {shape}, {}", kind.name);
            rows.push(Row::new(format!("{name}: error in mm"), mm, Reference::None));
            rows.push(Row::new(format!("{name}: error in deg"), degrees, Reference::None));
            by_shape.insert((*shape).to_owned(), errors[index].json());
            mean.pushes += pushes;
            mean.mm += mm;
            mean.degrees += degrees;
        }
        let n = errors.len().max(1) as f64;
        let mean = Errors { mm: mean.mm / n, degrees: mean.degrees / n, ..mean };
        let name = format!("end points, mean of shapes, {}", kind.name);
        let reference = |value: Option<f64>| value.map_or(Reference::None, Reference::Published);
        let (mm, degrees) = kind.published.unzip();
        rows.push(Row::new(format!("{name}: error in mm"), mean.mm, reference(mm)));
        rows.push(Row::new(format!("{name}: error in deg"), mean.degrees, reference(degrees)));
        let Value::Object(mut entry) = mean.json() else { continue };
        entry.insert("by_shape".to_owned(), Value::Object(by_shape));
        if let Some((mm, degrees)) = kind.published {
            entry.insert("published_mean_error_mm".to_owned(), json!(mm));
            entry.insert("published_mean_error_deg".to_owned(), json!(degrees));
        }
        kinds.insert(kind.name.replace(' ', "_"), Value::Object(entry));
    }
    Section { json: Map::from_iter([("endpoints".to_owned(), Value::Object(kinds))]), rows }
}

impl Errors {
    fn json(&self) -> Value {
        json!({
            "pushes": self.pushes, "mean_error_mm": self.mm, "mean_error_deg": self.degrees,
        })
    }
}
