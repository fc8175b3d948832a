//! Adding the best effect, as long as one obeys every rule.

use effects::Channels;
use models::Description;

use super::DiagnoseSettings;
use super::rules::{Objection, Rules};
use crate::{
    DiagnosisError, Fit, FitSettings, NoiseModel, Observations, Predictions, Screen, Whitening, fit,
    screen,
};

/// The search on the pushes to fit to.
pub(super) struct Search<'a> {
    pub(super) model: &'a Description,
    pub(super) fitted: &'a Observations,
    pub(super) noise: &'a NoiseModel,
    pub(super) settings: &'a DiagnoseSettings,
}

/// What a search found.
pub(super) struct Found {
    /// The model asked about, its nuisances fitted.
    pub(super) base: Fit,
    /// The screen of the model asked about.
    pub(super) first_screen: Screen,
    /// The screen of the last model.
    pub(super) last_screen: Screen,
    /// Effects in the order of adding.
    pub(super) accepted: Vec<Accepted>,
    /// Effects that passed the screen, and what speaks against them.
    pub(super) refused: Vec<Refused>,
}

/// An effect that was added.
pub(super) struct Accepted {
    pub(super) id: &'static str,
    pub(super) p_adjusted: f64,
    /// Effects that explain as much.
    pub(super) rivals: Vec<&'static str>,
    /// The model with it, and those before.
    pub(super) fit: Fit,
}

/// An effect that passed the screen and was not added.
pub(super) struct Refused {
    pub(super) id: &'static str,
    pub(super) p_adjusted: f64,
    pub(super) objection: Objection,
}

/// An effect fitted beside those that were added before.
struct Attempt {
    id: &'static str,
    p_adjusted: f64,
    freedom: usize,
    fit: Fit,
}

/// Effects that are refitted after a screen.
const MOST_REFITS: usize = 6;
/// An effect whose score is a smaller share of the largest is not refitted.
const LEAST_SHARE: f64 = 0.05;

impl Found {
    /// The model with the first `n` accepted effects.
    pub(super) fn fit_with(&self, n: usize) -> &Fit {
        match n {
            0 => &self.base,
            _ => &self.accepted[n - 1].fit,
        }
    }

    pub(super) fn model_with(&self, n: usize) -> &Description {
        &self.fit_with(n).description
    }
}

