//! All trials, in an order in which every beginning covers what the whole covers.

use effects::{Channel, by_id, tested};
use models::SurfaceKind;
use plant::effect_kinds;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::case::{Asked, Case, Family, Outline, Pushes, Rig, Sessions, Setup, Size};
use super::oracle::{OF_THE_PUSHES, Oracle};
use super::scattering::SCATTERING;
use super::variant::Variant;

/// Seeds of one family.
const SEEDS_PER_FAMILY: u64 = 10_000;
const N_NOTHING: usize = 100;
/// Sets of one effect and size.
const N_EACH: usize = 12;
const N_PAIRS: usize = 60;
const N_OUTSIDE: usize = 15;
const N_NARROW: usize = 60;
const N_ROBUST: usize = 2;
/// Sets of one scattering quantity.
const N_SCATTERED: usize = 50;
/// Every so many sets of rough rigs are large.
const LARGE_EVERY: usize = 6;
const LARGE: usize = 400;
/// Sizes of power curves, in nameable sizes.
const MULTIPLES: [f64; 4] = [0.5, 1.0, 2.0, 4.0];
const PAIR_MULTIPLE: f64 = 4.0;
const NARROW_MULTIPLE: f64 = 4.0;
/// What one edge, orientation and speed cannot tell apart.
const NARROW: [&str; 7] = [
    "friction-center-offset",
    "pose-offset",
    "friction-gradient",
    "contact-bias",
    "table-anisotropy",
    "body-anisotropy",
    "table-tilt",
];
/// Of which the simulator has laws of its own.
const SUPPORTS: [&str; 4] = ["support-points", "pressure-map", "vertex-contact", "push-height"];
/// Fixed to the table or to time.
const OF_THE_WORLD: [&str; 4] =
    ["table-anisotropy", "friction-gradient", "table-tilt", "friction-drift"];

/// The cases of a family with their seeds, before any size is known.
pub(super) fn cases(family: Family, first_seed: u64) -> Vec<Case> {
    let mut cases = match family {
        Family::Nothing => nothing(family, SurfaceKind::UniformPatch),
        Family::Ellipsoid => nothing(family, SurfaceKind::Ellipsoid),
        Family::Single => singles(),
        Family::Typical => each(N_EACH, &catalogue(), |id, turn| typical(family, id, turn)),
        Family::Pair => pairs(),
        Family::Outside => each(N_OUTSIDE, &outside(), |id, turn| typical(family, id, turn)),
        Family::Narrow => narrow(),
        Family::Untestable => untestable(),
        Family::WrongNominal => {
            each(N_ROBUST, &without(&catalogue(), "pusher-friction"), |id, turn| Case {
                variants: Variant::WRONG.to_vec(),
                ..typical(family, id, turn)
            })
        }
        Family::Robust => robust(),
        Family::WrongEffect => {
            let ids = without(&catalogue(), OF_THE_PUSHES);
            each(N_ROBUST, &ids, |id, turn| typical(family, id, turn))
        }
        Family::Rough => {
            let set = |turn: usize| Case {
                setup: rough(Setup { sessions: in_turn(turn), ..Setup::RICH }, turn),
                ..case(family, "", "", turn)
            };
            (0..N_NOTHING).map(set).collect()
        }
        Family::RoughTypical => {
            let ids = without(&catalogue(), OF_THE_PUSHES);
            let cases = each(N_EACH, &ids, |id, turn| Case {
                setup: Setup::of(id),
                ..typical(family, id, turn)
            });
            let on_rough = |(turn, mut case): (usize, Case)| {
                case.setup = rough(case.setup, turn);
                // An ellipse has no corners to round.
                if case.about == "edge-rounding" {
                    case.setup.outline = Outline::Square;
                }
                case
            };
            cases.into_iter().enumerate().map(on_rough).collect()
        }
        Family::Supports => each(N_EACH, &SUPPORTS, |id, turn| typical(family, id, turn)),
        Family::Scattered => {
            let names = SCATTERING.map(|source| source.name);
            each(N_SCATTERED, &names, |id, turn| case(family, id, "", turn))
        }
    };
    for (seed, case) in (first_seed + SEEDS_PER_FAMILY * family as u64..).zip(&mut cases) {
        case.seed = seed;
    }
    cases
}

/// Why a case cannot be made: a size out of the effect's range; none if it can.
pub(super) fn cannot_be(case: &Case, oracle: &Oracle) -> Option<String> {
    let share = |asked: &Asked| oracle.share(asked, &case.setup);
    let made = case.hidden.iter().map(|asked| share(asked).and_then(|share| asked.hidden(share)));
    made.filter_map(|effect| effect.err().map(|error| format!("{error:#}"))).next()
}

