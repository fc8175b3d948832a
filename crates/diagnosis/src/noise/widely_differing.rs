//! A model linearised over as much as pushes differ, where that is more than usual.

use std::sync::Arc;

use effects::Effect;
use models::Description;

use crate::predict::error_shapes::{Kind, SECANT_OF_OWN, SOURCES, push_directions, stated_sds};
use crate::predict::secants::{Direction, Linearisation};
use crate::{DiagnosisError, NoiseModel, Observations, Whitening};

/// Points beside the middle, in standard deviations, and the weight of each side's: a trapezoidal rule of the normal
/// density, with its variance. Many near ones, for a tip that holds on one side and slides on the other.
const NODES: [(f64, f64); 4] =
    [(0.75, 0.227660808), (1.5, 0.097915694), (2.25, 0.023995273), (3.0, 0.003350491)];

/// Where a model is linearised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum At {
    /// At a push in the middle of all.
    Middle,
    /// At what is expected of pushes that differ as the noise says.
    Expected,
}

/// What differs widely.
struct Wide {
    /// Its place among the slopes.
    slope: usize,
    direction: Direction,
    /// In the coordinate's unit.
    sd: f64,
}

impl NoiseModel {
    /// Moves a linearisation from the middle.
    ///
    /// # Errors
    /// `Model` for what the model refuses.
    pub(crate) fn put(
        &self,
        linearisation: &mut Linearisation,
        at: At,
        model: (&Description, &[Arc<dyn Effect>]),
        observations: &Observations,
    ) -> Result<(), DiagnosisError> {
        match at {
            At::Middle => Ok(()),
            At::Expected => self.widen(linearisation, model, observations),
        }
    }

    /// The mean and covariance of every push, about a model that is linearised somewhere.
    ///
    /// # Errors
    /// `Model` for what the model refuses.
    pub(crate) fn whitening_from(
        &self,
        at: At,
        model: &Description,
        own: &[Arc<dyn Effect>],
        observations: &Observations,
    ) -> Result<Whitening, DiagnosisError> {
        let directions = push_directions(model)?;
        let mut linearisation = Linearisation::of(model, own, observations, &directions)?;
        self.put(&mut linearisation, at, (model, own), observations)?;
        self.whitening_at(observations, &linearisation)
    }

    /// Puts in the place of a linearisation's predictions what is expected of pushes that differ as widely as
    /// this noise says, and in that of its slopes the straight line nearest to the model over all of them.
    ///
    /// A push of 0.8 times the pressure radius turns more by another angle than one of 1.2 times turns less. A
    /// model that is fitted as if that cancelled gets a wrong radius, and a turn that nothing explains.
    /// What a model states itself is in its predictions. Nothing changes where the mechanics refuse pushes that
    /// differ so much.
    ///
    /// # Errors
    /// `Model` if the catalogue refuses the model's values.
    ///
    /// # Source
    /// Gelb (1974), Applied optimal estimation: statistical linearization.
    fn widen(
        &self,
        linearisation: &mut Linearisation,
        (model, own): (&Description, &[Arc<dyn Effect>]),
        observations: &Observations,
    ) -> Result<(), DiagnosisError> {
        let mut wide = self.wide(model)?;
        // Beside a model at the end of a range nothing is known of what is beyond.
        wide.retain(|wide| linearisation.rooms[wide.slope] >= wide.sd);
        if wide.is_empty() {
            return Ok(());
        }
        let sized = |(reach, Wide { slope, direction, sd }): (f64, &Wide)| {
            let size = f64::min(reach * sd, linearisation.rooms[*slope]);
            Direction { size, ..direction.clone() }
        };
        let of_node = |(reach, _)| wide.iter().map(move |wide| sized((reach, wide)));
        let directions: Vec<Direction> = NODES.into_iter().flat_map(of_node).collect();
        let there = match Linearisation::of(model, own, observations, &directions) {
            // So much less friction may let an object slide by itself.
            Err(DiagnosisError::Model(_)) => return Ok(()),
            there => there?,
        };
        let mut shift = vec![[0.0; 7]; observations.n_steps()];
        for (k, Wide { slope, sd, .. }) in wide.iter().enumerate() {
            for (step, shift) in shift.iter_mut().enumerate() {
                for (number, shift) in shift.iter_mut().enumerate() {
                    let mut line = Line::default();
                    for (node, (reach, weight)) in NODES.into_iter().enumerate() {
                        let at = node * wide.len() + k;
                        let secant = there.slopes[at][step][number];
                        // The mean of both sides less the middle.
                        let mean = directions[at].size * there.bends[at][step][number];
                        line.add((reach, 2.0 * weight), secant, mean);
                    }
                    *shift += line.mean;
                    linearisation.predicted[step][number] += line.mean;
                    linearisation.slopes[*slope][step][number] = line.slope;
                    linearisation.bends[*slope][step][number] = line.bend() / sd;
                }
            }
        }
        linearisation.shift = Some(shift);
        Ok(())
    }

