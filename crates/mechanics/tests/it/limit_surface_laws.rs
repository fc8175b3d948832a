//! What every limit surface obeys.

use mechanics::{Ellipsoid, LimitSurface, Patch, PointSet, Quartic, uniform_surfaces};
use nalgebra::{Matrix3, Vector2, Vector3};
use planar::{Ellipse, Shape, Twist, Wrench, mit_object};
use proptest::prelude::{ProptestConfig, Strategy, prop_assert, proptest};
use std::sync::{Arc, OnceLock};

/// The moments and turns of all surfaces are scaled by a length of this size, in m.
const LENGTH: f64 = 0.04;

struct Row {
    name: &'static str,
    surface: Arc<dyn LimitSurface>,
    /// Relative error of level, dissipation and loads.
    tolerance: f64,
    /// Where all points lie on a line the surface has edges and the level no gradient there.
    smooth: bool,
}

fn surfaces() -> &'static [Row] {
    static ROWS: OnceLock<Vec<Row>> = OnceLock::new();
    ROWS.get_or_init(|| {
        let tilted = Matrix3::new(0.3, 0.05, 1.0, 0.05, 0.25, -2.0, 1.0, -2.0, 200.0);
        let ellipsoid = Ellipsoid::from_matrix(tilted).unwrap();
        let point = |x, y, f| (Vector2::new(x, y), f);
        let two = PointSet::new([point(0.05, 0.01, 1.0), point(-0.03, 0.02, 1.5)]).unwrap();
        let three = [point(0.0, 0.05, 1.0), point(-0.04, -0.03, 0.8), point(0.05, -0.02, 0.5)];
        let butter = mit_object("butter").unwrap().shape;
        let oval = Shape::Ellipse(Ellipse::new(0.05, 0.03).unwrap());
        let ramp = |r: &Vector2<f64>| 300.0 + 2000.0 * r.x + 1000.0 * r.y;
        let square = Shape::square(0.09).unwrap();
        // x⁴ + y⁴ + z⁴ with cross terms of 1.2 instead of the sphere's 2.
        let mut bulging = [0.0; 15];
        for (k, c) in [(0, 1.0), (10, 1.0), (14, 1.0), (3, 1.2), (5, 1.2), (12, 1.2)] {
            bulging[k] = c / 16.0;
        }
        let row = |name, surface, tolerance, smooth| Row { name, surface, tolerance, smooth };
        let uniform = uniform_surfaces().iter();
        let uniform =
            uniform.map(|kind| row(kind.name(), kind.over(&butter, 2.0).unwrap(), 1e-13, true));
        let others = vec![
            row("upright ellipsoid", Arc::new(Ellipsoid::new(2.0, 0.08).unwrap()), 1e-13, true),
            row("tilted ellipsoid", Arc::new(ellipsoid), 1e-13, true),
            row("two points", Arc::new(two), 1e-13, false),
            row("three points", Arc::new(PointSet::new(three).unwrap()), 1e-13, true),
            row("uniform oval", Arc::new(Patch::uniform(&oval, 2.0).unwrap()), 1e-13, true),
            row("ramp", Arc::new(Patch::with_traction(&square, ramp).unwrap()), 1e-10, true),
            row("bulging quartic", Arc::new(Quartic::new(bulging, LENGTH).unwrap()), 1e-13, true),
        ];
        uniform.chain(others).collect()
    })
}

fn direction() -> impl Strategy<Value = Vector3<f64>> {
    (-1.0..1.0, -1.0..1.0, -1.0..1.0)
        .prop_map(|(x, y, z)| Vector3::new(x, y, z))
        .prop_filter("too short", |v| v.norm() > 0.1)
}

fn wrench(v: &Vector3<f64>) -> Wrench {
    Wrench::new(v.x, v.y, v.z * LENGTH)
}

fn twist(v: &Vector3<f64>) -> Twist {
    Twist::new(v.x, v.y, v.z / LENGTH)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn the_level_is_symmetric_homogeneous_convex_and_bounded(a in direction(), b in direction()) {
        for Row { name, surface, tolerance, .. } in surfaces() {
            let level = |w: Wrench| surface.level(&w).unwrap();
            let (la, lb) = (level(wrench(&a)), level(wrench(&b)));
            prop_assert!(la > 0.0 && la.is_finite(), "{name}");
            prop_assert!((level(wrench(&-a)) - la).abs() <= tolerance * la, "{name}");
            prop_assert!((level(wrench(&(3.5 * a))) - 3.5 * la).abs() <= 4.0 * tolerance * la, "{name}");
            prop_assert!(level(wrench(&(a + b))) <= (la + lb) * (1.0 + tolerance), "{name}");
        }
    }

    #[test]
    fn the_dissipation_is_positive_symmetric_homogeneous_and_convex(a in direction(), b in direction()) {
        for Row { name, surface, tolerance, .. } in surfaces() {
            let power = |t: Twist| surface.dissipation(&t).unwrap();
            let (pa, pb) = (power(twist(&a)), power(twist(&b)));
            prop_assert!(pa > 0.0, "{name}");
            prop_assert!((power(twist(&-a)) - pa).abs() <= tolerance * pa, "{name}");
            prop_assert!((power(twist(&(3.5 * a))) - 3.5 * pa).abs() <= 4.0 * tolerance * pa, "{name}");
            prop_assert!(power(twist(&(a + b))) <= (pa + pb) * (1.0 + tolerance), "{name}");
        }
    }

    #[test]
    fn loads_and_motions_belong_to_each_other(a in direction(), b in direction()) {
        for Row { name, surface, tolerance, smooth } in surfaces() {
            let load = surface.wrench(&twist(&a)).unwrap();
            let power = surface.dissipation(&twist(&a)).unwrap();
            prop_assert!((load.power(&twist(&a)) - power).abs() <= tolerance * power, "{name}");
            prop_assert!((surface.level(&load).unwrap() - 1.0).abs() <= 10.0 * tolerance, "{name}");
            let other = surface.wrench(&twist(&b)).unwrap();
            prop_assert!(other.power(&twist(&a)) <= power * (1.0 + tolerance), "{name}: max power");
            if *smooth {
                let back = surface.twist(&load).unwrap().to_vector();
                let scale = Vector3::new(1.0, 1.0, LENGTH);
                let angle = back.component_mul(&scale).angle(&a);
                prop_assert!(angle <= 1e-5, "{name} {angle}");
            }
        }
    }

    #[test]
    fn the_motion_is_the_gradient_of_the_level(a in direction()) {
        for Row { name, surface, tolerance, smooth } in surfaces() {
            let motion = surface.twist(&wrench(&a)).unwrap();
            let level = surface.level(&wrench(&a)).unwrap();
            prop_assert!((wrench(&a).power(&motion) - level).abs() <= 10.0 * tolerance * level, "{name}");
            let power = surface.dissipation(&motion).unwrap();
            prop_assert!((power - 1.0).abs() <= 10.0 * tolerance, "{name}");
            if *smooth {
                let step = 1e-5;
                for axis in 0..3 {
                    let mut d = Vector3::zeros();
                    d[axis] = step;
                    let at = |v: Vector3<f64>| surface.level(&wrench(&v)).unwrap();
                    let slope = (at(a + d) - at(a - d)) / (2.0 * step);
                    let expected = wrench(&(d / step)).power(&motion);
                    prop_assert!((slope - expected).abs() <= 2e-4 * level, "{name} {slope} {expected}");
                }
            }
        }
    }
}
