//! Limit surfaces of every kind, each with its mirror image.

use mechanics::{
    Ellipsoid, LimitSurface, MechanicsError, PointSet, QUARTIC_EXPONENTS, Quartic, UniformPressure,
    WrenchSet, uniform_surfaces,
};
use nalgebra::{Matrix3, Vector2};
use planar::{Polygon, Shape, Twist, Wrench};
use std::sync::Arc;

/// A surface and the same of the object seen in a mirror along x.
pub(crate) struct Row {
    pub(crate) name: &'static str,
    pub(crate) surface: Arc<dyn LimitSurface>,
    pub(crate) mirrored: Arc<dyn LimitSurface>,
}

/// An ellipsoid that is not centered on the origin: friction that resists one way more than the other.
#[derive(Clone, Debug)]
pub(crate) struct Lopsided {
    pub(crate) ellipsoid: Ellipsoid,
    pub(crate) middle: Wrench,
}

impl LimitSurface for Lopsided {
    fn dissipation(&self, twist_s: &Twist) -> Result<f64, MechanicsError> {
        Ok(self.ellipsoid.dissipation(twist_s)? + self.middle.power(twist_s))
    }

    fn wrenches(&self, twist_s: &Twist) -> Result<WrenchSet, MechanicsError> {
        Ok(WrenchSet::Point(self.ellipsoid.wrench(twist_s)? + self.middle))
    }

    /// The smallest λ with w/λ − w₀ within the ellipsoid: the root of a quadratic.
    fn level(&self, wrench_s: &Wrench) -> Result<f64, MechanicsError> {
        let (w, middle) = (wrench_s.to_vector(), self.middle.to_vector());
        let metric = self.ellipsoid.matrix();
        let (own, both) = (w.dot(&(metric * w)), w.dot(&(metric * middle)));
        let inside = 1.0 - middle.dot(&(metric * middle));
        let root = (both * both + own * inside).sqrt();
        Ok(if own == 0.0 { 0.0 } else { own / (both + root) })
    }

    fn twist(&self, wrench_s: &Wrench) -> Result<Twist, MechanicsError> {
        let level = self.level(wrench_s)?;
        let on_surface = (1.0 / level) * *wrench_s;
        let normal = self.ellipsoid.twist(&(on_surface - self.middle))?;
        Ok(1.0 / on_surface.power(&normal) * normal)
    }

    fn characteristic_length(&self) -> f64 {
        self.ellipsoid.characteristic_length()
    }
}

/// Friction in N at points in m.
pub(crate) fn points(at: &[(f64, f64, f64)]) -> PointSet {
    PointSet::new(at.iter().map(|p| (Vector2::new(p.0, p.1), p.2))).unwrap()
}

fn set_of_points(name: &'static str, at: &[(f64, f64, f64)]) -> Row {
    let seen: Vec<_> = at.iter().map(|p| (p.0, -p.1, p.2)).collect();
    Row { name, surface: Arc::new(points(at)), mirrored: Arc::new(points(&seen)) }
}

fn quartic(name: &'static str, coefficients: [f64; 15], length: f64) -> Row {
    // Across the mirror Fy and M change their signs.
    let sign = |k: usize| {
        if (QUARTIC_EXPONENTS[k][1] + QUARTIC_EXPONENTS[k][2]).is_multiple_of(2) {
            1.0
        } else {
            -1.0
        }
    };
    let seen = std::array::from_fn(|k| sign(k) * coefficients[k]);
    Row {
        name,
        surface: Arc::new(Quartic::new(coefficients, length).unwrap()),
        mirrored: Arc::new(Quartic::new(seen, length).unwrap()),
    }
}

fn polygon(at: &[(f64, f64)]) -> Shape {
    Shape::Polygon(Polygon::new(at.iter().map(|p| Vector2::new(p.0, p.1)).collect()).unwrap())
}

/// Every kind that stands for uniform pressure, under a triangle; ellipsoids upright, tilted and off
/// center, few points with their facets, quartics.
pub(crate) fn rows() -> Vec<Row> {
    let tilted = |side: f64| {
        let (a, b, c) = (0.05 * side, 1.0 * side, -2.0);
        Ellipsoid::from_matrix(Matrix3::new(0.3, a, b, a, 0.25, c, b, c, 200.0)).unwrap()
    };
    let upright = Ellipsoid::new(2.0, 0.08).unwrap();
    let lopsided = |side: f64| Lopsided {
        ellipsoid: upright,
        middle: Wrench::new(0.9, 0.5 * side, -0.01 * side),
    };
    let corners = [(-0.04, -0.03), (0.05, -0.02), (0.01, 0.06)];
    let seen = [corners[0], corners[2], corners[1]].map(|(x, y)| (x, -y));
    let mut bulging = [0.0; 15];
    for (k, c) in [(0, 1.0), (10, 1.0), (14, 1.0), (3, 1.2), (5, 1.2), (12, 1.2)] {
        bulging[k] = c / 16.0;
    }
    let mut bent = bulging;
    for (k, c) in [(1, 0.1), (4, 0.2), (8, -0.15), (9, 0.1)] {
        bent[k] = c / 16.0;
    }
    let [corners, seen] = [&corners, &seen].map(|at| polygon(at));
    // Of a hundred points a path crosses many facets, and the error of each adds up: the bounds on
    // paths are those of few points, below.
    let kinds = uniform_surfaces().iter().filter(|kind| kind.name() != PointSet::NAME);
    let uniform = kinds.map(|kind| Row {
        name: kind.name(),
        surface: kind.over(&corners, 2.0).unwrap(),
        mirrored: kind.over(&seen, 2.0).unwrap(),
    });
    let others = vec![
        Row { name: "upright ellipsoid", surface: Arc::new(upright), mirrored: Arc::new(upright) },
        Row {
            name: "tilted ellipsoid",
            surface: Arc::new(tilted(1.0)),
            mirrored: Arc::new({
                // Of (Fx, Fy, M) the last two change their signs.
                let m = *tilted(1.0).matrix();
                let flip = Matrix3::from_diagonal(&nalgebra::Vector3::new(1.0, -1.0, -1.0));
                Ellipsoid::from_matrix(flip * m * flip).unwrap()
            }),
        },
        Row {
            name: "lopsided ellipsoid",
            surface: Arc::new(lopsided(1.0)),
            mirrored: Arc::new(lopsided(-1.0)),
        },
        set_of_points("three points", &[(0.0, 0.05, 1.0), (-0.04, -0.03, 0.8), (0.05, -0.02, 0.5)]),
        set_of_points(
            "four points",
            &[(0.045, 0.045, 0.4), (-0.045, 0.04, 0.7), (-0.04, -0.045, 0.5), (0.05, -0.03, 0.4)],
        ),
        quartic("quartic", bulging, 0.04),
        quartic("bent quartic", bent, 0.03),
    ];
    uniform.chain(others).collect()
}
