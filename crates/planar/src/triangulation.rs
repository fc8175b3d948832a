//! Simple polygons cut into triangles.

use crate::cross;
use nalgebra::Vector2;

/// Three corners, counter-clockwise, in m.
pub(crate) type Triangle = [Vector2<f64>; 3];

/// Cuts the roundest ear off a simple counter-clockwise polygon until nothing is left.
///
/// # Source
/// Meisters (1975), Polygons have ears, American Mathematical Monthly 82(6): there always is one.
pub(crate) fn triangulation(vertices: &[Vector2<f64>]) -> Vec<Triangle> {
    let mut rest = vertices.to_vec();
    let mut triangles = Vec::with_capacity(rest.len());
    while rest.len() > 3 {
        let ear = roundest_ear(&rest);
        triangles.push(corners(&rest, ear));
        rest.remove(ear);
    }
    triangles.push([rest[0], rest[1], rest[2]]);
    // Vertices along a line leave flat ones.
    triangles.retain(|[a, b, c]| cross(&(b - a), &(c - a)) > 0.0);
    triangles
}

fn corners(outline: &[Vector2<f64>], middle: usize) -> Triangle {
    let n = outline.len();
    [outline[(middle + n - 1) % n], outline[middle], outline[(middle + 1) % n]]
}

/// The last of the roundest ears; where rounding hides all, the roundest corner.
fn roundest_ear(outline: &[Vector2<f64>]) -> usize {
    let (mut best, mut corner) = (None, (0, f64::NEG_INFINITY));
    for middle in 0..outline.len() {
        let triangle = corners(outline, middle);
        let round = roundness(&triangle);
        if round > corner.1 {
            corner = (middle, round);
        }
        let is_better = best.is_none_or(|(_, other)| round >= other);
        if round >= 0.0 && is_better && is_empty(&triangle, outline) {
            best = Some((middle, round));
        }
    }
    best.unwrap_or(corner).0
}

/// Whether no vertex but its own is in a triangle or on its border.
fn is_empty([a, b, c]: &Triangle, outline: &[Vector2<f64>]) -> bool {
    let inside = |p: &Vector2<f64>| {
        p != a
            && p != b
            && p != c
            && cross(&(b - a), &(p - a)) >= 0.0
            && cross(&(c - b), &(p - b)) >= 0.0
            && cross(&(a - c), &(p - c)) >= 0.0
    };
    !outline.iter().any(inside)
}

/// Twice the area over the square of the longest side; negative for a clockwise triangle.
fn roundness([a, b, c]: &Triangle) -> f64 {
    let longest = (b - a).norm_squared().max((c - b).norm_squared()).max((a - c).norm_squared());
    cross(&(b - a), &(c - a)) / longest
}

#[cfg(test)]
mod tests {
    use super::{Triangle, roundness};
    use crate::{MIT_NAMES, Polygon, Shape, cross, mit_object};
    use nalgebra::Vector2;
    use proptest::prelude::{prop_assume, proptest};
    use std::f64::consts::TAU;

    fn polygon(points: &[[f64; 2]]) -> Polygon {
        Polygon::new(points.iter().map(|p| Vector2::new(p[0], p[1])).collect()).unwrap()
    }

    fn area([a, b, c]: &Triangle) -> f64 {
        0.5 * cross(&(b - a), &(c - a))
    }

    /// Areas are positive, their sum and their first moment are the outline's, and no point of a
    /// triangle is outside.
    #[track_caller]
    fn check(polygon: &Polygon) {
        let triangles = polygon.triangles();
        assert!(triangles.iter().all(|triangle| area(triangle) > 0.0));
        let sum: f64 = triangles.iter().map(area).sum();
        assert!((sum / polygon.area() - 1.0).abs() < 1e-12, "{sum} {}", polygon.area());
        let moment: Vector2<f64> =
            triangles.iter().map(|t| area(t) / 3.0 * (t[0] + t[1] + t[2])).sum();
        let size = polygon.perimeter();
        assert!((moment / sum - polygon.centroid()).norm() < 1e-12 * size);
        for triangle in triangles.iter().filter(|triangle| roundness(triangle) > 1e-9) {
            let [a, b, c] = triangle;
            let middle = (a + b + c) / 3.0;
            for (s, t) in [(0.0, 0.0), (0.9, 0.0), (0.0, 0.9), (-0.9, -0.9), (0.45, 0.45)] {
                let point = middle + (s * (b - a) + t * (c - a)) / 3.0;
                assert!(polygon.contains(&point), "{triangle:?} {point}");
            }
        }
    }

    #[test]
    fn shapes_that_no_point_sees_all_of_are_cut_into_their_triangles() {
        let l = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
        let u = [
            [0.0, 0.0],
            [5.0, 0.0],
            [5.0, 4.0],
            [4.0, 4.0],
            [4.0, 1.0],
            [1.0, 1.0],
            [1.0, 4.0],
            [0.0, 4.0],
        ];
        let bow = [[0.0, 0.0], [2.0, 0.9], [4.0, 0.0], [4.0, 2.0], [2.0, 1.1], [0.0, 2.0]];
        // Vertices along lines, and one that a diagonal would touch.
        let comb = [
            [0.0, 0.0],
            [1.0, 0.0],
            [3.0, 0.0],
            [3.0, 2.0],
            [2.0, 1.0],
            [1.5, 1.0],
            [1.0, 1.0],
            [0.0, 2.0],
        ];
        for points in [&l[..], &u, &bow, &comb] {
            check(&polygon(points));
        }
        assert_eq!(polygon(&l).triangles().len(), 4);
        assert_eq!(polygon(&u).triangles().len(), 6);
    }

    #[test]
    fn every_known_outline_is_cut_into_its_triangles() {
        for name in MIT_NAMES {
            if let Shape::Polygon(polygon) = mit_object(name).unwrap().shape {
                check(&polygon);
            }
        }
    }

    #[test]
    fn a_spiral_is_cut_into_its_triangles() {
        let at = |k: usize, gap: f64| {
            let turn = 0.15 * k as f64;
            (0.01 * (1.0 + turn) + gap) * Vector2::new(turn.cos(), turn.sin())
        };
        let outer = (0..80).map(|k| at(k, 0.02));
        let inner = (0..80).rev().map(|k| at(k, 0.0));
        check(&Polygon::new(outer.chain(inner).collect()).unwrap());
    }

    proptest! {
        #[test]
        fn any_simple_polygon_is_cut_into_its_triangles(
            n in 3..24usize, seed in 0..10_000u64, bend in 0.0..0.9f64, size in -6.0..6.0f64,
        ) {
            let share = |k: usize| ((seed as f64 + 1.0) * (k as f64 + 1.0) * 0.618_034).fract();
            let corner = |k: usize| {
                let turn = TAU * k as f64 / n as f64;
                let radius = 10_f64.powf(size) * (0.2 + share(k));
                let turn = turn + bend * (radius / 10_f64.powf(size)).powi(2);
                radius * Vector2::new(turn.cos(), turn.sin())
            };
            let polygon = Polygon::new((0..n).map(corner).collect());
            prop_assume!(polygon.is_ok());
            check(&polygon.unwrap());
        }
    }
}
