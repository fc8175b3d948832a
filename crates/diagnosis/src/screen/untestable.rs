//! Why data cannot show an effect, and what to measure.

use effects::{
    Channel, Effect, EffectInfo, Frame, FrictionField, FrictionGradient, Origin, Role, Stage,
};
use serde::Serialize;

use crate::cut_offs::ONE_SPEED;
use crate::data::coverage::Coverage;
use crate::predict::candidates::{Candidate, Candidates};
use crate::statistics::score::{Score, detectable};
use crate::{Covariate, Observations};

/// Why an effect cannot be tested with these data; it is not called absent.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NotTestable {
    /// The kind of reason.
    pub reason: Reason,
    /// The reason in words, to follow "because".
    pub because: String,
    /// What to measure, to follow "measure".
    pub measure: String,
}

/// Kinds of reasons.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Reason {
    /// No number that it changes was measured.
    NoChannel,
    /// What it depends on was not measured.
    NoCovariate,
    /// It changes what was measured by too little, even at three times its usual size, and is not seen.
    Weak,
    /// What it changes is what a nominal value that is not known well changes, too, and it is not seen.
    Nuisance,
}

impl Reason {
    /// Whether it holds for usual sizes alone: what is far larger may be seen.
    pub(crate) fn is_of_size(self) -> bool {
        matches!(self, Self::Weak | Self::Nuisance)
    }
}

/// The reason, if an effect of three times its usual size would be missed more often than one time
/// in ten.
pub(crate) fn untestable(
    observations: &Observations,
    candidates: &Candidates,
    candidate: &Candidate,
    scale: &[f64],
    score: Option<&Score>,
) -> Option<NotTestable> {
    let about = candidate.effect.info();
    if let Some(lacking) = lacking(observations, about) {
        return Some(lacking);
    }
    let seen = observations.channels();
    let reaches: Vec<Channel> = about.reaches.to_vec();
    let is_seen = |information: &nalgebra::DMatrix<f64>| {
        let freedom = information.nrows();
        let ratio = |k: usize| {
            let index = candidate.coordinates.start + k;
            candidates.prior_sd[index] / scale[index]
        };
        let scaled = nalgebra::DMatrix::from_fn(freedom, freedom, |i, j| {
            ratio(i) * information[(i, j)] * ratio(j)
        });
        let largest = scaled.symmetric_eigenvalues().max().max(0.0);
        largest.sqrt() > detectable(freedom)
    };
    let lacks_force = reaches.contains(&Channel::Force) && !seen.contains(&Channel::Force);
    let score = score.filter(|score| !is_seen(&score.information))?;
    let (reason, because) = if reaches.iter().all(|channel| !seen.contains(channel)) {
        let names: Vec<&str> = reaches.iter().map(|channel| name(*channel)).collect();
        (
            Reason::NoChannel,
            format!("it shows in the {} alone, which was not measured", names.join(" and ")),
        )
    } else if !is_seen(&score.plain_information) {
        let because = match lacks_force {
            true => "it hardly changes the motion, and the force was not measured".to_owned(),
            false => "at three times its usual size it is still within the noise".to_owned(),
        };
        (Reason::Weak, because)
    } else {
        let rival = rival(candidates, score);
        (
            Reason::Nuisance,
            format!("in these pushes it looks like {rival}, whose value is not known well"),
        )
    };
    let measure = advice(&Coverage::of(observations), about, lacks_force);
    Some(NotTestable { reason, because, measure })
}

