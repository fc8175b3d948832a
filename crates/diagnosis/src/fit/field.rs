//! A fitted field of friction: about which part of the table it is, and where the pushes tell it.

use effects::{Effect, EffectInfo, FrictionField, Role};
use nalgebra::{DMatrix, DVector, Vector2};
use serde::Serialize;

use super::member::Member;
use crate::{Footprints, Observations};

/// What a fit tells of the friction over a table, by how many pushes went there.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrictionFieldFit {
    /// Where objects of two pushes or more lay, of one, and of none; without those that are nowhere within the
    /// field's rectangle.
    pub regions: Vec<FieldRegion>,
}

/// Places of a table that as many pushes tell about.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FieldRegion {
    /// 0, 1, or 2 for two and more.
    pub n_pushes: usize,
    /// Share of the rectangle's area, 0 to 1.
    pub area: f64,
    /// Smallest and largest friction over the nominal one, less 1.
    pub range: [f64; 2],
    /// Standard error of the logarithm of friction, root mean square over the places.
    pub se: f64,
    /// The same before the fit.
    pub prior_sd: f64,
}

/// Places along each axis of the rectangle.
const N_PLACES: usize = 30;

/// Whether it is the effect whose waves these are.
pub(super) fn is_field(about: &EffectInfo) -> bool {
    about.id == FrictionField.info().id
}

/// A field on the rectangle of known values, or else on one about all that pushes touch.
pub(super) fn on_its_table(
    mut member: Member,
    known: Option<Vec<f64>>,
    observations: &Observations,
) -> Member {
    let touched = || {
        let [low, high] = Footprints::of(observations).bounds()?;
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        // To a millimeter, for people read it.
        let sides = [middle.x, middle.y, half.x, half.y].map(|side| (1e3 * side).round() / 1e3);
        Some(sides.to_vec())
    };
    let Some(sides) = known.or_else(touched) else { return member };
    let own = member.start.iter_mut().zip(member.effect.info().parameters);
    for ((value, _), side) in own.filter(|(_, own)| own.role == Role::Reference).zip(sides) {
        *value = side;
    }
    member
}

impl FrictionFieldFit {
    /// Of the values of all parameters of a [`FrictionField`], with their covariance.
    pub(super) fn of(
        values: &[f64],
        covariance: &DMatrix<f64>,
        observations: &Observations,
    ) -> Self {
        let parameters = FrictionField.info().parameters;
        let is_wave = |k: &usize| parameters[*k].role == Role::Wave;
        let waves: Vec<usize> = (0..parameters.len()).filter(is_wave).collect();
        let covariance = covariance.select_rows(&waves).select_columns(&waves);
        let prior = waves.iter().map(|k| parameters[*k].typical.powi(2));
        let prior = DVector::from_iterator(waves.len(), prior);
        let footprints = Footprints::of(observations);
        let mut places: [Vec<(f64, f64, f64)>; 3] = Default::default();
        for k in 0..N_PLACES * N_PLACES {
            let along = |k: usize| (2 * k + 1) as f64 / N_PLACES as f64 - 1.0;
            let x = values[0] + along(k % N_PLACES) * values[2];
            let place_w = Vector2::new(x, values[1] + along(k / N_PLACES) * values[3]);
            let here = FrictionField::waves(values, &place_w);
            let here = DVector::from_column_slice(&here);
            let variances =
                (here.dot(&(&covariance * &here)), here.component_mul(&here).dot(&prior));
            let relative = FrictionField::log_ratio(values, &place_w).exp_m1();
            let n_pushes = footprints.n_pushes_over(&place_w).min(2);
            places[n_pushes].push((relative, variances.0, variances.1));
        }
        let all = (N_PLACES * N_PLACES) as f64;
        let region = |n_pushes: usize| {
            let places = &places[n_pushes];
            let mean = |of: fn(&(f64, f64, f64)) -> f64| {
                (places.iter().map(of).sum::<f64>() / places.len() as f64).sqrt()
            };
            let range =
                places.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| {
                    [low.min(at.0), high.max(at.0)]
                });
            let (se, prior_sd) = (mean(|at| at.1), mean(|at| at.2));
            let area = places.len() as f64 / all;
            (area > 0.0).then_some(FieldRegion { n_pushes, area, range, se, prior_sd })
        };
        Self { regions: [2, 1, 0].into_iter().filter_map(region).collect() }
    }
}
