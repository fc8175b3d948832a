//! From a minimum to estimates that people read.

use effects::{Channels, Off, Role, Setting};
use models::{Description, ModelEffect};
use nalgebra::{DMatrix, DVector};

use super::descent::Minimum;
use super::field::{FrictionFieldFit, is_field};
use super::fitted_model::put;
use super::free_spread::FreeSpread;
use super::member::{CHART_STEP, Member, Part};
use super::problem::Problem;
use super::resemblance::{Resemblance, resemblances};
use super::sandwich::sandwich;
use super::search::Found;
use super::{EffectFit, Fit, FitSettings, Interval, NuisanceFit, ParameterFit};
use crate::cut_offs::{ALIKE, CLUSTERS_A_NUMBER, NAME};
use crate::statistics::quantile::{fisher_tail, student_975, student_tail};
use crate::undetermined::Undetermined;
use crate::{DiagnosisError, Observations};

/// A 95 % interval in standard errors.
const WIDTH: f64 = 3.92;

/// A minimum with what it leaves open.
struct Ending<'a> {
    problem: &'a Problem<'a>,
    before: &'a Minimum,
    minimum: Minimum,
    /// Of the numbers that were moved.
    covariance: DMatrix<f64>,
    /// The pushes of each cluster.
    clusters: Vec<Vec<usize>>,
}

pub(super) fn estimates(
    problem: &Problem,
    found: &Found,
    observations: &Observations,
    model: &Description,
    settings: &FitSettings,
) -> Result<Fit, DiagnosisError> {
    let ending = Ending::of(problem, found, observations)?;
    let minimum = &ending.minimum;
    let members = || problem.space.members.iter().enumerate();
    let asked = members().filter(|(_, member)| member.part == Part::Asked);
    let effects = asked.map(|(index, _)| ending.effect(index, settings));
    let mut asked = members().filter(|(_, member)| member.part == Part::Asked);
    let field = asked.find(|(_, member)| is_field(member.effect.info()));
    let field = field.map(|(index, _)| ending.values(index));
    let nuisances = members().filter(|(_, member)| member.part == Part::Nuisance);
    let names = problem.space.of_each(
        |member| {
            let names = member.coordinates.iter().map(|c| format!("{} {}", member.id(), c.name));
            names.collect()
        },
        FreeSpread::name,
    );
    let n_data = problem.whitening.n_numbers();
    let rms = |minimum: &Minimum| {
        (minimum.at.z.rows(0, n_data).norm_squared() / n_data.max(1) as f64).sqrt()
    };
    let source = observations.source();
    Ok(Fit {
        description: ending.description(model, &source, |part| part != Part::Nuisance)?,
        with_nuisances: ending.description(model, &source, |_| true)?,
        effects: effects.collect::<Result<_, _>>()?,
        nuisances: nuisances.flat_map(|(index, _)| ending.nuisance(index, settings)).collect(),
        field: field
            .map(|(values, covariance)| FrictionFieldFit::of(&values, &covariance, observations)),
        coordinates: minimum.moved.iter().map(|k| names[*k].clone()).collect(),
        covariance: ending.covariance.clone(),
        cluster: observations.cluster,
        n_clusters: ending.clusters.len(),
        n_pushes: observations.pushes().len(),
        n_steps: observations.n_steps(),
        whitened_rms: [rms(&found.before), rms(minimum)],
        scale: problem.robust.scale(),
        iterations: minimum.iterations,
        decrement: minimum.decrement,
    })
}

/// The model with what was asked for, and the same with its nuisances.
pub(super) fn descriptions(
    problem: &Problem,
    found: &Found,
    observations: &Observations,
    model: &Description,
) -> Result<[Description; 2], DiagnosisError> {
    let ending = Ending::of(problem, found, observations)?;
    let source = observations.source();
    let asked = ending.description(model, &source, |part| part != Part::Nuisance)?;
    Ok([asked, ending.description(model, &source, |_| true)?])
}

