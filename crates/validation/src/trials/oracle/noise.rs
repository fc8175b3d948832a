//! The noise of what is read of pushes, from the simulator's own settings.

use std::collections::BTreeMap;

use anyhow::{Context, Result, bail};
use nalgebra::linalg::Cholesky;
use nalgebra::{DMatrix, DVector, Dyn};
use plant::{GenerateSettings, Scatter, SimulatedPush, simulate};
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::view::View;

/// The covariance of each push's numbers, and of what the pushes of a session share.
pub(super) struct Noise {
    pushes: Vec<PushNoise>,
    sessions: Vec<Session>,
    noisy: GenerateSettings,
    rig: GenerateSettings,
}

/// Of one push.
pub(super) struct PushNoise {
    /// Of all numbers, with a place that is as good as unknown.
    pub(super) factor: Option<Cholesky<f64, Dyn>>,
    /// The same where the place is known.
    pub(super) in_place: DMatrix<f64>,
    /// What a change of everything that scatters does, by one standard deviation each; first of the frictions
    /// and of the pressure's radius.
    pub(super) slopes: DMatrix<f64>,
}

/// What the pushes of a session share.
struct Session {
    pushes: Vec<usize>,
    /// Of each of them, whitened: what one standard deviation of the session does.
    whitened: Vec<DMatrix<f64>>,
    /// M in the root 1 − W M Wᵀ of (1 + W Wᵀ)⁻¹, with W the whitened columns of all its pushes.
    taken: DMatrix<f64>,
}

/// A quantity that differs from push to push.
type Change = fn(&mut GenerateSettings, f64);

/// What scatters, in standard deviations, as `plant::Scatter` has it; the nuisances come first.
const SCATTER: [Change; 8] = [
    |rig, z| rig.truth.support_friction.coefficient *= 1.0 + z * USUAL.support_friction_sd,
    |rig, z| rig.truth.tip_friction.coefficient *= 1.0 + z * USUAL.tip_friction_sd,
    |rig, z| rig.truth.pressure.radius_ratio *= 1.0 + z * USUAL.pressure_radius_sd,
    |rig, z| rig.truth.pressure.center_shift[0] += z * USUAL.pressure_center_sd,
    |rig, z| rig.truth.pressure.center_shift[1] += z * USUAL.pressure_center_sd,
    |rig, z| rig.truth.tip.bias += z * USUAL.contact_sd,
    |rig, z| rig.truth.force_sensor.loaded_bias[0] += z * USUAL.force_bias_sd,
    |rig, z| rig.truth.force_sensor.loaded_bias[1] += z * USUAL.force_bias_sd,
];
pub(super) const N_NUISANCES: usize = 3;
/// Draws of where the object is laid down on a path that stays: as many as a place has numbers.
const N_PLACES: u64 = 3;
/// A measured start pose is taken as given: its scatter is so many times the usual.
const UNKNOWN: f64 = 10.0;
/// The scatter of the trials.
const USUAL: Scatter = Scatter {
    support_friction_sd: 0.02,
    tip_friction_sd: 0.02,
    pressure_radius_sd: 0.01,
    pressure_center_sd: 2e-4,
    contact_sd: 1e-4,
    force_bias_sd: 0.01,
    placing_sd: 1e-4,
    turning_sd: 1e-3,
    session_share: 0.0,
    ..Scatter::NONE
};

impl Noise {
    /// The noise that `noisy` states, at pushes of a rig without noise.
    pub(super) fn of(
        rig: &GenerateSettings,
        noisy: &GenerateSettings,
        pushes: &[SimulatedPush],
        views: &[View],
    ) -> Result<Self> {
        let session_share = noisy.scatter.session_share;
        if noisy.scatter != (Scatter { session_share, ..USUAL }) {
            bail!("the oracle knows the usual scatter alone, got {:?}", noisy.scatter);
        }
        let changed = |change: &Change, z: f64| {
            let mut other = rig.clone();
            change(&mut other, z);
            simulate(&other)
        };
        let mut ends = Vec::new();
        for change in &SCATTER {
            ends.push([changed(change, 1.0)?, changed(change, -1.0)?]);
        }
        let placing =
            Scatter { placing_sd: USUAL.placing_sd, turning_sd: USUAL.turning_sd, ..Scatter::NONE };
        let placed = |draw: u64| {
            simulate(&GenerateSettings { scatter: placing, seed: rig.seed + draw, ..rig.clone() })
        };
        let places = (1..=N_PLACES).map(placed).collect::<Result<Vec<_>, _>>()?;
        let own = (0..views.len()).into_par_iter().map(|push| {
            let view = &views[push];
            let base = view.numbers(&pushes[push]);
            let change = |end: &Vec<SimulatedPush>| view.numbers(&end[push]) - &base;
            let ends: Vec<_> = ends.iter().map(|pair| pair.each_ref().map(change)).collect();
            let places: Vec<_> = places.iter().map(change).collect();
            PushNoise::of(view.sensor_variances(noisy), &ends, &places)
        });
        let own: Vec<PushNoise> = own.collect();
        let mut members: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (push, simulated) in pushes.iter().enumerate() {
            members.entry(simulated.plan.session).or_default().push(push);
        }
        let session = |pushes: Vec<usize>| Session::of(pushes, &own, session_share);
        let sessions = match session_share > 0.0 {
            true => members.into_values().map(session).collect(),
            false => Vec::new(),
        };
        Ok(Self { pushes: own, sessions, noisy: noisy.clone(), rig: rig.clone() })
    }

