//! How much of what an effect changes another one changes just so.

use std::sync::Arc;

use effects::{Effect, by_id};
use nalgebra::DVector;
use serde::Serialize;

use super::descent::Minimum;
use super::member::Part;
use super::problem::Problem;
use crate::DiagnosisError;

/// Another effect that could be taken for a fitted one in these data.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Resemblance {
    /// Its id.
    pub id: &'static str,
    /// Correlation of the fitted effect's signature with the nearest one of the other, both beyond
    /// what the nuisances explain: 1 for effects that these data cannot tell apart.
    pub correlation: f64,
    /// When the two are known to look alike, and what tells them apart; empty where not known.
    pub when: &'static str,
}

/// The resemblances of a fitted effect: its confounders, and what else was asked for.
///
/// # Errors
/// What a prediction refuses.
pub(super) fn resemblances(
    problem: &Problem,
    minimum: &Minimum,
    index: usize,
) -> Result<Vec<Resemblance>, DiagnosisError> {
    let members = &problem.space.members;
    let about = members[index].effect.info();
    let signature = signature(problem, minimum, index)?;
    let declared = about.confounders.iter().map(|alike| (alike.id, alike.when));
    let others = members.iter().filter(|member| member.part != Part::Nuisance);
    let others = others.map(|member| (member.id(), "")).filter(|(id, _)| *id != about.id);
    let mut found: Vec<Resemblance> = Vec::new();
    for (id, when) in declared.chain(others) {
        if found.iter().any(|known| known.id == id) {
            continue;
        }
        let mut basis = Basis::default();
        for (k, member) in members.iter().enumerate() {
            if member.part == Part::Nuisance && member.id() != id {
                columns(problem, minimum, k)?.iter().for_each(|column| basis.add(column));
            }
        }
        let whole = basis.beyond(&signature).norm_squared();
        let of_other = match members.iter().position(|member| member.id() == id) {
            Some(k) => columns(problem, minimum, k)?,
            None => foreign(problem, minimum, by_id(id).map_err(models::ModelError::from)?)?,
        };
        let n_data = problem.whitening.n_numbers();
        for mut column in of_other {
            let n_priors = column.len() - n_data;
            column.rows_mut(n_data, n_priors).fill(0.0);
            basis.add(&column);
        }
        let share = 1.0 - basis.beyond(&signature).norm_squared() / whole;
        let correlation = if whole > 0.0 { share.clamp(0.0, 1.0).sqrt() } else { 0.0 };
        found.push(Resemblance { id, correlation, when });
    }
    Ok(found)
}

/// What the predictions lose without the effect, whitened and weighted.
fn signature(
    problem: &Problem,
    minimum: &Minimum,
    index: usize,
) -> Result<DVector<f64>, DiagnosisError> {
    let (space, first) = (&problem.space, problem.space.first(index));
    let member = &space.members[index];
    let mut x = minimum.at.x.clone();
    x[first..first + member.len()].copy_from_slice(&member.place(&member.off));
    let mut change = weighted(minimum, &(problem.residuals(&x)? - &minimum.at.z));
    change.rows_mut(problem.whitening.n_numbers() + first, member.len()).fill(0.0);
    Ok(change)
}

/// What the predictions gain along each number of an effect that is moved, or along its switch.
fn columns(
    problem: &Problem,
    minimum: &Minimum,
    index: usize,
) -> Result<Vec<DVector<f64>>, DiagnosisError> {
    let first = problem.space.first(index);
    let own = first..first + problem.space.members[index].len();
    let moved = minimum.moved.iter().enumerate().filter(|(_, k)| own.contains(k));
    let slopes: Vec<_> =
        moved.map(|(column, _)| weighted(minimum, &minimum.slopes.column(column).into())).collect();
    match slopes.is_empty() {
        true => Ok(vec![signature(problem, minimum, index)?]),
        false => Ok(slopes),
    }
}

/// The same of an effect that the model does not carry.
fn foreign(
    problem: &Problem,
    minimum: &Minimum,
    effect: &Arc<dyn Effect>,
) -> Result<Vec<DVector<f64>>, DiagnosisError> {
    let space = problem.space.with(effect)?;
    let n_known = minimum.at.x.len();
    let Some(member) = space.members.last() else { return Ok(Vec::new()) };
    let mut x = minimum.at.x.clone();
    x.extend(member.place(&member.start));
    let typical = member.typical.clone();
    let mut other = Problem::new(space, problem.whitening, problem.robust.clone());
    other.frozen[..n_known].fill(true);
    let at = other.stand(x)?;
    let rows = minimum.at.z.len();
    let cut = |column: DVector<f64>| weighted(minimum, &column.rows(0, rows).into());
    if other.moved().is_empty() {
        let mut on = at.x.clone();
        on[n_known..].copy_from_slice(&typical);
        return Ok(vec![cut(&at.z - other.residuals(&on)?)]);
    }
    let slopes = other.slopes(&at, &other.secants)?;
    Ok(slopes.column_iter().map(|column| cut(column.into())).collect())
}

fn weighted(minimum: &Minimum, column: &DVector<f64>) -> DVector<f64> {
    column.zip_map(&minimum.weights, |value, weight| value * weight.sqrt())
}

/// Orthonormal columns, by Gram and Schmidt's method in two rounds.
#[derive(Default)]
struct Basis(Vec<DVector<f64>>);

/// What is left of a column that depends on others, relative to it.
const DEPENDENT: f64 = 1e-7;

impl Basis {
    fn beyond(&self, column: &DVector<f64>) -> DVector<f64> {
        let mut rest = column.clone();
        for _ in 0..2 {
            for known in &self.0 {
                let share = known.dot(&rest);
                rest.axpy(-share, known, 1.0);
            }
        }
        rest
    }

    fn add(&mut self, column: &DVector<f64>) {
        let rest = self.beyond(column);
        let norm = rest.norm();
        if norm > DEPENDENT * column.norm() {
            self.0.push(rest / norm);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Basis;
    use nalgebra::DVector;

    #[test]
    fn what_is_beyond_a_basis_is_orthogonal_to_it() {
        let column = |numbers: [f64; 4]| DVector::from_row_slice(&numbers);
        let mut basis = Basis::default();
        let (one, two) = (column([1.0, 2.0, 0.0, -1.0]), column([1e-6, 0.0, 3e-6, 1e-6]));
        basis.add(&one);
        basis.add(&two);
        basis.add(&(2.0 * &one + &two));
        assert_eq!(basis.0.len(), 2);
        let rest = basis.beyond(&column([0.3, 0.7, -0.2, 0.9]));
        assert!(rest.dot(&one).abs() < 1e-14 && rest.dot(&two).abs() < 1e-20 && rest.norm() > 0.1);
    }
}
