//! The steps of a table with what a comparison asks of them.

use std::collections::{HashMap, HashSet};
use std::fmt;

use dataset::{
    Flags, MANIFEST_NAME, Manifest, ObjectChoice, StepRow, SupportSpec, Table, TableMapping,
};
use effects::{Channel, Channels, Track};
use models::{
    ChannelModel, ChannelObservation, Cluster, Description, Excluded, Split, StepSelection,
};
use serde::Serialize;
use sha2::{Digest, Sha256};

use crate::data::clusters::{clusters, numbered};
use crate::data::kept_steps::kept;
use crate::{Covariate, DiagnosisError, Runs};

/// Observed steps, the push of each, and the nominal table.
#[derive(Clone, Debug)]
pub struct Observations {
    pub(crate) steps: Vec<ChannelObservation>,
    pub(crate) places: Vec<Place>,
    /// Index of the push of each step.
    pub(crate) push_of: Vec<usize>,
    /// Index of what shares errors, for each step: the session where the whole set has enough, else the
    /// push. Every step of a push has the same; a part keeps those of the whole.
    pub(crate) cluster_of: Vec<usize>,
    pub(crate) cluster: Cluster,
    pub(crate) pushes: Vec<PushName>,
    pub(crate) support: SupportSpec,
    /// SHA-256 over the hashes of the recordings.
    pub(crate) set: String,
    /// The set's name in its manifest.
    pub(crate) name: String,
    /// What was not measured.
    pub(crate) unknown: Vec<Covariate>,
    pub(crate) excluded: Excluded,
    /// Where pushes are runs of rows.
    pub(crate) runs: Option<Runs>,
}

/// A push by its recording and its number there.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct PushName {
    /// The recording.
    pub recording: String,
    /// 0-based number within the recording.
    pub push: u32,
}

impl fmt::Display for PushName {
    /// `recording#push`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}#{}", self.recording, self.push)
    }
}

/// Where and how a step is, as the table states it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    pub(crate) step: u32,
    pub(crate) edge: u32,
    pub(crate) p: f64,
    pub(crate) beta: f64,
    pub(crate) speed: f64,
    pub(crate) flags: Flags,
    /// Of the object's pose at both ends, from the samples' noise: position (m) and yaw (rad).
    pub(crate) pose_sd: [[f64; 2]; 2],
    /// Whether the step is a whole push, of which the ends alone are known.
    pub(crate) is_whole: bool,
}

/// What steps are about.
struct EffectInfo<'a> {
    object: &'a ObjectChoice,
    /// In m.
    pusher_radius: f64,
    support: SupportSpec,
}

impl<'a> EffectInfo<'a> {
    fn of(manifest: &'a Manifest) -> Self {
        let (pusher_radius, support) = (manifest.pusher.radius, manifest.support);
        Self { object: &manifest.object, pusher_radius, support }
    }
}

/// Fewer pushes say nothing about errors that are shared within a push.
pub(crate) const FEWEST_PUSHES: usize = 3;

impl Observations {
    /// The steps in contact of a table about the set of a manifest.
    ///
    /// # Errors
    /// `Model` for a row that is no step; `TooFewPushes`.
    pub fn of(table: &Table, manifest: &Manifest) -> Result<Self, DiagnosisError> {
        Self::selected(table, &EffectInfo::of(manifest), StepSelection::default(), |_| true)
    }

    /// The steps of a table of others, read through its mapping.
    ///
    /// What the mapping does not give was not measured: without poses the contact gap, the object's
    /// place and orientation and the direction in the world, without times the order. Rows without
    /// poses that share their errors count as steps of one push, see [`Observations::runs`].
    ///
    /// # Errors
    /// As [`Observations::of`].
    pub fn of_mapped(table: &Table, mapping: &TableMapping) -> Result<Self, DiagnosisError> {
        let all = Self::of_rows(table, mapping)?;
        // Poses would tell which steps follow each other.
        if mapping.gives("object_x_m") { Ok(all) } else { all.in_runs(mapping.pusher.friction) }
    }

    /// The same, each row without ids a push of its own, whatever it shares with others.
    ///
    /// # Errors
    /// As [`Observations::of`].
    pub fn of_rows(table: &Table, mapping: &TableMapping) -> Result<Self, DiagnosisError> {
        let object = ObjectChoice::Fixed(Box::new(mapping.object.clone()));
        let (pusher_radius, support) = (mapping.pusher.radius, mapping.support);
        let about = EffectInfo { object: &object, pusher_radius, support };
        let mut all = Self::selected(table, &about, StepSelection::default(), |_| true)?;
        if !mapping.gives("object_theta_rad") {
            all.unknown.extend([Covariate::Orientation, Covariate::Direction]);
        }
        if !mapping.gives("object_x_m") {
            for step in &mut all.steps {
                let numbers = Channels::KINDS.iter().zip(&mut step.observed);
                let gaps = numbers.filter(|(kind, _)| **kind == Channel::Gap);
                gaps.for_each(|(_, value)| *value = None);
            }
            all.unknown.extend([Covariate::TableX, Covariate::TableY]);
        }
        Ok(all)
    }