    pub(super) fn pushes(&self) -> &[PushNoise] {
        &self.pushes
    }

    /// Numbers of each push in units of their noise, without what a session may have shared; empty where
    /// nothing is known of a push.
    pub(super) fn whiten(&self, numbers: impl Iterator<Item = DVector<f64>>) -> Vec<DVector<f64>> {
        let own = self.pushes.iter().zip(numbers);
        let mut white: Vec<DVector<f64>> =
            own.map(|(noise, numbers)| noise.whiten(numbers).unwrap_or_default()).collect();
        self.sessions.iter().for_each(|session| session.take(&mut white));
        white
    }

    /// Root mean square of the whitened differences of the same pushes simulated with noise, less
    /// the numbers that tell where the object was laid down.
    ///
    /// # Errors
    /// A push that cannot be simulated.
    pub(super) fn check(&self, pushes: &[SimulatedPush], views: &[View]) -> Result<f64> {
        let noisy = GenerateSettings {
            design: self.rig.design.clone(),
            seed: self.noisy.seed + 1,
            ..self.noisy.clone()
        };
        let again = simulate(&noisy)?;
        let (mut sum, mut n) = (0.0, 0.0);
        let pairs = views.iter().zip(pushes.iter().zip(&again));
        let white =
            self.whiten(pairs.map(|(view, (push, again))| view.difference(push, again, 1.0)));
        for white in white.iter().filter(|white| !white.is_empty() && white.amax() > 0.0) {
            sum += white.norm_squared();
            n += white.len() as f64 - N_PLACES as f64;
        }
        (n > 0.0).then(|| (sum / n).sqrt()).context("no push stays in contact")
    }
}

impl PushNoise {
    /// From the variances of the sensors and what one scatter to either side does.
    ///
    /// With y = h z + c z² and z normal the variance is h hᵀ + 2 c cᵀ.
    fn of(sensors: DVector<f64>, ends: &[[DVector<f64>; 2]], places: &[DVector<f64>]) -> Self {
        let mut in_place = DMatrix::from_diagonal(&sensors);
        let mut whole = DMatrix::zeros(sensors.len(), sensors.len());
        let slope = |[up, down]: &[DVector<f64>; 2]| 0.5 * (up - down);
        for end in ends {
            let (slope, bend) = (slope(end), 0.5 * (&end[0] + &end[1]));
            in_place += &slope * slope.transpose() + 2.0 * &bend * bend.transpose();
        }
        for place in places {
            whole += UNKNOWN * UNKNOWN * place * place.transpose();
        }
        let columns: Vec<DVector<f64>> = ends.iter().map(slope).collect();
        let slopes = match sensors.len() {
            0 => DMatrix::zeros(0, SCATTER.len()),
            _ => DMatrix::from_columns(&columns),
        };
        let factor = (&in_place + whole).cholesky().filter(|_| !sensors.is_empty());
        Self { factor, in_place, slopes }
    }

    fn whiten(&self, mut numbers: DVector<f64>) -> Option<DVector<f64>> {
        let factor = self.factor.as_ref()?;
        factor.l_dirty().solve_lower_triangular_mut(&mut numbers).then_some(numbers)
    }
}

impl Session {
    fn of(pushes: Vec<usize>, own: &[PushNoise], share: f64) -> Self {
        let of_push = |push: &usize| {
            let noise = &own[*push];
            let columns =
                noise.slopes.column_iter().filter_map(|column| noise.whiten(share * column));
            let columns: Vec<DVector<f64>> = columns.collect();
            match columns.is_empty() {
                true => DMatrix::zeros(0, SCATTER.len()),
                false => DMatrix::from_columns(&columns),
            }
        };
        let whitened: Vec<DMatrix<f64>> = pushes.iter().map(of_push).collect();
        let n = SCATTER.len();
        let product = whitened.iter().fold(DMatrix::zeros(n, n), |sum, own| sum + own.tr_mul(own));
        // With WᵀW = V S² Vᵀ it is V (1 − 1/√(1 + S²))/S² Vᵀ.
        let axes = product.symmetric_eigen();
        let of_axis = |square: f64| {
            let root = (1.0 + square.max(0.0)).sqrt();
            1.0 / (root * (1.0 + root))
        };
        let taken = &axes.eigenvectors
            * DMatrix::from_diagonal(&axes.eigenvalues.map(of_axis))
            * axes.eigenvectors.transpose();
        Self { pushes, whitened, taken }
    }

    /// Takes out what the session may have shared.
    fn take(&self, white: &mut [DVector<f64>]) {
        let own = || self.pushes.iter().zip(&self.whitened);
        let known = |push: usize, columns: &DMatrix<f64>| white[push].len() == columns.nrows();
        let sum = own()
            .filter(|(push, columns)| known(**push, columns))
            .fold(DVector::zeros(SCATTER.len()), |sum, (push, columns)| {
                sum + columns.tr_mul(&white[*push])
            });
        let shared = &self.taken * sum;
        for (push, columns) in own() {
            if white[*push].len() == columns.nrows() {
                white[*push] -= columns * &shared;
            }
        }
    }
}
