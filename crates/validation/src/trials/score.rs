//! Whether an answer is right.

use diagnosis::{Grade, Verdict};
use effects::{Origin, by_id};

use super::case::{Family, Rig};
use super::record::{Answer, Outcome, Record};
use super::scattering::SCATTERING;
use super::truth::TrueEffect;

/// The shape that an ellipsoid on a patch lacks, too.
const SHAPE: &str = "limit-surface-shape";
/// The simulated rig has it in every set: naming it is true where fast pushes show it.
pub(super) const ALWAYS: &str = "inertia";
/// Effects outside the catalogue and what of the catalogue says the same: the first is a compliance
/// that also remembers, the second a friction that is lower and depends on the speed, the third a corner that
/// is no longer there, the fourth a force over the table that hardly changes within a hand's breadth.
const EQUIVALENTS: [(&str, &[&str]); 4] = [
    ("flexing-tip", &["pusher-compliance"]),
    ("liquid-film", &["support-friction", "rate-dependent-friction", "support-stiction"]),
    ("chipped-corner", &["edge-rounding"]),
    ("cable-drag", &["table-tilt"]),
];

/// Supports of many numbers, and what says the same of them: a rim is a larger radius, and some feet are like
/// it.
const NESTED: [(&str, &[&str]); 2] = [
    ("support-points", &["pressure-radius", "limit-surface-shape"]),
    ("pressure-map", &["pressure-radius", "limit-surface-shape", "support-points"]),
];

/// What rough rigs have in every set: objects that stand on few spots of a bottom that is not flat, on
/// a table whose friction changes from place to place; corners that are broken or catch the tip, which
/// begins a little away and pushes above the table; friction of sides that changes along them; force
/// sensors that lose their zero.
const ROUGH: [&str; 13] = [
    "support-points",
    "pressure-map",
    "pressure-radius",
    "friction-center-offset",
    "limit-surface-shape",
    "effective-limit-surface",
    "friction-gradient",
    "edge-rounding",
    "vertex-contact",
    "approach-gap",
    "push-height",
    "pusher-friction",
    "force-bias",
];
/// What published surfaces have beside that: friction that falls over a set; rubber's that rises with the
/// speed and has a grain, too.
const DRIFTS: &str = "friction-drift";
const OF_RUBBER: [&str; 2] = ["rate-dependent-friction", "table-anisotropy"];

/// What of a rig effects outside the catalogue come from.
const ORIGINS: [(&str, Origin); 8] = [
    ("cable-drag", Origin::Table),
    ("chipped-corner", Origin::Contact),
    ("flexing-tip", Origin::Contact),
    ("liquid-film", Origin::Dynamics),
    ("magnet", Origin::Table),
    ("sticky-spot", Origin::Table),
    ("wobbling-foot", Origin::Support),
    ("worn-groove", Origin::Table),
];

/// Members of a class that is right, at most.
const MOST_OF_A_CLASS: usize = 3;

/// Three intervals of 95 % that are so much wider hold three numbers 19 times in 20.
const WIDER: f64 = 1.22;

/// What an answer is worth.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Score {
    /// For each hidden effect whether it is named, or in a group of its documented look-alikes.
    pub(super) found: Vec<bool>,
    /// Names that are not right, and groups without a right member. What the pushes of a set happen to
    /// share is right where it is told rightly.
    pub(super) wrong: Vec<String>,
}

impl Score {
    /// Of a record; without an answer nothing is found, and that is wrong.
    pub(super) fn of(record: &Record) -> Self {
        let hidden: Vec<&str> = record.truth.iter().map(|effect| effect.id.as_str()).collect();
        match &record.outcome {
            Outcome::Answer(answer) => {
                let mut score = Self::of_answer(answer, &hidden, &record.always());
                let is_drawn = |id: &String| {
                    record.drawn.iter().any(|one| one.id == *id && one.is_as_told(answer))
                };
                score.wrong.retain(|id| !is_drawn(id));
                score
            }
            Outcome::Failed(why) => {
                Self { found: vec![false; hidden.len()], wrong: vec![format!("failed: {why}")] }
            }
        }
    }

