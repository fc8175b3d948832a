//! How far a density is from the one that particles come from.

use std::f64::consts::{PI, TAU};
use std::sync::OnceLock;

use anyhow::{Context, Result};
use filter::Mixture;
use nalgebra::{Cholesky, Const, Matrix3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use super::neighbors::Neighbors;

/// Standard deviations by which particles and densities are widened alike, in m, m and rad: less than
/// any sensor's. A part of a mixture may have no density along the normal of its contact.
const WIDER_SD: [f64; 3] = [1e-5, 1e-5, 1e-4];
/// The neighbor whose distance tells the density.
const NEIGHBOR: usize = 10;
/// Most particles at which densities are read.
const N_READ: usize = 50_000;
const DIMENSION: f64 = 3.0;
const EULER: f64 = 0.577_215_664_901_532_9;

/// Widened particles in units of their covariance.
pub(super) struct Cloud {
    units: Units,
    tree: Neighbors,
    /// Some of them, in SI and in units.
    read: Vec<(Vector3<f64>, [f64; 3])>,
    /// In nats of m, m and rad, once it has been asked for.
    entropy: OnceLock<f64>,
}

/// A mean, and the root of a covariance.
#[derive(Clone)]
struct Units {
    mean: Vector3<f64>,
    root: Cholesky<f64, Const<3>>,
}

impl Units {
    /// A place's difference from the mean, in units in which the covariance is 1.
    fn scaled(&self, place: &Vector3<f64>) -> Vector3<f64> {
        let off = self.root.l().solve_lower_triangular(&(place - self.mean));
        off.expect("the diagonal of a Cholesky factor is positive")
    }
}

impl Cloud {
    /// Of equal particles, each widened by draws of a seed.
    pub(super) fn of(places: &[Vector3<f64>], seed: u64) -> Result<Self> {
        let (mean, covariance) = moments(places);
        let wider = covariance + widening();
        let root = wider.cholesky().context("widened particles have a covariance")?;
        Ok(Self::with_units(places, seed, Units { mean, root }))
    }

    /// Others in the units of this one, so that distances compare.
    pub(super) fn beside(&self, places: &[Vector3<f64>], seed: u64) -> Self {
        Self::with_units(places, seed, self.units.clone())
    }

    fn with_units(places: &[Vector3<f64>], seed: u64, units: Units) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut wide = |place: &Vector3<f64>| {
            let noise = WIDER_SD.map(|sd| sd * random.sample::<f64, _>(StandardNormal));
            let place = place + Vector3::from(noise);
            (place, units.scaled(&place).into())
        };
        let all: Vec<(Vector3<f64>, [f64; 3])> = places.iter().map(&mut wide).collect();
        let tree = Neighbors::of(all.iter().map(|(_, scaled)| *scaled).collect());
        let every = all.len().div_ceil(N_READ).max(1);
        let read = all.into_iter().step_by(every).collect();
        Self { units, tree, read, entropy: OnceLock::new() }
    }

    /// Of so many of the particles, evenly chosen.
    pub(super) fn thinned(places: &[Vector3<f64>], n: usize) -> Vec<Vector3<f64>> {
        places.iter().step_by((places.len() / n).max(1)).take(n).copied().collect()
    }

    /// The Kullback–Leibler divergence of a density from that of the particles, in nats.
    ///
    /// E ln p by the distances to the tenth neighbors, less the mean of ln q at the particles.
    ///
    /// # Source
    /// Kozachenko & Leonenko (1987), Sample estimate of the entropy of a random vector.
    pub(super) fn divergence_of(&self, density: &Density) -> f64 {
        let log = |(place, _): &(Vector3<f64>, _)| density.log_at(place);
        let entropy = self.entropy.get_or_init(|| self.entropy());
        -entropy - mean(&self.read.par_iter().map(log).collect::<Vec<_>>())
    }

    /// The same of the density of other particles, which are known by their distances alone.
    ///
    /// # Source
    /// Wang, Kulkarni & Verdú (2009), Divergence estimation for multidimensional densities via
    /// k-nearest-neighbor distances.
    pub(super) fn divergence_of_cloud(&self, other: &Self) -> f64 {
        let log = |(_, at): &(_, [f64; 3])| {
            let own = self.tree.distance(*at, NEIGHBOR + 1);
            (other.tree.distance(*at, NEIGHBOR) / own).ln()
        };
        let counts = other.tree.len() as f64 / (self.tree.len() as f64 - 1.0);
        DIMENSION * mean(&self.read.par_iter().map(log).collect::<Vec<_>>()) + counts.ln()
    }

    /// In nats of m, m and rad.
    fn entropy(&self) -> f64 {
        let log = |(_, at): &(_, [f64; 3])| self.tree.distance(*at, NEIGHBOR + 1).ln();
        let distances = mean(&self.read.par_iter().map(log).collect::<Vec<_>>());
        let units: f64 = self.units.root.l().diagonal().iter().map(|x| x.ln()).sum();
        let n = self.tree.len() as f64;
        // ψ(N) of a large N, and ψ(k) of a whole k.
        let digamma = (1..NEIGHBOR).map(|i| 1.0 / i as f64).sum::<f64>() - EULER;
        n.ln() - 0.5 / n - digamma + (4.0 / 3.0 * PI).ln() + DIMENSION * distances + units
    }
}

