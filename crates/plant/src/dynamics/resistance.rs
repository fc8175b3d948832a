//! What friction does to an object that slides on pads.

use nalgebra::{Matrix2, Matrix3, Vector3};
use pulp::{Scalar256b, Simd, WithSimd};

use crate::dynamics::pads::{LANES, Pads};
use crate::dynamics::quad::Quad;
use crate::truth::RateLaw;

/// Load of the friction on a moving object, and how it changes with the motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Resistance {
    /// Force (N) and moment about the reference point (N·m), opposite to what friction exerts.
    pub(crate) load: Vector3<f64>,
    /// Derivative of the load by the motion; symmetric.
    pub(crate) slope: Matrix3<f64>,
}

/// Pads seen from a reference point, in the body's axes.
#[derive(Clone, Debug)]
pub(crate) struct Footing {
    x: Vec<f64>,
    y: Vec<f64>,
    spin: Vec<f64>,
}

impl Footing {
    pub(crate) fn new(pads: &Pads, reference: &nalgebra::Vector2<f64>) -> Self {
        Self {
            x: pads.x.iter().map(|x| x - reference.x).collect(),
            y: pads.y.iter().map(|y| y - reference.y).collect(),
            spin: pads.spin.clone(),
        }
    }

    /// Place of a pad, in m, from the reference point.
    pub(crate) fn place(&self, index: usize) -> nalgebra::Vector2<f64> {
        nalgebra::Vector2::new(self.x[index], self.y[index])
    }

    /// The resistance against a motion (vx, vy, ω) of the reference point, in the body's axes.
    ///
    /// A pad that bears the friction w dissipates w·s with s² = vᵀGv + spin·ω² + creep², v its
    /// velocity: the Coulomb law, rounded where s is about the creep speed. A rate law multiplies
    /// the force by its factor at s. The cost is one square root and one division a pad.
    ///
    /// - `frictions`: largest friction of each pad, in N; - `metric`: G; - `creep`: in m/s.
    pub(crate) fn resistance(
        &self,
        frictions: &[f64],
        motion: &Vector3<f64>,
        metric: &Matrix2<f64>,
        creep: f64,
        law: &RateLaw,
    ) -> Resistance {
        let pass = Pass { footing: self, frictions, motion, metric, creep, law };
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            return Simd::vectorize(simd, pass);
        }
        Scalar256b.vectorize(pass)
    }
}

/// One pass over the pads, each lane by itself, so that the order of additions never changes and the bits do
/// not depend on the machine.
struct Pass<'a> {
    footing: &'a Footing,
    frictions: &'a [f64],
    motion: &'a Vector3<f64>,
    metric: &'a Matrix2<f64>,
    creep: f64,
    law: &'a RateLaw,
}

impl WithSimd for Pass<'_> {
    type Output = Resistance;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Resistance {
        let one = Quad::all(simd, 1.0);
        if self.law.is_off() {
            return self.sum(simd, |_, inverse| [inverse, one]);
        }
        self.sum(simd, |speed, inverse| {
            let factors = speed.numbers().map(|speed| self.law.factor(speed));
            let factor = Quad::new(simd, &factors.map(|(factor, _)| factor));
            let slope = Quad::new(simd, &factors.map(|(_, slope)| slope));
            [factor * inverse, factor - slope * speed]
        })
    }
}