    /// As [`Observations::of`], without steps whose noise is of another kind: the first touch, with
    /// its peak of force, those near a vertex, where the outline's normal jumps, and those within which the
    /// pusher starts or stops. For tables that were made with [`crate::steady_ingest`].
    ///
    /// # Errors
    /// As [`Observations::of`].
    pub fn steady(table: &Table, manifest: &Manifest) -> Result<Self, DiagnosisError> {
        let vertex = Flags::VERTEX | Flags::NEAR_VERTEX | Flags::EDGE_CHANGED;
        let without = StepSelection::default().without | vertex | Flags::FIRST_TOUCH;
        Self::selected(table, &EffectInfo::of(manifest), StepSelection { without }, goes_steadily)
    }

    fn selected(
        table: &Table,
        about: &EffectInfo<'_>,
        selection: StepSelection,
        is_wanted: fn(&Track) -> bool,
    ) -> Result<Self, DiagnosisError> {
        let EffectInfo { object, pusher_radius, support } = *about;
        let found = selection.channel_steps(table, object, pusher_radius)?;
        let (steps, rows, excluded) = kept(found, table, is_wanted);
        let rows: Vec<&StepRow> = rows.iter().map(|row| &table.rows[*row]).collect();
        let (mut pushes, mut known) = (Vec::new(), HashMap::new());
        let mut push = |row: &&StepRow| {
            let name = PushName { recording: row.recording.to_string(), push: row.push };
            *known.entry(name.clone()).or_insert_with(|| {
                pushes.push(name);
                pushes.len() - 1
            })
        };
        let push_of: Vec<usize> = rows.iter().map(&mut push).collect();
        let (cluster, cluster_of) = clusters(&steps, &push_of);
        let place = |row: &&StepRow| {
            let StepRow { step, edge, p, beta, speed, flags, .. } = **row;
            let start_sd = [row.start_position_sd, row.start_angle_sd];
            let pose_sd = [start_sd, [row.end_position_sd, row.end_angle_sd]];
            let is_whole = row.is_whole_push();
            Place { step, edge, p, beta, speed, flags, pose_sd, is_whole }
        };
        let observations = Self {
            places: rows.iter().map(place).collect(),
            steps,
            push_of,
            cluster_of,
            cluster,
            pushes,
            support,
            set: set_digest(table),
            name: table.provenance.get("set").unwrap_or_default().to_owned(),
            unknown: unknown(&rows),
            excluded,
            runs: None,
        };
        observations.checked()
    }

    /// The pushes that a part of a split names, such as `recording#0`; names of pushes that have no
    /// step here are passed over.
    ///
    /// # Errors
    /// `TooFewPushes`.
    pub fn part(&self, names: &[String]) -> Result<Self, DiagnosisError> {
        let names: HashSet<&str> = names.iter().map(String::as_str).collect();
        let is_kept = |push: &usize| names.contains(self.pushes[*push].to_string().as_str());
        let kept: Vec<usize> = (0..self.pushes.len()).filter(is_kept).collect();
        let place_of: HashMap<usize, usize> = kept.iter().copied().zip(0..).collect();
        let steps: Vec<usize> = (0..self.n_steps())
            .filter(|step| place_of.contains_key(&self.push_of[*step]))
            .collect();
        let kept_steps: Vec<_> = steps.iter().map(|step| self.steps[*step].clone()).collect();
        let push_of: Vec<usize> = steps.iter().map(|step| place_of[&self.push_of[*step]]).collect();
        let cluster_of = numbered(steps.iter().map(|step| self.cluster_of[*step]));
        let part = Self {
            steps: kept_steps,
            places: steps.iter().map(|step| self.places[*step]).collect(),
            push_of,
            cluster_of,
            cluster: self.cluster,
            pushes: kept.iter().map(|push| self.pushes[*push].clone()).collect(),
            support: self.support,
            set: self.set.clone(),
            name: self.name.clone(),
            unknown: self.unknown.clone(),
            excluded: self.excluded.clone(),
            runs: self.runs,
        };
        part.checked()
    }

    /// A covariate's value at each step.
    pub(crate) fn values_of(&self, covariate: Covariate) -> Vec<f64> {
        (0..self.n_steps()).map(|step| self.value_of(covariate, step)).collect()
    }

    /// A covariate's value at a step.
    pub(crate) fn value_of(&self, covariate: Covariate, step: usize) -> f64 {
        let (input, place) = (&self.steps[step].input, &self.places[step]);
        match covariate {
            Covariate::P => place.p,
            Covariate::Beta => place.beta,
            Covariate::Speed => place.speed,
            Covariate::Orientation => planar::wrap_angle(input.pose_wb.angle),
            Covariate::Direction => {
                let velocity = input.track.mean_velocity();
                velocity.y.atan2(velocity.x)
            }
            Covariate::TableX => input.pose_wb.position.x,
            Covariate::TableY => input.pose_wb.position.y,
            Covariate::Time => input.progress,
            Covariate::Edge => f64::from(place.edge),
        }
    }

