//! A screen's work: whitened residual and slopes of every push, and the tests made of them.

use models::Cluster;
use nalgebra::{DMatrix, DVector};
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use crate::cut_offs::NAME;
use crate::data::split::clusters;
use crate::predict::candidates::{Candidate, Candidates};
use crate::predict::tangent::Tangent;
use crate::screen::untestable::untestable;
use crate::statistics::score::{Products, Score, detectable, likeness};
use crate::statistics::sign_flips::{FlipTest, Flips};
use crate::{
    Calibration, LookAlikes, Nuisance, Observations, Screen, ScreenSettings, ScreenedCoordinate,
    ScreenedEffect, Whitening,
};

/// Products of whitened columns, with what is tested and what is a nuisance.
pub(crate) struct Whitened<'a> {
    observations: &'a Observations,
    candidates: &'a Candidates,
    settings: &'a ScreenSettings,
    whitening: &'a Whitening,
    /// Whitened residual and slopes of each push.
    pushes: Vec<(DVector<f64>, DMatrix<f64>)>,
    of_push: Vec<Products>,
    all: Products,
    /// Size of each coordinate in which it is whitened.
    scale: Vec<f64>,
    is_free: Vec<bool>,
    nuisances: Vec<usize>,
}

impl<'a> Whitened<'a> {
    pub(crate) fn new(
        observations: &'a Observations,
        tangent: &'a Tangent,
        whitening: &'a Whitening,
        settings: &'a ScreenSettings,
    ) -> Self {
        let Tangent { candidates, linearisation, .. } = tangent;
        let mut scale = candidates.prior_sd.clone();
        let mut is_free = vec![true; scale.len()];
        let mut nuisances = Vec::new();
        for candidate in &candidates.effects {
            let tolerance = settings.tolerances.of(candidate.effect.info());
            if let Some(tolerance) = tolerance.filter(|tolerance| tolerance.is_finite()) {
                for k in candidate.coordinates.clone() {
                    (scale[k], is_free[k]) = (tolerance, candidate.is_in_model);
                }
            }
            if tolerance.is_some() || candidate.is_in_model {
                nuisances.extend(candidate.coordinates.clone());
            }
        }
        let push = |push: usize| {
            let entries = whitening.entries(push);
            let columns = DMatrix::from_fn(entries.len(), 1 + scale.len(), |row, column| {
                let (step, number) = entries[row];
                match column.checked_sub(1) {
                    Some(k) => scale[k] * tangent.slopes(k)[step][number],
                    None => {
                        let observed = observations.steps[step].observed[number];
                        observed.unwrap_or_default() - linearisation.predicted[step][number]
                    }
                }
            });
            let white = whitening.whiten_columns(push, columns);
            (white.column(0).into_owned(), white.columns(1, scale.len()).into_owned())
        };
        let pushes: Vec<_> = (0..observations.pushes.len()).into_par_iter().map(push).collect();
        let of_push: Vec<Products> =
            (&pushes).into_par_iter().map(|(r, slopes)| Products::of(r, slopes)).collect();
        let mut all = Products::zero(scale.len());
        of_push.iter().for_each(|push| all.add(push));
        Self {
            observations,
            candidates,
            settings,
            whitening,
            pushes,
            of_push,
            all,
            scale,
            is_free,
            nuisances,
        }
    }

