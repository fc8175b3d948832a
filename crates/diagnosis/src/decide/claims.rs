//! What may be claimed.

use effects::Origin;

use super::constancy::Varies;
use super::found::{Accepted, Found};
use super::leftover::Left;
use super::{Grade, Verdict};
use crate::cut_offs::{MORE_FREEDOM, WIDE};
use crate::remains::Beside;
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

/// What an effect explains.
struct Explains {
    /// What the mean square of the whitened error rises by without it.
    square: f64,
    origin: Option<Origin>,
    is_small: bool,
}

/// Why what an effect explains may have another cause, by what free components take off the error beside it.
///
/// Both are counted in squares of the whitened error, for gains of clusters are bounded. More freedom of what an effect
/// comes from speaks against it if the effect's size moves with it, or is not sure beside it.
fn more_is_left(
    one: &Explains,
    after: f64,
    (remains, beside): (&Remains, Option<&Beside>),
) -> Option<String> {
    let Remains { gain: all, share, origins, .. } = remains;
    let square = |nats: f64| share * (nats / all.mean).min(1.0) * after * after;
    let told = |gain: &Gain| format!("{:.0} ± {:.0} nats", gain.mean, gain.se);
    if all.mean <= 0.0 {
        return None;
    }
    let stands = beside.is_some_and(Beside::stands);
    let own = origins.iter().find(|origin| Some(origin.origin) == one.origin);
    if let Some(own) = own.filter(|own| square(own.gain.mean) >= MORE_FREEDOM * one.square) {
        if let Some(moved) = beside.filter(|beside| beside.is_moved()) {
            return Some(moved.sentence());
        }
        if all.is_sure() && own.gain.is_sure() && !stands {
            let (name, gain) = (own.origin.name(), told(&own.gain));
            return Some(format!("more freedom of the {name} beside it gains {gain}"));
        }
    }
    // Where it stands beside what its own origin leaves, that and the rest are each held against it.
    let most = own.filter(|_| stands).map_or(all.mean, |own| {
        let own = own.gain.mean.max(0.0);
        own.max(all.mean - own)
    });
    let is_more = all.is_sure() && !one.is_small && square(most) >= one.square;
    is_more.then(|| {
        let gain = told(all);
        format!("more is left ({gain}) than it explains, and what causes that may cause this, too")
    })
}

/// The verdict.
pub(super) fn claims(
    found: &Found,
    (left, remains): (&Left, Option<&Remains>),
    besides: &[Beside],
) -> Claims {
    let is_left = left.is_left();
    let (mut identified, mut groups, mut effective) = (Vec::new(), Vec::new(), Vec::new());
    let mut small = Vec::new();
    for one in &found.accepted {
        let beside = besides.iter().find(|beside| beside.id == one.id);
        // One of a group may vary where another of it does not, and where the table varies its mean may stand.
        let is_field = |varies: &&Varies| {
            varies.is_over_table()
                && beside.is_some_and(|own| own.origin == Origin::Table && own.stands())
        };
        let is_alone = one.rivals.is_empty();
        let varies = one.varies.as_ref().filter(|varies| is_alone && !is_field(varies));
        let doubt = varies.map(Varies::sentence).or_else(|| wide_places(&one.effect));
        let raised = one.raised.as_ref().map(|raised| raised.sentence("it"));
        let raised_by_all = || Some(found.raised.as_ref()?.sentence("all that is claimed"));
        let doubt = doubt.or(raised).or_else(raised_by_all);
        let Accepted { square, origin, is_small, .. } = *one;
        let explains = Explains { square, origin, is_small };
        let beside = beside.filter(|_| is_alone);
        let more = || more_is_left(&explains, found.error.after, (remains?, beside));
        let doubt = doubt.or_else(more);
        match doubt {
            doubt if one.is_small => {
                let alone = if is_alone { Grade::Identified } else { Grade::Ambiguous };
                let grade = if doubt.is_some() { Grade::Effective } else { alone };
                small.push((one.id, grade, doubt.unwrap_or_default()));
            }
            Some(why) => effective.push((one.id, why)),
            None if is_alone => identified.push(one.id),
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
    use effects::Origin;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::{Beside, Explains, more_is_left};
    use crate::synthetic::{normal, pushed_with};
    use crate::{DiagnoseSettings, Gain, Grade, OriginShare, Predictions, Remains, diagnose};

    const TANGENTIAL: usize = 4;

    const SOME: Gain = Gain { mean: 100.0, se: 10.0 };

    /// What a table that differs all over leaves beside an effect of the table that takes off `square`, and beside
    /// which the effect moves by a share of its size, surely, and is so many standard errors.
    fn doubt_beside_a_field(square: f64, moved: f64, sds: f64) -> Option<String> {
        let origin = Origin::Table;
        let share = OriginShare { origin, gain: SOME, alone: None, last_in: None, at: None };
        let remains = Remains { gain: SOME, share: 0.1, smooth: SOME, origins: vec![share] };
        let beside = Beside { id: "table-anisotropy", origin, moved, moved_sds: 5.0, sds };
        let explains = Explains { square, origin: Some(origin), is_small: false };
        more_is_left(&explains, 1.0, (&remains, Some(&beside)))
    }

    #[test]
    fn a_rough_table_speaks_against_an_effect_that_moves_with_it_or_explains_less() {
        assert_eq!(doubt_beside_a_field(0.2, 0.1, 5.0), None);
        let why = |square, moved, sds| doubt_beside_a_field(square, moved, sds).unwrap();
        let moved = why(0.2, 0.5, 5.0);
        assert!(moved.ends_with("its size moves by 50 % of what it is"), "{moved}");
        let unsure = why(0.2, 0.1, 2.0);
        assert!(unsure.contains("more freedom of the table beside it gains 100 ± 10"), "{unsure}");
        let less = why(0.05, 0.1, 5.0);
        assert!(less.contains("more is left (100 ± 10 nats) than it explains"), "{less}");
        // The field takes off less than a quarter of what the effect does.
        assert_eq!(doubt_beside_a_field(0.5, 0.5, 2.0), None);
    }

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
