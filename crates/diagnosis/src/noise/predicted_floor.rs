//! The floor that sources of error predict where pushes were not repeated.

use std::sync::Arc;

use effects::{Channels, Effect};
use models::{Base, Description};

use crate::data::observations::Place;
use crate::predict::error_shapes::ErrorShapes;
use crate::predict::tangent::Tangent;
use crate::statistics::quantile::NORMAL_975;
use crate::{
    DiagnosisError, Floor, FloorSource, NoiseFloor, NoiseModel, Observations, Predictions,
    RepeatTolerance, noise_floor,
};

/// Repeats at so many places stand for all.
const MANY_CELLS: usize = 12;

impl NoiseFloor {
    /// The noise floor of observations about a model; `own` are effects besides those of the catalogue.
    ///
    /// By repeats it hardly depends on the model; by neighbours it is the lower, the less the model
    /// misses between them.
    ///
    /// # Errors
    /// `Model` for what the model refuses.
    pub fn about(
        model: &Description,
        own: &[Arc<dyn Effect>],
        observations: &Observations,
    ) -> Result<Self, DiagnosisError> {
        let predictions = Predictions::expected(model, own, observations)?;
        noise_floor(observations, &predictions, &RepeatTolerance::default())?.for_all_places(
            model,
            own,
            observations,
        )
    }

    /// The same about an analytical model that is linearised by every effect.
    ///
    /// # Errors
    /// `Model` if the catalogue refuses the model's values.
    pub(crate) fn at(
        tangent: &Tangent,
        model: &Description,
        own: &[Arc<dyn Effect>],
        observations: &Observations,
    ) -> Result<Self, DiagnosisError> {
        let predictions = Predictions::of_channels(&tangent.linearisation.predicted);
        let floor = noise_floor(observations, &predictions, &RepeatTolerance::default())?;
        floor.widened_by(observations, || predicted(&tangent.of_tested(own), model, observations))
    }

    /// The same floor, where repeats at few places set it, with that of numbers by which the sources
    /// of error, learnt from these repeats, let all steps scatter by clearly more.
    ///
    /// A push that sticks repeats well whatever the tip's friction; what its repeats tell of the
    /// center of pressure scatters others far more. No floor stays clearly below what the sensors alone
    /// make. Nothing changes for a learnt model, whose sources of error are not known.
    ///
    /// # Errors
    /// `Model` for what the model refuses.
    pub fn for_all_places(
        self,
        model: &Description,
        own: &[Arc<dyn Effect>],
        observations: &Observations,
    ) -> Result<Self, DiagnosisError> {
        self.widened_by(observations, || match model.base {
            Base::Analytical(_) => {
                predicted(&Tangent::of(model, own, observations)?, model, observations)
            }
            _ => Ok([None; 7]),
        })
    }

    /// With the floor that sources of error predict, where repeats at few places set it.
    fn widened_by(
        mut self,
        observations: &Observations,
        predicted: impl FnOnce() -> Result<[Option<Floor>; 7], DiagnosisError>,
    ) -> Result<Self, DiagnosisError> {
        if self.source == FloorSource::Repeats && self.n_cells < MANY_CELLS {
            for (k, floor) in predicted()?.into_iter().enumerate() {
                let is_wider = |(of_few, all): (Floor, Floor)| all.low95 > of_few.high95;
                if self.numbers[k].zip(floor).is_some_and(is_wider) {
                    self.numbers[k] = floor;
                    self.widened.push(Channels::NAMES[k]);
                }
            }
        }
        for (k, floor) in self.numbers.iter_mut().enumerate() {
            *floor = floor.map(|floor| floor.at_least(sensors(observations, k)));
        }
        Ok(self)
    }
}

impl Floor {
    /// The same floor where it is not clearly below that.
    fn at_least(self, rms: f64) -> Self {
        if self.high95 >= rms {
            return self;
        }
        let constant = (self.constant.powi(2) + rms.powi(2) - self.rms.powi(2)).sqrt();
        Self { rms, low95: rms, high95: rms, constant, ..self }
    }
}

/// What the sources of error make of each number, over all steps.
///
/// The interval holds the sources' own, as if they were independent.
fn predicted(
    tangent: &Tangent,
    model: &Description,
    observations: &Observations,
) -> Result<[Option<Floor>; 7], DiagnosisError> {
    let usual = NoiseModel::usual_beside(model)?;
    let noise = NoiseModel::learn_at(tangent, observations, None, &usual)?;
    if noise.source != FloorSource::Repeats {
        return Ok([None; 7]);
    }
    let mut n = [0_usize; 7];
    let mut sums = vec![[0.0; 7]; noise.sources.len()];
    for numbers in observations.all_numbers() {
        let shapes = ErrorShapes::of(observations, &tangent.linearisation, numbers);
        shapes.numbers.iter().for_each(|(_, number)| n[*number] += 1);
        for (sums, root) in sums.iter_mut().zip(&shapes.roots) {
            for ((_, number), square) in shapes.numbers.iter().zip(root.squares()) {
                sums[*number] += square;
            }
        }
    }
    let floor = |k: usize| {
        let sources = noise.sources.iter().zip(&sums);
        let parts = sources.map(|(source, sums)| {
            let variance = source.sd.powi(2) * sums[k] / n[k].max(1) as f64;
            let log_se = if source.sd > 0.0 {
                2.0 * (source.high95 / source.sd).ln() / NORMAL_975
            } else {
                0.0
            };
            (variance, variance * log_se)
        });
        let (variance, square) =
            parts.fold((0.0, 0.0), |(sum, square), (part, se)| (sum + part, square + se * se));
        let (rms, log_se) = (variance.sqrt(), 0.5 * square.sqrt() / variance);
        let ratio = (NORMAL_975 * log_se).exp();
        let floor =
            Floor { rms, low95: rms / ratio, high95: rms * ratio, constant: rms, per_meter: 0.0 };
        (n[k] > 0 && variance > 0.0).then_some(floor)
    };
    Ok(std::array::from_fn(floor))
}