    /// Whether anything differs so widely beside a model that [`Self::widen`] has a say.
    ///
    /// # Errors
    /// `Model` if the catalogue refuses the model's values.
    pub(crate) fn is_wide_beside(&self, model: &Description) -> Result<bool, DiagnosisError> {
        Ok(!self.wide(model)?.is_empty())
    }

    /// What differs by more than the secants reach for what is usual, and is not in the model's predictions.
    fn wide(&self, model: &Description) -> Result<Vec<Wide>, DiagnosisError> {
        let sources = SOURCES.iter().zip(&self.sources).zip(stated_sds(model)?);
        let of_coordinates = sources.flat_map(|((source, own), stated)| {
            let Kind::Push { coordinates } = source.kind else { return Vec::new() };
            vec![if stated == 0.0 { own.sd } else { 0.0 }; coordinates.len()]
        });
        let directions = push_directions(model)?.into_iter().zip(of_coordinates).enumerate();
        let wide = directions.filter_map(|(slope, (direction, sd))| {
            (SECANT_OF_OWN * sd > direction.size).then_some(Wide { slope, direction, sd })
        });
        Ok(wide.collect())
    }
}

/// Values of a number over what differs, with their weights: how it is nearest to a straight line.
#[derive(Default)]
struct Line {
    slope: f64,
    /// Of what is alike on both sides, beside the middle's.
    mean: f64,
    square: f64,
}

impl Line {
    /// Two values of opposite sides: the secant between them, and their mean beside the middle's.
    fn add(&mut self, (reach, weight): (f64, f64), secant: f64, mean: f64) {
        self.slope += weight * reach * reach * secant;
        self.mean += weight * mean;
        self.square += weight * mean * mean;
    }

    /// Standard deviation of what is alike on both sides, with its sign.
    fn bend(&self) -> f64 {
        (self.square - self.mean * self.mean).max(0.0).sqrt().copysign(self.mean)
    }
}

#[cfg(test)]
mod tests {
    use effects::by_id;
    use models::{ChannelModel, Description, ModelEffect};

    use super::At;
    use crate::predict::error_shapes::{SOURCES, push_directions};
    use crate::predict::secants::{Direction, Linearisation, moved};
    use crate::synthetic::{NOISE, recorded, with_own};
    use crate::{FitSettings, NoiseModel, Observations, fit};

    /// Usual noise, but for what differs widely.
    fn noise(id: &str, sd: f64) -> NoiseModel {
        let of = |source: &crate::predict::error_shapes::Source| {
            if source.name == id { sd } else { source.usual_sd }
        };
        NoiseModel::of_sds(&SOURCES.each_ref().map(of)).unwrap()
    }

    fn usual(model: &Description, observations: &Observations) -> Linearisation {
        let directions = push_directions(model).unwrap();
        Linearisation::of(model, &[], observations, &directions).unwrap()
    }

