//! Where along an object's outline a model fails.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use effects::Object;
use nalgebra::Vector2;
use planar::{Shape, perpendicular};

use crate::data::clusters::ClusterMean;
use crate::{DiagnosisError, MapSettings, Observations, Predictions};

/// Mean residual motion along the outline of one object.
#[derive(Clone, Debug)]
pub struct OutlineMap {
    /// The object.
    pub object: Arc<Object>,
    /// Stretches with enough data, along the outline.
    pub cells: Vec<OutlineCell>,
}

/// The steps that begin in contact with one stretch of the outline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutlineCell {
    /// The edge, or one of them where edges are shorter than a stretch.
    pub edge: usize,
    /// Mean contact point at the start of a step, in m, body frame.
    pub contact_b: Vector2<f64>,
    /// Steps.
    pub n_steps: usize,
    /// Pushes that they are of.
    pub n_pushes: usize,
    /// Mean of observed less predicted: motion of the object along x and y, in m, axes of the body
    /// at the start of the step, and its turn, in rad.
    pub mean: [f64; 3],
    /// Half widths of the 95 % intervals of `mean`, from whole clusters.
    pub half95: [f64; 3],
}

/// Stretches of a whole outline, about.
const STRETCHES: f64 = 36.0;
/// Up to so many edges each is cut by itself.
const MOST_CUT_EDGES: usize = 12;

/// The mean residual motion at each stretch of each object's outline.
///
/// # Errors
/// `OtherSteps` if the predictions are of other observations.
pub fn outline_maps(
    observations: &Observations,
    predictions: &Predictions,
    settings: &MapSettings,
) -> Result<Vec<OutlineMap>, DiagnosisError> {
    let residuals = predictions.residuals(observations)?;
    let mut objects: Vec<Arc<Object>> = Vec::new();
    let mut steps_of: BTreeMap<(usize, usize, usize), Vec<Step>> = BTreeMap::new();
    for (index, values_of_step) in residuals.iter().enumerate() {
        let [Some(dx), Some(dy), Some(dtheta), ..] = *values_of_step else { continue };
        let (input, place) = (&observations.steps[index].input, &observations.places[index]);
        let known = objects.iter().position(|object| Arc::ptr_eq(object, &input.object));
        let object = known.unwrap_or_else(|| {
            objects.push(input.object.clone());
            objects.len() - 1
        });
        let along_w = input.direction_w();
        let moved_b = input.pose_wb.inverse_rotate(&(dx * along_w + dy * perpendicular(&along_w)));
        let edge = place.edge as usize;
        let (first_edge, stretch) = stretch_of(input.object.shape(), edge, place.p);
        let step = Step {
            push: observations.push_of[index],
            cluster: observations.cluster_of[index],
            edge,
            contact_b: input.object.shape().point_at(edge, place.p),
            residual: [moved_b.x, moved_b.y, dtheta],
        };
        steps_of.entry((object, first_edge, stretch)).or_default().push(step);
    }
    let mut maps: Vec<OutlineMap> =
        objects.into_iter().map(|object| OutlineMap { object, cells: Vec::new() }).collect();
    for ((object, ..), steps) in steps_of {
        maps[object].cells.extend(cell(&steps, settings));
    }
    Ok(maps)
}

/// A step as the outline sees it.
struct Step {
    push: usize,
    cluster: usize,
    edge: usize,
    contact_b: Vector2<f64>,
    residual: [f64; 3],
}

fn cell(steps: &[Step], settings: &MapSettings) -> Option<OutlineCell> {
    let of = |k: usize| {
        let values: Vec<_> = steps.iter().map(|step| (step.cluster, step.residual[k])).collect();
        ClusterMean::of(&values)
    };
    let means = [of(0)?, of(1)?, of(2)?];
    let n_steps = steps.len();
    let n_pushes = steps.iter().map(|step| step.push).collect::<BTreeSet<_>>().len();
    let is_enough = n_steps >= settings.fewest_steps && n_pushes >= settings.fewest_pushes;
    let sum: Vector2<f64> = steps.iter().map(|step| step.contact_b).sum();
    is_enough.then(|| OutlineCell {
        edge: steps[0].edge,
        contact_b: sum / n_steps as f64,
        n_steps,
        n_pushes,
        mean: means.map(|mean| mean.mean),
        half95: means.map(|mean| mean.interval()[1] - mean.mean),
    })
}

/// The stretch of a point on the outline: the edge and a part of it, or, where edges are many and
/// short, a part of the whole outline.
fn stretch_of(shape: &Shape, edge: usize, p: f64) -> (usize, usize) {
    let perimeter = shape.perimeter();
    let part = |share: f64, n: f64| ((share * n) as usize).min(n as usize - 1);
    if shape.n_edges() <= MOST_CUT_EDGES {
        let n = (STRETCHES * length(shape, edge) / perimeter).round().max(1.0);
        return (edge, part(p, n));
    }
    let before: f64 = (0..edge).map(|edge| length(shape, edge)).sum();
    (0, part((before + p * length(shape, edge)) / perimeter, STRETCHES))
}

fn length(shape: &Shape, edge: usize) -> f64 {
    match shape {
        Shape::Polygon(_) => (shape.point_at(edge, 1.0) - shape.point_at(edge, 0.0)).norm(),
        Shape::Ellipse(_) => shape.perimeter(),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use dataset::{IngestSettings, RecordingSet, ingest};
    use planar::{MIT_NAMES, mit_object};

    use super::{outline_maps, stretch_of};
    use crate::{MapSettings, Observations, Predictions};

    #[test]
    fn every_outline_is_cut_into_some_dozens_of_stretches() {
        for name in MIT_NAMES {
            let shape = mit_object(name).unwrap().shape;
            let places = (0..shape.n_edges()).flat_map(|edge| (0..200).map(move |k| (edge, k)));
            let stretches: BTreeSet<_> =
                places.map(|(edge, k)| stretch_of(&shape, edge, f64::from(k) / 199.0)).collect();
            assert!((30..=42).contains(&stretches.len()), "{name}: {}", stretches.len());
        }
    }

    #[test]
    fn an_object_that_moves_farther_than_predicted_has_arrows_into_it() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/pushes");
        let set = RecordingSet::open(folder.as_ref()).unwrap();
        let table = ingest(&set, &IngestSettings::default()).unwrap().0;
        let observations = Observations::of(&table, set.manifest()).unwrap();
        let behind = |step: &models::ChannelObservation| {
            let [dx, dy, dtheta, ..] = step.observed;
            [dx.map(|dx| dx - 1e-3), dy, dtheta.map(|turn| turn - 0.01), None, None, None, None]
        };
        let values: Vec<_> = observations.steps().iter().map(behind).collect();
        let variances = vec![[None; 7]; values.len()];
        let predictions = Predictions { values, variances };
        let settings = MapSettings { fewest_steps: 1, fewest_pushes: 2, ..MapSettings::default() };
        let maps = outline_maps(&observations, &predictions, &settings).unwrap();
        assert_eq!(maps.len(), 1);
        let shape = maps[0].object.shape();
        assert!(maps[0].cells.len() > 25, "{}", maps[0].cells.len());
        for cell in &maps[0].cells {
            let normal = shape.inward_normal_at(cell.edge, 0.5);
            let [x, y, turn] = cell.mean;
            assert!(x * normal.x + y * normal.y > 0.0 && x.hypot(y) < 1e-3 + 1e-12, "{cell:?}");
            assert!((turn - 0.01).abs() < 1e-12 && cell.half95[2] < 1e-12, "{cell:?}");
        }
    }
}
