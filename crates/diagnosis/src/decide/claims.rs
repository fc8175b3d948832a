//! What may be claimed.

use super::constancy::Varies;
use super::found::{Accepted, Found};
use super::leftover::Left;
use super::{Grade, Verdict};
use crate::cut_offs::{MORE_FREEDOM, WIDE};
use crate::{EffectFit, Gain, ParameterFit, Remains};

/// What may be claimed of a set.
pub(super) struct Claims {
    pub(super) verdict: Verdict,
    /// Effects that are missing, and groups of which one is.
    pub(super) identified: Vec<&'static str>,
    pub(super) groups: Vec<Vec<&'static str>>,
    /// Effects that lower the error, and why another cause may be behind it.
    pub(super) effective: Vec<(&'static str, String)>,
    /// Those of them that are there and hardly seen stand here alone.
    pub(super) small: Vec<(&'static str, Grade, String)>,
    /// Whether something is left that no effect explains.
    pub(super) is_left: bool,
}

/// What is known of where an object rests, where its places are not.
fn wide_places(effect: &EffectFit) -> Option<String> {
    let [x, y, c] = effect.follows.as_slice() else { return None };
    let half = |one: &ParameterFit| one.interval.map(|ends| 0.5 * (ends.high95 - ends.low95));
    let places = effect.parameters.iter().filter(|one| one.unit == "m" && one.value != 0.0);
    let widest = places.filter_map(half).fold(0.0, f64::max);
    let told = |one: &ParameterFit| {
        let half = half(one).map_or(String::new(), |half| format!(" ± {:.1}", 1e3 * half));
        format!("{:.1}{half}", 1e3 * one.value)
    };
    (widest > WIDE * c.value).then(|| {
        format!(
            "points elsewhere have nearly the same friction. What is known: the center of friction at \
             x {} mm and y {} mm, and the mean distance c of the pressure from it, {} mm",
            told(x),
            told(y),
            told(c)
        )
    })
}

/// Why what an effect explains may have another cause, by what free components take off the error beside it.
///
/// Both are counted in squares of the whitened error, for gains of clusters are bounded.
fn more_is_left(one: &Accepted, after: f64, remains: &Remains) -> Option<String> {
    let Remains { gain: all, share, origins, .. } = remains;
    let square = |gain: &Gain| share * (gain.mean / all.mean).min(1.0) * after * after;
    let told = |gain: &Gain| format!("{:.0} ± {:.0} nats", gain.mean, gain.se);
    if !all.is_sure() {
        return None;
    }
    let mut sure = origins.iter().filter(|origin| origin.gain.is_sure());
    let own = sure.find(|origin| Some(origin.origin) == one.origin);
    if let Some(own) = own.filter(|own| square(&own.gain) >= MORE_FREEDOM * one.square) {
        let (name, gain) = (own.origin.name(), told(&own.gain));
        return Some(format!("more freedom of the {name} beside it gains {gain}"));
    }
    let is_more = !one.is_small && square(all) >= one.square;
    is_more.then(|| {
        let gain = told(all);
        format!("more is left ({gain}) than it explains, and what causes that may cause this, too")
    })
}

/// The verdict.
pub(super) fn claims(found: &Found, (left, remains): (&Left, Option<&Remains>)) -> Claims {
    let is_left = left.is_left();
    let (mut identified, mut groups, mut effective) = (Vec::new(), Vec::new(), Vec::new());
    let mut small = Vec::new();
    for one in &found.accepted {
        // One of a group may vary where another of it does not.
        let varies = one.varies.as_ref().filter(|_| one.rivals.is_empty());
        let doubt = varies.map(Varies::sentence).or_else(|| wide_places(&one.effect));
        let raised = one.raised.as_ref().map(|raised| raised.sentence("it"));
        let raised_by_all = || Some(found.raised.as_ref()?.sentence("all that is claimed"));
        let doubt = doubt.or(raised).or_else(raised_by_all);
        let doubt = doubt.or_else(|| more_is_left(one, found.error.after, remains?));
        match doubt {
            doubt if one.is_small => {
                let alone =
                    if one.rivals.is_empty() { Grade::Identified } else { Grade::Ambiguous };
                let grade = if doubt.is_some() { Grade::Effective } else { alone };
                small.push((one.id, grade, doubt.unwrap_or_default()));
            }
            Some(why) => effective.push((one.id, why)),
            None if one.rivals.is_empty() => identified.push(one.id),
            None => groups.push([&[one.id], one.rivals.as_slice()].concat()),
        }
    }
    let is_doubted = found.refused.iter().any(|refused| refused.objection.is_hint());
    let verdict = if !identified.is_empty() {
        Verdict::Identified
    } else if !groups.is_empty() {
        Verdict::Ambiguous
    } else if !effective.is_empty() {
        Verdict::Effective
    } else if is_left {
        Verdict::Unexplained
    } else if is_doubted || left.is_hint() {
        Verdict::Inconclusive
    } else {
        Verdict::NoneFound
    };
    Claims { verdict, identified, groups, effective, small, is_left }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use crate::synthetic::{normal, pushed_with};
    use crate::{DiagnoseSettings, Grade, Predictions, diagnose};

    const TANGENTIAL: usize = 4;

    /// Motions are those of a tip with more friction, tangential forces those of the nominal one, beside what each push
    /// adds of its own, in N.
    #[test]
    fn what_moves_pushes_rightly_and_makes_a_force_worse_is_no_more_than_effective() {
        let (mut observed, model, _) = pushed_with(("pusher-friction", &[0.45]), 3);
        let nominal = Predictions::of(&model, &[], &observed).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let own: Vec<f64> = observed.pushes().iter().map(|_| 0.1 * normal(&mut rng)).collect();
        for (index, told) in nominal.steps().iter().enumerate() {
            let own = own[observed.push_of[index]];
            observed.steps[index].observed[TANGENTIAL] = told[TANGENTIAL].map(|force| force + own);
        }
        let found = diagnose(&observed, &model, &DiagnoseSettings::default()).unwrap().diagnosis;
        let told = found.effects.iter().find(|effect| effect.id == "pusher-friction").unwrap();
        let why = &told.why;
        assert_eq!(told.grade, Grade::Effective, "{}", found.sentence);
        assert!(why.contains("miss the tangential force by more"), "{why}");
    }
}
