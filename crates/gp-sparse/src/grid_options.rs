//! How the nodes of a process are placed, and how its parameters are learnt.

use faer::MatRef;
use gp_core::checks::{check_not_negative, check_positive, check_range};
use gp_core::{GpError, HyperPrior, Kernel, Mean, Role};

use crate::grid::Grid;
use crate::grid_sums::GridSums;
use crate::placement::spread;

/// How the nodes are placed, and how parameters are learnt on them.
#[derive(Clone, Debug, PartialEq)]
pub struct GridOptions {
    /// The most nodes: an evaluation costs their cube.
    pub most_nodes: usize,
    /// Nodes are no nearer to each other than this share of a lengthscale.
    pub finest_spacing: f64,
    /// The mean, of degree 2 at most.
    pub mean: Mean,
    /// Variance of a noise on the nodes over their prior variance, as in
    /// [`SparseSettings::jitter`](crate::SparseSettings).
    pub jitter: f64,
    /// Rows of the exact process on a random part of the data, from which parameters start and the
    /// lengthscales of the spacing come.
    pub warm_start_rows: usize,
    /// Seed of all that is drawn.
    pub seed: u64,
    /// Most quasi-Newton iterations.
    pub max_iterations: usize,
    /// Largest component of the gradient at convergence, in nats per log-parameter.
    pub gradient_tolerance: f64,
    /// What is known of the hyperparameters before the data.
    pub prior: HyperPrior,
}

impl Default for GridOptions {
    fn default() -> Self {
        Self {
            most_nodes: 900,
            finest_spacing: 0.2,
            mean: Mean::Estimated,
            jitter: 1e-8,
            warm_start_rows: 300,
            seed: 0,
            max_iterations: 200,
            gradient_tolerance: 0.1,
            prior: HyperPrior::Flat,
        }
    }
}

/// The grid for a kernel, and the rows summed on it.
pub(crate) fn summed(
    kernel: &dyn Kernel,
    x: MatRef<'_, f64>,
    y: &[f64],
    options: &GridOptions,
) -> Result<(Grid, GridSums), GpError> {
    options.mean.check()?;
    let degree = options.mean.degree().unwrap_or(0);
    check_range("degree of the mean on a grid", f64::from(degree), 0.0, 2.0)?;
    check_positive("finest_spacing", options.finest_spacing)?;
    check_not_negative("jitter", options.jitter)?;
    let scales = lengthscales(kernel, x);
    let grid = Grid::finest(x, &scales, options.finest_spacing, options.most_nodes)?;
    let sums = GridSums::new(&grid, x, y)?;
    Ok((grid, sums))
}

/// The shortest lengthscale or period of each input; its spread where the kernel has none.
pub(crate) fn lengthscales(kernel: &dyn Kernel, x: MatRef<'_, f64>) -> Vec<f64> {
    let parameters = kernel.parameters();
    let of_input = |d: usize| {
        let lengths = parameters.iter().filter_map(|parameter| match &parameter.role {
            Role::Lengthscale { inputs } => Some((inputs, parameter.value)),
            Role::Period { inputs } => Some((inputs, 0.2 * parameter.value)),
            _ => None,
        });
        let own = lengths.filter(|(inputs, _)| inputs.is_empty() || inputs.contains(&d));
        let shortest = own.map(|(_, value)| value).fold(f64::INFINITY, f64::min);
        // A function that changes less than its inputs' range needs nodes no farther apart.
        shortest.min(2.0 * spread(x, d))
    };
    (0..x.ncols()).map(of_input).collect()
}
