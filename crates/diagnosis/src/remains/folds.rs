//! Parts of the pushes, each predicted by what is fitted to the others.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use rayon::iter::{IntoParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::columns::Columns;
use super::ridge::Normal;
use crate::fit::Robust;

/// Parts of the clusters.
const N_FOLDS: usize = 5;
/// Share of the numbers that a fit leaves free at least: where it takes more, what is left tells no noise.
const LEAST_FREEDOM: f64 = 0.25;
/// Say of a push below which it is an outlier, and tells no noise.
const LEAST_SAY: f64 = 0.5;

pub(super) struct Folds {
    folds: Vec<Fold>,
    /// All pushes, none of them its own.
    whole: Fold,
    n_pushes: usize,
    /// Of each component's number.
    room: Vec<[f64; 2]>,
}

struct Fold {
    /// What each component's number takes of the open ones, and the open ones without components.
    open: (DMatrix<f64>, DVector<f64>),
    /// Covariance of the open ones without components.
    covariance: DMatrix<f64>,
    /// The components' numbers beside the open ones, of all other pushes.
    others: Normal,
    /// Of each push of its own: what the open numbers alone leave, and what each number of a component adds
    /// while they follow.
    own: Vec<(usize, DVector<f64>, DMatrix<f64>)>,
}

/// Open numbers beside components, fitted to all pushes.
pub(super) struct FittedBeside {
    /// By what the components move them.
    pub(super) shift: DVector<f64>,
    /// Covariance of that.
    pub(super) of_shift: DMatrix<f64>,
    /// Covariance of the open numbers without components.
    pub(super) alone: DMatrix<f64>,
}

/// What a component gains in each row of each push, in nats.
pub(super) struct Gains {
    pub(super) of_rows: Vec<DVector<f64>>,
    /// Squares without the component.
    square: f64,
}

impl Folds {
    /// Of whole clusters, each a list of pushes; `rows` are those of each push. None where some part leaves
    /// the open numbers undetermined.
    pub(super) fn new(
        columns: &Columns,
        (rows, mut clusters): (Vec<Range<usize>>, Vec<Vec<usize>>),
        seed: u64,
    ) -> Option<Self> {
        clusters.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
        let (pushes, _) = weighted(columns, &rows);
        let part = |fold: usize| clusters.iter().skip(fold).step_by(N_FOLDS).flatten().copied();
        let parts: Vec<Vec<usize>> = (0..N_FOLDS).map(|fold| part(fold).collect()).collect();
        let products: Vec<DMatrix<f64>> =
            parts.par_iter().map(|part| product(&pushes, part)).collect();
        let zero = DMatrix::zeros(products[0].nrows(), products[0].ncols());
        let whole = products.iter().fold(zero, |sum, part| sum + part);
        let fold = |(part, own): (&Vec<usize>, &DMatrix<f64>)| {
            Fold::new(&pushes, part, &(&whole - own), &columns.beliefs())
        };
        let folds = parts.iter().zip(&products).map(fold).collect::<Option<_>>()?;
        let all = Fold::new(&pushes, &[], &whole, &columns.beliefs())?;
        Some(Self { folds, whole: all, n_pushes: pushes.len(), room: columns.room() })
    }

    /// The groups' variances by each fold; none where they are not determined.
    pub(super) fn variances(&self, groups: &[Range<usize>]) -> Option<Vec<Vec<f64>>> {
        let (columns, groups) = packed(groups);
        self.folds.par_iter().map(|fold| fold.others.of(&columns).variances(&groups)).collect()
    }

    /// What groups of columns gain where they have these variances in each fold.
    pub(super) fn gains(&self, groups: &[Range<usize>], variances: &[Vec<f64>]) -> Option<Gains> {
        let (columns, groups) = packed(groups);
        let mut found = Gains { of_rows: vec![DVector::zeros(0); self.n_pushes], square: 0.0 };
        for (fold, variances) in self.folds.iter().zip(variances) {
            let change = fold.others.of(&columns).mean(&groups, variances)?;
            for (push, left, added) in &fold.own {
                let mut then = left.clone();
                for (column, change) in columns.iter().zip(&change) {
                    let [least, most] = self.room[*column];
                    then.axpy(-change.max(least).min(most), &added.column(*column), 1.0);
                }
                found.square += left.norm_squared();
                found.of_rows[*push] =
                    left.zip_map(&then, |left, then| 0.5 * (left * left - then * then));
            }
        }
        Some(found)
    }

    /// The open numbers beside groups of columns, as large as makes all pushes likeliest; `evens` has the open number
    /// that a column adds to everywhere. None where they are not determined.
    pub(super) fn beside(
        &self,
        groups: &[Range<usize>],
        evens: &[Option<usize>],
    ) -> Option<FittedBeside> {
        let (columns, groups) = packed(groups);
        let others = self.whole.others.of(&columns);
        let variances = others.variances(&groups)?;
        let change = others.mean(&groups, &variances)?;
        let mut precision = others.information.clone();
        for (group, variance) in groups.iter().zip(&variances) {
            group.clone().for_each(|k| precision[(k, k)] += variance.recip());
        }
        let (shares, _) = &self.whole.open;
        let taken = |row: usize, column: usize| {
            let adds = evens[columns[column]] == Some(row);
            f64::from(u8::from(adds)) - shares[(row, columns[column])]
        };
        let moves = DMatrix::from_fn(shares.nrows(), columns.len(), taken);
        let of_shift = &moves * precision.cholesky()?.solve(&moves.transpose());
        let alone = self.whole.covariance.clone();
        Some(FittedBeside { shift: &moves * change, of_shift, alone })
    }

    /// What groups of columns gain alone.
    pub(super) fn alone(&self, groups: &[Range<usize>]) -> Option<Gains> {
        self.gains(groups, &self.variances(groups)?)
    }
}