    /// Of an answer about sets that hide some effects, on a rig that always has others.
    pub(super) fn of_answer(answer: &Answer, hidden: &[&str], always: &[&str]) -> Self {
        let mut right: Vec<&str> = [hidden, always].concat();
        for (id, same) in EQUIVALENTS.iter().filter(|(id, _)| hidden.contains(id)) {
            assert!(by_id(id).is_err());
            right.extend(*same);
        }
        for (_, same) in NESTED.iter().filter(|(id, _)| hidden.contains(id)) {
            right.extend(*same);
        }
        let is_found = |id: &&str| {
            // No diagnosis names a map.
            let is_map = NESTED[1].0 == *id;
            let says_it = |name: &str| name == *id || is_map && NESTED[1].1.contains(&name);
            let names = answer.named().any(says_it);
            names || answer.ambiguous.iter().any(|group| is_class_of(group, id))
        };
        let is_wrong = |name: &&str| !right.contains(name);
        let mut wrong: Vec<String> = answer.named().filter(is_wrong).map(str::to_owned).collect();
        let are_wrong = |group: &&Vec<String>| group.iter().all(|id| is_wrong(&id.as_str()));
        let groups = answer.ambiguous.iter().filter(are_wrong);
        wrong.extend(groups.map(|group| format!("one of {}", group.join(", "))));
        Self { found: hidden.iter().map(is_found).collect(), wrong }
    }

    pub(super) fn is_all_found(&self) -> bool {
        self.found.iter().all(|found| *found)
    }
}

/// Whether an answer is what its family asks for, as far as one answer tells.
pub(super) fn is_right(record: &Record) -> bool {
    let score = Score::of(record);
    let answer = record.outcome.answer();
    let is_unexplained = answer.is_some_and(|answer| answer.verdict == Verdict::Unexplained);
    match record.family {
        Family::Nothing => score.wrong.is_empty() && !is_unexplained,
        Family::Ellipsoid | Family::Rough => score.wrong.is_empty(),
        Family::RoughTypical => {
            score.wrong.is_empty() && record.truth.iter().all(|one| is_effective(record, &one.id))
        }
        Family::Scattered => score.wrong.is_empty() && names_what_scatters(record),
        Family::Single | Family::Typical | Family::Pair | Family::Robust | Family::Supports => {
            score.is_all_found() && score.wrong.is_empty()
        }
        Family::WrongNominal | Family::WrongEffect => score.is_all_found(),
        Family::Outside => score.wrong.is_empty() && finds_origin(record),
        Family::Narrow => {
            let names_one = answer.is_some_and(|answer| !answer.identified.is_empty());
            answer.is_some() && score.wrong.is_empty() && (record.alike.is_empty() || !names_one)
        }
        Family::Untestable => {
            let told = answer.and_then(|answer| answer.told(&record.about));
            told.is_some_and(|told| told.grade == Grade::NotTestable)
        }
    }
}

/// Whether an effect is named, in a class, or told to lower the error.
pub(super) fn is_effective(record: &Record, id: &str) -> bool {
    let answer = record.outcome.answer();
    answer.is_some_and(|answer| {
        let in_class = answer.ambiguous.iter().any(|group| is_class_of(group, id));
        in_class
            || answer.named().any(|name| name == id)
            || answer.effective.iter().any(|one| one == id)
    })
}

/// Whether what scatters from push to push is told to scatter the motion most.
pub(super) fn names_what_scatters(record: &Record) -> bool {
    let first = record.outcome.answer().and_then(|answer| answer.push_to_push.first());
    first.is_some_and(|first| first.effect == record.about)
}

/// Whether the 90 % interval of what scatters holds the truth.
pub(super) fn holds_what_scatters(record: &Record) -> bool {
    // From an interval of 95 % of a logarithm.
    const NARROWER: f64 = 1.645 / 1.96;
    let truth = SCATTERING.iter().find(|source| source.name == record.about);
    let answer = record.outcome.answer();
    let told =
        answer.and_then(|one| one.push_to_push.iter().find(|one| one.effect == record.about));
    truth.zip(told).is_some_and(|(truth, told)| {
        let off = (truth.sd / told.sd).ln();
        off.abs() <= NARROWER * (told.high95 / told.sd).ln()
    })
}

