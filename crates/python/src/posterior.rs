//! Gaussian processes: exact, sparse and on random features, behind one class.

use std::sync::Arc;

use gp_core::{Gp, GpError, Kernel, KernelSpec, LearnOptions, Mean};
use gp_rff::{FeatureOptions, RffGp, RffOptions, Spectrum};
use gp_sparse::{Approximation, Placement, PseudoInputs, SparseGp, SparseOptions, SparseSettings};
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::types::PyAnyMethods;
use pyo3::{Bound, PyAny, PyResult, Python, pyclass, pymethods};

use crate::array::{Rows, array_of};
use crate::failure::{PushlabError, refused};
use crate::interruptible::interruptible;

/// Means and variances.
type Moments<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>);

/// Means and their covariance.
type JointMoments<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>);

/// A process that has seen data.
#[pyclass(frozen, module = "pushlab._native")]
pub(crate) struct Posterior(Arc<Process>);

enum Process {
    Exact(Gp),
    Sparse(Box<SparseGp>),
    Features(RffGp),
}

impl Process {
    fn posterior(&self) -> &dyn gp_core::Posterior {
        match self {
            Self::Exact(gp) => gp,
            Self::Sparse(gp) => gp.as_ref(),
            Self::Features(gp) => gp,
        }
    }
}

#[pymethods]
impl Posterior {
    /// The exact process; learns its hyperparameters, or keeps them as they are.
    #[staticmethod]
    #[pyo3(signature = (kernel, x, y, *, noise_variance, row_noise, mean, learn, fixed, bounds, n_starts, seed))]
    #[expect(clippy::too_many_arguments, reason = "the keywords of a Python function")]
    fn exact(
        py: Python<'_>,
        kernel: &str,
        x: PyReadonlyArray2<'_, f64>,
        y: PyReadonlyArray1<'_, f64>,
        noise_variance: Option<f64>,
        row_noise: Option<PyReadonlyArray1<'_, f64>>,
        mean: &str,
        learn: bool,
        fixed: Vec<(String, f64)>,
        bounds: Vec<(String, f64, f64)>,
        n_starts: usize,
        seed: u64,
    ) -> PyResult<Self> {
        let (kernel, mean) = (kernel_of(kernel)?, mean_of(mean)?);
        let options = LearnOptions { mean, n_starts, seed, ..LearnOptions::default() };
        let mut builder = Gp::builder(kernel).options(options);
        if let Some(value) = noise_variance {
            builder = builder.noise_variance(value);
        }
        if let Some(variances) = row_noise {
            builder = builder.row_noise(&values(&variances));
        }
        builder = fixed.iter().fold(builder, |builder, (name, value)| builder.fix(name, *value));
        builder = bounds
            .iter()
            .fold(builder, |builder, (name, low, high)| builder.bound(name, *low..=*high));
        learnt(py, (x, y), move |x, y| {
            let x = x.matrix();
            Ok(Process::Exact(if learn { builder.fit(x, y)? } else { builder.condition(x, y)? }))
        })
    }

    /// The process through pseudo-inputs, which are learnt with its hyperparameters.
    #[staticmethod]
    #[pyo3(signature = (kernel, x, y, *, n_pseudo_inputs, approximation, n_starts, seed))]
    #[expect(clippy::too_many_arguments, reason = "the keywords of a Python function")]
    fn sparse(
        py: Python<'_>,
        kernel: &str,
        x: PyReadonlyArray2<'_, f64>,
        y: PyReadonlyArray1<'_, f64>,
        n_pseudo_inputs: usize,
        approximation: &str,
        n_starts: usize,
        seed: u64,
    ) -> PyResult<Self> {
        let kernel = kernel_of(kernel)?;
        let approximation = match approximation {
            "vfe" => Approximation::Vfe,
            "fitc" => Approximation::Fitc,
            "dtc" => Approximation::Dtc,
            other => {
                let text = format!("there is no approximation `{other}`; there are vfe, fitc, dtc");
                return Err(PushlabError::new_err(text));
            }
        };
        let placement = Placement::default();
        let options = SparseOptions {
            settings: SparseSettings { approximation, ..SparseSettings::default() },
            pseudo_inputs: PseudoInputs::Learnt { count: n_pseudo_inputs, placement },
            n_starts,
            seed,
            ..SparseOptions::default()
        };
        learnt(py, (x, y), move |x, y| {
            Ok(Process::Sparse(Box::new(SparseGp::learn(kernel, x.matrix(), y, &options)?.0)))
        })
    }

