//! What a screen of effects found.

use models::Cluster;
use serde::Serialize;

use crate::cut_offs::NAME;
use crate::statistics::score::detectable;
use crate::{NotTestable, Tolerances};

/// What a screen of effects found, the likeliest effect first.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Screen {
    /// Pushes of the set; a larger set than is needed is thinned.
    pub n_pushes_in_all: usize,
    /// Pushes used.
    pub n_pushes: usize,
    /// Steps used.
    pub n_steps: usize,
    /// Numbers used.
    pub n_numbers: usize,
    /// Root mean square of the whitened residual of each number of a step, nuisances fitted: 1
    /// where noise is all; none for what is not observed, or follows from other numbers as the gap that ends a step does.
    pub whitened_rms: [Option<f64>; 7],
    /// Correlation of the same in consecutive steps of a push: 0 where the noise model is true.
    pub step_correlation: [Option<f64>; 7],
    /// How probabilities were found.
    pub calibration: Calibration,
    /// The nuisances as they would be fitted if nothing else were there.
    pub nuisances: Vec<Nuisance>,
    /// Every effect that the model does not have.
    pub effects: Vec<ScreenedEffect>,
    /// Pairs of effects that these data hardly tell apart, the most alike first.
    pub look_alikes: Vec<LookAlikes>,
}

impl Screen {
    /// The adjusted probability of an effect; 1 of one that the screen does not know.
    pub(crate) fn p_of(&self, id: &str) -> f64 {
        self.effects.iter().find(|effect| effect.id == id).map_or(1.0, |effect| effect.p_adjusted)
    }
}

/// How probabilities were found: by flipping the signs of whole clusters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Calibration {
    /// What flips as a whole.
    pub cluster: Cluster,
    /// How many there are.
    pub n_clusters: usize,
    /// Flips used.
    pub n_flips: usize,
    /// Effects that are tested together.
    pub n_tests: usize,
    /// The adjusted probability of an effect that every cluster shows, and that explains more than the
    /// others do after any flip of signs.
    pub smallest_p: f64,
    /// Clusters that are missing for that to be 0.01.
    pub clusters_missing: usize,
}

/// A nominal value that every test takes as uncertain.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Nuisance {
    /// Id of its effect.
    pub effect: &'static str,
    /// Its coordinate.
    pub name: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// Standard error beforehand; none where nothing is known.
    pub tolerance: Option<f64>,
    /// One-step estimate of its change.
    pub change: f64,
}

/// The test of one effect.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScreenedEffect {
    /// Its id.
    pub id: &'static str,
    /// Why these data cannot show it, where that is so.
    pub not_testable: Option<NotTestable>,
    /// Twice the gain in log likelihood that one step would expect: the score statistic
    /// T = Uᵀ I⁻¹ U, less where the step would leave the parameters' range.
    pub statistic: f64,
    /// Degrees of freedom of T.
    pub freedom: usize,
    /// Probability of so large a statistic, were every cluster as likely of the other sign.
    pub p: f64,
    /// The same of any effect at least as surprising.
    pub p_adjusted: f64,
    /// Its coordinates.
    pub coordinates: Vec<ScreenedCoordinate>,
}

impl ScreenedEffect {
    /// Decides by its own test of what these pushes would hardly show at three times its usual size: it is testable
    /// if it is seen for all that, and untested otherwise.
    ///
    /// What is far larger than usual passes for noise where noise is told by how pushes differ, and hides itself.
    pub(crate) fn settle(&mut self) {
        if self.not_testable.is_none() {
            return;
        }
        if self.p_adjusted <= NAME && self.statistic >= detectable(self.freedom).powi(2) {
            self.not_testable = None;
        } else {
            (self.statistic, self.p, self.p_adjusted) = (0.0, 1.0, 1.0);
            self.coordinates.clear();
        }
    }
}

/// A coordinate of an effect: a parameter, or for a ratio along a direction φ one of
/// (e cos 2φ, e sin 2φ) with e = ½ ln ratio.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ScreenedCoordinate {
    /// Name.
    pub name: &'static str,
    /// SI unit; `1` for numbers without one.
    pub unit: &'static str,
    /// Value where the effect is not there.
    pub off: f64,
    /// Value in the model.
    pub here: f64,
    /// Smallest and largest that may be.
    pub range: (f64, f64),
    /// Change from its value in the model, by one step of generalised least squares.
    pub change: f64,
    /// Standard error of the change: by the noise model, or by the scatter over the clusters where
    /// that is larger.
    pub se: f64,
    /// Size that is found with probability 0.9 at an adjusted p of 0.01, were it the only one of
    /// the effect's coordinates; larger where the pushes of a session share more than the noise knows of.
    pub detection_limit: f64,
}

/// Two effects that look alike in these data.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LookAlikes {
    /// One effect.
    pub one: &'static str,
    /// The other.
    pub other: &'static str,
    /// Largest correlation of what they do to the observed numbers, beyond the nuisances.
    pub correlation: f64,
}

/// How a screen is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScreenSettings {
    /// How exactly nominal values are known.
    pub tolerances: Tolerances,
    /// Random flips of signs: no p is adjusted to less than 2/(1 + n).
    pub n_flips: usize,
    /// Seed of the flips.
    pub seed: u64,
    /// Steps above which a part of the pushes is used, chosen evenly over edges and speeds.
    pub most_steps: usize,
    /// Correlation from which two effects count as look-alikes.
    pub alike: f64,
}

impl Default for ScreenSettings {
    fn default() -> Self {
        Self {
            tolerances: Tolerances::default(),
            n_flips: 9999,
            seed: 7,
            most_steps: 20_000,
            alike: 0.9,
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::synthetic::{in_more_noise, pushed_with};
    use crate::{DiagnoseSettings, Grade, diagnose};

    /// What is told of an effect of so many times some values, in so many times the noise.
    fn told((id, values): (&str, [f64; 2]), times: f64, noise: f64) -> (Grade, String) {
        let values: Vec<f64> = values.iter().map(|value| times * value).collect();
        let (observed, model, truth) = pushed_with((id, &values), 1);
        let observed = in_more_noise(observed, &truth, noise);
        let found = diagnose(&observed, &model, &DiagnoseSettings::default()).unwrap().diagnosis;
        let told = found.effects.into_iter().find(|one| one.id == id).unwrap();
        (told.grade, told.why)
    }

    #[test]
    fn what_these_pushes_hardly_show_at_its_usual_sizes_is_named_where_it_is_far_larger() {
        let tilt = ("table-tilt", [1.0, 0.6]);
        let (grade, why) = told(tilt, 0.0, 60.0);
        assert!(why.contains("three times its usual size it is still within the noise"), "{why}");
        assert_eq!(grade, Grade::NotTestable, "{why}");
        let (grade, why) = told(tilt, 1.0, 60.0);
        assert_eq!(grade, Grade::Identified, "{why}");
    }

    #[test]
    fn what_looks_like_a_number_that_is_not_known_well_at_its_usual_sizes_is_fitted_where_it_is_far_larger()
     {
        let (grade, why) = told(("friction-gradient", [5.0, -4.0]), 1.0, 20.0);
        assert!(
            grade == Grade::Hint && why.contains("up to an end of its range"),
            "{grade:?} {why}"
        );
    }
}