/// Whether most of what is left comes surely from where an effect outside the catalogue comes from.
pub(super) fn finds_origin(record: &Record) -> bool {
    let answer = record.outcome.answer();
    let origin = answer.and_then(|answer| answer.leftover.origin);
    origin.is_some_and(|origin| ORIGINS.contains(&(record.about.as_str(), origin)))
}

/// Whether a group is an effect with documented look-alikes of it.
fn is_class_of(group: &[String], id: &str) -> bool {
    let documents = |one: &str, other: &str| {
        let confounders = by_id(one).map(|effect| effect.info().confounders);
        confounders.is_ok_and(|all| all.iter().any(|one| one.id == other))
    };
    let is_alike = |other: &String| other == id || documents(id, other) || documents(other, id);
    group.len() <= MOST_OF_A_CLASS
        && group.iter().any(|member| member == id)
        && group.iter().all(is_alike)
}

impl TrueEffect {
    /// Whether the intervals that an answer tells hold it, a little widened since there are several.
    fn is_as_told(&self, answer: &Answer) -> bool {
        let Some(told) = answer.told(&self.id) else { return false };
        let parameters = self.parameters();
        let holds = |(name, truth): &(&str, f64)| {
            let found = told.parameters.iter().find(|parameter| parameter.name == *name);
            let ends = found.and_then(|one| one.low95.zip(one.high95));
            ends.zip(found.and_then(|one| one.estimate)).is_some_and(|((low, high), estimate)| {
                let end = if *truth < estimate { low } else { high };
                (truth - estimate).abs() <= WIDER * (end - estimate).abs()
            })
        };
        parameters.iter().all(holds)
    }
}

impl Record {
    pub(super) fn has_ellipsoid(&self) -> bool {
        self.surface == models::SurfaceKind::Ellipsoid.name()
    }

    /// What is there in every set of the rig, or is what the base lacks.
    fn always(&self) -> Vec<&'static str> {
        let mut always = vec![ALWAYS];
        if self.has_ellipsoid() {
            always.push(SHAPE);
        }
        if self.setup.rig != Rig::Quiet {
            always.extend(ROUGH);
        }
        if !matches!(self.setup.rig, Rig::Quiet | Rig::Rough) {
            always.push(DRIFTS);
        }
        if self.setup.rig == Rig::Pu {
            always.extend(OF_RUBBER);
        }
        always
    }
}

/// How many of an answer's intervals hold the truth, of how many: those of claimed effects that
/// are hidden, of parameters with an interval and of the same law.
pub(super) fn intervals(record: &Record) -> Vec<(String, bool)> {
    let Some(answer) = record.outcome.answer() else { return Vec::new() };
    let mut held = Vec::new();
    for effect in record.truth.iter().filter(|effect| effect.is_same_law()) {
        let claimed = answer.claimed().contains(effect.id.as_str());
        let Some(told) = answer.told(&effect.id).filter(|_| claimed) else { continue };
        for (name, truth) in effect.parameters() {
            let found = told.parameters.iter().find(|parameter| parameter.name == name);
            let Some((low, high)) = found.and_then(|one| one.low95.zip(one.high95)) else {
                continue;
            };
            let turn = if name == "direction" { std::f64::consts::PI } else { 0.0 };
            let holds = [-turn, 0.0, turn].iter().any(|by| (low..=high).contains(&(truth + by)));
            let estimate = found.and_then(|one| one.estimate).unwrap_or(f64::NAN);
            let text = format!(
                "{}: {} {name} is {truth:.2e}, told {estimate:.2e} ({low:.2e} to {high:.2e})",
                record.case, effect.id
            );
            held.push((text, holds));
        }
    }
    held
}

#[cfg(test)]
pub(super) mod tests {
    use diagnosis::{ErrorFall, Grade, Leftover, Verdict};

    use super::super::case::{Family, Rig};
    use super::super::plan;
    use super::super::record::{Answer, Outcome, Record, Told};
    use super::super::truth::Truth;
    use super::Score;

