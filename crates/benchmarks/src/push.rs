//! The quasi-static push on every kind of limit surface.

use anyhow::Result;
use mechanics::{
    Ellipsoid, Patch, PathSettings, PointSet, Push, Pusher, Quartic, Slider, StraightPath, predict,
    predict_with_external_wrench, push_along,
};
use nalgebra::{Unit, Vector2};
use planar::{Pose, Shape, Wrench};

use super::benchmark::Benchmark;
use super::timing::{Case, Row};

pub(super) const BENCHMARK: Benchmark = Benchmark {
    name: "push",
    about: "one push (or a path of 4 mm), by points of a sampled surface; the reference is the general \
            solver on the ellipsoid, for it the closed form (for the path, 2000 plain steps)",
    rows: |_| rows(),
};

const SIDE: f64 = 0.09;
const F_MAX: f64 = 2.0;
const N_POINTS: usize = 400;
const N_EULER_STEPS: usize = 2000;
const PUSHER: Pusher = Pusher { radius: 0.00475, friction: 0.3 };

fn rows() -> Result<Vec<Row>> {
    let square = Shape::square(SIDE)?;
    let ellipsoid = Ellipsoid::uniform(&square, F_MAX)?;
    let patch = Patch::uniform(&square, F_MAX)?;
    let quartic = Quartic::from_ellipsoid(&ellipsoid)?;
    let points = PointSet::sampling(&square, F_MAX, N_POINTS)?;
    let general = |push: &Push| predict_with_external_wrench(&ellipsoid, push, &Wrench::default());
    let closed = |push: &Push| predict(&ellipsoid, push);
    Ok(vec![
        row("ellipsoid, closed form", 1, 4096, &closed, &general),
        row("ellipsoid, general solver", 1, 256, &general, &closed),
        row("quartic", 1, 64, &|push: &Push| predict(&quartic, push), &general),
        row("uniform patch", 1, 64, &|push: &Push| predict(&patch, push), &general),
        row("point set", N_POINTS, 4, &|push: &Push| predict(&points, push), &general),
        path_row(&square, &ellipsoid),
    ])
}

fn row<T, U>(
    name: &str,
    size: usize,
    calls: usize,
    candidate: &impl Fn(&Push) -> T,
    reference: &impl Fn(&Push) -> U,
) -> Row {
    let pushes = pushes();
    let (mut ours, mut theirs) = (pushes.iter().cycle(), pushes.iter().cycle());
    let none = "the ring of pushes never ends";
    let case = Case { name, size, threads: 1, rounds: 21, calls };
    case.compare(|| candidate(ours.next().expect(none)), || reference(theirs.next().expect(none)))
}

/// Pushes on the square's left side that stick and slide to both sides.
fn pushes() -> Vec<Push> {
    let push = |k: usize| {
        let (place, angle) = (k % 8, k / 8);
        let y = SIDE * ((place as f64 + 0.5) / 8.0 - 0.5);
        let (sin, cos) = (0.3 * angle as f64 - 1.05).sin_cos();
        Push {
            p_sc: Vector2::new(-0.5 * SIDE, y),
            normal_s: Unit::new_unchecked(Vector2::x()),
            v_wp_s: 0.02 * Vector2::new(cos, sin),
            friction: PUSHER.friction,
        }
    };
    (0..64).map(push).collect()
}

/// A sliding push of 4 mm, beside Euler's method with steps of 2 µm, which is right to about a
/// micrometer too.
fn path_row(shape: &Shape, surface: &Ellipsoid) -> Row {
    let slider = Slider { shape, surface, pose_bs: Pose::default() };
    let case = Case { name: "path of 4 mm", size: 1, threads: 1, rounds: 21, calls: 8 };
    let path = path();
    let settings = PathSettings::default();
    case.compare(
        || push_along(&slider, &PUSHER, &path, &Pose::default(), &settings),
        || euler(&slider, &path),
    )
}

fn path() -> StraightPath {
    StraightPath {
        start_w: Vector2::new(-0.5 * SIDE - PUSHER.radius, 0.02),
        velocity_w: Vector2::new(0.018, 0.008),
        duration: 0.2,
    }
}

fn euler(slider: &Slider, path: &StraightPath) -> Pose {
    let h = path.duration / N_EULER_STEPS as f64;
    let mut pose = Pose::default();
    for k in 0..N_EULER_STEPS {
        let center = path.start_w + k as f64 * h * path.velocity_w;
        let contact = slider.contact(&PUSHER, &pose, &center);
        let push = slider.push_at(&PUSHER, &pose, &contact, &path.velocity_w);
        let Ok((_, twist)) = slider.velocity(&push, &pose) else { return pose };
        pose.position += h * twist.linear;
        pose.angle += h * twist.angular;
    }
    pose
}

#[cfg(test)]
mod tests {
    use super::{PUSHER, SIDE, euler, path, pushes};
    use mechanics::{ContactMode, Ellipsoid, PathSettings, Slider, predict, push_along};
    use planar::{Pose, Shape};

    #[test]
    fn the_pushes_stick_and_slide_to_both_sides() {
        let square = Shape::square(SIDE).unwrap();
        let surface = Ellipsoid::uniform(&square, 2.0).unwrap();
        let modes: Vec<_> =
            pushes().iter().map(|push| predict(&surface, push).unwrap().mode).collect();
        for mode in [ContactMode::Sticking, ContactMode::SlidingLeft, ContactMode::SlidingRight] {
            assert!(modes.iter().filter(|m| **m == mode).count() >= 8, "{mode:?}");
        }
    }

    #[test]
    fn both_sides_end_in_the_same_place() {
        let square = Shape::square(SIDE).unwrap();
        let surface = Ellipsoid::uniform(&square, 2.0).unwrap();
        let slider = Slider { shape: &square, surface: &surface, pose_bs: Pose::default() };
        let settings = PathSettings::default();
        let ours = push_along(&slider, &PUSHER, &path(), &Pose::default(), &settings).unwrap();
        let theirs = euler(&slider, &path());
        assert!((ours.pose_wb.position - theirs.position).norm() < 2e-6);
        assert!((ours.pose_wb.angle - theirs.angle).abs() < 2e-5);
    }
}
