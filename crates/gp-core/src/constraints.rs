//! What a user asks of hyperparameters by name: fixed, bounded, tied, with a prior.

use std::ops::{Bound, RangeBounds};
use std::sync::Arc;

use crate::checks::{check_count, check_positive, check_range};
use crate::{GpError, Kernel, Prior};

/// Wishes about hyperparameters, by name; a name without an index stands for all that have one.
#[derive(Clone, Debug, Default)]
pub struct Constraints {
    wishes: Vec<(String, Wish)>,
}

#[derive(Clone, Debug)]
enum Wish {
    Fix(f64),
    Start(f64),
    Bound(f64, f64),
    Tie(String),
    Prior(Arc<dyn Prior>),
}

/// What is asked of one hyperparameter.
#[derive(Clone, Debug, Default)]
pub(crate) struct Constraint {
    pub(crate) fixed: Option<f64>,
    pub(crate) start: Option<f64>,
    /// Lowest and highest value.
    pub(crate) bounds: Option<(f64, f64)>,
    /// The hyperparameter before it to which it is equal.
    pub(crate) leader: Option<usize>,
    pub(crate) priors: Vec<Arc<dyn Prior>>,
}

impl Constraints {
    /// Holds a hyperparameter at a value.
    pub fn fix(&mut self, name: &str, value: f64) {
        self.wishes.push((name.to_owned(), Wish::Fix(value)));
    }

    /// Begins the first start at a value.
    pub fn start(&mut self, name: &str, value: f64) {
        self.wishes.push((name.to_owned(), Wish::Start(value)));
    }

    /// The same, with a noise variance at which the first start begins, if it is given.
    pub fn starting_at(&self, noise_variance: Option<f64>) -> Self {
        let mut constraints = self.clone();
        if let Some(value) = noise_variance {
            constraints.start(NOISE_VARIANCE, value);
        }
        constraints
    }

    /// Keeps a hyperparameter in a range.
    pub fn bound(&mut self, name: &str, range: impl RangeBounds<f64>) {
        let end = |bound: Bound<&f64>, open: f64| match bound {
            Bound::Included(value) | Bound::Excluded(value) => *value,
            Bound::Unbounded => open,
        };
        let (low, high) = (end(range.start_bound(), 0.0), end(range.end_bound(), f64::INFINITY));
        self.wishes.push((name.to_owned(), Wish::Bound(low, high)));
    }

    /// Keeps two hyperparameters equal, or all of a name; the second takes the first one's value.
    pub fn tie(&mut self, first: &str, second: &str) {
        self.wishes.push((second.to_owned(), Wish::Tie(first.to_owned())));
    }

    /// Adds what is known of a hyperparameter before the data.
    pub fn prior(&mut self, name: &str, prior: impl Prior + 'static) {
        self.wishes.push((name.to_owned(), Wish::Prior(Arc::new(prior))));
    }

    /// One constraint a hyperparameter; those of tied ones stand with the first of them.
    ///
    /// # Errors
    /// `UnknownParameter`; `NotPositive` or `OutOfRange` for values and ranges that are none;
    /// `ShapeMismatch` for ties of different numbers; `Incompatible` for tied values that differ.
    pub(crate) fn resolve(&self, names: &[String]) -> Result<Vec<Constraint>, GpError> {
        let mut all = vec![Constraint::default(); names.len()];
        for (name, wish) in &self.wishes {
            let those = matching(name, names)?;
            match wish {
                Wish::Fix(value) => {
                    check_positive(name, *value)?;
                    those.iter().for_each(|&i| all[i].fixed = Some(*value));
                }
                Wish::Start(value) => {
                    check_positive(name, *value)?;
                    those.iter().for_each(|&i| all[i].start = Some(*value));
                }
                Wish::Bound(low, high) => {
                    let what = |end: &str| format!("{end} bound of {name}");
                    check_range(&what("lower"), *low, 0.0, f64::MAX)?;
                    check_range(&what("upper"), *high, low.next_up(), f64::INFINITY)?;
                    those.iter().for_each(|&i| all[i].bounds = Some((*low, *high)));
                }
                Wish::Tie(first) => tie(&mut all, &matching(first, names)?, &those)?,
                Wish::Prior(prior) => those.iter().for_each(|&i| all[i].priors.push(prior.clone())),
            }
        }
        gather(&mut all)?;
        check_bounds(&all, names)?;
        Ok(all)
    }

    /// How many hyperparameters are free.
    pub(crate) fn n_free(&self, names: &[String]) -> Result<usize, GpError> {
        let all = self.resolve(names)?;
        Ok(all.iter().filter(|one| one.fixed.is_none() && one.leader.is_none()).count())
    }