/// Pushes, each with what is left of its numbers, in SI units.
pub(super) type LeftOfPushes = Vec<(usize, DVector<f64>)>;

/// What is left of each push where every origin has its component and the open numbers are fitted, in SI
/// units, made larger by what a fit of so many numbers takes of the noise; without pushes that hardly have a
/// say in a robust fit. None where the numbers are not determined.
pub(super) fn left_by_all(columns: &Columns, rows: &[Range<usize>]) -> Option<LeftOfPushes> {
    let (pushes, says) = weighted(columns, rows);
    let all: Vec<usize> = (0..pushes.len()).collect();
    let beliefs = columns.beliefs();
    let whole = Fold::new(&pushes, &[], &product(&pushes, &all), &beliefs)?;
    let mut groups = columns.origins.concat();
    groups.push(columns.smooth.clone());
    groups.retain(|group| !group.is_empty());
    let variances = whole.others.variances(&groups)?;
    let change = whole.others.mean(&groups, &variances)?;
    let n: usize = rows.iter().map(Range::len).sum();
    let n_free = whole.others.determined(&groups, &variances)? + beliefs.len() as f64;
    let growth = (n as f64 / (n as f64 - n_free).max(LEAST_FREEDOM * n as f64)).sqrt();
    let (shares, estimate) = &whole.open;
    let open = estimate - shares * &change;
    let of_push = |push: usize| {
        if says[push] < LEAST_SAY {
            return None;
        }
        let plain = columns.plain(push);
        let of_open = plain.columns(1, open.len()) * &open;
        let of_components = plain.columns(1 + open.len(), change.len()) * &change;
        Some((push, (plain.column(0) - of_open - of_components) * growth))
    };
    Some((0..rows.len()).into_par_iter().filter_map(of_push).collect())
}

impl Gains {
    /// Share of the squares that is taken off.
    pub(super) fn share_of_square(&self) -> f64 {
        let falls: f64 = self.of_rows.iter().map(|gains| 2.0 * gains.sum()).sum();
        (falls / self.square).clamp(0.0, 1.0)
    }
}

impl Fold {
    /// `product` is that of all columns, over the pushes of the other folds; none where the open numbers are
    /// not determined.
    fn new(
        pushes: &[DMatrix<f64>],
        own: &[usize],
        product: &DMatrix<f64>,
        beliefs: &[f64],
    ) -> Option<Self> {
        let n_open = beliefs.len();
        let n = product.ncols() - 1 - n_open;
        let mut open = product.view((1, 1), (n_open, n_open)).into_owned();
        beliefs.iter().enumerate().for_each(|(k, precision)| open[(k, k)] += precision);
        let open = open.cholesky()?;
        let cross = product.view((1, 1 + n_open), (n_open, n)).into_owned();
        let right = product.view((1, 0), (n_open, 1)).column(0).into_owned();
        let (shares, estimate) = (open.solve(&cross), open.solve(&right));
        let information = product.view((1 + n_open, 1 + n_open), (n, n)) - cross.tr_mul(&shares);
        let pull = product.view((1 + n_open, 0), (n, 1)).column(0) - shares.tr_mul(&right);
        let of_push = |push: &usize| {
            let all = &pushes[*push];
            let of_open = all.columns(1, n_open);
            let left = all.column(0) - of_open * &estimate;
            (*push, left, all.columns(1 + n_open, n) - of_open * &shares)
        };
        let own = own.par_iter().map(of_push).collect();
        let covariance = open.inverse();
        Some(Self {
            open: (shares, estimate),
            covariance,
            others: Normal { information, pull },
            own,
        })
    }
}

/// Whitened columns of each push, with the say that its rows have in a robust fit and in units of the
/// typical residual; and the say of each push as a whole.
fn weighted(columns: &Columns, rows: &[Range<usize>]) -> (Vec<DMatrix<f64>>, Vec<f64>) {
    let mut pushes: Vec<DMatrix<f64>> =
        (0..rows.len()).into_par_iter().map(|push| columns.of_push(push)).collect();
    let residuals: Vec<f64> =
        pushes.iter().flat_map(|push| push.column(0).iter().copied().collect::<Vec<_>>()).collect();
    let residuals = DVector::from_vec(residuals);
    let robust = Robust::at(rows, &residuals);
    let weights = robust.weights(&residuals).map(f64::sqrt);
    let say = |rows: &Range<usize>| {
        let of_rows = [&weights.component_mul(&residuals), &residuals]
            .map(|all| all.rows(rows.start, rows.len()).norm());
        of_rows[0] / of_rows[1].max(f64::MIN_POSITIVE)
    };
    let says = rows.iter().map(say).collect();
    let weights = weights / robust.scale();
    for (push, rows) in pushes.iter_mut().zip(rows) {
        let of_push = weights.rows(rows.start, rows.len());
        push.column_iter_mut().for_each(|mut column| column.component_mul_assign(&of_push));
    }
    (pushes, says)
}

fn product(pushes: &[DMatrix<f64>], part: &[usize]) -> DMatrix<f64> {
    let n = pushes[0].ncols();
    let mut sum = DMatrix::zeros(n, n);
    for push in part.iter().map(|push| &pushes[*push]) {
        sum.gemm(1.0, &push.transpose(), push, 1.0);
    }
    sum
}

/// The columns of groups one after the other, and the groups among them.
fn packed(groups: &[Range<usize>]) -> (Vec<usize>, Vec<Range<usize>>) {
    let columns: Vec<usize> = groups.iter().flat_map(Clone::clone).collect();
    let mut start = 0;
    let packed = groups.iter().map(|group| {
        start += group.len();
        start - group.len()..start
    });
    let packed = packed.collect();
    (columns, packed)
}
