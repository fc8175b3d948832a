//! Three independent processes over what a learnt model sees of a step.

use std::sync::{Arc, OnceLock};

use faer::MatRef;
use gp_core::GpError;
use nalgebra::{Matrix3, Vector3};
use planar::Shape;

use crate::learnt::closed_form::ClosedForm;
use crate::learnt::step_table::{Belief, StepTable};
use crate::process::{Process, ProcessReport};
use crate::steps::contact_place::ContactPlaces;
use crate::steps::prediction::of_output;
use crate::{
    ModelError, Noise, Outline, ProcessKind, SeenSteps, StepFeatures, StepInput, StepPrediction,
    TableReport, Training, Weights,
};

/// One process an output, for outputs per meter of the pusher's way.
///
/// A quasi-static push does not know time, and a short one is proportional to the way; what is
/// learnt at one step length, or pooled over several speeds, thus serves others near them.
#[derive(Clone, Debug)]
pub(crate) struct StepProcesses {
    outputs: [Process; 3],
    features: StepFeatures,
    outlines: Vec<Outline>,
    seen: Option<SeenSteps>,
    /// How each was learnt, where that is known.
    learning: Option<[ProcessReport; 3]>,
    /// What is read instead of the processes, where it reaches.
    table: Option<Arc<StepTable>>,
    /// Worked out when it is asked for.
    closed_form: OnceLock<Arc<ClosedForm>>,
}

impl StepProcesses {
    /// Learns all hyperparameters from steps and their targets, in m, m and rad.
    pub(crate) fn learn(
        steps: &[&StepInput],
        targets: &[Vector3<f64>],
        training: &Training,
    ) -> Result<(Self, [ProcessReport; 3]), ModelError> {
        let x = training.features.training_rows(steps)?;
        let mut places = ContactPlaces::default();
        let per_meter = targets.iter().zip(steps).map(|(target, step)| match training.features {
            StepFeatures { contact: true, .. } => places.of(step).to_common(target),
            _ => *target,
        } / step.distance());
        let per_meter: Vec<Vector3<f64>> = per_meter.collect();
        let learn = |k: usize| {
            let y: Vec<f64> = per_meter.iter().map(|target| target[k]).collect();
            Process::learn(x.as_ref(), &y, training).map_err(of_output(k))
        };
        let [(dx, report_x), (dy, report_y), (dtheta, report_theta)] =
            [learn(0)?, learn(1)?, learn(2)?];
        let outputs = [dx, dy, dtheta];
        let mut shapes: Vec<&Arc<Shape>> = Vec::new();
        for shape in steps.iter().map(|step| step.shared_shape()) {
            if !shapes.iter().any(|known| Arc::ptr_eq(known, shape) || *known == shape) {
                shapes.push(shape);
            }
        }
        let outlines = shapes.into_iter().map(|shape| Outline::of(shape)).collect();
        let seen = SeenSteps::of(training.features, steps)?;
        let features = training.features;
        let closed_form = OnceLock::new();
        let reports = [report_x, report_y, report_theta];
        let learning = Some(reports.clone());
        let processes =
            Self { outputs, features, outlines, seen, learning, table: None, closed_form };
        Ok((processes, reports))
    }

    /// The kind of the processes.
    pub(crate) fn kind(&self) -> ProcessKind {
        self.outputs[0].kind()
    }

    /// The outputs' Gaussians, in m, m and rad.
    pub(crate) fn predict(
        &self,
        steps: &[StepInput],
        noise: Noise,
    ) -> Result<Vec<StepPrediction>, ModelError> {
        let zero = StepPrediction { mean: Vector3::zeros(), covariance: Matrix3::zeros() };
        let mut predictions = vec![zero; steps.len()];
        if steps.is_empty() {
            return Ok(predictions);
        }
        self.check_outlines(steps)?;
        let beyond: Vec<usize> = match &self.table {
            Some(table) => table.read(steps, noise, &mut predictions),
            None => (0..steps.len()).collect(),
        };
        if beyond.is_empty() {
            return Ok(predictions);
        }
        let x = self.features.rows(beyond.iter().map(|i| &steps[*i]))?;
        for (k, process) in self.outputs.iter().enumerate() {
            let (mean, variance) = match noise {
                Noise::Included => process.posterior().predict_observation(x.as_ref()),
                Noise::Excluded => process.posterior().predict(x.as_ref()),
            }
            .map_err(of_output(k))?;
            for ((i, mean), variance) in beyond.iter().zip(mean).zip(variance) {
                check_number(mean)?;
                check_number(variance)?;
                let (distance, prediction) = (steps[*i].distance(), &mut predictions[*i]);
                prediction.mean[k] = mean * distance;
                prediction.covariance[(k, k)] = variance * distance * distance;
            }
        }
        if self.features.contact {
            let mut places = ContactPlaces::default();
            for (prediction, step) in predictions.iter_mut().zip(steps) {
                *prediction = places.of(step).prediction_of(prediction);
            }
        }
        Ok(predictions)
    }

    /// The same, read from a table where that reaches.
    pub(crate) fn tabulated(&self) -> Result<(Self, TableReport), ModelError> {
        if self.features != StepFeatures::default() {
            let inputs = self.features.names().join(", ");
            return Err(ModelError::NoTable { inputs });
        }
        let (table, report) = StepTable::of(|x| self.beliefs(x))?;
        Ok((Self { table: Some(Arc::new(table)), ..self.clone() }, report))
    }

