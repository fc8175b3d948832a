//! The steps of the pushes that the page plays: in which cells they are, and what is missed of them.

use ::report::{PlayedSteps, PlayerAxis, PlayerNumber, Shown};
use diagnosis::{CovariateCells, Observations, StepResiduals};

use super::measure::{Measure, covariate, key, range_text, title};
use super::{Report, Tried};

/// All steps, as players and maps count them.
pub(super) struct StepsOf<'a> {
    observations: &'a Observations,
    models: &'a [Tried],
    axes: Vec<CovariateCells>,
    /// Numbers that some model predicts of some step, by their place in the models' residuals.
    numbers: Vec<usize>,
    /// The steps of each push, in their order.
    by_push: Vec<Vec<usize>>,
}

impl<'a> StepsOf<'a> {
    pub(super) fn new(report: &'a Report) -> Self {
        let (observations, models) = (&report.all, &report.models[..]);
        let mut by_push: Vec<Vec<usize>> = vec![Vec::new(); observations.pushes().len()];
        for step in 0..observations.n_steps() {
            by_push[observations.push_of(step)].push(step);
        }
        let start = |step: &usize| observations.steps()[*step].input.since_contact;
        by_push.iter_mut().for_each(|steps| steps.sort_by(|a, b| start(a).total_cmp(&start(b))));
        let is_known = |number: &usize| {
            models.iter().any(|model| model.residuals[*number].values.iter().any(Option::is_some))
        };
        let numbers = (0..models[0].residuals.len()).filter(is_known).collect();
        Self { observations, models, axes: CovariateCells::all(observations), numbers, by_push }
    }

    fn residuals(&self) -> impl Iterator<Item = &StepResiduals> {
        self.numbers.iter().map(|number| &self.models[0].residuals[*number])
    }

    /// What the player says of the axes of maps.
    pub(super) fn axes(&self) -> Vec<PlayerAxis> {
        let axis = |axis: &CovariateCells| PlayerAxis {
            key: key(axis.covariate).to_owned(),
            name: covariate(axis.covariate).to_owned(),
            short: axis.covariate.name().to_owned(),
            unit: Measure::of(axis.covariate.unit()).unit.to_owned(),
            cells: axis.ranges.iter().map(|ends| range_text(axis.covariate, *ends)).collect(),
        };
        self.axes.iter().map(axis).collect()
    }

    /// What it says of the numbers.
    pub(super) fn numbers(&self) -> Vec<PlayerNumber> {
        let own: Vec<&StepResiduals> = self.residuals().collect();
        let number = |residuals: &&StepResiduals| {
            let plain = own.iter().position(|one| one.number == residuals.number);
            let in_sense = ["drift", "turn"].contains(&residuals.name);
            PlayerNumber {
                key: residuals.name.to_owned(),
                name: title(residuals.name).to_owned(),
                unit: measure(residuals).unit.trim().to_owned(),
                shown: match plain.filter(|_| in_sense) {
                    Some(plain) => Shown::As(plain),
                    None if residuals.name.starts_with("force") => Shown::Values,
                    None => Shown::Error,
                },
            }
        };
        own.iter().map(number).collect()
    }

    /// The steps of a push, with times from the start of its first one.
    pub(super) fn of_push(&self, push: usize, start: f64) -> PlayedSteps {
        let steps = &self.by_push[push];
        let time = |step: &usize| {
            let input = &self.observations.steps()[*step].input;
            let from = input.since_contact - start;
            [from, from + input.track.duration()]
        };
        let observed = |residuals: &StepResiduals| -> Vec<Option<f64>> {
            if ["drift", "turn"].contains(&residuals.name) {
                return Vec::new();
            }
            let per = measure(residuals).per;
            let value = |step: &usize| self.observations.steps()[*step].observed[residuals.number];
            steps.iter().map(|step| Some(per * value(step)?)).collect()
        };
        let missed = |model: &Tried| -> Vec<Vec<Option<f64>>> {
            let of = |number: &usize| {
                let residuals = &model.residuals[*number];
                let per = measure(residuals).per;
                steps.iter().map(|step| Some(per * residuals.values[*step]?)).collect()
            };
            self.numbers.iter().map(of).collect()
        };
        PlayedSteps {
            times: steps.iter().map(time).collect(),
            cells: self
                .axes
                .iter()
                .map(|axis| steps.iter().map(|step| axis.cell_of[*step]).collect())
                .collect(),
            observed: self.residuals().map(observed).collect(),
            residuals: self.models.iter().map(missed).collect(),
        }
    }
}

/// How a number is shown; gaps and forces have no sense of a model.
fn measure(residuals: &StepResiduals) -> Measure {
    Measure::of(match residuals.number {
        2 => "rad",
        3 | 4 => "N",
        _ => "m",
    })
}