    pub(crate) fn screen(&self) -> Screen {
        let (cluster, members) = (self.observations.cluster, clusters(self.observations));
        let of_cluster = |pushes: &Vec<usize>| {
            let mut sum = Products::zero(self.scale.len());
            pushes.iter().for_each(|push| sum.add(&self.of_push[*push]));
            sum
        };
        let clusters: Vec<Products> = members.iter().map(of_cluster).collect();
        let tested = self.candidates.effects.iter().filter(|candidate| !candidate.is_in_model);
        let mut effects = Vec::new();
        let mut tests = Vec::new();
        for candidate in tested {
            let (effect, test) = self.tested(candidate, &clusters);
            effects.push(effect);
            tests.push(test);
        }
        let n_parts = tests.iter().map(FlipTest::n_parts).max().unwrap_or_default();
        let flips = Flips::new(n_parts, self.settings.n_flips, self.settings.seed);
        for (effect, found) in effects.iter_mut().zip(flips.probabilities(&tests)) {
            (effect.p, effect.p_adjusted) = (found.p, found.p_adjusted);
            effect.settle();
        }
        let look_alikes = self.look_alikes(&effects);
        effects.sort_by(|a, b| b.statistic.total_cmp(&a.statistic));
        let n_tests = tests.iter().filter(|test| test.n_parts() > 0).count();
        let calibration = Calibration::of(cluster, members.len(), flips.len(), n_tests);
        let (whitened_rms, step_correlation, nuisances) = self.without_effects();
        Screen {
            n_pushes_in_all: self.observations.pushes.len(),
            n_pushes: self.observations.pushes.len(),
            n_steps: self.observations.n_steps(),
            n_numbers: self.whitening.n_numbers(),
            whitened_rms,
            step_correlation,
            calibration,
            nuisances,
            effects,
            look_alikes,
        }
    }

    fn score(&self, coordinates: Vec<usize>) -> Option<Score> {
        let other = self.nuisances.iter().copied().filter(|k| !coordinates.contains(k));
        Score::new(&self.all, coordinates.clone(), other.collect(), &self.is_free)
    }

    /// The test of one effect, with each cluster's part in it.
    fn tested(&self, candidate: &Candidate, clusters: &[Products]) -> (ScreenedEffect, FlipTest) {
        let about = candidate.effect.info();
        let indices: Vec<usize> = candidate.coordinates.clone().collect();
        let freedom = indices.len();
        let mut found = ScreenedEffect {
            id: about.id,
            not_testable: None,
            statistic: 0.0,
            freedom,
            p: 1.0,
            p_adjusted: 1.0,
            coordinates: Vec::new(),
        };
        let no_test = FlipTest::none();
        let score = self.score(indices);
        found.not_testable =
            untestable(self.observations, self.candidates, candidate, &self.scale, score.as_ref());
        let may_be_seen = found.not_testable.as_ref().is_none_or(|why| why.reason.is_of_size());
        let Some(score) = score.filter(|_| may_be_seen) else { return (found, no_test) };
        let (Some(statistic), Some(covariance)) = (score.statistic(), score.covariance()) else {
            return (found, no_test);
        };
        let change = &covariance * &score.score;
        let share = self.share(&score, &change);
        found.statistic = share * (2.0 - share) * statistic;
        let parts = clusters.iter().map(|cluster| score.part(cluster));
        let parts: Vec<_> = parts.chain(score.beliefs(&self.is_free)).collect();
        let zero = DMatrix::zeros(freedom, freedom);
        let scatter = parts.iter().fold(zero, |sum, part| sum + part * part.transpose());
        let sandwich = &covariance * scatter * &covariance;
        let shared = self.shared(&score, clusters);
        found.coordinates = (0..freedom)
            .map(|k| {
                let index = score.tested[k];
                let ((name, unit), scale) = (self.candidates.names[index], self.scale[index]);
                let (off, here) = (self.candidates.off[index], self.candidates.here[index]);
                let [down, up] = self.candidates.room[index];
                ScreenedCoordinate {
                    name,
                    unit,
                    off,
                    here,
                    range: (off + down, off + up),
                    change: scale * change[k],
                    se: scale * covariance[(k, k)].max(sandwich[(k, k)]).sqrt(),
                    detection_limit: scale
                        * detectable(freedom)
                        * (shared[k] / score.information[(k, k)]).sqrt(),
                }
            })
            .collect();
        if share == 0.0 {
            return (found, no_test);
        }
        (found, FlipTest::new(&parts, &score.information))
    }

