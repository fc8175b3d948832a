//! How the errors of the steps of a push go together.

use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use rand_distr::{ChiSquared, Distribution};
use serde::{Deserialize, Serialize};

use crate::ContactGap;

/// Which part of a model's variance the steps of a push share, and for how long, which is each step's
/// own, and which is noise of the measured poses, that one step has in excess and the next one lacks.
///
/// z_k = A_k (s (√held · g_k + √own · w_k) + √measured · (e_{k+1} − e_k)), of errors
/// z = A L⁻¹(observed − mean) with L Lᵀ the model's covariance of a step and A the directions that
/// contact leaves free ([`RollOut`](crate::RollOut) conditions draws on the gap); g, w and e have
/// variance 1, g_k and g_l the correlation exp(−way from k to l / length): where a model errs it errs
/// near by, too, until the contact has moved on. s² is a push's own, ν/χ²_ν: some pushes go where the
/// model is worse than it says.
///
/// The shares and the length come from the mean products of a push's errors, by least squares; the
/// degrees of freedom ν, and how large held and own are together, from what the errors of whole pushes
/// add up to, by maximum likelihood: the sum is what a roll-out ends with. Few pushes leave ν open,
/// which makes the tails heavier. Where pushes draw numbers ([`PushModel::n_drawn`](crate::PushModel::n_drawn)),
/// errors are about each push's likeliest draw. A bias that all pushes share counts as held.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StepCorrelation {
    /// Of Δx, Δy and Δθ, as shares of the model's variance: the scale squared of a t.
    pub held: [f64; 3],
    /// The pusher's way, in m, over which the correlation of what is held falls to 1/e.
    pub length: f64,
    /// As `held`, of what each step has for itself.
    pub own: [f64; 3],
    /// The degrees of freedom of a push's size: many for pushes that are all alike.
    pub freedom: f64,
    /// Share of the model's variance that is noise of a measured pose; it does not move the object.
    pub measured: [f64; 3],
    /// What contact holds of the gap that was measured at its start.
    pub gap: ContactGap,
    /// Pushes that it was measured on.
    pub n_pushes: usize,
    /// Their steps.
    pub n_steps: usize,
    /// How many of their ends are within the regions of roll-outs, if that was checked.
    pub ends: Option<EndCheck>,
}

/// How many measured ends of pushes the regions of roll-outs hold.
///
/// By chance alone the number within a region of level q of n ends scatters with a standard deviation of
/// √(n q (1 − q)).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EndCheck {
    /// Pushes that were rolled out.
    pub n_pushes: usize,
    /// Those that end within the regions of [`EndCheck::LEVELS`].
    pub n_within: [usize; 3],
}

impl EndCheck {
    /// The levels of the regions.
    pub const LEVELS: [f64; 3] = [0.5, 0.9, 0.95];
}

impl StepCorrelation {
    /// What no measurement gives, and the key that says it; far beyond all that one can give, which has to be read back.
    pub(crate) fn problem(&self) -> Option<(&'static str, String)> {
        let shares = [
            ("calibration.correlation.held", self.held),
            ("calibration.correlation.own", self.own),
            ("calibration.correlation.measured", self.measured),
        ];
        let shares =
            shares.into_iter().flat_map(|(key, of)| of.map(|share| (key, share, [0.0, 1e30])));
        let ContactGap { offset, kept, sd } = self.gap;
        let others = [
            ("calibration.correlation.length", self.length, [1e-9, 1e9]),
            ("calibration.correlation.freedom", self.freedom, [1.0, 1e9]),
            ("calibration.correlation.gap.offset", offset, [-1e9, 1e9]),
            ("calibration.correlation.gap.kept", kept, [-1e9, 1e9]),
            ("calibration.correlation.gap.sd", sd, [0.0, 1e9]),
        ];
        let mut all = shares.chain(others);
        all.find_map(|(key, value, [low, high])| {
            let problem = || format!("must be from {low} to {high}, got {value:?}");
            (!(low..=high).contains(&value)).then(|| (key, problem()))
        })
    }

    /// A push's size s: the root of ν/χ²_ν.
    pub(crate) fn size(&self, random: &mut ChaCha8Rng) -> f64 {
        // Degrees of freedom are positive; without them there is no scatter of the scatter.
        ChiSquared::new(self.freedom).map_or(1.0, |chi| (self.freedom / chi.sample(random)).sqrt())
    }

    /// What is kept of g over a way of the pusher, in m.
    pub(crate) fn kept(&self, way: f64) -> f64 {
        (-way / self.length).exp()
    }

    /// A whitened error of a step, of the numbers g and w for a push of size 1.
    pub(crate) fn drawn(&self, held: &Vector3<f64>, own: &Vector3<f64>) -> Vector3<f64> {
        Vector3::from_fn(|k, _| self.held[k].sqrt() * held[k] + self.own[k].sqrt() * own[k])
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Vector3};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{ChiSquared, Distribution, StandardNormal};

    use super::StepCorrelation;
    use crate::ModelError;
    use crate::scatter::given_draw::GivenDraw;
    use crate::scatter::push_errors::PushErrors;
    use crate::steps::prediction::root;

    const STEPS: usize = 12;
    const WAY: f64 = 0.004;
    const N_PUSHES: usize = 8000;

    /// Known shares, and the size of pushes: all alike, or as a t of some degrees of freedom.
    struct Truth {
        held: f64,
        length: f64,
        own: f64,
        measured: f64,
        freedom: f64,
        /// Whether contact holds, at places that differ from push to push.
        in_contact: bool,
    }

    const TRUTH: Truth = Truth {
        held: 0.4,
        length: 0.012,
        own: 0.4,
        measured: 0.1,
        freedom: f64::INFINITY,
        in_contact: false,
    };

