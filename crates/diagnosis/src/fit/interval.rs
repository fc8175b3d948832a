//! Profile-likelihood intervals of the values that people read.

use effects::Role;

use nalgebra::DMatrix;

use super::descent::{Exactness, Minimum, Start};
use super::member::Member;
use super::problem::Problem;
use crate::DiagnosisError;

/// The 95 % interval of a number, where it closes on both sides.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Interval {
    /// Lower end; of a direction perhaps below 0.
    pub low95: f64,
    /// Upper end; of a direction perhaps above π.
    pub high95: f64,
}

/// A number whose interval is sought.
pub(super) struct Target {
    /// Index of the effect among those moved, and of the value in it.
    pub(super) member: usize,
    pub(super) value: usize,
    pub(super) se: f64,
    /// Variance by the curvature alone over se².
    pub(super) ratio: f64,
    /// Quantile of Student's t.
    pub(super) quantile: f64,
}

/// Refits of a side.
const MOST_REFITS: usize = 8;
/// Share of the quantile from which an end is where a straight line reaches it.
const NEAR: f64 = 0.2;

/// The interval of a number: where the sum, minimised over all others, has risen by t²/ratio.
///
/// The ratio makes the rise that of noise which clusters share; the profile gives the interval its
/// shape. None where the rise is not reached within the range, or all around the circle; a share's
/// interval ends with its range.
///
/// # Errors
/// As a descent.
pub(super) fn interval(
    problem: &Problem,
    minimum: &Minimum,
    target: &Target,
) -> Result<Option<Interval>, DiagnosisError> {
    let space = problem.space.in_values(target.member);
    let k = space.first(target.member) + target.value;
    let values = |x: &[f64]| {
        let of = problem.space.shares(x).map(|(member, own)| member.values(own));
        of.collect::<Vec<_>>()
    };
    let x: Vec<f64> = values(&minimum.at.x)
        .iter()
        .zip(problem.space.shares(&minimum.at.x))
        .enumerate()
        .flat_map(|(index, (values, (_, own)))| match index == target.member {
            true => values.clone(),
            false => own.to_vec(),
        })
        .collect();
    let role = space.members[target.member].parameters()[target.value].role;
    let mut profile = Problem::new(space, problem.whitening, problem.robust.clone());
    profile.frozen.clone_from(&problem.frozen);
    let column = profile.moved().iter().position(|moved| *moved == k);
    let slopes = in_values(problem, minimum, target.member, &x);
    let slopes = column.map_or(slopes.clone(), |column| slopes.remove_column(column));
    profile.frozen[k] = true;
    let (low, high) = match role {
        Role::Direction(_) => (x[k] - HALF_TURN, x[k] + HALF_TURN),
        _ => profile.ranges[k],
    };
    let side = |sign: f64, bound: f64| {
        end(&profile, (&x, &slopes), k, (minimum.at.value, target), sign, bound)
    };
    Ok(match (side(-1.0, low)?, side(1.0, high)?) {
        (Some(low95), Some(high95)) => Some(Interval { low95, high95 }),
        _ => None,
    })
}

/// A direction and its opposite are the same axis.
const HALF_TURN: f64 = std::f64::consts::FRAC_PI_2;

/// Where the root of the rise, in standard errors, reaches the quantile on one side.
fn end(
    profile: &Problem,
    (best, slopes): (&[f64], &DMatrix<f64>),
    k: usize,
    (least, target): (f64, &Target),
    sign: f64,
    bound: f64,
) -> Result<Option<f64>, DiagnosisError> {
    let scale = profile.robust.scale();
    let (mut x, mut slopes) = (best.to_vec(), slopes.clone());
    let mut rise = |value: f64| -> Result<f64, DiagnosisError> {
        x[k] = value;
        let at = profile.stand(x.clone())?;
        let known = Some(slopes.clone());
        let found = profile.descend(Start { at, slopes: known, exactness: Exactness::Sum })?;
        x.copy_from_slice(&found.at.x);
        slopes = found.whole;
        Ok((target.ratio * (found.at.value - least).max(0.0)).sqrt() / scale)
    };
    let room = sign * (bound - best[k]);
    // (distance, rise): below and above the quantile.
    let (mut below, mut above) = ((0.0, 0.0), None::<(f64, f64)>);
    let mut distance = (target.quantile * target.se).min(room);
    for _ in 0..MOST_REFITS {
        let here = (distance, rise(best[k] + sign * distance)?);
        // The rise is nearly in proportion to the distance.
        if (here.1 / target.quantile - 1.0).abs() < NEAR {
            let end = (distance * target.quantile / here.1).min(room);
            return Ok(Some(best[k] + sign * end));
        }
        if here.1 < target.quantile {
            if distance >= room {
                return Ok(profile.shares[k].then_some(bound));
            }
            below = here;
        } else {
            above = Some(here);
        }
        distance = match above {
            Some(above) => {
                let share = (target.quantile - below.1) / (above.1 - below.1);
                below.0 + share.clamp(0.1, 0.9) * (above.0 - below.0)
            }
            None => {
                let slope = if below.0 > 0.0 { below.1 / below.0 } else { 0.0 };
                let ahead = if slope > 0.0 { target.quantile / slope } else { f64::INFINITY };
                ahead.clamp(1.2 * below.0, 3.0 * below.0).min(room)
            }
        };
    }
    Ok(above.map(|above| best[k] + sign * above.0))
}

/// The slopes at a minimum with those of one effect by its values.
fn in_values(problem: &Problem, minimum: &Minimum, index: usize, x: &[f64]) -> DMatrix<f64> {
    let member = &problem.space.members[index];
    let (first, moved) = (problem.space.first(index), problem.moved());
    let values = &x[first..first + member.len()];
    let column = |k: usize| moved.iter().position(|moved| *moved == first + k);
    let mut slopes = minimum.whole.clone();
    for j in 0..member.len() {
        let Some(own) = column(j) else { continue };
        let mut by_value = slopes.column(own) * 0.0;
        for (k, change) in coordinate_slopes(member, values, j).into_iter().enumerate() {
            if let Some(other) = column(k) {
                by_value.axpy(change, &minimum.whole.column(other), 1.0);
            }
        }
        slopes.set_column(own, &by_value);
    }
    slopes
}

/// Step of differences between charts, in secants.
const NUDGE: f64 = 1e-4;

/// How the coordinates of an effect change with one of its values.
fn coordinate_slopes(member: &Member, values: &[f64], k: usize) -> Vec<f64> {
    let step = NUDGE * member.coordinates[k].secant;
    let place = |values: &[f64]| member.effect.info().to_coordinates(values);
    let mut moved = values.to_vec();
    moved[k] += step;
    place(&moved).iter().zip(place(values)).map(|(moved, known)| (moved - known) / step).collect()
}