    /// The process on random features, whose hyperparameters are learnt.
    #[staticmethod]
    #[pyo3(signature = (spectrum, x, y, *, n_features, n_starts, seed))]
    fn features(
        py: Python<'_>,
        spectrum: &str,
        x: PyReadonlyArray2<'_, f64>,
        y: PyReadonlyArray1<'_, f64>,
        n_features: usize,
        n_starts: usize,
        seed: u64,
    ) -> PyResult<Self> {
        let spectrum: Spectrum = parsed("kernel", &format!("{spectrum:?}"))?;
        let features = FeatureOptions { n_features, seed, ..FeatureOptions::default() };
        let options = RffOptions { spectrum, features, n_starts, seed, ..RffOptions::default() };
        learnt(py, (x, y), move |x, y| {
            Ok(Process::Features(RffGp::learn(x.matrix(), y, &options)?.0))
        })
    }

    /// The process that `to_json` wrote.
    #[staticmethod]
    fn from_json(py: Python<'_>, kind: &str, text: String) -> PyResult<Self> {
        let kind = kind.to_owned();
        let process = interruptible(py, None, move |_| {
            Ok(match kind.as_str() {
                "exact" => Process::Exact(serde_json::from_str(&text)?),
                "sparse" => Process::Sparse(serde_json::from_str(&text)?),
                _ => Process::Features(serde_json::from_str(&text)?),
            })
        })?;
        process
            .map(|process| Self(Arc::new(process)))
            .map_err(|error: serde_json::Error| refused(error))
    }

    /// Everything from which the same predictions come again.
    fn to_json(&self) -> PyResult<String> {
        let text = match &*self.0 {
            Process::Exact(gp) => serde_json::to_string(gp),
            Process::Sparse(gp) => serde_json::to_string(gp),
            Process::Features(gp) => serde_json::to_string(gp),
        };
        text.map_err(refused)
    }

    /// For `pickle` and `copy`.
    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, (&'static str, String))> {
        let of_class = py.get_type::<Self>().getattr("from_json")?;
        Ok((of_class, (self.kind(), self.to_json()?)))
    }

