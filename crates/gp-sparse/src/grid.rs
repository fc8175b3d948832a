//! A regular grid of nodes, and how a function between them follows from its values there.

use faer::{Mat, MatRef};
use gp_core::GpError;
use gp_core::checks::{check_count, check_positive};

/// Nodes that stand a distance apart along each input; kept are those that some row of data needs.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Grid {
    /// Where the first node stands, one an input.
    pub(crate) first: Vec<f64>,
    pub(crate) spacing: Vec<f64>,
    pub(crate) counts: Vec<usize>,
    /// Numbers on the whole grid of the nodes that are kept, rising.
    pub(crate) nodes: Vec<u32>,
    /// Where each node of the whole grid stands among them.
    places: Vec<u32>,
}

/// The nodes that an input lies among, and their shares: 4 along each input.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stencil {
    pub(crate) nodes: Vec<u32>,
    pub(crate) weights: Vec<f64>,
    along: Vec<[f64; 4]>,
}

const NONE: u32 = u32::MAX;
/// The most inputs: a row meets 4 nodes along each.
pub(crate) const MOST_INPUTS: usize = 4;
/// The most nodes of a whole grid, kept or not.
const MOST_NODES: usize = 1 << 23;

impl Grid {
    /// The finest grid of at most `most_nodes` kept nodes whose spacing is `finest` of the scales or
    /// wider, equally in all inputs.
    ///
    /// - `scales`: over which the function changes, one an input.
    ///
    /// # Errors
    /// `OutOfRange` for too many inputs; `NotPositive`.
    pub(crate) fn finest(
        x: MatRef<'_, f64>,
        scales: &[f64],
        finest: f64,
        most_nodes: usize,
    ) -> Result<Self, GpError> {
        if x.ncols() > MOST_INPUTS {
            return Err(GpError::OutOfRange {
                name: "number of inputs of a grid".to_owned(),
                value: x.ncols() as f64,
                lowest: 1.0,
                highest: MOST_INPUTS as f64,
            });
        }
        check_positive("most_nodes", most_nodes as f64)?;
        let mut ratio = finest;
        loop {
            let spacing: Vec<f64> = scales.iter().map(|scale| ratio * scale).collect();
            let grid = Self::over(x, &spacing);
            if let Some(grid) = grid.filter(|grid| grid.nodes.len() <= most_nodes) {
                return Ok(grid);
            }
            if ratio > 1e9 {
                let expected = 1 << (2 * x.ncols());
                let what = "nodes that a row of data needs, and most_nodes";
                return Err(GpError::ShapeMismatch { what, expected, actual: most_nodes });
            }
            ratio *= WIDER;
        }
    }

    /// A grid over all rows, with one node beyond them on each side; none if it is too large.
    fn over(x: MatRef<'_, f64>, spacing: &[f64]) -> Option<Self> {
        let (mut first, mut counts) = (Vec::new(), Vec::new());
        for (d, spacing) in spacing.iter().enumerate() {
            let [low, high] = x
                .col(d)
                .iter()
                .fold([f64::INFINITY, -f64::INFINITY], |[l, h], x| [l.min(*x), h.max(*x)]);
            let steps = ((high - low) / spacing).ceil().max(1.0);
            if steps > MOST_NODES as f64 {
                return None;
            }
            // What the last step is too long by is shared by both ends.
            first.push(low - spacing - 0.5 * (steps * spacing - (high - low)));
            counts.push(steps as usize + 3);
        }
        let total = counts.iter().try_fold(1_usize, |total, count| total.checked_mul(*count))?;
        if total > MOST_NODES {
            return None;
        }
        let spacing = spacing.to_vec();
        let mut grid = Self { first, spacing, counts, nodes: Vec::new(), places: vec![0; total] };
        let (mut stencil, mut row) = (Stencil::default(), vec![0.0; x.ncols()]);
        let mut is_needed = vec![false; total];
        for i in 0..x.nrows() {
            gp_core::kernel::copy_row(x, i, &mut row);
            if grid.locate(&row, &mut stencil) {
                stencil.nodes.iter().for_each(|&node| is_needed[node as usize] = true);
            }
        }
        grid.nodes = (0..total as u32).filter(|&node| is_needed[node as usize]).collect();
        grid.place();
        Some(grid)
    }

    /// The grid of saved numbers.
    ///
    /// # Errors
    /// `ShapeMismatch`, `NotPositive`, `OutOfRange` for numbers that are no grid.
    pub(crate) fn saved(
        first: Vec<f64>,
        spacing: Vec<f64>,
        counts: Vec<usize>,
        nodes: Vec<u32>,
    ) -> Result<Self, GpError> {
        check_count("spacings of the grid", first.len(), spacing.len())?;
        check_count("counts of the grid", first.len(), counts.len())?;
        spacing.iter().try_for_each(|spacing| check_positive("spacing of the grid", *spacing))?;
        let total = counts.iter().try_fold(1_usize, |total, count| total.checked_mul(*count));
        let total = total.filter(|total| *total <= MOST_NODES && !counts.contains(&0)).unwrap_or(0);
        let is_rising = nodes.is_sorted_by(|a, b| a < b);
        if !is_rising || nodes.last().is_none_or(|last| *last as usize >= total) {
            return Err(GpError::OutOfRange {
                name: "numbers of the grid's nodes".to_owned(),
                value: nodes.last().copied().unwrap_or(0).into(),
                lowest: 0.0,
                highest: total as f64,
            });
        }
        let mut grid = Self { first, spacing, counts, nodes, places: vec![NONE; total] };
        grid.place();
        Ok(grid)
    }