fn case(family: Family, about: &str, kind: &str, turn: usize) -> Case {
    let name = if kind.is_empty() { String::new() } else { format!("/{kind}") };
    let label = if about.is_empty() { String::new() } else { format!("/{about}") };
    let family_name = clap::ValueEnum::to_possible_value(&family);
    let family_name = family_name.map_or(String::new(), |value| value.get_name().to_owned());
    Case {
        name: format!("{family_name}{label}{name}/{turn:02}"),
        family,
        about: about.to_owned(),
        seed: 0,
        surface: SurfaceKind::UniformPatch,
        setup: Setup::RICH,
        hidden: Vec::new(),
        variants: Vec::new(),
    }
}

/// What is tested for, but for what stands among the supports.
fn catalogue() -> Vec<&'static str> {
    let ids = tested().iter().map(|effect| effect.info().id);
    ids.filter(|id| !SUPPORTS.contains(id)).collect()
}

/// Sessions of one trial after the other.
fn in_turn(turn: usize) -> Sessions {
    Sessions::ALL[turn % Sessions::ALL.len()]
}

fn without(ids: &[&'static str], id: &str) -> Vec<&'static str> {
    ids.iter().copied().filter(|other| *other != id).collect()
}

fn outside() -> Vec<&'static str> {
    effect_kinds().iter().filter(|kind| !kind.in_catalogue).map(|kind| kind.id).collect()
}

/// So many turns of the same list.
fn each(n: usize, ids: &[&'static str], make: impl Fn(&'static str, usize) -> Case) -> Vec<Case> {
    (0..n)
        .flat_map(|turn| ids.iter().map(move |id| (*id, turn)))
        .map(|(id, turn)| make(id, turn))
        .collect()
}

fn nothing(family: Family, surface: SurfaceKind) -> Vec<Case> {
    let set = |turn: usize| {
        let pushes = if turn % 4 == 3 { Pushes::Speeds } else { Pushes::Rich };
        let outline = Outline::ALL[turn / 2 % 4];
        let sessions = in_turn(turn);
        let setup = Setup { pushes, has_force: turn % 5 != 4, outline, sessions, ..Setup::RICH };
        Case { surface, setup, ..case(family, "", "", turn) }
    };
    (0..N_NOTHING).map(set).collect()
}

/// One effect of its typical size.
fn typical(family: Family, id: &'static str, turn: usize) -> Case {
    let asked = Asked { is_mirrored: turn % 2 == 1, ..Asked::typical(id) };
    let setup = Setup { sessions: in_turn(turn), ..Setup::of(id) };
    Case { setup, hidden: vec![asked], ..case(family, id, "", turn) }
}

/// A rig as rough as real ones: surfaces and shapes in turn.
fn rough(setup: Setup, turn: usize) -> Setup {
    const RIGS: [Rig; 5] = [Rig::Rough, Rig::Abs, Rig::Delrin, Rig::Plywood, Rig::Pu];
    let n_pushes = if turn % LARGE_EVERY == LARGE_EVERY - 1 { LARGE } else { setup.n_pushes };
    let (rig, outline) = (RIGS[turn % RIGS.len()], Outline::ALL[turn % Outline::ALL.len()]);
    Setup { rig, outline, n_pushes, ..setup }
}

fn is_shown_by_force_alone(id: &str) -> bool {
    by_id(id).is_ok_and(|effect| effect.info().reaches == [Channel::Force])
}

fn singles() -> Vec<Case> {
    let ids = without(&catalogue(), OF_THE_PUSHES);
    let with = |id: &'static str, turn: usize, times: f64| {
        let asked = Asked { id, size: Size::Nameable(times), is_mirrored: turn % 2 == 1 };
        // The thesis' ellipsoid misses the shape as well.
        let on_ellipsoid = turn % 4 == 3 && id != "limit-surface-shape";
        let surface = if on_ellipsoid { SurfaceKind::Ellipsoid } else { SurfaceKind::UniformPatch };
        let has_force = turn % 6 != 5 || is_shown_by_force_alone(id);
        let setup = Setup { has_force, sessions: in_turn(turn), ..Setup::of(id) };
        Case {
            surface,
            setup,
            hidden: vec![asked],
            ..case(Family::Single, id, &format!("{times}x"), turn)
        }
    };
    let turns = (0..N_EACH).flat_map(|turn| [4.0, 2.0, 1.0, 0.5].map(|times| (turn, times)));
    assert_eq!(MULTIPLES.len(), 4);
    turns.flat_map(|(turn, times)| ids.iter().map(move |id| with(id, turn, times))).collect()
}

