//! The same set, told or asked otherwise.

use std::collections::BTreeSet;
use std::sync::Arc;

use anyhow::{Context, Result, ensure};
use dataset::{RecordingSet, Table};
use models::{Analytical, Base, Description, Estimate};
use nalgebra::Vector2;
use planar::Pose;
use plant::Nominal;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// What is changed; the verdict should be the same, but for `Shuffled` and [`Variant::WRONG`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Variant {
    /// Four in five of the pushes, drawn without replacement: twice the same push would pass for
    /// a repeat without noise.
    Subsample,
    /// Another choice of the held-out pushes.
    OtherSplit,
    /// One of each group of repeats alone: the noise has to come from neighbours.
    WithoutRepeats,
    /// One step in twenty is off by 0.3 mm and 0.8°.
    Outliers,
    /// The table's pushes in another order.
    Reordered,
    /// The nominal friction of the pusher is a fifth too small.
    WrongNominal,
    /// The manifest's tip is a fifth too thin.
    WrongRadius,
    /// The manifest's object is a fifth too light.
    WrongMass,
    /// Every push at the place, orientation and time of another one.
    Shuffled,
}

/// Share of the pushes that a subsample keeps.
const KEPT: f64 = 0.8;
const OUTLIER_SHARE: f64 = 0.05;
const OUTLIER: [f64; 2] = [3e-4, 0.8 * std::f64::consts::PI / 180.0];
/// Seed of the usual choice of held-out pushes, and of the other one.
pub(super) const SPLIT_SEED: u64 = 7;
const OTHER_SPLIT_SEED: u64 = 8;
const WRONG_BY: f64 = 0.8;
/// Side (m) and mass (kg) of the square that is pushed.
const SQUARE: (f64, f64) = (0.09, 0.8374);

impl Variant {
    /// Those after which the verdict should be the same.
    pub(super) const SAME: [Self; 5] =
        [Self::Subsample, Self::OtherSplit, Self::WithoutRepeats, Self::Outliers, Self::Reordered];