    /// How many times as much as the pushes' the parts of clusters scatter, 1 or more, for each coordinate: what
    /// the pushes of a session share hides effects.
    fn shared(&self, score: &Score, clusters: &[Products]) -> DVector<f64> {
        let scatter = |all: &[Products]| {
            let n = all.len() as f64;
            let mean = &score.score / n;
            let square = |part: DVector<f64>| (part - &mean).map(|off| off * off);
            let sum: DVector<f64> = all.iter().map(|one| square(score.part(one))).sum();
            sum * (n / (n - 1.0).max(1.0))
        };
        match self.observations.cluster {
            Cluster::Push => DVector::from_element(score.tested.len(), 1.0),
            Cluster::Session => {
                scatter(clusters).zip_map(&scatter(&self.of_push), |of_clusters, of_pushes| {
                    if of_pushes > 0.0 { (of_clusters / of_pushes).max(1.0) } else { 1.0 }
                })
            }
        }
    }

    /// The share of a change that the parameters' ranges allow.
    fn share(&self, score: &Score, change: &DVector<f64>) -> f64 {
        let of = |(index, change): (&usize, &f64)| {
            let change = self.scale[*index] * change;
            let room = self.candidates.room[*index][usize::from(change > 0.0)];
            if change == 0.0 { 1.0 } else { (room / change).clamp(0.0, 1.0) }
        };
        score.tested.iter().zip(change.iter()).map(of).fold(1.0, f64::min)
    }

    /// Whitened RMS of each number with the nuisances fitted, and the nuisances.
    fn without_effects(&self) -> ([Option<f64>; 7], [Option<f64>; 7], Vec<Nuisance>) {
        let Some(score) = self.score(Vec::new()) else { return ([None; 7], [None; 7], Vec::new()) };
        let (mut squares, mut counts, mut products) = ([0.0; 7], [0_usize; 7], [0.0; 7]);
        for (push, (residual, slopes)) in self.pushes.iter().enumerate() {
            let mut left = residual.clone();
            for (nuisance, change) in self.nuisances.iter().zip(score.estimate.iter()) {
                left.axpy(-change, &slopes.column(*nuisance), 1.0);
            }
            let mut before = [0.0; 7];
            for ((_, number), left) in self.whitening.entries(push).iter().zip(left.iter()) {
                squares[*number] += left * left;
                products[*number] += left * before[*number];
                counts[*number] += 1;
                before[*number] = *left;
            }
        }
        let rms = |k: usize| (counts[k] > 0).then(|| (squares[k] / counts[k] as f64).sqrt());
        let owner = |index: usize| {
            let effects = &self.candidates.effects;
            effects.iter().find(|candidate| candidate.coordinates.contains(&index))
        };
        let nuisance = |(index, change): (&usize, &f64)| {
            let (name, unit) = self.candidates.names[*index];
            let scale = self.scale[*index];
            let tolerance = (!self.is_free[*index]).then_some(scale);
            let effect = owner(*index)?.effect.info().id;
            Some(Nuisance { effect, name, unit, tolerance, change: scale * change })
        };
        let nuisances = self.nuisances.iter().zip(score.estimate.iter()).filter_map(nuisance);
        let correlation = |k: usize| (squares[k] > 0.0).then(|| products[k] / squares[k]);
        (std::array::from_fn(rms), std::array::from_fn(correlation), nuisances.collect())
    }

    fn look_alikes(&self, effects: &[ScreenedEffect]) -> Vec<LookAlikes> {
        let is_tested = |candidate: &&Candidate| {
            let id = candidate.effect.info().id;
            effects.iter().any(|effect| effect.id == id && effect.not_testable.is_none())
        };
        let tested: Vec<&Candidate> = self.candidates.effects.iter().filter(is_tested).collect();
        let mut found = Vec::new();
        for (index, one) in tested.iter().enumerate() {
            for other in &tested[index + 1..] {
                let groups: [Vec<usize>; 2] =
                    [one, other].map(|candidate| candidate.coordinates.clone().collect());
                let correlation =
                    likeness(&self.all, (&groups[0], &groups[1]), &self.nuisances, &self.is_free);
                if let Some(correlation) = correlation.filter(|c| *c >= self.settings.alike) {
                    let (one, other) = (one.effect.info().id, other.effect.info().id);
                    found.push(LookAlikes { one, other, correlation });
                }
            }
        }
        found.sort_by(|a, b| b.correlation.total_cmp(&a.correlation));
        found
    }
}

