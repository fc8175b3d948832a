//! A part of a set that is larger than is needed.

use std::borrow::Cow;
use std::collections::BTreeMap;

use crate::data::repeats::cells;
use crate::{DiagnosisError, Observations, RepeatTolerance};

/// Pushes that are kept at least, however many steps each has: statistics count pushes.
const FEWEST_KEPT: usize = 60;

/// Pushes with about as many steps as are wanted, evenly over edges and speeds; all where there are
/// no more, and more steps where few pushes have so many.
///
/// Repeats of a push stay together: they tell the noise.
///
/// # Errors
/// `TooFewPushes`.
pub(crate) fn thinned(
    observations: &Observations,
    most_steps: usize,
) -> Result<Cow<'_, Observations>, DiagnosisError> {
    let stride = observations.n_steps().div_ceil(most_steps.max(1));
    if stride < 2 {
        return Ok(Cow::Borrowed(observations));
    }
    let mut first = vec![None; observations.pushes().len()];
    for (place, push) in observations.places.iter().zip(&observations.push_of) {
        first[*push].get_or_insert((place.edge, (1e3 * place.speed).round() as u64));
    }
    let mut groups: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    let tolerance = RepeatTolerance::default();
    for (push, cell) in cells(observations, &tolerance).into_iter().enumerate() {
        groups.entry(cell).or_default().push(push);
    }
    let mut groups: Vec<Vec<usize>> = groups.into_values().collect();
    groups.sort_by_key(|group| first[group[0]]);
    let n_kept = |stride: &usize| groups.iter().step_by(*stride).map(Vec::len).sum::<usize>();
    let fewest = FEWEST_KEPT.min(observations.pushes().len());
    let stride = (1..=stride).rev().find(|stride| n_kept(stride) >= fewest).unwrap_or(1);
    let chosen = groups.into_iter().step_by(stride).flatten();
    let names: Vec<String> = chosen.map(|push| observations.pushes()[push].to_string()).collect();
    observations.part(&names).map(Cow::Owned)
}

#[cfg(test)]
mod tests {
    use super::{FEWEST_KEPT, thinned};
    use crate::synthetic::made;
    use std::borrow::Cow;

    #[test]
    fn a_small_set_stays_whole_and_a_large_one_keeps_its_repeats() {
        let (mut all, ..) = made(0, |_| 0.0);
        let (n_steps, n_pushes) = (all.n_steps(), all.pushes().len());
        assert!(matches!(thinned(&all, n_steps).unwrap(), Cow::Borrowed(_)));
        // Every push three times.
        let steps_of_a_push = n_steps / n_pushes;
        for step in 0..n_steps {
            let push = step / steps_of_a_push;
            let first = step - (push % 3) * steps_of_a_push;
            all.steps[step] = all.steps[first].clone();
            all.places[step] = all.places[first];
        }
        let part = thinned(&all, n_steps / 4).unwrap();
        assert_eq!(part.pushes().len(), n_pushes / 4);
        // Statistics count pushes: of many there stay some, however many steps are wanted.
        let kept = thinned(&all, 1).unwrap().pushes().len();
        assert!((FEWEST_KEPT..FEWEST_KEPT + 3).contains(&kept), "{kept} of {n_pushes}");
        for three in part.pushes().chunks(3) {
            let number = |k: usize| three[k].recording[5..].parse::<usize>().unwrap();
            assert_eq!([number(0) / 3, number(1) / 3], [number(2) / 3; 2]);
        }
    }
}