    #[getter]
    fn kind(&self) -> &'static str {
        match &*self.0 {
            Process::Exact(_) => "exact",
            Process::Sparse(_) => "sparse",
            Process::Features(_) => "features",
        }
    }

    /// Names and values of the kernel's parameters and of the noise variance.
    #[getter]
    fn hyperparameters(&self) -> PyResult<Vec<(String, f64)>> {
        let of_kernel = |kernel: &dyn Kernel| {
            kernel
                .parameters()
                .into_iter()
                .map(|parameter| (parameter.name, parameter.value))
                .collect()
        };
        let (mut named, noise): (Vec<_>, f64) = match &*self.0 {
            Process::Exact(gp) => (of_kernel(gp.kernel()), gp.noise_variance()),
            Process::Sparse(gp) => (of_kernel(gp.kernel()), gp.noise_variance()),
            Process::Features(gp) => {
                let (features, signal) = (gp.features(), gp.signal_variance());
                let kernel = features.spectrum().kernel(features.lengthscales(), signal);
                (of_kernel(&*kernel.map_err(refused)?), gp.noise_variance())
            }
        };
        named.push(("noise_variance".to_owned(), noise));
        Ok(named)
    }

    /// The log marginal likelihood, or what stands for it, in nats.
    #[getter]
    fn log_marginal_likelihood(&self) -> f64 {
        match &*self.0 {
            Process::Exact(gp) => gp.log_marginal_likelihood(),
            Process::Sparse(gp) => gp.objective(),
            Process::Features(gp) => gp.log_evidence(),
        }
    }

    /// How learning went, in words.
    #[getter]
    fn report(&self) -> Option<String> {
        match &*self.0 {
            Process::Exact(gp) => gp.report().map(ToString::to_string),
            _ => None,
        }
    }

    /// The mean of f at each row.
    fn predict_mean<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArray2<'_, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let mean = self.ask(py, x, |posterior, x| posterior.predict_mean(x.matrix()))?;
        Ok(PyArray1::from_vec(py, mean))
    }

    /// Mean and variance of f at each row.
    fn predict<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArray2<'_, f64>,
    ) -> PyResult<Moments<'py>> {
        let (mean, variance) = self.ask(py, x, |posterior, x| posterior.predict(x.matrix()))?;
        Ok((PyArray1::from_vec(py, mean), PyArray1::from_vec(py, variance)))
    }

    /// The variance of the noise at each row.
    fn predict_noise<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArray2<'_, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let noise = self.ask(py, x, |posterior, x| posterior.predict_noise(x.matrix()))?;
        Ok(PyArray1::from_vec(py, noise))
    }

    /// Mean and covariance of f at all rows together.
    fn predict_joint<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArray2<'_, f64>,
    ) -> PyResult<JointMoments<'py>> {
        let joint = self.ask(py, x, |posterior, x| posterior.predict_joint(x.matrix()))?;
        let covariance = array_of(py, &joint.covariance().to_owned())?;
        Ok((PyArray1::from_slice(py, joint.mean()), covariance))
    }

    /// Draws of f at all rows together, M×n.
    fn sample<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArray2<'_, f64>,
        n: usize,
        seed: u64,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let draws = self.ask(py, x, move |posterior, x| posterior.sample(x.matrix(), n, seed))?;
        array_of(py, &draws)
    }
}

impl Posterior {
    /// Asks the process while Python may go on.
    fn ask<T: Send + 'static>(
        &self,
        py: Python<'_>,
        x: PyReadonlyArray2<'_, f64>,
        ask: impl FnOnce(&dyn gp_core::Posterior, &Rows) -> Result<T, GpError> + Send + 'static,
    ) -> PyResult<T> {
        let (process, x) = (self.0.clone(), Rows::of(&x));
        interruptible(py, None, move |_| ask(process.posterior(), &x))?.map_err(refused)
    }
}

/// Learns while Python may go on.
fn learnt(
    py: Python<'_>,
    (x, y): (PyReadonlyArray2<'_, f64>, PyReadonlyArray1<'_, f64>),
    learn: impl FnOnce(&Rows, &[f64]) -> Result<Process, GpError> + Send + 'static,
) -> PyResult<Posterior> {
    let (x, y) = (Rows::of(&x), values(&y));
    let process = interruptible(py, None, move |_| learn(&x, &y))?;
    Ok(Posterior(Arc::new(process.map_err(refused)?)))
}

fn values(array: &PyReadonlyArray1<'_, f64>) -> Vec<f64> {
    array.as_array().iter().copied().collect()
}

fn kernel_of(text: &str) -> PyResult<Box<dyn Kernel>> {
    Ok(parsed::<KernelSpec>("kernel", text)?.build())
}

fn mean_of(text: &str) -> PyResult<Mean> {
    parsed("mean", text)
}

fn parsed<T: serde::de::DeserializeOwned>(what: &str, text: &str) -> PyResult<T> {
    serde_json::from_str(text)
        .map_err(|error| PushlabError::new_err(format!("no such {what}: {error}")))
}