    /// Whether a split is of these recordings.
    pub fn are_of(&self, split: &Split) -> bool {
        split.set == self.set
    }

    /// Values at which an effect changes nothing of a model on these steps.
    ///
    /// # Errors
    /// `Model` for a learnt model, or for what the model refuses.
    pub fn off(
        &self,
        model: &Description,
        about: &effects::EffectInfo,
    ) -> Result<Vec<f64>, DiagnosisError> {
        let model = ChannelModel::new(model, self.support, &[])?;
        let physics = model.physics(&self.steps[0].input.object)?;
        Ok(about.off(physics.rig()))
    }

    /// Whether a number of one of the channels was observed at some step.
    pub(crate) fn show(&self, channels: &[Channel]) -> bool {
        let is_shown = |(number, value): (usize, &Option<f64>)| {
            value.is_some() && channels.contains(&Channels::KINDS[number])
        };
        self.steps.iter().any(|step| step.observed.iter().enumerate().any(is_shown))
    }

    /// What an estimate from these observations names as its source.
    pub(crate) fn source(&self) -> String {
        let (pushes, steps) = (self.pushes.len(), self.steps.len());
        format!("fit to {pushes} pushes ({steps} steps) of {}, sha256:{}", self.name, self.set)
    }

    fn checked(self) -> Result<Self, DiagnosisError> {
        match self.pushes.len() {
            FEWEST_PUSHES.. => Ok(self),
            n_pushes => Err(self.too_few(n_pushes, FEWEST_PUSHES)),
        }
    }

    /// The error for fewer pushes than are needed.
    pub(crate) fn too_few(&self, n_pushes: usize, needed: usize) -> DiagnosisError {
        DiagnosisError::TooFewPushes { n_pushes, needed, excluded: self.excluded.to_string() }
    }

    /// Whether the covariate was measured.
    pub(crate) fn knows(&self, covariate: Covariate) -> bool {
        !self.unknown.contains(&covariate)
    }

    /// How far the pusher moves in a step, in m.
    pub(crate) fn way(&self, step: usize) -> f64 {
        let track = &self.steps[step].input.track;
        (track.end() - track.start()).norm()
    }

    /// The first step of each push.
    pub(crate) fn first_steps(&self) -> Vec<usize> {
        let mut first = vec![0; self.pushes.len()];
        for (step, push) in self.push_of.iter().enumerate().rev() {
            first[*push] = step;
        }
        first
    }

    /// How many pushes some steps are of.
    pub(crate) fn n_pushes_of(&self, steps: &[usize]) -> usize {
        steps.iter().map(|step| self.push_of[*step]).collect::<HashSet<_>>().len()
    }

    /// How many steps there are.
    pub fn n_steps(&self) -> usize {
        self.steps.len()
    }

    /// The pushes, in the order of the table.
    pub fn pushes(&self) -> &[PushName] {
        &self.pushes
    }

    /// What was observed of each step.
    pub fn steps(&self) -> &[ChannelObservation] {
        &self.steps
    }

    /// Whether a step begins where the one before it ends.
    pub(crate) fn goes_on(&self, index: usize) -> bool {
        index > 0
            && self.push_of[index - 1] == self.push_of[index]
            && self.places[index - 1].step + 1 == self.places[index].step
    }

    /// The channels that are observed at any step.
    pub fn channels(&self) -> Vec<Channel> {
        let of = |channel: Channel, step: &ChannelObservation| {
            let numbers = Channels::KINDS.iter().zip(&step.observed);
            numbers.into_iter().any(|(kind, value)| *kind == channel && value.is_some())
        };
        let is_there = |channel: &Channel| self.steps.iter().any(|step| of(*channel, step));
        Channel::ALL.into_iter().filter(is_there).collect()
    }

    /// Rows of the whole table that are not compared.
    pub fn excluded(&self) -> &Excluded {
        &self.excluded
    }
}

/// What rows do not tell: where all are at one time, it was not known.
fn unknown(rows: &[&StepRow]) -> Vec<Covariate> {
    let is_timeless = rows.windows(2).all(|pair| pair[0].t == pair[1].t);
    if is_timeless { vec![Covariate::Time] } else { Vec::new() }
}

/// Whether the pusher moves on during all of a step: at its ends it is no slower than half its
/// mean velocity.
fn goes_steadily(track: &Track) -> bool {
    let mean = track.mean_velocity();
    [0.0, track.duration()].iter().all(|time| track.at(*time).1.dot(&mean) > 0.5 * mean.dot(&mean))
}

/// SHA-256 over the sources of a table that are not the set's own files, in their order.
fn set_digest(table: &Table) -> String {
    let mut hash = Sha256::new();
    let is_recording =
        |source: &str| !SET_FILES.iter().any(|name| source.ends_with(&format!(" {name}")));
    for (key, source) in &table.provenance.entries {
        if key == "source" && is_recording(source) {
            hash.update(source);
            hash.update("\n");
        }
    }
    format!("{:x}", hash.finalize())
}

/// What may be edited without making it another set.
const SET_FILES: [&str; 2] = [MANIFEST_NAME, "sessions.csv"];