fn pairs() -> Vec<Case> {
    let ids = without(&catalogue(), OF_THE_PUSHES);
    let looks_like = |one: &str, other: &str| {
        by_id(one).is_ok_and(|effect| effect.info().confounders.iter().any(|one| one.id == other))
    };
    let mut pairs: Vec<(&'static str, &'static str)> = Vec::new();
    for (k, one) in ids.iter().enumerate() {
        let others = ids[k + 1..].iter();
        let others = others.filter(|other| !looks_like(one, other) && !looks_like(other, one));
        pairs.extend(others.map(|other| (*one, *other)));
    }
    pairs.shuffle(&mut ChaCha8Rng::seed_from_u64(0));
    let set = |(turn, (one, other)): (usize, (&'static str, &'static str))| {
        let asked =
            |id| Asked { id, size: Size::Nameable(PAIR_MULTIPLE), is_mirrored: turn % 2 == 1 };
        let pushes = [one, other].map(|id| Setup::of(id).pushes);
        let pushes = if pushes.contains(&Pushes::Speeds) { Pushes::Speeds } else { Pushes::Rich };
        let setup = Setup { pushes, sessions: in_turn(turn), ..Setup::RICH };
        let hidden = vec![asked(one), asked(other)];
        Case { setup, hidden, ..case(Family::Pair, &format!("{one}+{other}"), "", turn) }
    };
    pairs.into_iter().take(N_PAIRS).enumerate().map(set).collect()
}

fn narrow() -> Vec<Case> {
    let set = |turn: usize| {
        let id = NARROW[turn % NARROW.len()];
        let has_force = (turn / NARROW.len()).is_multiple_of(2);
        let setup = Setup { pushes: Pushes::Narrow, n_pushes: 100, has_force, ..Setup::RICH };
        let asked = Asked { id, size: Size::Nameable(NARROW_MULTIPLE), is_mirrored: turn % 2 == 1 };
        let case = case(Family::Narrow, id, "", turn);
        Case { setup, hidden: vec![asked], ..case }
    };
    (0..N_NARROW).map(set).collect()
}

fn untestable() -> Vec<Case> {
    let of_force = catalogue().into_iter().filter(|id| is_shown_by_force_alone(id));
    let ids: Vec<_> = of_force.chain(["edge-rounding"]).collect();
    each(N_EACH, &ids, |id, turn| {
        let has_force = !is_shown_by_force_alone(id);
        // Pushes at the middle of an edge say nothing about its corners.
        let pushes = if has_force { Pushes::Central } else { Pushes::Rich };
        let setup = Setup { pushes, has_force, sessions: in_turn(turn), ..Setup::RICH };
        Case { setup, ..typical(Family::Untestable, id, turn) }
    })
}

fn robust() -> Vec<Case> {
    let mut cases = each(N_ROBUST, &catalogue(), |id, turn| {
        let mut variants = Variant::SAME.to_vec();
        // Places in time are what this effect is about.
        variants.retain(|variant| id != "friction-drift" || *variant != Variant::Reordered);
        if OF_THE_WORLD.contains(&id) {
            variants.push(Variant::Shuffled);
        }
        Case { variants, ..typical(Family::Robust, id, turn) }
    });
    let shuffled = |turn: usize| Case {
        variants: [Variant::SAME.as_slice(), &[Variant::Shuffled]].concat(),
        ..case(Family::Robust, "", "nothing", turn)
    };
    cases.extend((0..4 * N_ROBUST).map(shuffled));
    cases
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use clap::ValueEnum;

    use super::super::case::Family;
    use super::cases;

    #[test]
    fn names_and_seeds_of_all_trials_differ() {
        let all: Vec<_> = Family::value_variants().iter().flat_map(|f| cases(*f, 1000)).collect();
        let names: BTreeSet<_> = all.iter().map(|case| case.name.as_str()).collect();
        let seeds: BTreeSet<_> = all.iter().map(|case| case.seed).collect();
        assert_eq!((names.len(), seeds.len()), (all.len(), all.len()));
    }

    #[test]
    fn every_effect_is_hidden_alone_twelve_times_at_each_size() {
        let singles = cases(Family::Single, 0);
        let of = |times: f64| singles.iter().filter(|case| case.multiple() == Some(times)).count();
        assert_eq!([0.5, 1.0, 2.0, 4.0].map(of), [23 * 12; 4]);
    }
}