    /// What the processes believe at inputs, per meter of way.
    fn beliefs(&self, x: MatRef<'_, f64>) -> Result<Vec<Belief>, ModelError> {
        let mut beliefs = vec![Belief::default(); x.nrows()];
        for (k, process) in self.outputs.iter().enumerate() {
            let process = process.posterior();
            let (mean, variance) = process.predict(x).map_err(of_output(k))?;
            let noise = process.predict_noise(x).map_err(of_output(k))?;
            for (i, belief) in beliefs.iter_mut().enumerate() {
                belief.mean[k] = mean[i];
                belief.observed_sd[k] = (variance[i] + noise[i]).max(0.0).sqrt();
                belief.function_sd[k] = variance[i].max(0.0).sqrt();
            }
        }
        Ok(beliefs)
    }

    /// The outputs' means alone, in m, m and rad.
    pub(crate) fn means(&self, steps: &[&StepInput]) -> Result<Vec<Vector3<f64>>, ModelError> {
        let mut means = vec![Vector3::zeros(); steps.len()];
        if steps.is_empty() {
            return Ok(means);
        }
        self.check_outlines(steps.iter().copied())?;
        let x = self.features.rows(steps.iter().copied())?;
        for (k, process) in self.outputs.iter().enumerate() {
            let found = process.posterior().predict_mean(x.as_ref()).map_err(of_output(k))?;
            for ((mean, found), step) in means.iter_mut().zip(found).zip(steps) {
                check_number(found)?;
                mean[k] = found * step.distance();
            }
        }
        if self.features.contact {
            let mut places = ContactPlaces::default();
            for (mean, step) in means.iter_mut().zip(steps) {
                *mean = places.of(step).mean_of(mean);
            }
        }
        Ok(means)
    }

    /// What the processes say of steps that are uncertain themselves.
    ///
    /// # Errors
    /// `NoClosedForm` for processes or inputs of which no moments are known.
    pub(crate) fn closed_form(&self) -> Result<Arc<ClosedForm>, ModelError> {
        if let Some(known) = self.closed_form.get() {
            return Ok(known.clone());
        }
        let found = Arc::new(ClosedForm::of(&self.outputs, self.features)?);
        Ok(self.closed_form.get_or_init(|| found).clone())
    }

    /// The span of the training steps; none for weights that do not tell it.
    pub(crate) fn seen(&self) -> Option<&SeenSteps> {
        self.seen.as_ref()
    }

    /// Whether each step is within that span.
    pub(crate) fn has_seen(&self, steps: &[StepInput]) -> Result<Vec<bool>, ModelError> {
        let Some(seen) = &self.seen else { return Ok(vec![true; steps.len()]) };
        let mut places = ContactPlaces::default();
        let holds = |step| {
            let row = self.features.row(step, &mut places)?;
            Ok(seen.holds(&row[..self.features.n_inputs()]))
        };
        steps.iter().map(holds).collect()
    }

    /// The processes as plain data.
    pub(crate) fn weights(&self) -> Result<Weights, ModelError> {
        let model = |k: usize| self.outputs[k].to_model().map_err(of_output(k));
        Ok(Weights {
            schema: Weights::SCHEMA.to_owned(),
            inputs: self.features.names().into_iter().map(str::to_owned).collect(),
            outlines: self.outlines.clone(),
            outputs: [model(0)?, model(1)?, model(2)?],
            seen: self.seen.clone(),
            learning: self.learning.clone(),
            orthogonal_discrepancy: None,
        })
    }

    /// The processes that `weights` described.
    pub(crate) fn from_weights(weights: &Weights) -> Result<Self, ModelError> {
        let features = weights.features()?;
        let build = |k: usize| {
            let process = Process::from_model(&weights.outputs[k]).map_err(of_output(k))?;
            let (expected, actual) = (features.names().len(), process.posterior().n_inputs());
            if expected != actual {
                let what = "inputs";
                return Err(of_output(k)(GpError::ShapeMismatch { what, expected, actual }));
            }
            Ok(process)
        };
        let outputs = [build(0)?, build(1)?, build(2)?];
        let seen = weights.seen.clone();
        if seen.as_ref().is_some_and(|seen| !seen.is_sound(features.names().len())) {
            return Err(ModelError::UnsoundWeights { what: "seen" });
        }
        let (outlines, learning) = (weights.outlines.clone(), weights.learning.clone());
        let closed_form = OnceLock::new();
        Ok(Self { outputs, features, outlines, seen, learning, table: None, closed_form })
    }

    /// Refuses steps of objects that nothing was learnt about, unless the inputs are what outlines
    /// have in common.
    fn check_outlines<'a>(
        &self,
        steps: impl IntoIterator<Item = &'a StepInput>,
    ) -> Result<(), ModelError> {
        if self.features.contact {
            return Ok(());
        }
        let mut last: Option<&Arc<Shape>> = None;
        for shape in steps.into_iter().map(StepInput::shared_shape) {
            if last.is_some_and(|last| Arc::ptr_eq(last, shape)) {
                continue;
            }
            let outline = Outline::of(shape);
            if !self.outlines.iter().any(|known| known.is_near(&outline)) {
                return Err(ModelError::UnknownOutline { n_known: self.outlines.len() });
            }
            last = Some(shape);
        }
        Ok(())
    }
}

/// Refuses what a process says if it is no number: its weights are finite, but not of any data.
fn check_number(value: f64) -> Result<(), ModelError> {
    match value.is_finite() {
        true => Ok(()),
        false => Err(ModelError::UnsoundWeights { what: "outputs" }),
    }
}