    pub(in super::super) fn answer(named: &[&str], ambiguous: &[&[&str]]) -> Answer {
        let owned = |ids: &[&str]| ids.iter().map(|id| (*id).to_owned()).collect::<Vec<_>>();
        let told = |id: &&str| Told {
            id: (*id).to_owned(),
            grade: Grade::Identified,
            small: false,
            p: Some(0.001),
            gain: None,
            why: String::new(),
            rivals: Vec::new(),
            parameters: Vec::new(),
        };
        Answer {
            verdict: if named.is_empty() { Verdict::NoneFound } else { Verdict::Identified },
            identified: owned(named),
            ambiguous: ambiguous.iter().map(|group| owned(group)).collect(),
            effective: Vec::new(),
            sentence: String::new(),
            error: ErrorFall::default(),
            leftover: Leftover { p: None, covariate: None, origin: None },
            remains: None,
            push_to_push: Vec::new(),
            effects: named.iter().map(told).collect(),
        }
    }

    fn score(named: &[&str], ambiguous: &[&[&str]], hidden: &[&str], lacks_shape: bool) -> Score {
        let always: &[&str] =
            if lacks_shape { &[super::ALWAYS, super::SHAPE] } else { &[super::ALWAYS] };
        Score::of_answer(&answer(named, ambiguous), hidden, always)
    }

    #[test]
    fn the_hidden_name_is_found_and_any_other_is_wrong() {
        let right = score(&["table-tilt"], &[], &["table-tilt"], false);
        assert_eq!(right, Score { found: vec![true], wrong: Vec::new() });
        let extra = score(&["table-tilt", "edge-rounding"], &[], &["table-tilt"], false);
        assert_eq!((extra.found, extra.wrong), (vec![true], vec!["edge-rounding".to_owned()]));
        let other = score(&["friction-gradient"], &[], &["table-tilt"], false);
        assert_eq!((other.found, other.wrong.len()), (vec![false], 1));
        assert_eq!(score(&[], &[], &["table-tilt"], false).found, [false]);
    }

    #[test]
    fn a_group_counts_if_its_members_are_documented_confounders() {
        let group: &[&[&str]] = &[&["friction-gradient", "table-tilt"]];
        assert_eq!(score(&[], group, &["table-tilt"], false).found, [true]);
        let loose: &[&[&str]] = &[&["inertia", "table-tilt"]];
        assert_eq!(score(&[], loose, &["table-tilt"], false).found, [false]);
        let wrong = score(&[], group, &["inertia"], false).wrong;
        assert_eq!(wrong, ["one of friction-gradient, table-tilt"]);
    }

    #[test]
    fn the_shape_is_right_beside_anything_only_where_the_base_lacks_it() {
        let names: &[&str] = &["limit-surface-shape", "inertia"];
        assert!(score(names, &[], &["inertia"], true).wrong.is_empty());
        assert_eq!(score(names, &[], &["inertia"], false).wrong, ["limit-surface-shape"]);
    }

    #[test]
    fn a_class_of_more_than_three_is_no_answer() {
        let group: &[&[&str]] =
            &[&["friction-gradient", "table-tilt", "friction-drift", "inertia"]];
        assert_eq!(score(&[], group, &["table-tilt"], false).found, [false]);
    }

    #[test]
    fn what_rough_rigs_have_is_no_wrong_name_on_them_alone() {
        let wrong = |rig: Rig, named: &[&str]| {
            let mut case = plan::cases(Family::Rough, 1).remove(0);
            case.setup.rig = rig;
            let record = Record::failed(&case, String::new(), Truth::default(), 1.0);
            let outcome = Outcome::Answer(Box::new(answer(named, &[])));
            Score::of(&Record { outcome, ..record }).wrong.len()
        };
        let of = |rig| {
            wrong(rig, &["support-points", "friction-drift", "table-anisotropy", "table-tilt"])
        };
        assert_eq!([Rig::Quiet, Rig::Rough, Rig::Abs, Rig::Pu].map(of), [4, 3, 2, 1]);
    }

    #[test]
    fn what_the_rig_always_has_is_no_wrong_name() {
        let found = score(&["inertia"], &[], &["table-tilt"], false);
        assert!(found.wrong.is_empty() && found.found == [false]);
    }

    #[test]
    fn of_what_no_catalogue_has_documented_equivalents_are_no_wrong_names() {
        assert!(score(&["pusher-compliance"], &[], &["flexing-tip"], false).wrong.is_empty());
        assert_eq!(score(&["pusher-compliance"], &[], &["magnet"], false).wrong.len(), 1);
    }
}