/// Widened Gaussians with weights.
pub(super) struct Density {
    parts: Vec<(f64, Units)>,
}

impl Density {
    /// Of a mixture.
    pub(super) fn of(mixture: &Mixture) -> Result<Self> {
        let part = |(part, weight): &(filter::Gaussian, f64)| {
            let covariance = Matrix3::from_iterator(part.covariance().iter().copied());
            let mean = Vector3::from_iterator(part.mean().iter().copied());
            let root = (covariance + widening()).cholesky();
            Ok((weight.ln(), Units { mean, root: root.context("a widened part is positive")? }))
        };
        Ok(Self { parts: mixture.components().iter().map(part).collect::<Result<_>>()? })
    }

    fn log_at(&self, place: &Vector3<f64>) -> f64 {
        let log = |(log_weight, units): &(f64, Units)| {
            let square = units.scaled(place).norm_squared();
            let size: f64 = units.root.l().diagonal().iter().map(|x| x.ln()).sum();
            log_weight - 0.5 * (square + DIMENSION * TAU.ln()) - size
        };
        let logs = self.parts.iter().map(log);
        let largest = logs.clone().fold(f64::NEG_INFINITY, f64::max);
        largest + logs.map(|log| (log - largest).exp()).sum::<f64>().ln()
    }
}

/// Mean and covariance of equal places.
pub(super) fn moments(places: &[Vector3<f64>]) -> (Vector3<f64>, Matrix3<f64>) {
    let n = places.len() as f64;
    let mean = places.iter().sum::<Vector3<f64>>() / n;
    let off = places.iter().map(|place| place - mean);
    (mean, off.map(|off| off * off.transpose()).sum::<Matrix3<f64>>() / n)
}

fn widening() -> Matrix3<f64> {
    Matrix3::from_diagonal(&Vector3::from(WIDER_SD.map(|sd| sd * sd)))
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[cfg(test)]
mod tests {
    use filter::{Gaussian, Mixture};
    use nalgebra::{DMatrix, DVector, Vector3};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::{Cloud, Density};

    /// x of two bumps, y bent over x, as where pushes stick or slip.
    fn mixture(shift: f64) -> Mixture {
        let part = |x: f64, y: f64, weight: f64| {
            let root =
                DMatrix::from_row_slice(3, 3, &[1e-3, 0.0, 0.0, 5e-4, 2e-4, 0.0, 1e-2, 0.0, 2e-2]);
            let mean = DVector::from_vec(vec![x + shift, y, 0.1]);
            (Gaussian::new(mean, &root * root.transpose()).unwrap(), weight)
        };
        Mixture::new(vec![part(0.0, 0.0, 0.7), part(3e-3, 1e-3, 0.3)]).unwrap()
    }

    fn places(mixture: &Mixture, n: usize, seed: u64) -> Vec<Vector3<f64>> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let draw = |_| Vector3::from_iterator(mixture.sample(&mut random).iter().copied());
        (0..n).map(draw).collect()
    }

    #[test]
    fn a_density_is_nowhere_from_its_own_draws_and_as_far_from_others_as_known() {
        let (own, other) = (mixture(0.0), mixture(2e-4));
        let draws = places(&own, 100_000, 1);
        let cloud = Cloud::of(&draws, 2).unwrap();
        let [to_own, to_other] = [&own, &other].map(|q| Density::of(q).unwrap());
        let floor = cloud.divergence_of(&to_own);
        assert!(floor.abs() < 0.02, "{floor}");
        // The divergence of mixtures as a mean over the draws of the first.
        let known = draws.iter().map(|at| to_own.log_at(at) - to_other.log_at(at)).sum::<f64>()
            / draws.len() as f64;
        let found = cloud.divergence_of(&to_other);
        assert!(known > 0.08 && (found - known).abs() < 0.02, "{found} {known}");
        let [same, shifted] = [&own, &other].map(|q| cloud.beside(&places(q, 100_000, 3), 4));
        let (floor, found) =
            (cloud.divergence_of_cloud(&same), cloud.divergence_of_cloud(&shifted));
        assert!(floor.abs() < 0.02 && (found - known).abs() < 0.02, "{floor} {found} {known}");
    }
}