    /// Those after which the verdict should say which number is wrong, and nothing else be another.
    pub(super) const WRONG: [Self; 3] = [Self::WrongNominal, Self::WrongRadius, Self::WrongMass];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Subsample => "four fifths of the pushes",
            Self::OtherSplit => "another choice of held-out pushes",
            Self::WithoutRepeats => "noise from neighbours instead of repeats",
            Self::Outliers => "5 % outliers",
            Self::Reordered => "pushes in another order",
            Self::WrongNominal => "nominal friction of the pusher 20 % too small",
            Self::WrongRadius => "radius of the tip 20 % too small",
            Self::WrongMass => "mass of the object 20 % too small",
            Self::Shuffled => "places, orientations and times shuffled",
        }
    }

    /// The effect that says what is wrong; none if nothing is.
    pub(super) fn effect(self) -> Option<&'static str> {
        match self {
            Self::WrongNominal => Some("pusher-friction"),
            Self::WrongRadius => Some("pusher-radius"),
            // What the table's friction carries is mass times friction: either is as wrong.
            Self::WrongMass => Some("support-friction"),
            _ => None,
        }
    }

    /// The manifest as it is told.
    ///
    /// # Errors
    /// A manifest without the line that is to be wrong.
    pub(super) fn manifest(self, text: &str) -> Result<String> {
        let nominal = Nominal::default();
        let (line, told) = match self {
            Self::WrongRadius => {
                let radius = nominal.pusher_radius;
                (format!("radius_m = {radius:?}"), format!("radius_m = {:?}", WRONG_BY * radius))
            }
            Self::WrongMass => {
                let (side, mass) = (SQUARE.0, WRONG_BY * SQUARE.1);
                let told = format!("shape = \"square\"\nside_m = {side:?}\nmass_kg = {mass:?}");
                ("shape = \"rect1\"".to_owned(), told)
            }
            _ => return Ok(text.to_owned()),
        };
        ensure!(text.contains(&line), "the manifest has no line {line}");
        Ok(text.replace(&line, &told))
    }

    pub(super) fn split_seed(self) -> u64 {
        if self == Self::OtherSplit { OTHER_SPLIT_SEED } else { SPLIT_SEED }
    }

    /// The model under test.
    ///
    /// # Errors
    /// A model without physics.
    pub(super) fn model(self, model: &Description) -> Result<Description> {
        let Base::Analytical(base) = &model.base else { anyhow::bail!("the model has no physics") };
        if self != Self::WrongNominal {
            return Ok(model.clone());
        }
        let friction = Estimate::exact(WRONG_BY * base.pusher_friction().value, "wrong on purpose");
        let wrong = Analytical::new(friction, base.length().clone(), *base.scatter())?;
        let wrong = wrong.with_surface(base.surface())?;
        Ok(Description { base: Base::Analytical(wrong), ..model.clone() })
    }

    /// The steps as they are told.
    ///
    /// # Errors
    /// A recording that the set's sessions do not know.
    pub(super) fn table(self, table: &Table, set: &RecordingSet, seed: u64) -> Result<Table> {
        let mut told = table.clone();
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        match self {
            Self::OtherSplit | Self::WrongNominal | Self::WrongRadius | Self::WrongMass => {}
            Self::Subsample => {
                let mut pushes = recordings(table);
                pushes.shuffle(&mut random);
                pushes.truncate((KEPT * pushes.len() as f64).round() as usize);
                let kept: BTreeSet<_> = pushes.into_iter().collect();
                told.rows.retain(|row| kept.contains(&row.recording));
            }
            Self::WithoutRepeats => {
                let mut seen = BTreeSet::new();
                let mut kept = BTreeSet::new();
                for name in recordings(table) {
                    let session = set.session(&name).context("sessions.csv lacks a push")?;
                    if session.repeat.is_empty() || seen.insert(session.repeat.clone()) {
                        kept.insert(name);
                    }
                }
                told.rows.retain(|row| kept.contains(&row.recording));
            }
            Self::Outliers => {
                for row in &mut told.rows {
                    if random.random_bool(OUTLIER_SHARE) {
                        let angle = random.random_range(0.0..std::f64::consts::TAU);
                        row.dx += OUTLIER[0] * angle.cos();
                        row.dy += OUTLIER[0] * angle.sin();
                        row.dtheta += OUTLIER[1] * if random.random_bool(0.5) { 1.0 } else { -1.0 };
                    }
                }
            }
            Self::Reordered => {
                let mut order = recordings(table);
                order.shuffle(&mut random);
                let place = |name: &Arc<str>| order.iter().position(|other| other == name);
                told.rows.sort_by_key(|row| (place(&row.recording), row.push, row.step));
            }
            Self::Shuffled => shuffle(&mut told, &mut random),
        }
        Ok(told)
    }
}

/// The recordings, in the order of the table; each is one push.
pub(super) fn recordings(table: &Table) -> Vec<Arc<str>> {
    let mut names: Vec<Arc<str>> = table.rows.iter().map(|row| row.recording.clone()).collect();
    names.dedup();
    names
}

/// Moves every push, rigidly, to where and when another push of its session began.
fn shuffle(table: &mut Table, random: &mut ChaCha8Rng) {
    let names = recordings(table);
    let first = |name: &Arc<str>| table.rows.iter().find(|row| row.recording == *name);
    let starts: Vec<(Pose, f64, Option<Arc<str>>)> = names
        .iter()
        .filter_map(first)
        .map(|row| (row.object_pose, row.t, row.session.clone()))
        .collect();
    let mut partners: Vec<usize> = (0..names.len()).collect();
    let mut sessions: Vec<&Option<Arc<str>>> = starts.iter().map(|start| &start.2).collect();
    sessions.sort();
    sessions.dedup();
    for session in sessions {
        let own: Vec<usize> = (0..names.len()).filter(|k| starts[*k].2 == *session).collect();
        let mut others = own.clone();
        others.shuffle(random);
        own.into_iter().zip(others).for_each(|(push, other)| partners[push] = other);
    }
    for row in &mut table.rows {
        let Some(push) = names.iter().position(|name| *name == row.recording) else { continue };
        let ((from, t, _), (to, other_t, _)) = (&starts[push], &starts[partners[push]]);
        let moved = *to * from.inverse();
        let turned = |v: Vector2<f64>| moved.rotate(&v);
        row.object_pose = moved * row.object_pose;
        row.object_twist.linear = turned(row.object_twist.linear);
        row.pusher_start = moved.transform_point(&row.pusher_start);
        row.pusher_end = moved.transform_point(&row.pusher_end);
        row.pusher_velocity = turned(row.pusher_velocity);
        row.pusher_acceleration = turned(row.pusher_acceleration);
        row.contact_point = moved.transform_point(&row.contact_point);
        row.contact_normal = turned(row.contact_normal);
        row.t += other_t - t;
    }
}

