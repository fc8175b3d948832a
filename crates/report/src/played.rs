//! A push of a player: where everything was, and what of each step was observed and predicted.

use serde_json::{Value, json};

use crate::error::{ReportError, check_finite, check_length, check_some};

/// One push at a few times, between which the player interpolates.
#[derive(Clone, Debug, PartialEq)]
pub struct PlayedPush {
    /// Its name, with what tells it from others.
    pub name: String,
    /// Which outline.
    pub outline: usize,
    /// Times from the start.
    pub times: Vec<f64>,
    /// Measured x, y and angle of the body frame at each time.
    pub measured: Vec<[f64; 3]>,
    /// Center of the pusher at each time.
    pub pusher: Vec<[f64; 2]>,
    /// The same of the body frame by each model; none where it has no answer.
    pub predicted: Vec<Option<Vec<[f64; 3]>>>,
    /// Its steps.
    pub steps: PlayedSteps,
}

/// What a push has to say of each of its steps.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlayedSteps {
    /// Start and end of each, in s from the start of the push.
    pub times: Vec<[f64; 2]>,
    /// For each axis of the player the cell of each step.
    pub cells: Vec<Vec<usize>>,
    /// For each number of the player what was observed of each step; empty where the number is
    /// another one in the sense of a model.
    pub observed: Vec<Vec<Option<f64>>>,
    /// For each model, and each number, observed less predicted of each step.
    pub residuals: Vec<Vec<Vec<Option<f64>>>>,
}

/// How many of everything the player has that a push is of.
#[derive(Clone, Copy)]
pub(crate) struct Sizes {
    pub(crate) n_models: usize,
    pub(crate) n_outlines: usize,
    pub(crate) n_axes: usize,
    pub(crate) n_numbers: usize,
}

/// Parts of a meter, a radian and a second in the embedded numbers.
pub(crate) const LENGTH: f64 = 1e5;
const ANGLE: f64 = 1e4;
const TIME: f64 = 1e3;
/// Parts of the unit of a number of a step.
const NUMBER: f64 = 1e3;

impl PlayedPush {
    pub(crate) fn check(&self, sizes: Sizes) -> Result<(), ReportError> {
        let mark = format!("push `{}`", self.name);
        let n = self.times.len();
        check_some(&mark, n)?;
        check_finite(&mark, "times", &self.times)?;
        check_length(&mark, "measured", n, self.measured.len())?;
        check_finite(&mark, "measured (x, y, angle)", self.measured.as_flattened())?;
        check_length(&mark, "pusher", n, self.pusher.len())?;
        check_finite(&mark, "pusher (x, y)", self.pusher.as_flattened())?;
        check_length(&mark, "predicted", sizes.n_models, self.predicted.len())?;
        for poses in self.predicted.iter().flatten() {
            check_length(&mark, "predicted poses", n, poses.len())?;
            check_finite(&mark, "predicted (x, y, angle)", poses.as_flattened())?;
        }
        self.steps.check(&mark, sizes)?;
        if self.outline < sizes.n_outlines {
            return Ok(());
        }
        Err(ReportError::Parameter {
            mark,
            field: "outline",
            expected: "the index of an outline",
            value: self.outline as f64,
        })
    }

    pub(crate) fn to_json(&self) -> Value {
        let column = |values: &mut dyn Iterator<Item = f64>| coded(values);
        let pose = |poses: &[[f64; 3]]| {
            let scaled = |k: usize, scale: f64| column(&mut poses.iter().map(|p| p[k] * scale));
            json!([scaled(0, LENGTH), scaled(1, LENGTH), scaled(2, ANGLE)])
        };
        let pusher = |k: usize| column(&mut self.pusher.iter().map(|p| p[k] * LENGTH));
        json!({
            "o": self.outline,
            "t": column(&mut self.times.iter().map(|t| t * TIME)),
            "m": pose(&self.measured),
            "p": [pusher(0), pusher(1)],
            "r": self.predicted.iter().map(|r| r.as_deref().map(pose)).collect::<Vec<_>>(),
            "s": self.steps.to_json(),
        })
    }
}

impl PlayedSteps {
    fn check(&self, mark: &str, sizes: Sizes) -> Result<(), ReportError> {
        let n = self.times.len();
        check_finite(mark, "times of steps", self.times.as_flattened())?;
        check_length(mark, "cells of steps", sizes.n_axes, self.cells.len())?;
        self.cells
            .iter()
            .try_for_each(|cells| check_length(mark, "cells of steps", n, cells.len()))?;
        let Sizes { n_numbers, n_models, .. } = sizes;
        check_length(mark, "observed numbers of steps", n_numbers, self.observed.len())?;
        check_length(mark, "models of residuals", n_models, self.residuals.len())?;
        for residuals in &self.residuals {
            check_length(mark, "residuals of steps", n_numbers, residuals.len())?;
        }
        let observed = self.observed.iter().filter(|values| !values.is_empty());
        for values in observed.chain(self.residuals.iter().flatten()) {
            check_length(mark, "numbers of steps", n, values.len())?;
            let known: Vec<f64> = values.iter().flatten().copied().collect();
            check_finite(mark, "numbers of steps", &known)?;
        }
        Ok(())
    }

    fn to_json(&self) -> Value {
        let time = |end: usize| coded(self.times.iter().map(|times| times[end] * TIME));
        let whole = |values: &Vec<Option<f64>>| -> Vec<Option<i64>> {
            values.iter().map(|value| Some((value.as_ref()? * NUMBER).round() as i64)).collect()
        };
        let wholes = |of: &Vec<Vec<Option<f64>>>| of.iter().map(whole).collect::<Vec<_>>();
        json!({
            "t": [time(0), time(1)],
            "c": self.cells,
            "v": wholes(&self.observed),
            "e": self.residuals.iter().map(wholes).collect::<Vec<_>>(),
        })
    }
}

/// Rounded numbers, the first and the differences that follow, which do not drift.
pub(crate) fn coded(values: impl Iterator<Item = f64>) -> Vec<i64> {
    let mut last = 0;
    let difference = |value: f64| {
        let now = value.round() as i64;
        let step = now - last;
        last = now;
        step
    };
    values.map(difference).collect()
}
