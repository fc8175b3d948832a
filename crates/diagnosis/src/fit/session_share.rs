//! How much of what differs from push to push is the same for all pushes of a session.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{DMatrix, DVector};

use super::motion_errors::{Missed, MotionErrors};
use crate::cut_offs::{FEWEST_SESSIONS_OF_SPREAD, SURE_OF_SPREAD};
use crate::{DiagnosisError, Observations};

/// Shares that are tried.
const N_SHARES: usize = 100;

/// What a push's motions tell of the normal numbers that it drew: J'C⁻¹J and J'C⁻¹r of its errors C.
struct Told {
    information: DMatrix<f64>,
    score: DVector<f64>,
}

/// The likeliest share of the variance of a spread that sessions have, of a model whose spread from push to
/// push holds both; none for fewer than four sessions, where pushes do not differ, and where the share may be
/// chance (p > 0.05).
///
/// # Errors
/// `NotACovariance` for a push whose numbers overflow.
pub(super) fn session_share(
    observations: &Observations,
    all: &[Missed],
    errors: &MotionErrors,
) -> Result<Option<f64>, DiagnosisError> {
    let session_of = sessions(observations);
    let n_sessions = session_of.values().copied().collect::<BTreeSet<_>>().len();
    if n_sessions < FEWEST_SESSIONS_OF_SPREAD {
        return Ok(None);
    }
    let mut pushes: BTreeMap<u32, Vec<Told>> = BTreeMap::new();
    for (push, session) in session_of {
        let missed = &all[push];
        if missed.n_steps() > 0 && missed.has_drawn() {
            let (information, score) = errors.told_of_draws(push, missed)?;
            pushes.entry(session).or_default().push(Told { information, score });
        }
    }
    let density = |share: f64| pushes.values().map(|session| log_density(session, share)).sum();
    let share_at = |k: usize| k as f64 / N_SHARES as f64;
    let densities: Vec<f64> = (0..=N_SHARES).map(|k| density(share_at(k))).collect();
    let best = (0..=N_SHARES).max_by(|a, b| densities[*a].total_cmp(&densities[*b]));
    let is_sure = |k: &usize| densities[*k] - densities[0] > SURE_OF_SPREAD;
    Ok(best.filter(is_sure).map(share_at))
}

/// The session of each push that has steps: that in which it begins.
fn sessions(observations: &Observations) -> BTreeMap<usize, u32> {
    let mut sessions = BTreeMap::new();
    for (step, push) in observations.steps.iter().zip(&observations.push_of) {
        sessions.entry(*push).or_insert(step.input.session);
    }
    sessions
}

/// Log density of the pushes of a session that share a part of what they draw, but for what no share changes.
///
/// A push's own part is integrated out first, then the part that all of them have.
fn log_density(pushes: &[Told], share: f64) -> f64 {
    let Some(first) = pushes.first() else { return 0.0 };
    let n = first.score.len();
    let unit = DMatrix::identity(n, n);
    let (mut information, mut score) = (DMatrix::zeros(n, n), DVector::zeros(n));
    let mut density = 0.0;
    for push in pushes {
        let Some(own) = (&unit + (1.0 - share) * &push.information).cholesky() else {
            return f64::NEG_INFINITY;
        };
        let left = own.solve(&push.score);
        density += 0.5 * ((1.0 - share) * push.score.dot(&left) - own.ln_determinant());
        information += own.solve(&push.information);
        score += left;
    }
    let Some(common) = (&unit + share * &information).cholesky() else {
        return f64::NEG_INFINITY;
    };
    density + 0.5 * (share * score.dot(&common.solve(&score)) - common.ln_determinant())
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::{Told, log_density};
    use crate::synthetic::normal;

    /// The log density of numbers that pushes draw, each measured with variance 1, from their whole covariance.
    fn dense(values: &[f64], share: f64) -> f64 {
        let n = values.len();
        let covariance = DMatrix::from_fn(n, n, |one, other| {
            share + if one == other { 1.0 + (1.0 - share) } else { 0.0 }
        });
        let (factor, values) = (covariance.cholesky().unwrap(), DVector::from_column_slice(values));
        -0.5 * (factor.ln_determinant() + values.dot(&factor.solve(&values)))
    }

    #[test]
    fn parts_that_are_integrated_out_leave_the_density_of_the_whole_covariance() {
        let values = [0.3, -1.2, 0.8, 2.0];
        let told = |value: &f64| Told {
            information: DMatrix::from_element(1, 1, 1.0),
            score: DVector::from_element(1, *value),
        };
        let pushes: Vec<Told> = values.iter().map(told).collect();
        let off = |share: f64| log_density(&pushes, share) - dense(&values, share);
        for share in [0.2, 0.7, 1.0] {
            assert!((off(share) - off(0.0)).abs() < 1e-12, "{share}");
        }
    }

    #[test]
    fn the_likeliest_share_is_that_which_sessions_have() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        for truth in [0.0_f64, 0.5] {
            let session = |_| {
                let common = truth.sqrt() * normal(&mut rng);
                let mut push = || {
                    let drawn = common + (1.0 - truth).sqrt() * normal(&mut rng);
                    let information = DMatrix::from_element(1, 1, 4.0);
                    let score = DVector::from_element(1, 4.0 * drawn + 2.0 * normal(&mut rng));
                    Told { information, score }
                };
                (0..10).map(|_| push()).collect::<Vec<_>>()
            };
            let sessions: Vec<Vec<Told>> = (0..200).map(session).collect();
            let density = |share: f64| -> f64 {
                sessions.iter().map(|session| log_density(session, share)).sum()
            };
            let best = (0..=20).map(|k| f64::from(k) / 20.0);
            let best = best.max_by(|a, b| density(*a).total_cmp(&density(*b))).unwrap();
            assert!((best - truth).abs() < 0.11, "{truth} {best}");
        }
    }
}
