//! What pushes a set has.

use std::collections::BTreeSet;
use std::f64::consts::{PI, TAU};

use planar::wrap_angle;
use serde::Serialize;

use crate::data::repeats::cells;
use crate::{Covariate, Observations, RepeatTolerance};

/// Where the steps of a set lie, in SI units; ranges are from smallest to largest.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Coverage {
    /// Pushes.
    pub n_pushes: usize,
    /// Steps.
    pub n_steps: usize,
    /// Measuring sessions; 1 where none are known.
    pub n_sessions: usize,
    /// Pushes that are done more than once.
    pub n_cells: usize,
    /// How often those are done in all.
    pub n_repeated: usize,
    /// Place of the contact along its edge, 0 to 1.
    pub p: [f64; 2],
    /// Angle of the push from the inward normal, in rad.
    pub beta: [f64; 2],
    /// Speed of the pusher, in m/s.
    pub speed: [f64; 2],
    /// Steps on each edge.
    pub steps_on_edges: Vec<usize>,
    /// Twelfths of the circle in which the object's yaw lies.
    pub n_orientations: usize,
    /// Place of the object on the table along x and y, in m.
    pub table: [[f64; 2]; 2],
    /// Time in contact, in s.
    pub contact_time: f64,
}

const N_SECTORS: usize = 12;

impl Observations {
    /// What the rows do not tell of a step: what a coverage says of it says nothing.
    pub fn unknown(&self) -> &[Covariate] {
        &self.unknown
    }
}

impl Coverage {
    /// Of observations.
    pub fn of(observations: &Observations) -> Self {
        let (places, steps) = (&observations.places, &observations.steps);
        let last = places.iter().map(|place| place.edge).max().unwrap_or_default();
        let mut steps_on_edges = vec![0; last as usize + 1];
        places.iter().for_each(|place| steps_on_edges[place.edge as usize] += 1);
        let sector = |step: &models::ChannelObservation| {
            let yaw = wrap_angle(step.input.pose_wb.angle);
            ((yaw + PI) / TAU * N_SECTORS as f64) as usize % N_SECTORS
        };
        let cells = cells(observations, &RepeatTolerance::default());
        let n_members = |cell: usize| cells.iter().filter(|other| **other == cell).count();
        let members = (0..cells.len()).map(n_members).filter(|n| *n > 1);
        let (n_cells, n_repeated) = members.fold((0, 0), |(n, sum), own| (n + 1, sum + own));
        let sessions: BTreeSet<u32> = steps.iter().map(|step| step.input.session).collect();
        Self {
            n_pushes: observations.pushes.len(),
            n_steps: steps.len(),
            n_sessions: sessions.len(),
            n_cells,
            n_repeated,
            p: range(places.iter().map(|place| place.p)),
            beta: range(places.iter().map(|place| place.beta)),
            speed: range(places.iter().map(|place| place.speed)),
            steps_on_edges,
            n_orientations: steps.iter().map(sector).collect::<BTreeSet<_>>().len(),
            table: [0, 1].map(|k| range(steps.iter().map(|step| step.input.pose_wb.position[k]))),
            contact_time: steps.iter().map(|step| step.input.track.duration()).sum(),
        }
    }

    /// What pushes of so few kinds cannot tell, each in a sentence.
    #[must_use]
    pub fn cannot_tell(&self) -> Vec<&'static str> {
        let is_on_one_edge = self.steps_on_edges.iter().filter(|n| **n > 0).count() == 1;
        let is_within = |[low, high]: [f64; 2], most: f64| high - low < most;
        let all = [
            (
                is_on_one_edge && self.n_orientations <= 2,
                "all pushes are on one edge in one orientation: what belongs to the object and what \
                 belongs to the table look alike (friction-center-offset, pose-offset, contact-bias \
                 and friction-gradient; table-anisotropy, body-anisotropy and table-tilt); turn the \
                 object, and push other edges",
            ),
            (
                is_within(self.beta, ONE_ANGLE),
                "all pushes have one angle to the edge: the pusher's friction does not show, nor \
                 what acts when it slides; push up to 45° from the normal",
            ),
            (
                is_within(self.p, ONE_PLACE),
                "all pushes meet one place of an edge: size and shape of the limit surface look \
                 alike; push along the whole edge",
            ),
        ];
        all.into_iter().filter_map(|(is_so, sentence)| is_so.then_some(sentence)).collect()
    }
}

/// Spread of the angles of pushes that are all of one, in rad, and of their places.
const ONE_ANGLE: f64 = 0.25;
const ONE_PLACE: f64 = 0.2;

fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
}