    fn place(&mut self) {
        self.places.fill(NONE);
        for (place, node) in self.nodes.iter().enumerate() {
            self.places[*node as usize] = place as u32;
        }
    }

    /// Nodes kept, M.
    pub(crate) fn n_nodes(&self) -> usize {
        self.nodes.len()
    }

    /// The place among the kept nodes of a number on the whole grid.
    pub(crate) fn place_of(&self, node: i64) -> u32 {
        self.places[node as usize]
    }

    /// Where the kept nodes stand, M×D.
    pub(crate) fn positions(&self) -> Mat<f64> {
        Mat::from_fn(self.nodes.len(), self.counts.len(), |a, d| {
            let below: usize = self.counts[d + 1..].iter().product();
            let step = self.nodes[a] as usize / below % self.counts[d];
            self.first[d] + step as f64 * self.spacing[d]
        })
    }

    /// Fills the stencil with places of kept nodes; `false` where the input is beyond them.
    pub(crate) fn stencil(&self, x: &[f64], stencil: &mut Stencil) -> bool {
        let is_inside = self.locate(x, stencil);
        stencil.nodes.iter_mut().for_each(|node| *node = self.places[*node as usize]);
        is_inside && !stencil.nodes.contains(&NONE)
    }

    /// The same with numbers on the whole grid.
    ///
    /// # Source
    /// Keys, Cubic convolution interpolation for digital image processing (1981): exact for squares.
    fn locate(&self, x: &[f64], stencil: &mut Stencil) -> bool {
        let Stencil { nodes, weights, along } = stencil;
        nodes.clear();
        weights.clear();
        along.clear();
        let mut start = 0;
        for (d, x) in x.iter().enumerate() {
            let t = (x - self.first[d]) / self.spacing[d];
            let last = self.counts[d] as f64 - 2.0;
            if !(t > 1.0 - ROUNDING && t < last + ROUNDING) {
                return false;
            }
            let base = t.floor().clamp(1.0, last - 1.0);
            let u = t - base;
            let (squared, cubed) = (u * u, u * u * u);
            along.push([
                -0.5 * cubed + squared - 0.5 * u,
                1.5 * cubed - 2.5 * squared + 1.0,
                -1.5 * cubed + 2.0 * squared + 0.5 * u,
                0.5 * (cubed - squared),
            ]);
            start = start * self.counts[d] + base as usize - 1;
        }
        nodes.push(start as u32);
        weights.push(1.0);
        let mut stride = 1;
        for (d, shares) in along.iter().enumerate().rev() {
            // The last input varies fastest; blocks of earlier ones follow each other.
            let n = nodes.len();
            for (k, share) in shares.iter().enumerate() {
                for i in 0..n {
                    if k > 0 {
                        nodes.push(nodes[i] + (k * stride) as u32);
                        weights.push(weights[i] * share);
                    }
                }
            }
            weights[..n].iter_mut().for_each(|weight| *weight *= shares[0]);
            stride *= self.counts[d];
        }
        true
    }
}

/// By how much a grid with too many nodes is widened.
const WIDER: f64 = 1.1;
/// By how much of a spacing an input may be beyond the grid.
const ROUNDING: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use faer::Mat;

    use super::{Grid, Stencil};

    #[test]
    fn squares_and_products_are_exact_between_nodes() {
        let x = Mat::from_fn(40, 2, |i, d| (1.7 * (2 * i + d) as f64).sin() * (1.0 + d as f64));
        let grid = Grid::finest(x.as_ref(), &[1.0, 1.5], 0.4, 1000).unwrap();
        let z = grid.positions();
        let f = |a: f64, b: f64| 1.0 + a - 2.0 * b + 0.5 * a * a + a * b - 3.0 * b * b;
        let mut stencil = Stencil::default();
        for i in 0..40 {
            assert!(grid.stencil(&[x[(i, 0)], x[(i, 1)]], &mut stencil));
            assert_eq!(stencil.nodes.len(), 16);
            let terms = stencil.nodes.iter().zip(&stencil.weights);
            let sum: f64 = terms.map(|(&a, w)| w * f(z[(a as usize, 0)], z[(a as usize, 1)])).sum();
            assert!((sum - f(x[(i, 0)], x[(i, 1)])).abs() < 1e-12);
        }
        assert!(!grid.stencil(&[9.0, 0.0], &mut stencil));
    }

    #[test]
    fn only_nodes_near_data_are_kept_and_no_more_than_asked_for() {
        let line = Mat::from_fn(300, 2, |i, _| 0.01 * i as f64);
        let grid = Grid::finest(line.as_ref(), &[1.0, 1.0], 0.05, 400).unwrap();
        let whole: usize = grid.counts.iter().product();
        assert!(grid.n_nodes() <= 400 && 2 * grid.n_nodes() < whole, "{} {whole}", grid.n_nodes());
        assert!(Grid::finest(line.as_ref(), &[1.0, 1.0], 0.1, 5).is_err());
        assert!(Grid::finest(Mat::zeros(3, 5).as_ref(), &[1.0; 5], 0.1, 500).is_err());
    }
}
