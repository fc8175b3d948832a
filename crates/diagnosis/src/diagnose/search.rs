//! Adding the best effect, as long as one obeys every rule.

use effects::Channels;
use models::Description;

use super::DiagnoseSettings;
use super::rules::{Objection, Rules};
use crate::{
    DiagnosisError, EffectFit, Fit, FitSettings, NoiseModel, Observations, Predictions, Screen,
    Whitening, fit, screen,
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
    /// The model asked about: its nuisances fitted, but for those that are claimed to be wrong.
    pub(super) base: Description,
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
#[derive(Clone)]
pub(super) struct Accepted {
    pub(super) id: &'static str,
    pub(super) p_adjusted: f64,
    /// Effects that explain as much.
    pub(super) rivals: Vec<&'static str>,
    /// The effect as fitted beside those before it.
    pub(super) effect: EffectFit,
    /// The model with it, and those before.
    pub(super) description: Description,
    /// The same with the nuisances, for predictions.
    pub(super) with_nuisances: Description,
}

/// An effect that passed the screen and was not added.
pub(super) struct Refused {
    pub(super) id: &'static str,
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
    /// The model with the first `n` accepted effects and the nuisances, for predictions.
    pub(super) fn predictor(&self, n: usize) -> &Description {
        match n {
            0 => &self.base,
            _ => &self.accepted[n - 1].with_nuisances,
        }
    }
}

impl Search<'_> {
    pub(super) fn run(&self) -> Result<Found, DiagnosisError> {
        let own = &self.settings.own;
        let mut whitening = self.noise.whitening(self.model, own, self.fitted)?;
        let mut here = self.fit(&[], &whitening, false)?;
        let first_screen = self.screen(&here.description)?;
        let mut found = Found {
            base: here.with_nuisances.clone(),
            last_screen: first_screen.clone(),
            first_screen,
            accepted: Vec::new(),
            refused: Vec::new(),
        };
        while found.accepted.len() < self.settings.most_effects {
            let known: Vec<&'static str> = found.accepted.iter().map(|one| one.id).collect();
            whitening = self.noise.whitening(&here.with_nuisances, own, self.fitted)?;
            here = self.fit(&known, &whitening, false)?;
            let (best, refused) = self.next(&here, &known, &found.last_screen, &whitening)?;
            found.refused.extend(refused);
            let Some((accepted, fit)) = best else { break };
            found.refused.retain(|one| one.id != accepted.id);
            found.last_screen = self.screen(&fit.description)?;
            found.accepted.push(accepted);
            here = fit;
        }
        self.add_nominal(&mut found, &here, &whitening)?;
        Ok(found)
    }

    /// The best effect beside those known that obeys every rule, and those that did not.
    fn next(
        &self,
        here: &Fit,
        known: &[&'static str],
        screen: &Screen,
        whitening: &Whitening,
    ) -> Result<(Option<(Accepted, Fit)>, Vec<Refused>), DiagnosisError> {
        let mut attempts = self.attempts(known, screen, whitening)?;
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
            let Attempt { id, p_adjusted, .. } = *attempt;
            let gain = misfit(here, whitening) - misfit(&attempt.fit, whitening);
            let size = self.size(&here.with_nuisances, &attempt.fit.with_nuisances)?;
            let mut objection = rules.objection(p_adjusted, gain, size);
            if objection.is_none() {
                let ids: Vec<&str> = known.iter().copied().chain([id]).collect();
                let whole = self.fit(&ids, whitening, true)?;
                objection = rules.objection_to(&whole, id, &self.settings.screen.tolerances);
                if objection.is_none()
                    && let Some(accepted) = Accepted::of(&whole, id, p_adjusted)
                {
                    let rivals = rivals(&attempts, index, whitening);
                    return Ok((Some((Accepted { rivals, ..accepted }, whole)), refused));
                }
            }
            refused.extend(objection.map(|objection| Refused { id, objection }));
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
    pub(super) fn size(
        &self,
        one: &Description,
        other: &Description,
    ) -> Result<f64, DiagnosisError> {
        let own = &self.settings.own;
        let predict = |model: &Description| Predictions::of(model, own, self.fitted);
        let (one, other) = (predict(one)?, predict(other)?);
        let sd = self.noise.whitening(self.model, own, self.fitted)?.sd();
        let of_number = |number: usize| {
            let own = sd.iter().filter(|(_, other, _)| *other == number);
            let squares: Vec<f64> = own
                .filter_map(|(step, number, sd)| {
                    let difference = one.values[*step][*number]? - other.values[*step][*number]?;
                    Some((difference / sd).powi(2))
                })
                .collect();
            (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
        };
        Ok((0..Channels::NAMES.len()).map(of_number).fold(0.0, f64::max))
    }

    pub(super) fn fit(
        &self,
        ids: &[&str],
        whitening: &Whitening,
        intervals: bool,
    ) -> Result<Fit, DiagnosisError> {
        let (own, tolerances) = (self.settings.own.clone(), self.settings.screen.tolerances);
        let settings = FitSettings { own, tolerances, priors: true, intervals };
        fit(self.fitted, self.model, ids, whitening, &settings)
    }

    fn screen(&self, model: &Description) -> Result<Screen, DiagnosisError> {
        screen(model, &self.settings.own, self.fitted, self.noise, &self.settings.screen)
    }
}

impl Accepted {
    /// An effect of a fit, without rivals.
    pub(super) fn of(fit: &Fit, id: &'static str, p_adjusted: f64) -> Option<Self> {
        let effect = fit.effects.iter().find(|effect| effect.id == id)?.clone();
        let (description, with_nuisances) = (fit.description.clone(), fit.with_nuisances.clone());
        Some(Self { id, p_adjusted, rivals: Vec::new(), effect, description, with_nuisances })
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
