//! Limits that a step is on one side of: predictions jump there, so values are tried.

use effects::Parameter;

use super::Interval;
use super::member::Part;
use super::problem::Problem;
use crate::DiagnosisError;

/// Values tried before the gaps beside the best are halved.
pub(crate) const N_LIMITS: usize = 19;
/// These, in the typical one.
const TRIED: [f64; N_LIMITS] = [
    0.0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0, 1.25, 1.5, 1.75, 2.0, 2.5, 3.0, 4.0,
    6.0, 8.0, 10.0,
];
/// Times that the gaps beside the best one are halved.
const HALVINGS: usize = 3;
/// Rise of the sum at the ends of a 95 % interval, in squares of the typical residual.
const RISE: f64 = 3.841;

/// A limit at the values that were tried, in rising order, with the sum at each.
type Tried = Vec<(f64, f64)>;

impl Problem<'_> {
    /// The place with the limits that were asked for at their best values, the others as they are.
    ///
    /// # Errors
    /// What a prediction refuses.
    pub(super) fn limited(&self, mut x: Vec<f64>) -> Result<Vec<f64>, DiagnosisError> {
        for (index, member) in self.space.members.iter().enumerate() {
            if member.part == Part::Nuisance {
                continue;
            }
            for own in member.thresholds() {
                let k = self.space.first(index) + own;
                let here = self.stand(x.clone())?.value;
                let tried = self.tried(&x, k, &member.parameters()[own])?;
                x[k] = tried.iter().fold((x[k], here), |a, b| if b.1 < a.1 { *b } else { a }).0;
            }
        }
        Ok(x)
    }

    /// From the value of a limit to those under which the sum, at the others' values, is as good as the
    /// best; up to the end of its range where no step lies beyond the best.
    ///
    /// # Errors
    /// What a prediction refuses.
    pub(super) fn limits(
        &self,
        x: &[f64],
        k: usize,
        parameter: &Parameter,
    ) -> Result<Interval, DiagnosisError> {
        let tried = self.tried(x, k, parameter)?;
        let least = tried.iter().map(|tried| tried.1).fold(f64::INFINITY, f64::min);
        let enough = least + RISE * self.robust.scale().powi(2);
        let is_good = |tried: &(f64, f64)| tried.1 <= enough;
        let before = tried.iter().take_while(|tried| !is_good(tried)).last();
        let after = tried.iter().rev().take_while(|tried| !is_good(tried)).last();
        let (low, high) = parameter.range;
        let low95 = before.map_or(low, |(value, _)| value.min(x[k]));
        let high95 = after.map_or(high, |(value, _)| value.max(x[k]));
        Ok(Interval { low95, high95 })
    }

    fn tried(&self, x: &[f64], k: usize, parameter: &Parameter) -> Result<Tried, DiagnosisError> {
        let at = |value: f64| {
            let mut x = x.to_vec();
            x[k] = value;
            Ok::<_, DiagnosisError>((value, self.stand(x)?.value))
        };
        let (low, high) = parameter.range;
        let values = TRIED.iter().map(|share| (share * parameter.typical).clamp(low, high));
        let mut tried = values.map(at).collect::<Result<Tried, _>>()?;
        for _ in 0..HALVINGS {
            let best = tried.iter().enumerate().min_by(|a, b| a.1.1.total_cmp(&b.1.1));
            let Some((best, _)) = best else { break };
            for right in [best + 1, best] {
                if (1..tried.len()).contains(&right) {
                    tried.insert(right, at(0.5 * (tried[right - 1].0 + tried[right].0))?);
                }
            }
        }
        Ok(tried)
    }
}