#[cfg(test)]
mod tests {
    use dataset::{RecordingSet, Table, ingest};
    use diagnosis::{Observations, steady_ingest};
    use plant::generate;

    use super::super::case::Setup;
    use super::{Variant, recordings};

    fn with_tables(test: impl Fn(&Table, &RecordingSet, &dyn Fn(Variant) -> Table)) {
        let folder = tempfile::tempdir().unwrap();
        let rig = Setup { n_pushes: 20, ..Setup::RICH }.rig(7);
        let set = generate(&rig, &folder.path().join("set")).unwrap().set;
        let set = RecordingSet::open(&set).unwrap();
        let table = ingest(&set, &steady_ingest()).unwrap().0;
        test(&table, &set, &|variant| variant.table(&table, &set, 7).unwrap());
    }

    #[test]
    fn a_manifest_that_is_wrong_is_so_in_one_number() {
        let text = "[object]\nshape = \"rect1\"\n\n[pusher]\nradius_m = 0.00475\n";
        let changed = |variant: Variant| {
            let told = variant.manifest(text).unwrap();
            text.lines().filter(|line| !told.contains(line)).count()
        };
        let all =
            [Variant::WrongRadius, Variant::WrongMass, Variant::WrongNominal, Variant::Outliers];
        assert_eq!(all.map(changed), [1, 1, 0, 0]);
        assert!(Variant::WrongMass.manifest("shape = \"tri1\"").is_err());
    }

    #[test]
    fn each_variant_changes_what_it_says_and_nothing_else() {
        with_tables(|table, set, told| {
            let n = recordings(table).len();
            let fewer = recordings(&told(Variant::Subsample)).len();
            assert_eq!(fewer, (0.8 * n as f64).round() as usize);
            let rows = |table: &Table| {
                let mut rows = table.rows.clone();
                rows.sort_by_key(|row| (row.recording.clone(), row.push, row.step));
                rows
            };
            let reordered = told(Variant::Reordered);
            assert_ne!(recordings(&reordered), recordings(table));
            assert_eq!(rows(&reordered), rows(table));
            let single = told(Variant::WithoutRepeats);
            let repeats = recordings(&single).into_iter().filter_map(|name| {
                let repeat = &set.session(&name)?.repeat;
                (!repeat.is_empty()).then(|| repeat.clone())
            });
            let mut repeats: Vec<_> = repeats.collect();
            let n_repeats = repeats.len();
            repeats.sort();
            repeats.dedup();
            assert_eq!((repeats.len(), n_repeats), (4, 4));
            let outliers = told(Variant::Outliers);
            let pairs = outliers.rows.iter().zip(&table.rows);
            let n_off = pairs.filter(|(one, other)| one.dx != other.dx).count() as f64;
            let share = n_off / table.rows.len() as f64;
            assert!((0.01..0.12).contains(&share), "{share}");
        });
    }

    #[test]
    fn shuffled_pushes_are_elsewhere_and_look_the_same_to_the_pusher() {
        with_tables(|table, set, told| {
            let shuffled = told(Variant::Shuffled);
            let of = |table: &Table| Observations::steady(table, set.manifest()).unwrap();
            let (before, after) = (of(table), of(&shuffled));
            let mut n_moved = 0;
            for (one, other) in before.steps().iter().zip(after.steps()) {
                assert_eq!(one.observed, other.observed);
                let tip = |step: &models::ChannelObservation| {
                    step.input.pose_wb.inverse_transform_point(&step.input.track.start())
                };
                assert!((tip(one) - tip(other)).norm() < 1e-12);
                n_moved += usize::from(one.input.pose_wb.angle != other.input.pose_wb.angle);
            }
            assert!(2 * n_moved > before.n_steps());
        });
    }
}