impl Calibration {
    fn of(cluster: Cluster, n_clusters: usize, n_flips: usize, n_tests: usize) -> Self {
        let smallest_p = (2.0 / (1 + n_flips) as f64).max(of_all_flips(n_clusters)).min(1.0);
        let needed = (1..).find(|n| of_all_flips(*n) <= NAME).unwrap_or(n_clusters);
        let clusters_missing = needed.saturating_sub(n_clusters);
        Self { cluster, n_clusters, n_flips, n_tests, smallest_p, clusters_missing }
    }
}

/// What all flips of so many clusters give an effect that every cluster shows, and that explains more than
/// the others do after any flip.
///
/// A flip and its opposite are one, and the probability is twice the smaller one of two: 2 · 2^(1−n).
fn of_all_flips(n_clusters: usize) -> f64 {
    0.5_f64.powi(n_clusters as i32 - 2)
}

#[cfg(test)]
mod tests {
    use models::Cluster;
    use nalgebra::{DMatrix, DVector};

    use crate::screen::screen_at;
    use crate::statistics::sign_flips::{FlipTest, Flips};
    use crate::synthetic::{SessionErrors, recorded, white};
    use crate::{Calibration, ScreenSettings};

    /// The adjusted probability of an effect that every cluster shows alike, beside others each of
    /// which is as sure, and explains half as much, after another flip: by all flips.
    fn by_all_flips(n_clusters: usize, n_tests: usize) -> f64 {
        let sign = |test: usize, k: usize| match test {
            0 => 1.0,
            test if test >> k & 1 == 1 => -0.5_f64.sqrt(),
            _ => 0.5_f64.sqrt(),
        };
        let part = |test: usize, cluster: usize| DVector::from_element(1, sign(test, cluster));
        let test = |test: usize| {
            let parts: Vec<DVector<f64>> = (0..n_clusters).map(|k| part(test, k)).collect();
            FlipTest::new(&parts, &DMatrix::identity(1, 1))
        };
        let tests: Vec<FlipTest> = (0..n_tests).map(test).collect();
        let flips = Flips::new(n_clusters, usize::MAX, 1);
        flips.probabilities(&tests)[0].p_adjusted
    }

    #[test]
    fn clusters_that_are_missing_are_those_that_all_flips_need() {
        const NEEDED: usize = 9;
        for n_tests in [3, 23, 26] {
            let told = |n: usize| Calibration::of(Cluster::Push, n, usize::MAX - 1, n_tests);
            assert_eq!(told(4).clusters_missing, NEEDED - 4, "{n_tests}");
            for n in [NEEDED - 1, NEEDED] {
                let (told, found) = (told(n), by_all_flips(n, n_tests));
                assert!((told.smallest_p / found - 1.0).abs() < 1e-9, "{told:?} {found}");
                assert_eq!(found <= 0.01, told.clusters_missing == 0, "{told:?} {found}");
            }
        }
    }

    /// The detectable change of a friction with the table, and of a shift of the contact, where the former differs
    /// from session to session by so much.
    fn limits(sd: f64) -> [f64; 2] {
        let sessions = SessionErrors::of(recorded(12), &[("support-friction", sd)]);
        let observed = sessions.observed(1, 0.0);
        assert_eq!(observed.cluster, Cluster::Session);
        let white = white(&observed);
        let screen = screen_at(&sessions.tangent, &observed, &white, &ScreenSettings::default());
        ["support-friction", "contact-bias"].map(|id| {
            let found = screen.effects.iter().find(|one| one.id == id).unwrap();
            found.coordinates[0].detection_limit
        })
    }

    #[test]
    fn what_differs_from_session_to_session_has_to_be_larger_to_be_found() {
        let ([friction, shift], [of_friction, of_shift]) = (limits(0.0), limits(0.02));
        assert!(of_friction > 2.0 * friction, "{friction} {of_friction}");
        assert!(of_shift < 1.5 * shift && shift < 1.5 * of_shift, "{shift} {of_shift}");
    }

    #[test]
    fn few_flips_leave_a_probability_however_many_clusters_there_are() {
        let told = Calibration::of(Cluster::Push, 60, 999, 23);
        assert_eq!((told.smallest_p, told.clusters_missing), (0.002, 0));
    }
}