impl Pass<'_> {
    /// `law` gives for s and 1/s: f/s and f − s f′, f the factor on the friction.
    #[inline(always)]
    fn sum<S: Simd>(&self, simd: S, law: impl Fn(Quad<S>, Quad<S>) -> [Quad<S>; 2]) -> Resistance {
        let Self { footing, frictions, motion, metric, creep, .. } = *self;
        let all = |number| Quad::all(simd, number);
        let [gxx, gxy, gyy] = [all(metric.m11), all(metric.m12), all(metric.m22)];
        let [vx, vy, omega] = [all(motion.x), all(motion.y), all(motion.z)];
        let floor = all(creep * creep);
        let mut totals = [all(0.0); 9];
        let columns = [&footing.x, &footing.y, &footing.spin, frictions];
        let [x, y, spin, frictions] = columns.map(|column| column.as_chunks::<LANES>().0);
        for (((x, y), spin), friction) in x.iter().zip(y).zip(spin).zip(frictions) {
            let new = |numbers| Quad::new(simd, numbers);
            let (x, y, spin, friction) = (new(x), new(y), new(spin), new(friction));
            let (px, py) = (vx - omega * y, vy + omega * x);
            // The gradient of s²/2 by the motion.
            let ux = gxx * px + gxy * py;
            let uy = gxy * px + gyy * py;
            let turning = spin * omega;
            let um = x * uy - y * ux + turning;
            let speed = (px * ux + py * uy + turning * omega + floor).sqrt();
            let inverse = speed.inverse();
            let [by_speed, rest] = law(speed, inverse);
            let first = friction * by_speed;
            let second = friction * rest * inverse * inverse * inverse;
            let (mx, my) = (x * gxy - y * gxx, x * gyy - y * gxy);
            let (sx, sy) = (second * ux, second * uy);
            let terms = [
                first * ux,
                first * uy,
                first * um,
                first * gxx - sx * ux,
                first * gxy - sx * uy,
                first * gyy - sy * uy,
                first * mx - sx * um,
                first * my - sy * um,
                first * (x * my - y * mx + spin) - second * um * um,
            ];
            for k in 0..9 {
                totals[k] = totals[k] + terms[k];
            }
        }
        let [fx, fy, m, xx, xy, yy, xm, ym, mm] = totals.map(Quad::sum);
        Resistance {
            load: Vector3::new(fx, fy, m),
            slope: Matrix3::new(xx, xy, xm, xy, yy, ym, xm, ym, mm),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Footing, Pass};
    use crate::dynamics::pads::Pads;
    use crate::truth::{Grain, RateLaw};
    use nalgebra::{Matrix2, Vector2, Vector3};
    use planar::Shape;
    use proptest::prelude::{ProptestConfig, prop_assert, proptest};
    use pulp::{Scalar256b, Simd};

    const CREEP: f64 = 1e-4;

    fn square(n: usize) -> (Footing, Vec<f64>) {
        let pads = Pads::uniform(&Shape::square(0.09).unwrap(), n);
        let frictions = pads.share.iter().map(|share| 2.0 * share).collect();
        (Footing::new(&pads, &Vector2::new(0.003, -0.001)), frictions)
    }

    #[test]
    fn a_translation_meets_the_whole_friction_and_rest_meets_none() {
        let (footing, frictions) = square(144);
        let law = RateLaw::default();
        let one = Matrix2::identity();
        let slide = footing.resistance(&frictions, &Vector3::new(0.3, 0.4, 0.0), &one, CREEP, &law);
        assert!((slide.load.xy() - Vector2::new(1.2, 1.6)).norm() < 1e-6);
        let rest = footing.resistance(&frictions, &Vector3::zeros(), &one, CREEP, &law);
        assert_eq!(rest.load, Vector3::zeros());
    }

    #[test]
    fn one_plate_of_spin_resists_like_an_ellipsoid() {
        let pads = Pads::uniform(&Shape::square(0.09).unwrap(), 144).blended(0.0);
        let footing = Footing::new(&pads, &Vector2::zeros());
        let c = 0.09 * (2.0_f64.sqrt() + (1.0 + 2.0_f64.sqrt()).ln()) / 6.0;
        let motion = Vector3::new(0.02, -0.01, 0.5);
        let one = Matrix2::identity();
        let frictions: Vec<_> = pads.share.iter().map(|share| 2.0 * share).collect();
        let load = footing.resistance(&frictions, &motion, &one, 1e-9, &RateLaw::default()).load;
        let level = (load.x / 2.0).powi(2) + (load.y / 2.0).powi(2) + (load.z / (2.0 * c)).powi(2);
        assert!((level - 1.0).abs() < 1e-3, "{level}");
    }

    #[test]
    fn a_machine_without_vector_registers_finds_the_same_bits() {
        let (footing, frictions) = square(100);
        let metric = Matrix2::new(1.2, 0.1, 0.1, 0.9);
        let motion = Vector3::new(0.02, -0.01, 0.5);
        for law in [RateLaw::default(), RateLaw { breakaway_ratio: 1.3, ..RateLaw::default() }] {
            let here = footing.resistance(&frictions, &motion, &metric, CREEP, &law);
            let (footing, frictions) = (&footing, frictions.as_slice());
            let (motion, metric, law) = (&motion, &metric, &law);
            let pass = Pass { footing, frictions, motion, metric, creep: CREEP, law };
            assert_eq!(here, Scalar256b.vectorize(pass));
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn the_slope_is_the_derivative_and_the_load_dissipates(
            v in (-0.05..0.05f64, -0.05..0.05f64, -1.0..1.0f64),
            ratio in 0.7..1.5f64, log_slope in 0.0..0.2f64, breakaway in 1.0..1.4f64,
        ) {
            let (footing, frictions) = square(100);
            let root = Grain { ratio, direction: 0.7 }.root_metric(0.0);
            let metric = root * root;
            let law = RateLaw { log_slope, breakaway_ratio: breakaway, ..RateLaw::default() };
            let motion = Vector3::new(v.0, v.1, v.2);
            let at = |motion: &Vector3<f64>| {
                footing.resistance(&frictions, motion, &metric, 1e-3, &law)
            };
            let here = at(&motion);
            prop_assert!(here.load.dot(&motion) >= 0.0);
            for k in 0..3 {
                let mut step = Vector3::zeros();
                step[k] = 1e-6;
                let rise = (at(&(motion + step)).load - at(&(motion - step)).load) / 2e-6;
                let error = (rise - here.slope.column(k)).amax();
                prop_assert!(error < 1e-4 * (1.0 + here.slope.amax()), "{error}");
            }
        }
    }
}
