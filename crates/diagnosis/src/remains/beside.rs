//! What becomes of an effect's size where its origin is free to take any form.

use std::ops::Range;

use effects::Origin;
use nalgebra::{DMatrix, DVector};

use super::columns::Columns;
use super::folds::Folds;
use crate::cut_offs::{MOVED, SURE_BESIDE, SURE_MOVED};
use crate::predict::candidates::Candidate;
use crate::statistics::quantile::normal_of_chi_square;
use crate::statistics::score::pick;

/// An effect of a model beside the free component of its origin, all numbers fitted together to all pushes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Beside {
    pub(crate) id: &'static str,
    pub(crate) origin: Origin,
    /// How far its size moves, as a share of its distance from "off".
    pub(crate) moved: f64,
    /// That in its standard errors.
    pub(crate) moved_sds: f64,
    /// Its distance from "off" there, in its standard errors.
    pub(crate) sds: f64,
}

impl Beside {
    /// Whether something else of its origin may be behind it: its size surely moves.
    pub(crate) fn is_moved(&self) -> bool {
        self.moved >= MOVED && self.moved_sds >= SURE_MOVED
    }

    /// Whether it is what it is whatever else its origin does: it is sure beside that, and of nearly the same size.
    pub(crate) fn stands(&self) -> bool {
        self.moved < MOVED && self.sds >= SURE_BESIDE
    }

    /// Why another cause may be behind it.
    pub(crate) fn sentence(&self) -> String {
        format!(
            "with more freedom of the {} beside it, its size moves by {:.0} % of what it is",
            self.origin.name(),
            100.0 * self.moved
        )
    }
}

/// The effects of a model beside the component of an origin, which they come from; none where that is not
/// determined.
pub(super) fn beside(
    (folds, columns): (&Folds, &Columns),
    (origin, groups): (Origin, &[Range<usize>]),
) -> Option<Vec<Beside>> {
    let fitted = folds.beside(groups, &columns.evens())?;
    let of = |one: &Candidate| {
        let at: Vec<usize> =
            one.coordinates.clone().map(|k| columns.open_of(k)).collect::<Option<_>>()?;
        let size = DVector::from_iterator(
            at.len(),
            one.coordinates.clone().map(|k| columns.distance_from_off(k)),
        );
        let shift = DVector::from_iterator(at.len(), at.iter().map(|k| fitted.shift[*k]));
        let sds = |covariance: &DMatrix<f64>, of: &DVector<f64>| {
            let own = pick(covariance, &at, &at);
            Some(own.cholesky()?.solve(of).dot(of).max(0.0).sqrt())
        };
        let before = sds(&fitted.alone, &size)?;
        // As one number would be as many standard errors off.
        let normal = |sds: f64| normal_of_chi_square(sds * sds, at.len() as f64);
        Some(Beside {
            id: one.effect.info().id,
            origin,
            moved: sds(&fitted.alone, &shift)? / before,
            moved_sds: sds(&fitted.of_shift, &shift).map_or(0.0, normal),
            sds: normal(sds(&(&fitted.alone + &fitted.of_shift), &(size + shift))?),
        })
    };
    Some(columns.in_model_from(origin).filter_map(of).collect())
}