    /// Mean of the model's numbers over normal values of what differs, less those of the middle, and the slope
    /// of the nearest straight line: of every step, by steps of a tenth of a standard deviation.
    fn by_quadrature(
        id: &str,
        sd: f64,
        model: &Description,
        all: &Observations,
    ) -> Vec<[[f64; 7]; 2]> {
        let channels = ChannelModel::new(model, all.support, &[]).unwrap();
        let direction = Direction { effect: by_id(id).unwrap().clone(), coordinate: 0, size: sd };
        let of_step = |step: &models::ChannelObservation| {
            let input = &step.input;
            let physics = channels.physics(&input.object).unwrap().in_half_the_substeps();
            let at = |z: f64| {
                let there =
                    moved(physics.clone(), [(&direction, z * sd)].into_iter(), input).unwrap();
                there.predict(input).unwrap().to_array()
            };
            let middle = at(0.0);
            let mut sums = [[0.0; 7]; 2];
            for z in (-30..=30).map(|k| 0.1 * f64::from(k)) {
                let weight = 0.1 * (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt();
                for (k, value) in at(z).iter().enumerate() {
                    sums[0][k] += weight * (value - middle[k]);
                    sums[1][k] += weight * z * value / sd;
                }
            }
            sums
        };
        all.steps.iter().map(of_step).collect()
    }

    /// Root mean square of what differs between two lists, and of the second, in the noise.
    fn off(found: &[[f64; 7]], exact: &[[f64; 7]]) -> [f64; 2] {
        let square = |of: &dyn Fn(usize, usize) -> f64| {
            let numbers = |step: usize| (0..5).map(move |k| (of(step, k) / NOISE[k]).powi(2));
            (0..exact.len()).flat_map(numbers).sum::<f64>().sqrt()
        };
        [square(&|step, k| found[step][k] - exact[step][k]), square(&|step, k| exact[step][k])]
    }

    #[test]
    fn what_is_expected_and_the_line_are_those_over_all_pushes() {
        let (all, model) = recorded(1);
        let names: Vec<String> = all.pushes.iter().take(12).map(ToString::to_string).collect();
        let all = all.part(&names).unwrap();
        for (id, sd, least) in [("pressure-radius", 0.15, 0.05), ("pusher-friction", 0.06, 0.1)] {
            let plain = usual(&model, &all);
            let k = push_directions(&model).unwrap().iter().position(|d| d.effect.info().id == id);
            let mut line = plain.clone();
            noise(id, sd).widen(&mut line, (&model, &[]), &all).unwrap();
            let exact = by_quadrature(id, sd, &model, &all);
            let [means, slopes] = [0, 1].map(|k| exact.iter().map(|of| of[k]).collect::<Vec<_>>());
            let [missed, whole] = off(line.shift.as_ref().unwrap(), &means);
            assert!(missed < least * whole && whole > 1.0, "{id}: mean {missed} of {whole}");
            let k = k.unwrap();
            let [missed, whole] = off(&line.slopes[k], &slopes);
            assert!(missed < least * whole, "{id}: slope {missed} of {whole}");
            let [usual, _] = off(&plain.slopes[k], &slopes);
            assert!(missed < 0.7 * usual, "{id}: slope {missed}, of what is usual {usual}");
        }
    }

    #[test]
    fn what_is_usual_or_stated_by_the_model_adds_nothing() {
        let (all, mut model) = recorded(1);
        let shift = |model: &Description, sd: f64| {
            let mut line = usual(model, &all);
            noise("pressure-radius", sd).widen(&mut line, (model, &[]), &all).unwrap();
            line.shift
        };
        assert!(shift(&model, 0.02).is_none());
        assert!(shift(&model, 0.1).is_some());
        let about = by_id("pressure-radius").unwrap().info();
        let mut stated = ModelEffect::from(effects::Setting::new(about, &[1.0]));
        stated.per_push.insert("ratio".to_owned(), effects::Spread::RelativeSd(0.1));
        model.effects.push(stated);
        assert!(shift(&model, 0.1).is_none());
    }

    #[test]
    fn a_fit_to_pushes_that_differ_widely_finds_their_mean() {
        const SD: f64 = 0.15;
        let noise = noise("pressure-radius", SD);
        let mut off = [0.0; 2];
        for seed in 1..=4 {
            let (observed, model, own) = with_own("pressure-radius", SD, seed);
            let mean = own.iter().sum::<f64>() / own.len() as f64;
            let expected = noise.whitening_from(At::Expected, &model, &[], &observed).unwrap();
            let plain = noise.whitening_at(&observed, &usual(&model, &observed)).unwrap();
            for (off, whitening) in off.iter_mut().zip([expected, plain]) {
                let free = ["pressure-radius"];
                let settings = FitSettings::default();
                let fitted = fit(&observed, &model, &free, &whitening, &settings).unwrap();
                *off += 0.25 * (fitted.effects[0].parameters[0].value.ln() - mean);
            }
        }
        // The standard error of the mean of four sets is 0.01.
        let [expected, plain] = off;
        assert!(expected.abs() < 0.35 * plain.abs() && plain < -0.05, "{off:?}");
    }
}
