//! Where each push would have the size of an effect, all others following.

use nalgebra::{DMatrix, DVector};

use super::Refit;
use super::descent::Minimum;
use super::estimates::is_size;
use crate::statistics::score::pick;

/// What pushes say of an effect's size at a minimum, beside all others that a fit moves. What is no size, as the
/// speed over which friction changes, stays what it is: few pushes would not tell it.
pub(crate) struct Pulls {
    /// How far each number is from "off".
    pub(crate) size: DVector<f64>,
    /// Of each push: the slope of half the sum that it would have fall, and the information on the
    /// numbers. All slopes together are nearly none.
    pub(crate) of_pushes: Vec<(DVector<f64>, DMatrix<f64>)>,
}

impl Refit<'_> {
    /// The pulls on an effect's size; none where it is not moved or the others are not determined.
    pub(crate) fn pulls(&self, id: &str) -> Option<Pulls> {
        let Minimum { at, slopes, weights, curvature, moved, .. } = &self.minimum;
        let numbers = self.problem.space.numbers_of(id)?;
        let member = self.problem.space.members.iter().find(|member| member.id() == id)?;
        let (own, others): (Vec<usize>, Vec<usize>) =
            (0..moved.len()).partition(|column| numbers.contains(&moved[*column]));
        let is_of_size = |column: &usize| is_size(member, moved[*column] - numbers.start);
        let own: Vec<usize> = own.into_iter().filter(is_of_size).collect();
        let off = self.place_with(|other| other == id, |member| member.off.clone());
        let size: Vec<f64> = own.iter().map(|k| at.x[moved[*k]] - off[moved[*k]]).collect();
        let of_others = pick(curvature, &others, &others).cholesky()?;
        let taken = of_others.solve(&pick(curvature, &others, &own));
        let left = slopes.select_columns(&own) - slopes.select_columns(&others) * taken;
        let of_push = |rows: std::ops::Range<usize>| {
            let mut weighted = left.rows(rows.start, rows.len()).into_owned();
            let information_half = weighted.clone();
            for (mut of_row, row) in weighted.row_iter_mut().zip(rows.clone()) {
                of_row *= weights[row];
            }
            let pull = weighted.tr_mul(&at.z.rows(rows.start, rows.len()));
            (pull, information_half.tr_mul(&weighted))
        };
        let of_pushes = self.problem.whitening.rows().into_iter().map(of_push).collect();
        (!own.is_empty()).then_some(Pulls { size: DVector::from_vec(size), of_pushes })
    }
}