    /// A kernel and a noise variance as they are, but for values that are fixed, given or tied.
    ///
    /// # Errors
    /// `UnknownParameter`; `NotPositive` or `OutOfRange` for values and ranges that are none, or that do
    /// not agree; `ShapeMismatch` for ties of different numbers; `Incompatible` for tied values that
    /// differ; `NoNoiseVariance` where there is none.
    pub fn apply(
        &self,
        kernel: &dyn Kernel,
        noise_variance: Option<f64>,
    ) -> Result<(Box<dyn Kernel>, f64), GpError> {
        let names = hyperparameter_names(kernel);
        let of_kernel = kernel.parameters().into_iter().map(|parameter| Some(parameter.value));
        let values: Vec<Option<f64>> = of_kernel.chain([noise_variance]).collect();
        let mut applied: Vec<f64> = Vec::new();
        for (i, constraint) in self.resolve(&names)?.iter().enumerate() {
            let own = constraint.fixed.or(constraint.start).or(values[i]);
            let value = constraint.leader.map(|leader| applied[leader]).or(own);
            let value = value.ok_or(GpError::NoNoiseVariance)?;
            if let Some((low, high)) = constraint.bounds {
                check_range(&names[i], value, low, high)?;
            }
            applied.push(value);
        }
        let noise_variance = applied.pop().ok_or(GpError::NoNoiseVariance)?;
        Ok((kernel.with_parameters(&applied)?, noise_variance))
    }
}

/// Names of all hyperparameters: those of the kernel, and `noise_variance`, which comes last.
pub fn hyperparameter_names(kernel: &dyn Kernel) -> Vec<String> {
    let of_kernel = kernel.parameters().into_iter().map(|parameter| parameter.name);
    of_kernel.chain([NOISE_VARIANCE.to_owned()]).collect()
}

/// The name of the noise variance among the hyperparameters.
pub(crate) const NOISE_VARIANCE: &str = "noise_variance";

/// The places of a name, or of all that have an index behind it.
fn matching(name: &str, names: &[String]) -> Result<Vec<usize>, GpError> {
    let matches = |known: &str| match known.strip_prefix(name) {
        Some(rest) => rest.is_empty() || rest.starts_with('['),
        None => false,
    };
    let those: Vec<usize> = (0..names.len()).filter(|&i| matches(&names[i])).collect();
    if those.is_empty() {
        let known = names.join(", ");
        return Err(GpError::UnknownParameter { name: name.to_owned(), known });
    }
    Ok(those)
}

fn tie(all: &mut [Constraint], first: &[usize], second: &[usize]) -> Result<(), GpError> {
    let pairs: Vec<(usize, usize)> = if first.len() == 1 || first == second {
        second.iter().map(|&other| (first[0], other)).collect()
    } else {
        check_count("tied hyperparameters", first.len(), second.len())?;
        first.iter().copied().zip(second.iter().copied()).collect()
    };
    for (a, b) in pairs {
        let (a, b) = (leader(all, a), leader(all, b));
        if a != b {
            all[a.max(b)].leader = Some(a.min(b));
        }
    }
    Ok(())
}

fn leader(all: &[Constraint], mut i: usize) -> usize {
    while let Some(before) = all[i].leader {
        i = before;
    }
    i
}

/// Moves what is asked of tied hyperparameters to the first of them.
fn gather(all: &mut [Constraint]) -> Result<(), GpError> {
    for i in 0..all.len() {
        let first = leader(all, i);
        if first == i {
            continue;
        }
        let Constraint { fixed, start, bounds, priors, .. } = std::mem::take(&mut all[i]);
        all[i].leader = Some(first);
        let one = &mut all[first];
        match (one.fixed, fixed) {
            (Some(a), Some(b)) if a != b => {
                return Err(GpError::Incompatible { what: "fixed values of tied hyperparameters" });
            }
            _ => one.fixed = one.fixed.or(fixed),
        }
        one.start = one.start.or(start);
        one.bounds = match (one.bounds, bounds) {
            (Some(a), Some(b)) if a.0.max(b.0) >= a.1.min(b.1) => {
                return Err(GpError::Incompatible { what: "bounds of tied hyperparameters" });
            }
            (Some(a), Some(b)) => Some((a.0.max(b.0), a.1.min(b.1))),
            (a, b) => a.or(b),
        };
        one.priors.extend(priors);
    }
    Ok(())
}

fn check_bounds(all: &[Constraint], names: &[String]) -> Result<(), GpError> {
    for (constraint, name) in all.iter().zip(names) {
        if let Some((low, high)) = constraint.bounds {
            for value in constraint.fixed.iter().chain(&constraint.start) {
                check_range(name, *value, low, high)?;
            }
        }
    }
    Ok(())
}
