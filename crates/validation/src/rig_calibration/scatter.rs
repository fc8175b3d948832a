//! How far steps that begin alike are apart, and how a model's errors hang together.

use models::StepObservation;
use nalgebra::Vector3;

/// Differences in p and in β (rad) that count as equally far, between steps that begin alike and
/// between those of one run.
const ALIKE: (f64, f64) = (0.01, 0.035);
const LINKED: (f64, f64) = (0.008, 0.016);

/// What is closest to each step.
pub(super) struct Neighbors {
    /// The step that begins most alike, if one is near enough.
    alike: Vec<Option<usize>>,
    /// The same among the steps of other runs.
    elsewhere: Vec<Option<usize>>,
    /// The one so near that it is taken for the next of the same push.
    linked: Vec<Option<usize>>,
}

impl Neighbors {
    /// - `pushes`: of each step; if not known, steps that are linked count as one push.
    pub(super) fn of(steps: &[StepObservation], pushes: Option<&[usize]>) -> Self {
        let places: Vec<_> = steps.iter().map(|step| (step.input.p(), step.input.beta())).collect();
        let far = |i: usize, j: usize, scale: (f64, f64)| {
            let (p, beta) = (places[i].0 - places[j].0, places[i].1 - places[j].1);
            (p / scale.0).hypot(beta / scale.1)
        };
        let nearest = |scale: (f64, f64), is_meant: &dyn Fn(usize, usize) -> bool| {
            let near = |i: usize| {
                let others = (0..places.len()).filter(|&j| j != i && is_meant(i, j));
                let all = others.map(|j| (far(i, j, scale), j)).filter(|(far, _)| *far < 1.0);
                all.min_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, j)| j)
            };
            (0..places.len()).map(near).collect::<Vec<_>>()
        };
        let linked = || runs(places.len(), |i, j| far(i, j, LINKED) < 1.0);
        let run = pushes.map_or_else(linked, <[usize]>::to_vec);
        Self {
            alike: nearest(ALIKE, &|_, _| true),
            elsewhere: nearest(ALIKE, &|i, j| run[i] != run[j]),
            linked: nearest(LINKED, &|i, j| run[i] == run[j]),
        }
    }

    /// Standard deviation of steps that begin alike, of each output, in m, m and rad.
    pub(super) fn scatter(&self, steps: &[StepObservation]) -> Vector3<f64> {
        rms(differences(steps, &self.alike).map(|(_, apart)| apart)) / 2.0_f64.sqrt()
    }

    /// The same for steps of different runs.
    pub(super) fn scatter_elsewhere(&self, steps: &[StepObservation]) -> Vector3<f64> {
        rms(differences(steps, &self.elsewhere).map(|(_, apart)| apart)) / 2.0_f64.sqrt()
    }

    /// Scatter of the steps inside over that of those outside, root mean square of the outputs over
    /// their sizes.
    pub(super) fn growth(
        &self,
        steps: &[StepObservation],
        inside: impl Fn(&StepObservation) -> bool,
        outside: impl Fn(&StepObservation) -> bool,
    ) -> f64 {
        let size = rms(steps.iter().map(|step| step.outputs));
        let part = |is_meant: &dyn Fn(&StepObservation) -> bool| {
            let own = differences(steps, &self.alike).filter(|(i, _)| is_meant(&steps[*i]));
            rms(own.map(|(_, apart)| apart.component_div(&size))).norm()
        };
        part(&inside) / part(&outside)
    }

    /// Correlation of errors with those of the next step of the same push.
    pub(super) fn correlation(&self, errors: &[Vector3<f64>]) -> f64 {
        let pairs = self.linked.iter().enumerate().filter_map(|(i, near)| Some((i, (*near)?)));
        let (mut both, mut own) = (0.0, 0.0);
        for (i, j) in pairs {
            both += errors[i].dot(&errors[j]);
            own += 0.5 * (errors[i].norm_squared() + errors[j].norm_squared());
        }
        both / own
    }
}

fn differences<'a>(
    steps: &'a [StepObservation],
    near: &'a [Option<usize>],
) -> impl Iterator<Item = (usize, Vector3<f64>)> + 'a {
    let pairs = near.iter().enumerate().filter_map(|(i, near)| Some((i, (*near)?)));
    pairs.map(|(i, j)| (i, steps[i].outputs - steps[j].outputs))
}

/// Number of the run of each step: those that are linked, by whatever chain, are one.
fn runs(n: usize, is_linked: impl Fn(usize, usize) -> bool) -> Vec<usize> {
    let mut run = vec![usize::MAX; n];
    for first in 0..n {
        if run[first] != usize::MAX {
            continue;
        }
        run[first] = first;
        let mut open = vec![first];
        while let Some(i) = open.pop() {
            for (j, number) in run.iter_mut().enumerate() {
                if *number == usize::MAX && is_linked(i, j) {
                    *number = first;
                    open.push(j);
                }
            }
        }
    }
    run
}

/// Root of the mean square of each component.
pub(super) fn rms(values: impl Iterator<Item = Vector3<f64>>) -> Vector3<f64> {
    let (mut sum, mut n) = (Vector3::zeros(), 0);
    for value in values {
        sum += value.component_mul(&value);
        n += 1;
    }
    (sum / f64::from(n.max(1))).map(f64::sqrt)
}

#[cfg(test)]
mod tests {
    use super::{Neighbors, runs};
    use models::{StepInput, StepObservation};
    use nalgebra::Vector3;
    use planar::Shape;
    use std::sync::Arc;

    #[test]
    fn links_make_runs() {
        assert_eq!(runs(6, |i, j| i.abs_diff(j) == 2 && i != 5 && j != 5), [0, 1, 0, 1, 0, 5]);
    }

    /// Two pushes that begin alike, 1 mm apart in Δx, and one far away.
    #[test]
    fn scatter_is_that_between_pushes_and_errors_of_one_push_hang_together() {
        let shape = Arc::new(Shape::square(0.09).unwrap());
        let step = |p: f64, dx: f64| {
            let input = StepInput::on_edge(shape.clone(), 0.005, 0, p, 0.0, 0.004).unwrap();
            StepObservation { input, outputs: Vector3::new(dx, 0.0, 0.0) }
        };
        let steps = [
            step(0.2, 0.004),
            step(0.201, 0.004),
            step(0.2095, 0.003),
            step(0.2105, 0.003),
            step(0.9, 0.0),
        ];
        let near = Neighbors::of(&steps, None);
        assert_eq!(near.scatter(&steps).x, 0.0);
        assert!((near.scatter_elsewhere(&steps).x - 1e-3 / 2.0_f64.sqrt()).abs() < 1e-12);
        let along = [1.0, 1.0, -1.0, -1.0, 5.0].map(|x| Vector3::new(x, 0.0, 0.0));
        assert_eq!(near.correlation(&along), 1.0);
        let against = [1.0, -1.0, 1.0, -1.0, 5.0].map(|x| Vector3::new(x, 0.0, 0.0));
        assert_eq!(near.correlation(&against), -1.0);
    }
}