/// The reason, if what an effect depends on does not differ in these observations or is not known, such
/// as the object's orientation for what acts along directions of the table.
pub fn lacking(observations: &Observations, about: &EffectInfo) -> Option<NotTestable> {
    let lacks = |because: &str, measure: &str| {
        let (because, measure) = (because.to_owned(), measure.to_owned());
        Some(NotTestable { reason: Reason::NoCovariate, because, measure })
    };
    // Without the force, a law of friction and speed is a shape of the limit surface at one speed; one of
    // places is not.
    let is_of_speed = about.stages.contains(&Stage::Local) && about.origin != Origin::Table;
    if is_of_speed
        && !observations.channels().contains(&Channel::Force)
        && at_one_speed(observations)
    {
        return lacks(
            "it shows in how pushes at different speeds differ, and these are all at one",
            "pushes at several speeds, or the contact force",
        );
    }
    let is_known = |covariate| !observations.unknown.contains(&covariate);
    let of_place = [Covariate::TableX, Covariate::TableY].into_iter().all(is_known);
    let because = match (fixed_to(about, Frame::World), is_known(Covariate::Orientation), of_place)
    {
        (false, ..) | (true, true, true) => return None,
        (true, false, _) => {
            "it depends on how the object lies on the table, and its orientation is not known"
        }
        (true, true, false) if is_of_place(about) => {
            "it depends on where the object lies on the table, which is not known"
        }
        (true, true, false) => return None,
    };
    lacks(because, "the object's pose on the table")
}

/// Whether nine tenths of the steps are at speeds that hardly differ.
fn at_one_speed(observations: &Observations) -> bool {
    let speeds: Vec<f64> = observations.places.iter().map(|place| place.speed).collect();
    let [low, high] = [0.05, 0.95].map(|share| dataset::quantile(speeds.clone(), share));
    low.zip(high).is_some_and(|(low, high)| high < ONE_SPEED * low)
}

/// Whether it is another one at another place of the table.
fn is_of_place(about: &EffectInfo) -> bool {
    [FrictionGradient.info().id, FrictionField.info().id].contains(&about.id)
}

/// Whether one of an effect's vectors, axes or waves is fixed to a frame.
fn fixed_to(about: &EffectInfo, frame: Frame) -> bool {
    let of_frame = |role: Role| match role {
        Role::X(fixed) | Role::Ratio(fixed) => fixed == frame,
        Role::Wave => frame == Frame::World,
        _ => false,
    };
    about.parameters.iter().any(|parameter| of_frame(parameter.role))
}

fn name(channel: Channel) -> &'static str {
    match channel {
        Channel::Motion => "motion",
        Channel::Force => "contact force",
        Channel::Gap => "gap",
    }
}

/// The nuisance that takes most of the effect.
fn rival(candidates: &Candidates, score: &Score) -> &'static str {
    let share = |k: &usize| score.shares.row(*k).norm();
    let most = (0..score.nuisances.len()).max_by(|a, b| share(a).total_cmp(&share(b)));
    let index = most.map(|k| score.nuisances[k]);
    let owner = candidates
        .effects
        .iter()
        .find(|candidate| index.is_some_and(|index| candidate.coordinates.contains(&index)));
    owner.map_or("another one", |candidate| candidate.effect.info().id)
}

/// What would make an effect show.
fn advice(coverage: &Coverage, about: &EffectInfo, lacks_force: bool) -> String {
    let has = |stage: Stage| about.stages.contains(&stage);
    let mut list = Vec::new();
    if lacks_force {
        list.push("the contact force");
    }
    if coverage.speed[1] < 2.0 * coverage.speed[0]
        && (has(Stage::Local) || has(Stage::Dynamics) || has(Stage::Measurement))
    {
        list.push("pushes at several speeds");
    }
    if fixed_to(about, Frame::World) && coverage.n_orientations < 4 {
        list.push("pushes of the object in other orientations");
    }
    if fixed_to(about, Frame::Body)
        && coverage.steps_on_edges.iter().filter(|n| **n > 0).count() < 2
    {
        list.push("pushes on other edges");
    }
    if has(Stage::Contact) && coverage.beta[1] - coverage.beta[0] < 1.0 {
        list.push("pushes up to 45° from the normal");
    }
    list.extend(about.shown_by);
    if list.is_empty() {
        list.push("more pushes");
    }
    list.join(", and ")
}