    const IN_CONTACT: Truth = Truth { in_contact: true, ..TRUTH };

    impl Truth {
        /// The directions that contact leaves free in a push.
        fn free(&self, push: usize) -> Matrix3<f64> {
            let turn = 2.4 * push as f64;
            let held = Vector3::new(0.6 * turn.cos(), 0.6 * turn.sin(), 0.8);
            let part = if self.in_contact { 1.0 } else { 0.0 };
            Matrix3::identity() - part * held * held.transpose()
        }
    }

    fn errors(n_pushes: usize, truth: &Truth, seed: u64) -> Vec<PushErrors> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let Truth { held, length, own, measured, freedom, .. } = *truth;
        let kept = (-WAY / length).exp();
        let mut push = |k| {
            let free = truth.free(k);
            let size = match freedom.is_finite() {
                true => (freedom / ChiSquared::new(freedom).unwrap().sample(&mut random)).sqrt(),
                false => 1.0,
            };
            let mut normal =
                || -> Vector3<f64> { Vector3::from_fn(|_, _| random.sample(StandardNormal)) };
            let (mut shared, mut noise) = (normal(), normal());
            let mut step = |_| {
                let before = std::mem::replace(&mut noise, normal());
                let of_push = size * (held.sqrt() * shared + own.sqrt() * normal());
                shared = kept * shared + (1.0 - kept * kept).sqrt() * normal();
                of_push + measured.sqrt() * (noise - before)
            };
            let errors = (0..STEPS).map(&mut step).map(|error| free * error).collect();
            PushErrors { errors, free: vec![free; STEPS], drawn: GivenDraw::default(), way: WAY }
        };
        (0..n_pushes).map(&mut push).collect()
    }

    #[test]
    fn known_shares_and_their_length_are_found() {
        let heavy = Truth { freedom: 5.0, ..TRUTH };
        let held = Truth { length: 1e3, ..TRUTH };
        let noise = Truth { held: 0.0, own: 0.2, measured: 0.4, ..TRUTH };
        for truth in [TRUTH, IN_CONTACT, heavy, held, noise] {
            let found = StepCorrelation::of_errors(&errors(N_PUSHES, &truth, 7)).unwrap();
            for (values, truth) in
                [(found.held, truth.held), (found.own, truth.own), (found.measured, truth.measured)]
            {
                assert!(values.iter().all(|value| (value - truth).abs() < 0.1), "{found:?}");
            }
            // Which of them it is shows at a few lags only; how much there is at all of them.
            for k in 0..3 {
                let whole = found.held[k] + found.own[k] + 2.0 * found.measured[k];
                let truth = truth.held + truth.own + 2.0 * truth.measured;
                assert!((whole / truth - 1.0).abs() < 0.05, "{found:?}");
            }
            assert!((1.0 / found.freedom - 1.0 / truth.freedom).abs() < 0.03, "{found:?}");
            let is_long = found.length > 40.0 * WAY;
            let is_near = (found.length / truth.length).ln().abs() < 0.3;
            assert!(truth.held == 0.0 || is_near || (truth.length > 1.0 && is_long), "{found:?}");
            assert_eq!((found.n_pushes, found.n_steps), (N_PUSHES, N_PUSHES * STEPS));
        }
    }

    #[test]
    fn a_push_ends_as_far_off_as_its_shares_say() {
        for truth in [TRUTH, IN_CONTACT, Truth { freedom: 5.0, ..TRUTH }] {
            let shares = StepCorrelation::of_errors(&errors(N_PUSHES, &truth, 7)).unwrap();
            let pushes = errors(N_PUSHES, &truth, 8);
            let square =
                |push: &PushErrors| push.errors.iter().sum::<Vector3<f64>>().norm_squared();
            let real = pushes.iter().map(square).sum::<f64>() / N_PUSHES as f64;
            let parts = |parts: [f64; 3]| Vector3::from(parts);
            let mean_square_size = shares.freedom / (shares.freedom - 2.0);
            let mut forecast = 2.0 * parts(shares.measured);
            for (k, l) in (0..STEPS).flat_map(|k| (0..STEPS).map(move |l| (k, l))) {
                let kept = shares.kept(WAY * k.abs_diff(l) as f64);
                let own = if k == l { parts(shares.own) } else { Vector3::zeros() };
                forecast += mean_square_size * (kept * parts(shares.held) + own);
            }
            let free = |k| truth.free(k).diagonal().dot(&forecast);
            let forecast = (0..N_PUSHES).map(free).sum::<f64>() / N_PUSHES as f64;
            assert!((forecast / real - 1.0).abs() < 0.1, "{forecast} {real}");
            let alone = if truth.in_contact { 2.0 } else { 3.0 } * STEPS as f64;
            assert!(real / alone > 2.0, "independent steps would say 1, and be far too sure");
        }
    }

    #[test]
    fn few_or_short_pushes_are_refused() {
        let mut few = errors(5, &TRUTH, 7);
        few[0].errors.truncate(2);
        few[1].errors.truncate(1);
        let error = StepCorrelation::of_errors(&few).unwrap_err();
        assert!(matches!(error, ModelError::TooFewPushes { n_pushes: 3, needed: 4 }), "{error}");
    }

    #[test]
    fn a_root_gives_its_covariance_back_even_if_that_is_singular() {
        let factor = Matrix3::new(1.0, 0.0, 0.0, -0.5, 2.0, 0.0, 0.25, 1.0, 0.5);
        let full = factor * factor.transpose();
        let flat = Vector3::new(1.0, 0.0, 2.0);
        for covariance in [full, flat * flat.transpose(), Matrix3::zeros()] {
            let root = root(&covariance);
            assert!((root * root.transpose() - covariance).amax() < 1e-12, "{covariance}");
        }
    }
}