/// What the sensors alone make of a number of a step, from the samples about its ends; 0 where that is
/// not known.
fn sensors(observations: &Observations, number: usize) -> f64 {
    let sd = |place: &Place| match number {
        0 | 1 => place.pose_sd[0][0].hypot(place.pose_sd[1][0]),
        2 => place.pose_sd[0][1].hypot(place.pose_sd[1][1]),
        _ => 0.0,
    };
    let places = observations.places.iter();
    (places.map(|place| sd(place).powi(2)).sum::<f64>() / observations.n_steps() as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use crate::data::repeats::cells;
    use crate::synthetic::{NOISE, SessionErrors, repeated};
    use crate::{Floor, NoiseFloor, Observations, Predictions, RepeatTolerance, noise_floor};

    const OFFSET: &str = "friction-center-offset";
    const OFFSET_SD: f64 = 3e-3;
    /// Δθ.
    const TURN: usize = 2;

    /// Every push once, and one that a wandering center turns less several times.
    fn repeated_where_it_shows_less() -> SessionErrors {
        let (all, model) = repeated(1, 8);
        let made = SessionErrors::of((all, model), &[(OFFSET, OFFSET_SD)]);
        let all = &made.observations;
        let calm = (0..all.pushes().len()).min_by(|a, b| {
            let half = 0.4 * rms(&made, all, |_| true);
            let turn =
                |push: usize| (rms(&made, all, |step| all.push_of[step] == push) - half).abs();
            turn(*a).total_cmp(&turn(*b))
        });
        let first = calm.unwrap();
        let calm = all.pushes()[first].recording.clone();
        let kind = calm.rsplit_once('-').unwrap().0;
        let cells = cells(all, &RepeatTolerance::default());
        let is_kept = |push: &usize| {
            let own = all.pushes()[*push].recording.rsplit_once('-').unwrap().0;
            own == kind || cells[*push] == *push && cells[*push] != cells[first]
        };
        let names: Vec<String> =
            (0..cells.len()).filter(is_kept).map(|push| all.pushes()[push].to_string()).collect();
        let mut part = all.part(&names).unwrap();
        // Each push has an error of its own.
        for (step, push) in part.steps.iter_mut().zip(&part.push_of) {
            step.input.session = *push as u32;
        }
        SessionErrors::of((part, made.model), &[(OFFSET, OFFSET_SD)])
    }

    /// What the wandering center and the noise make of Δθ, over some steps.
    fn rms(made: &SessionErrors, all: &Observations, is_in: impl Fn(usize) -> bool) -> f64 {
        let effects = &made.tangent.candidates.effects;
        let offset = effects.iter().find(|one| one.effect.info().id == OFFSET).unwrap();
        let steps: Vec<usize> = (0..all.n_steps()).filter(|step| is_in(*step)).collect();
        let square = |step: &usize| {
            let slopes = offset.coordinates.clone().map(|k| made.tangent.slopes(k)[*step][TURN]);
            slopes.map(|slope| (OFFSET_SD * slope).powi(2)).sum::<f64>() + NOISE[TURN].powi(2)
        };
        (steps.iter().map(square).sum::<f64>() / steps.len() as f64).sqrt()
    }

    fn floors(made: &SessionErrors, observed: &Observations) -> [NoiseFloor; 2] {
        let predictions = Predictions::of(&made.model, &[], observed).unwrap();
        let few = noise_floor(observed, &predictions, &RepeatTolerance::default()).unwrap();
        [few.clone(), few.for_all_places(&made.model, &[], observed).unwrap()]
    }

    #[test]
    fn repeats_where_an_error_shows_less_do_not_set_the_floor_elsewhere() {
        let made = repeated_where_it_shows_less();
        let observed = made.observed(3, 0.0);
        let truth = rms(&made, &observed, |_| true);
        let [few, all] = floors(&made, &observed).map(|floor| floor.numbers[TURN].unwrap().rms);
        assert!(few < truth / 1.5, "{few} {all} {truth}");
        assert!((1.0 / 1.4..1.4).contains(&(all / truth)), "{few} {all} {truth}");
    }

    #[test]
    fn sensors_bound_a_floor_from_below() {
        let made = repeated_where_it_shows_less();
        let mut observed = made.observed(3, 0.0);
        observed.places.iter_mut().for_each(|place| place.pose_sd = [[1e-3, 0.1]; 2]);
        let [_, all] = floors(&made, &observed);
        for (number, sensors) in [(0, 1e-3), (1, 1e-3), (TURN, 0.1)] {
            let Floor { rms, .. } = all.numbers[number].unwrap();
            assert!(rms >= 0.99 * sensors * 2.0_f64.sqrt(), "{number}: {rms}");
        }
    }
}
