//! The support as small plates that slide and turn with the object.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

use crate::friction::Load;

/// Plates are handled in groups of this many, side by side in vector registers.
const LANES: usize = 4;

/// Plates that dissipate √(|T v|² + s ω²) per load, with v the velocity of a plate's middle, T a
/// tensor of friction and s half the square of the plate's radius of gyration: smooth where the
/// object turns about a plate.
#[derive(Clone, Debug)]
pub(crate) struct Plates {
    groups: Vec<Group>,
}

/// Plates side by side; a last group is filled up with plates without load.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Group {
    /// Places from S, in m, axes of the outline.
    x: [f64; LANES],
    y: [f64; LANES],
    /// s, in m².
    spin: [f64; LANES],
    /// Share of uniform pressure's load.
    pub(crate) uniform: [f64; LANES],
    /// Share of the load.
    pub(crate) share: [f64; LANES],
}

/// One plate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plate {
    /// From S, in m, axes of the outline.
    pub(crate) place: Vector2<f64>,
    /// s, in m².
    pub(crate) spin: f64,
    /// Share of uniform pressure's load.
    pub(crate) uniform: f64,
    /// Share of the load.
    pub(crate) share: f64,
}

impl Plates {
    pub(crate) fn new(plates: impl Iterator<Item = Plate>) -> Self {
        let plates: Vec<Plate> = plates.collect();
        let group = |plates: &[Plate]| {
            let of = |value: fn(&Plate) -> f64| {
                std::array::from_fn(|lane| plates.get(lane).map_or(0.0, value))
            };
            Group {
                x: of(|plate| plate.place.x),
                y: of(|plate| plate.place.y),
                spin: of(|plate| plate.spin),
                uniform: of(|plate| plate.uniform),
                share: of(|plate| plate.share),
            }
        };
        Self { groups: plates.chunks(LANES).map(group).collect() }
    }

    /// The plates with a load, in their order.
    pub(crate) fn each(&self) -> impl Iterator<Item = Plate> {
        let plate = |group: &Group, lane: usize| Plate {
            place: Vector2::new(group.x[lane], group.y[lane]),
            spin: group.spin[lane],
            uniform: group.uniform[lane],
            share: group.share[lane],
        };
        let of = move |group: &Group| {
            let group = *group;
            (0..LANES).map(move |lane| plate(&group, lane))
        };
        self.groups.iter().flat_map(of).filter(|plate| plate.uniform > 0.0)
    }

    /// The load of a motion at S, and its derivatives by the motion, with a weight for each plate of
    /// each group; zero for no motion.
    pub(crate) fn load(
        &self,
        tensor: &Matrix2<f64>,
        motion: &Vector3<f64>,
        mut weights: impl FnMut(&Group) -> [f64; LANES],
    ) -> Load {
        if *motion == Vector3::zeros() {
            return (Vector3::zeros(), Matrix3::zeros());
        }
        let through = tensor * motion.xy();
        let (t11, t12, t22) = (tensor.m11, tensor.m12, tensor.m22);
        let omega = motion.z;
        let mut sums = [[0.0; LANES]; 9];
        for group in &self.groups {
            let weights = weights(group);
            let Group { x, y, spin, .. } = group;
            // T J r, and T v along with it.
            let a = each(|k| t12 * x[k] - t11 * y[k]);
            let b = each(|k| t22 * x[k] - t12 * y[k]);
            let u = each(|k| through.x + omega * a[k]);
            let v = each(|k| through.y + omega * b[k]);
            let square = each(|k| u[k] * u[k] + v[k] * v[k] + spin[k] * omega * omega);
            let slowness = each(|k| 1.0 / square[k].max(f64::MIN_POSITIVE).sqrt());
            let u = each(|k| slowness[k] * u[k]);
            let v = each(|k| slowness[k] * v[k]);
            let turn = each(|k| a[k] * u[k] + b[k] * v[k] + slowness[k] * spin[k] * omega);
            let stiff = each(|k| weights[k] * slowness[k]);
            add(&mut sums[0], |k| weights[k] * u[k]);
            add(&mut sums[1], |k| weights[k] * v[k]);
            add(&mut sums[2], |k| weights[k] * turn[k]);
            add(&mut sums[3], |k| stiff[k] * (1.0 - u[k] * u[k]));
            add(&mut sums[4], |k| stiff[k] * (1.0 - v[k] * v[k]));
            add(&mut sums[5], |k| -stiff[k] * u[k] * v[k]);
            add(&mut sums[6], |k| stiff[k] * (a[k] - u[k] * turn[k]));
            add(&mut sums[7], |k| stiff[k] * (b[k] - v[k] * turn[k]));
            let arm = each(|k| a[k] * a[k] + b[k] * b[k] + spin[k]);
            add(&mut sums[8], |k| stiff[k] * (arm[k] - turn[k] * turn[k]));
        }
        let [x, y, z, xx, yy, xy, xz, yz, zz] = sums.map(|lanes| lanes.iter().sum::<f64>());
        let map = Matrix3::new(t11, t12, 0.0, t12, t22, 0.0, 0.0, 0.0, 1.0);
        let slope = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        (map * Vector3::new(x, y, z), map * slope * map)
    }
}

/// A number of each lane.
#[inline(always)]
fn each(value: impl Fn(usize) -> f64) -> [f64; LANES] {
    std::array::from_fn(value)
}

/// Adds a number to each lane.
#[inline(always)]
fn add(sum: &mut [f64; LANES], value: impl Fn(usize) -> f64) {
    for (lane, sum) in sum.iter_mut().enumerate() {
        *sum += value(lane);
    }
}
