//! Which pushes a player should have, where it cannot have all.

use std::collections::BTreeMap;

use diagnosis::{Covariate, CovariateCells, ResidualMap};

use super::maps::{MOST_OPEN, SURE, is_over_place};
use super::{Report, Tried};

/// Most pushes of a group that are asked for.
const MOST: usize = 12;
/// What the groups are.
pub(super) const ARE: &str = "each finding and each cell of the maps that are not folded";

/// The pushes of each finding, and then of each cell of the maps that the page opens with, by their
/// index; those first that are missed most in the sense of all.
pub(super) fn of(report: &Report) -> Vec<Vec<usize>> {
    let axes = CovariateCells::all(&report.all);
    let (mut of_findings, mut of_cells) = (Vec::new(), Vec::new());
    for model in report.models.iter().filter(|model| model.is_of_all) {
        let grouped = Grouped { report, axes: &axes, model };
        let findings = model.found.findings.iter().map(|one| (one.name, &one.region));
        let gathered = model.found.concentrations.iter().map(|one| (one.name, &one.region));
        of_findings.extend(findings.chain(gathered).map(|(name, cells)| grouped.of(name, cells)));
        let maps = || model.found.maps.iter();
        let profiles = maps().filter(|map| map.covariates.len() == 1 && map.p_adjusted <= SURE);
        let open = profiles.take(MOST_OPEN).chain(maps().filter(|map| is_over_place(map)));
        of_cells.extend(open.flat_map(|map| grouped.of_cells(map)));
    }
    of_findings.extend(of_cells);
    of_findings
}

/// What groups of a model are made from.
struct Grouped<'a> {
    report: &'a Report,
    axes: &'a [CovariateCells],
    model: &'a Tried,
}

impl Grouped<'_> {
    fn values(&self, name: &str) -> &[Option<f64>] {
        let known = self.model.residuals.iter().find(|residuals| residuals.name == name);
        known.map_or(&[], |residuals| &residuals.values)
    }

    fn axis(&self, covariate: Covariate) -> Option<&[usize]> {
        let known = self.axes.iter().find(|axis| axis.covariate == covariate);
        known.map(|axis| &axis.cell_of[..])
    }

    fn of(&self, name: &str, region: &[(Covariate, Vec<usize>)]) -> Vec<usize> {
        let ranges: Vec<_> = region
            .iter()
            .filter_map(|(covariate, cells)| Some((self.axis(*covariate)?, cells)))
            .collect();
        let is_in =
            |step: usize| ranges.iter().all(|(cell_of, cells)| cells.contains(&cell_of[step]));
        let values = self.values(name).iter().enumerate();
        let steps = values.filter_map(|(step, value)| Some((step, (*value)?)));
        self.sorted(steps.filter(|(step, _)| is_in(*step)))
    }

    /// A group for each cell of a map, by one pass over all steps.
    fn of_cells(&self, map: &ResidualMap) -> Vec<Vec<usize>> {
        let axes: Vec<&[usize]> =
            map.covariates.iter().filter_map(|covariate| self.axis(*covariate)).collect();
        let mut steps: BTreeMap<Vec<usize>, Vec<(usize, f64)>> = BTreeMap::new();
        for (step, value) in self.values(map.name).iter().enumerate() {
            let cell = axes.iter().map(|cell_of| cell_of[step]).collect();
            if let Some(value) = value {
                steps.entry(cell).or_default().push((step, *value));
            }
        }
        let cells = map.cells.iter().filter_map(|cell| steps.get(&cell.indices));
        cells.map(|steps| self.sorted(steps.iter().copied())).collect()
    }

    fn sorted(&self, steps: impl Iterator<Item = (usize, f64)>) -> Vec<usize> {
        let mut sums: BTreeMap<usize, (f64, f64)> = BTreeMap::new();
        for (step, value) in steps {
            let (sum, n) = sums.entry(self.report.all.push_of(step)).or_default();
            (*sum, *n) = (*sum + value, *n + 1.0);
        }
        let sense = sums.values().map(|(sum, _)| sum).sum::<f64>().signum();
        let means = sums.into_iter().map(|(push, (sum, n))| (push, sense * sum / n));
        let mut pushes: Vec<(usize, f64)> = means.collect();
        pushes.sort_by(|a, b| b.1.total_cmp(&a.1));
        pushes.truncate(MOST);
        pushes.into_iter().map(|(push, _)| push).collect()
    }
}
