//! Contact of a round pusher with the shapes of the MIT set.

use std::f64::consts::TAU;

use anyhow::Result;
use nalgebra::Vector2;
use planar::{MIT_NAMES, Shape, mit_object};

use super::benchmark::Benchmark;
use super::timing::{Case, Row};

pub(super) const BENCHMARK: Benchmark = Benchmark {
    name: "contact",
    about: "one contact query by edges of the shape, beside the nearest of 360 to 480 outline points",
    rows: |_| rows(),
};

const PUSHER_RADIUS: f64 = 0.00475;
const N_CENTERS: usize = 64;
/// The reference's points, at least: about one a millimetre.
const N_OUTLINE_POINTS: usize = 360;

fn rows() -> Result<Vec<Row>> {
    MIT_NAMES.iter().map(|name| row(name)).collect()
}

fn row(name: &str) -> Result<Row> {
    let shape = mit_object(name)?.shape;
    let outline = outline(&shape);
    let centers = centers(&shape);
    let next = || centers.iter().cycle();
    let (mut candidate_center, mut reference_center) = (next(), next());
    let case = Case { name, size: shape.n_edges(), threads: 1, rounds: 21, calls: 512 };
    let none = "the ring of centers never ends";
    Ok(case.compare(
        || shape.contact(candidate_center.next().expect(none), PUSHER_RADIUS),
        || nearest_distance(&outline, reference_center.next().expect(none)),
    ))
}

/// Pusher centers on a ring around the shape.
fn centers(shape: &Shape) -> Vec<Vector2<f64>> {
    let distance = shape.bounding_radius() + PUSHER_RADIUS;
    let center = |index| {
        let angle = TAU * index as f64 / N_CENTERS as f64;
        distance * Vector2::new(angle.cos(), angle.sin())
    };
    (0..N_CENTERS).map(center).collect()
}

/// Points all around the outline, equally spaced along each edge.
fn outline(shape: &Shape) -> Vec<Vector2<f64>> {
    let per_edge = N_OUTLINE_POINTS.div_ceil(shape.n_edges());
    let point =
        |index| shape.point_at(index / per_edge, (index % per_edge) as f64 / per_edge as f64);
    (0..per_edge * shape.n_edges()).map(point).collect()
}

/// Distance of the center to the nearest point of the sampled outline, in m.
fn nearest_distance(outline: &[Vector2<f64>], center: &Vector2<f64>) -> f64 {
    let squared = outline.iter().map(|point| (point - center).norm_squared());
    squared.fold(f64::INFINITY, f64::min).sqrt()
}

#[cfg(test)]
mod tests {
    use planar::{MIT_NAMES, mit_object};

    use super::{PUSHER_RADIUS, centers, nearest_distance, outline};

    #[test]
    fn both_sides_answer_the_same_question() {
        for name in MIT_NAMES {
            let shape = mit_object(name).unwrap().shape;
            let outline = outline(&shape);
            // Half the longest step between outline points bounds the reference's error.
            let tolerance = outline
                .iter()
                .zip(outline.iter().cycle().skip(1))
                .map(|(a, b)| (a - b).norm() / 2.0)
                .fold(0.0, f64::max);
            assert!(tolerance < 1e-3, "{name}: {tolerance} m");
            for center in centers(&shape) {
                let exact = shape.contact(&center, PUSHER_RADIUS).gap + PUSHER_RADIUS;
                let sampled = nearest_distance(&outline, &center);
                assert!((-1e-12..=tolerance).contains(&(sampled - exact)), "{name} {center}");
            }
        }
    }
}