impl<'a> Ending<'a> {
    fn of(
        problem: &'a Problem<'a>,
        found: &'a Found,
        observations: &Observations,
    ) -> Result<Self, DiagnosisError> {
        let (before, minimum) = (&found.before, problem.between_edges(&found.after));
        let covariance = sandwich(problem, &minimum, observations)?;
        let clusters = observations.pushes_of_clusters();
        Ok(Self { problem, before, minimum, covariance, clusters })
    }
}

impl Ending<'_> {
    /// The place of a member's numbers, and the columns of those that were moved.
    fn own(&self, index: usize) -> (Vec<f64>, Vec<Option<usize>>) {
        let first = self.problem.space.first(index);
        let own = first..first + self.problem.space.members[index].len();
        let column = |k: usize| self.minimum.moved.iter().position(|moved| *moved == k);
        (self.minimum.at.x[own.clone()].to_vec(), own.map(column).collect())
    }

    /// The part of a matrix that is a member's; 0 for numbers that were not moved.
    fn block(&self, columns: &[Option<usize>], matrix: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(columns.len(), columns.len(), |i, j| match (columns[i], columns[j]) {
            (Some(i), Some(j)) => matrix[(i, j)],
            _ => 0.0,
        })
    }

    /// The values of a member, with their covariance by clusters.
    fn values(&self, index: usize) -> (Vec<f64>, DMatrix<f64>) {
        let member = &self.problem.space.members[index];
        let (x, columns) = self.own(index);
        let slopes = member.value_slopes(&x);
        let of_numbers = self.block(&columns, &self.covariance);
        (member.values(&x), &slopes * of_numbers * slopes.transpose())
    }

    fn effect(&self, index: usize, settings: &FitSettings) -> Result<EffectFit, DiagnosisError> {
        let member = &self.problem.space.members[index];
        let p = self.p(index)?;
        let resemblances = match settings.resemblances {
            true => resemblances(self.problem, &self.minimum, index)?,
            false => Vec::new(),
        };
        let unseen = self.unseen(index);
        let has_intervals = unseen.is_none() && (p <= NAME || !has_direction(member));
        let (values, covariance) = self.values(index);
        let mut parameters = Vec::new();
        for (k, (parameter, value)) in member.parameters().iter().zip(values).enumerate() {
            let mut se = covariance[(k, k)].sqrt();
            let interval = match parameter.role {
                Role::Threshold => Some(self.limits(index, k)?),
                _ if has_intervals => self.interval(member.range_of(k), value, se),
                _ => None,
            };
            if let (Role::Threshold, Some(Interval { low95, high95 })) = (parameter.role, interval)
            {
                se = (high95 - low95) / WIDTH;
            }
            let off = (parameter.off != Off::Undefined).then(|| member.off[k]);
            let (name, unit) = (parameter.name, parameter.unit);
            parameters.push(ParameterFit { name, unit, off, value, se, interval });
        }
        let undetermined =
            unseen.or_else(|| alike(&resemblances)).or_else(|| open(member, &parameters));
        let follows = self.follows(index);
        Ok(EffectFit { id: member.id(), parameters, follows, p, resemblances, undetermined })
    }

    /// The values of a limit that are as good as the best.
    fn limits(&self, member: usize, own: usize) -> Result<Interval, DiagnosisError> {
        let k = self.problem.space.first(member) + own;
        let parameter = &self.problem.space.members[member].parameters()[own];
        self.problem.limits(&self.minimum.at.x, k, parameter)
    }

    /// The interval by a standard error, within a range; none without one.
    fn interval(&self, (low, high): (f64, f64), value: f64, se: f64) -> Option<Interval> {
        let reach = student_975(self.clusters.len() as f64 - 1.0) * se;
        let (low95, high95) = ((value - reach).max(low), (value + reach).min(high));
        (se > 0.0).then_some(Interval { low95, high95 })
    }

    /// What follows from where the object rests.
    fn follows(&self, index: usize) -> Vec<ParameterFit> {
        let member = &self.problem.space.members[index];
        let (x, columns) = self.own(index);
        let Some(told) = member.support(&x) else { return Vec::new() };
        let mut slopes = DMatrix::zeros(told.len(), x.len());
        for (k, coordinate) in member.coordinates.iter().enumerate() {
            let mut moved = x.clone();
            moved[k] -= CHART_STEP * coordinate.secant;
            for (row, (moved, at)) in member.support(&moved).iter().flatten().zip(&told).enumerate()
            {
                slopes[(row, k)] = (at - moved) / (CHART_STEP * coordinate.secant);
            }
        }
        let covariance = &slopes * self.block(&columns, &self.covariance) * slopes.transpose();
        let names = [
            ("center of friction x", f64::NEG_INFINITY),
            ("center of friction y", f64::NEG_INFINITY),
            ("mean distance c", 0.0),
        ];
        let one = |(k, ((name, least), value)): (usize, ((&'static str, f64), f64))| {
            let se = covariance[(k, k)].sqrt();
            let interval = self.interval((least, f64::INFINITY), value, se);
            ParameterFit { name, unit: "m", off: None, value, se, interval }
        };
        names.into_iter().zip(told).enumerate().map(one).collect()
    }

    /// Probability of an estimate as far from "off": Wald's test by the covariance of clusters, with
    /// Hotelling's distribution, for the covariance is itself an estimate; of hardly more clusters than
    /// numbers it tells nothing. For a switch, the test of the mean gain of a cluster.
    fn p(&self, index: usize) -> Result<f64, DiagnosisError> {
        let member = &self.problem.space.members[index];
        let has_no_way = member.switches().iter().any(|is_switch| *is_switch)
            || member.is_mixture()
            || !member.thresholds().is_empty();
        if has_no_way {
            return Ok(self.p_of_gain());
        }
        let (x, columns) = self.own(index);
        let off = member.place(&member.off);
        let sized = |k: &usize| is_size(member, *k) && columns[*k].is_some();
        let sized: Vec<usize> = (0..x.len()).filter(sized).collect();
        let block = self.block(&columns, &self.covariance);
        let covariance = block.select_rows(&sized).select_columns(&sized);
        let distance = DVector::from_iterator(sized.len(), sized.iter().map(|k| x[*k] - off[*k]));
        let Some(factor) = covariance.cholesky().filter(|_| !sized.is_empty()) else {
            return Ok(1.0);
        };
        let (n, freedom) = (self.clusters.len() as f64, sized.len() as f64);
        if n < CLUSTERS_A_NUMBER * freedom {
            return Ok(1.0);
        }
        let square = distance.dot(&factor.solve(&distance));
        let per_freedom = square * (n - freedom) / (freedom * (n - 1.0));
        Ok(fisher_tail(per_freedom, freedom, n - freedom))
    }

    fn p_of_gain(&self) -> f64 {
        let robust = &self.problem.robust;
        let [before, after] =
            [self.before, &self.minimum].map(|minimum| robust.of_pushes(&minimum.at.z));
        let of_push: Vec<f64> =
            before.iter().zip(after).map(|(before, after)| before - after).collect();
        p_of_mean(&of_push, &self.clusters)
    }

    /// Whether the data do not show the effect at all.
    fn unseen(&self, index: usize) -> Option<Undetermined> {
        let Problem { space, whitening, robust, .. } = self.problem;
        let member = &space.members[index];
        let about = member.effect.info();
        let n_pushes = whitening.rows().len();
        let numbers = (0..n_pushes).flat_map(|push| whitening.entries(push));
        let mut channels = numbers.map(|(_, number)| Channels::KINDS[*number]);
        if !channels.any(|channel| about.reaches.contains(&channel)) {
            return Some(Undetermined::NoChannel { shown_in: about.reaches.to_vec() });
        }
        let ((x, columns), off) = (self.own(index), member.place(&member.off));
        let Minimum { slopes, weights, .. } = &self.minimum;
        let shows = |(k, (column, coordinate)): (usize, (&Option<usize>, &effects::Coordinate))| {
            let Some(column) = column else { return true };
            let rows = 0..whitening.n_numbers();
            let of_row = |row: usize| weights[row] * slopes[(row, *column)].powi(2);
            let information = rows.map(of_row).sum::<f64>() / robust.scale().powi(2);
            (2.0 * coordinate.secant).max((x[k] - off[k]).abs()) * information.sqrt() > 1.0
        };
        let coordinates = columns.iter().zip(&member.coordinates).enumerate();
        let mut sizes = coordinates.filter(|(k, _)| is_size(member, *k));
        (!sizes.any(shows)).then_some(Undetermined::Invisible)
    }

    fn nuisance(&self, index: usize, settings: &FitSettings) -> Vec<NuisanceFit> {
        let member = &self.problem.space.members[index];
        let (values, covariance) = self.values(index);
        let parameters = member.parameters().iter().zip(values).enumerate();
        let of = |(k, (parameter, value)): (usize, (&effects::Parameter, f64))| NuisanceFit {
            id: member.id(),
            name: parameter.name,
            unit: parameter.unit,
            nominal: member.start[k],
            tolerance: settings.tolerances.of(member.effect.info()).filter(|sd| sd.is_finite()),
            value,
            se: covariance[(k, k)].sqrt(),
        };
        parameters.map(of).collect()
    }

    /// The model with the estimates of some of its members.
    fn description(
        &self,
        model: &Description,
        source: &str,
        is_kept: impl Fn(Part) -> bool,
    ) -> Result<Description, DiagnosisError> {
        let mut model = model.clone();
        for (index, member) in self.problem.space.members.iter().enumerate() {
            if !is_kept(member.part) {
                continue;
            }
            let (values, covariance) = self.values(index);
            let mut effect = ModelEffect::from(Setting::new(member.effect.info(), &values));
            for (k, parameter) in member.parameters().iter().enumerate() {
                if let Some(estimate) = effect.parameters.get_mut(parameter.name) {
                    (estimate.se, estimate.source) = (covariance[(k, k)].sqrt(), source.to_owned());
                }
            }
            put(&mut model, effect)?;
        }
        Ok(model)
    }
}

/// Probability, were the mean gain of a cluster 0, of gains as large as those of some pushes.
fn p_of_mean(of_push: &[f64], clusters: &[Vec<usize>]) -> f64 {
    let sum = |pushes: &Vec<usize>| pushes.iter().map(|push| of_push[*push]).sum::<f64>();
    let gains: Vec<f64> = clusters.iter().map(sum).collect();
    let n = gains.len() as f64;
    let mean = gains.iter().sum::<f64>() / n;
    let variance = gains.iter().map(|gain| (gain - mean).powi(2)).sum::<f64>() / (n - 1.0);
    student_tail(mean / (variance / n).sqrt().max(f64::MIN_POSITIVE), n - 1.0)
}

/// Whether a coordinate tells how large the effect is: not so a direction or a reference.
pub(super) fn is_size(member: &Member, k: usize) -> bool {
    let parameter = &member.parameters()[k];
    parameter.off != Off::Undefined || matches!(parameter.role, Role::Direction(_))
}

/// Whether the effect has a direction that is not defined when it is off.
fn has_direction(member: &Member) -> bool {
    member.parameters().iter().any(|parameter| matches!(parameter.role, Role::Direction(_)))
}

fn alike(resemblances: &[Resemblance]) -> Option<Undetermined> {
    let nearest = resemblances.iter().max_by(|a, b| a.correlation.total_cmp(&b.correlation))?;
    let Resemblance { id: other, correlation, when } = *nearest;
    (correlation > ALIKE).then_some(Undetermined::LooksLike { other, correlation, when })
}

/// A size that the data leave open; a reference, as the speed at which a law sets in, may be, and so may how far a
/// limit reaches beyond the last step that shows it.
fn open(member: &Member, parameters: &[ParameterFit]) -> Option<Undetermined> {
    if member.is_mixture() {
        return None;
    }
    let (switches, shares) = (member.switches(), member.shares());
    let is_open = |(k, fitted): &(usize, &ParameterFit)| {
        let (low, high) = member.range_of(*k);
        // An interval that reaches "off" says that the effect may not be there, which its p does as well.
        let is_end = |end: f64| end != member.off[*k];
        let is_limit = member.parameters()[*k].role == Role::Threshold;
        let reaches = |ends: Interval| {
            ends.low95 <= low && is_end(low) || ends.high95 >= high && is_end(high) && !is_limit
        };
        let is_at_bound = fitted.se == 0.0;
        is_size(member, *k)
            && !switches[*k]
            && (is_at_bound || !shares[*k] && fitted.interval.is_some_and(reaches))
    };
    let open = parameters.iter().enumerate().find(is_open);
    open.map(|(_, parameter)| Undetermined::Open { parameter: parameter.name })
}

#[cfg(test)]
mod tests {
    use effects::{Rig, Surface, by_id};

    use super::{open, p_of_mean};
    use crate::fit::member::{Member, Part};
    use crate::{Interval, ParameterFit, Undetermined};

    #[test]
    fn a_size_is_open_to_the_ends_of_its_range_but_not_to_off() {
        let rig = Rig::new(Surface::Ellipsoid, 0.25, 0.3).unwrap();
        let is_open = |id: &str, low95: f64, high95: f64| {
            let effect = by_id(id).unwrap();
            let member = Member::new(effect, Part::Asked, &effect.info().off(&rig), &rig);
            let parameter = &member.parameters()[0];
            let (name, unit, value) = (parameter.name, parameter.unit, 0.5 * (low95 + high95));
            let interval = Some(Interval { low95, high95 });
            let fitted = ParameterFit { name, unit, off: None, value, se: 0.1 * value, interval };
            open(&member, &[fitted]) == Some(Undetermined::Open { parameter: name })
        };
        let range = |id: &str| by_id(id).unwrap().info().parameters[0].range;
        let (least, most) = range("pusher-friction");
        assert!(!is_open("pusher-friction", 0.2, 0.3));
        assert!(is_open("pusher-friction", least, 0.3) && is_open("pusher-friction", 0.2, most));
        let (off, most) = range("pusher-compliance");
        assert!(!is_open("pusher-compliance", off, 1e-5));
        assert!(is_open("pusher-compliance", 1e-6, most));
        assert!(!is_open("vertex-contact", 5e-3, range("vertex-contact").1));
    }

    #[test]
    fn pushes_that_repeat_their_session_make_no_switch_surer() {
        let of_session = [3.0, -1.0, 2.5, 4.0, 0.5, -2.0, 1.0, 3.5, 2.0, -0.5, 1.5, 0.0];
        let alone: Vec<Vec<usize>> = (0..12).map(|push| vec![push]).collect();
        let five: Vec<Vec<usize>> = (0..12).map(|k| (5 * k..5 * k + 5).collect()).collect();
        let gains: Vec<f64> = (0..60).map(|push| 0.2 * of_session[push / 5]).collect();
        let (one, many) = (p_of_mean(&of_session, &alone), p_of_mean(&gains, &five));
        assert!((one / many - 1.0).abs() < 1e-12, "{one} {many}");
        // Student's t of 2.2308 with eleven degrees.
        assert!((one - 0.023_731).abs() < 1e-6, "{one}");
        assert_eq!(p_of_mean(&[5.0, 5.0], &[vec![0, 1]]), 1.0);
    }
}
