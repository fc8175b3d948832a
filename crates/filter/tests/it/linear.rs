//! Random linear systems, and all that is known of them by one big Gaussian.

use filter::{Gaussian, LinearMeasurement, LinearMotion};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::{Strategy, prop};

/// How many states.
pub(crate) const D: usize = 3;
/// How many of a measurement.
pub(crate) const M: usize = 2;
/// How many motions.
pub(crate) const T: usize = 4;

/// x′ = F x + w, z = H x + v, measured before the first motion and after each.
#[derive(Clone, Debug)]
pub(crate) struct System {
    pub(crate) start: Gaussian,
    pub(crate) matrix: DMatrix<f64>,
    pub(crate) added: Gaussian,
    pub(crate) observed: DMatrix<f64>,
    pub(crate) noise: Gaussian,
    pub(crate) seen: Vec<DVector<f64>>,
}

fn matrix(rows: usize, columns: usize) -> impl Strategy<Value = DMatrix<f64>> {
    prop::collection::vec(-1.0..1.0_f64, rows * columns)
        .prop_map(move |values| DMatrix::from_vec(rows, columns, values))
}

/// A Gaussian of which the covariance has a rank of at least `rank`, and no more if that is all.
fn gaussian(d: usize, rank: usize, floor: f64) -> impl Strategy<Value = Gaussian> {
    (matrix(d, 1), matrix(d, rank)).prop_map(move |(mean, root)| {
        let covariance = &root * root.transpose() + floor * DMatrix::identity(d, d);
        Gaussian::new(mean.column(0).into(), covariance).unwrap()
    })
}

/// Systems whose motion has noise along one direction only.
pub(crate) fn systems() -> impl Strategy<Value = System> {
    let seen = prop::collection::vec(matrix(M, 1), T + 1);
    (
        gaussian(D, D, 0.02),
        matrix(D, D),
        gaussian(D, 1, 0.0),
        matrix(M, D),
        gaussian(M, M, 0.02),
        seen,
    )
        .prop_map(|(start, matrix, added, observed, noise, seen)| {
            let seen = seen.into_iter().map(|z| 2.0 * z.column(0)).collect();
            System { start, matrix, added, observed, noise, seen }
        })
}

impl System {
    pub(crate) fn motion(&self) -> LinearMotion {
        LinearMotion::new(self.matrix.clone(), self.added.clone()).unwrap()
    }

    pub(crate) fn moved(&self, x: &DVector<f64>) -> Gaussian {
        let mean = &self.matrix * x + self.added.mean();
        Gaussian::new(mean, self.added.covariance().clone()).unwrap()
    }

    pub(crate) fn measurement(&self, k: usize) -> LinearMeasurement {
        let (seen, noise) = (self.seen[k].clone(), self.noise.clone());
        LinearMeasurement::new(seen, self.observed.clone(), noise).unwrap()
    }

    /// All states, and then all measurements, as one Gaussian.
    pub(crate) fn joint(&self) -> Gaussian {
        let n = T + 1;
        // All of it is `root` · (start, added 1 … T, noise 0 … T), each by its own mean and covariance.
        let columns = n * D + n * M;
        let mut root = DMatrix::zeros(columns, columns);
        for k in 0..n {
            for j in 0..=k {
                let power = (j..k).fold(DMatrix::identity(D, D), |power, _| &self.matrix * power);
                root.view_mut((k * D, j * D), (D, D)).copy_from(&power);
                let observed = &self.observed * power;
                root.view_mut((n * D + k * M, j * D), (M, D)).copy_from(&observed);
            }
            root.view_mut((n * D + k * M, n * D + k * M), (M, M)).fill_with_identity();
        }
        let mut mean = DVector::zeros(columns);
        let mut covariance = DMatrix::zeros(columns, columns);
        for k in 0..n {
            let source = if k == 0 { &self.start } else { &self.added };
            for (at, part) in [(k * D, source), (n * D + k * M, &self.noise)] {
                let d = part.mean().len();
                mean.rows_mut(at, d).copy_from(part.mean());
                covariance.view_mut((at, at), (d, d)).copy_from(part.covariance());
            }
        }
        let covariance = &root * covariance * root.transpose();
        let covariance = 0.5 * (&covariance + covariance.transpose());
        Gaussian::new(root * mean, covariance).unwrap()
    }

    /// What the joint Gaussian says of state k once the measurements up to `last` are known; and their
    /// log density.
    pub(crate) fn known(&self, k: usize, last: usize) -> (DVector<f64>, DMatrix<f64>, f64) {
        let joint = self.joint();
        let (at, n) = ((T + 1) * D, (last + 1) * M);
        let of_seen = joint.covariance().view((at, at), (n, n)).into_owned();
        let cross = joint.covariance().view((k * D, at), (D, n)).into_owned();
        let seen = DVector::from_iterator(n, self.seen[..=last].iter().flatten().copied());
        let expected = joint.mean().rows(at, n).into_owned();
        let inverse = of_seen.clone().try_inverse().unwrap();
        let gain = &cross * inverse;
        let mean = joint.mean().rows(k * D, D) + &gain * (&seen - &expected);
        let own = joint.covariance().view((k * D, k * D), (D, D)).into_owned();
        let evidence = Gaussian::new(expected, of_seen).unwrap().log_density(&seen).unwrap();
        (mean, own - gain * cross.transpose(), evidence)
    }
}