impl Search<'_> {
    pub(super) fn run(&self) -> Result<Found, DiagnosisError> {
        let own = &self.settings.own;
        let mut whitening = self.noise.whitening(self.model, own, self.fitted)?;
        let base = self.fit(&[], &whitening, false)?;
        let first_screen = self.screen(&base.description)?;
        let mut found = Found {
            base,
            last_screen: first_screen.clone(),
            first_screen,
            accepted: Vec::new(),
            refused: Vec::new(),
        };
        while found.accepted.len() < self.settings.most_effects {
            let known: Vec<&'static str> = found.accepted.iter().map(|one| one.id).collect();
            let here = found.fit_with(known.len());
            whitening = self.noise.whitening(&here.with_nuisances, own, self.fitted)?;
            let here = self.fit(&known, &whitening, false)?;
            let (accepted, refused) = self.next(&here, &known, &found, &whitening)?;
            found.refused.extend(refused);
            let Some(accepted) = accepted else { break };
            found.refused.retain(|one| one.id != accepted.id);
            found.last_screen = self.screen(&accepted.fit.description)?;
            found.accepted.push(accepted);
        }
        Ok(found)
    }

    /// The best effect beside those known that obeys every rule, and those that did not.
    fn next(
        &self,
        here: &Fit,
        known: &[&'static str],
        found: &Found,
        whitening: &Whitening,
    ) -> Result<(Option<Accepted>, Vec<Refused>), DiagnosisError> {
        let mut attempts = self.attempts(known, &found.last_screen, whitening)?;
        let cost =
            |attempt: &Attempt| misfit(&attempt.fit, whitening) + 2.0 * attempt.freedom as f64;
        attempts.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
        let base = match known {
            [] => misfit(here, whitening),
            _ => misfit(&self.fit(&[], whitening, false)?, whitening),
        };
        let gain_so_far = base - misfit(here, whitening);
        let rules = Rules { gain_so_far, is_first: known.is_empty() };
        let mut refused = Vec::new();
        for (index, attempt) in attempts.iter().enumerate() {
            let gain = misfit(here, whitening) - misfit(&attempt.fit, whitening);
            let size = self.size(here, &attempt.fit)?;
            let ids: Vec<&str> = known.iter().copied().chain([attempt.id]).collect();
            let Attempt { id, p_adjusted, .. } = *attempt;
            let objection = match rules.objection(p_adjusted, gain, size) {
                Some(objection) => Some(objection),
                None => {
                    let whole = self.fit(&ids, whitening, true)?;
                    match rules.objection_to(&whole, id, &self.settings.nuisances) {
                        Some(objection) => Some(objection),
                        None => {
                            let rivals = rivals(&attempts, index, whitening);
                            let accepted = Accepted { id, p_adjusted, rivals, fit: whole };
                            return Ok((Some(accepted), refused));
                        }
                    }
                }
            };
            refused.extend(objection.map(|objection| Refused { id, p_adjusted, objection }));
        }
        Ok((None, refused))
    }

    /// The best effects of a screen, each fitted beside those known.
    fn attempts(
        &self,
        known: &[&'static str],
        screen: &Screen,
        whitening: &Whitening,
    ) -> Result<Vec<Attempt>, DiagnosisError> {
        let largest = screen.effects.iter().map(|effect| effect.statistic).fold(0.0, f64::max);
        let is_worth = |effect: &&crate::ScreenedEffect| {
            effect.not_testable.is_none()
                && effect.p_adjusted <= Rules::HINT
                && effect.statistic >= LEAST_SHARE * largest
        };
        let mut attempts = Vec::new();
        for effect in screen.effects.iter().filter(is_worth).take(MOST_REFITS) {
            let ids: Vec<&str> = known.iter().copied().chain([effect.id]).collect();
            // An effect whose refit does not settle is no explanation.
            if let Ok(fit) = self.fit(&ids, whitening, false) {
                let (id, p_adjusted, freedom) = (effect.id, effect.p_adjusted, effect.freedom);
                attempts.push(Attempt { id, p_adjusted, freedom, fit });
            }
        }
        Ok(attempts)
    }

    /// The largest root mean square difference that two models' predictions have in one number of a
    /// step, over the standard deviation of its noise.
    fn size(&self, one: &Fit, other: &Fit) -> Result<f64, DiagnosisError> {
        let own = &self.settings.own;
        let predict = |fit: &Fit| Predictions::of(&fit.with_nuisances, own, self.fitted);
        let (one, other) = (predict(one)?, predict(other)?);
        let sd = self.noise.whitening(self.model, own, self.fitted)?.sd();
        let of_number = |number: usize| {
            let mut squares = (0.0, 0);
            for (step, number, sd) in sd.iter().filter(|(_, other, _)| *other == number) {
                let values = [&one, &other].map(|p| p.values[*step][*number]);
                if let [Some(a), Some(b)] = values {
                    squares = (squares.0 + ((a - b) / sd).powi(2), squares.1 + 1);
                }
            }
            (squares.0 / f64::from(squares.1.max(1))).sqrt()
        };
        Ok((0..Channels::NAMES.len()).map(of_number).fold(0.0, f64::max))
    }

    fn fit(
        &self,
        ids: &[&str],
        whitening: &Whitening,
        intervals: bool,
    ) -> Result<Fit, DiagnosisError> {
        let DiagnoseSettings { own, nuisances, .. } = self.settings;
        let (own, nuisances) = (own.clone(), nuisances.clone());
        let settings = FitSettings { own, nuisances, priors: true, intervals };
        fit(self.fitted, self.model, ids, whitening, &settings)
    }

    fn screen(&self, model: &Description) -> Result<Screen, DiagnosisError> {
        screen(model, &self.settings.own, self.fitted, self.noise, &self.settings.screen)
    }
}

/// Sum of squares of the whitened residuals.
fn misfit(fit: &Fit, whitening: &Whitening) -> f64 {
    fit.whitened_rms[1].powi(2) * whitening.n_numbers() as f64
}

/// Effects that explain nearly as much as one of the attempts.
fn rivals(attempts: &[Attempt], best: usize, whitening: &Whitening) -> Vec<&'static str> {
    let scale = attempts[best].fit.whitened_rms[1].max(1.0).powi(2);
    let least = misfit(&attempts[best].fit, whitening);
    let others = attempts.iter().enumerate().filter(|(index, _)| *index != best);
    let near =
        others.filter(|(_, other)| misfit(&other.fit, whitening) - least < Rules::APART * scale);
    near.map(|(_, other)| other.id).collect()
}
