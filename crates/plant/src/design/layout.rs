//! Which pushes are made.

use planar::Shape;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

use crate::dynamics::outline::Outline;
use crate::error::check_range;
use crate::random::{Purpose, Random};
use crate::truth::Wear;
use crate::{PlannedPush, PlantError};

const USUAL_SPEEDS: [f64; 1] = [0.02];
const THESIS_SPEEDS: [f64; 5] = [0.02, 0.05, 0.1, 0.2, 0.4];
const N_PLACES: usize = 11;
const N_ANGLES: usize = 9;
const THESIS_STEEPEST: f64 = 80.0 * PI / 180.0;
/// Outlines with more edges than this are curves; four of their edges stand for them.
const MOST_EDGES: usize = 8;
/// Distance that the tip keeps at the start, in m.
const CLEARANCE: f64 = 5e-4;
const MAX_DRAWS: usize = 1000;

/// A plan of pushes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Design {
    /// How places, angles and speeds are chosen.
    pub layout: Layout,
    /// Number of pushes; 0 for all of a grid or list.
    pub n_pushes: usize,
    /// Speeds to choose from, in m/s; if there are none, 20 mm/s, or the thesis' five.
    pub speeds: Vec<f64>,
    /// Share of the pushes of a drawn layout that repeat a few of them over and over.
    pub repeat_share: f64,
    /// How many of them are repeated.
    pub n_repeated: usize,
    /// Measuring sessions that the pushes are spread over, in order of time.
    pub n_sessions: usize,
    /// Way after the touch, in m.
    pub travel: f64,
    /// Largest angle from the normal of drawn pushes, in rad.
    pub steepest: f64,
    /// How far the object is laid down from the table's origin at most, along each axis, in m.
    pub spread: f64,
    /// The robot's acceleration, in m/s².
    pub acceleration: f64,
    /// Time at rest before and after the push, in s.
    pub rests: [f64; 2],
}

/// How places, angles and speeds are chosen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Layout {
    /// Any place of the outline, angle, orientation and place on the table.
    Rich,
    /// The thesis' grid: 11 places on each edge, 9 angles up to 80°, each at every speed.
    Thesis,
    /// One edge, one orientation, one place on the table and the first of the speeds; places along
    /// the edge and angles are drawn.
    Narrow {
        /// The edge.
        edge: usize,
    },
    /// As many pushes as are repeated, each equally often.
    Repeats,
    /// These pushes.
    List(Vec<PlannedPush>),
}

impl Default for Design {
    fn default() -> Self {
        Self {
            layout: Layout::Rich,
            n_pushes: 200,
            speeds: Vec::new(),
            repeat_share: 0.15,
            n_repeated: 3,
            n_sessions: 1,
            travel: 0.05,
            steepest: 40.0 * PI / 180.0,
            spread: 0.1,
            acceleration: 10.0,
            rests: [0.2, 0.3],
        }
    }
}

/// The pushes of a design, in order of time, and how many of its grid were left out because the
/// tip would have begun inside the object.
pub(crate) struct Plan {
    pub(crate) pushes: Vec<PlannedPush>,
    pub(crate) n_blocked: usize,
}

impl Design {
    /// The pushes, for a nominal shape and a tip of a nominal radius (m).
    ///
    /// # Errors
    /// `Design` for a design without pushes, `OutOfRange` for one that cannot be done.
    pub(crate) fn plan(&self, shape: &Shape, radius: f64, seed: u64) -> Result<Plan, PlantError> {
        let mut planner =
            Planner { design: self, shape, radius, random: Random::new(seed, Purpose::Design, 0) };
        self.check()?;
        let mut pushes = match &self.layout {
            Layout::List(pushes) => pushes.clone(),
            Layout::Thesis => planner.grid(),
            Layout::Rich | Layout::Narrow { .. } => planner.drawn()?,
            Layout::Repeats => planner.repeats(self.n_pushes)?,
        };
        let is_list = matches!(self.layout, Layout::List(_));
        if !is_list {
            planner.shuffle(&mut pushes);
        }
        if self.n_pushes > 0 {
            pushes.truncate(self.n_pushes);
        }
        let n = pushes.len();
        for (index, push) in pushes.iter().enumerate() {
            push.check(shape).map_err(|source| PlantError::Push {
                name: push_name(index),
                source: Box::new(source),
            })?;
        }
        if !is_list {
            pushes.retain(|push| planner.is_free(push));
        }
        let (n_kept, n_sessions) = (pushes.len(), self.n_sessions.max(1));
        if n_kept == 0 {
            return Err(PlantError::Design { what: "the design makes no pushes".into() });
        }
        if !is_list {
            for (index, push) in pushes.iter_mut().enumerate() {
                push.session = index * n_sessions / n_kept;
            }
        }
        Ok(Plan { pushes, n_blocked: n - n_kept })
    }

    /// The speeds that are chosen from.
    fn speeds(&self) -> &[f64] {
        match self.layout {
            _ if !self.speeds.is_empty() => &self.speeds,
            Layout::Thesis => &THESIS_SPEEDS,
            _ => &USUAL_SPEEDS,
        }
    }

    fn check(&self) -> Result<(), PlantError> {
        let needs_pushes = !matches!(self.layout, Layout::Thesis | Layout::List(_));
        if needs_pushes && self.n_pushes == 0 {
            let what = "a drawn design needs a number of pushes";
            return Err(PlantError::Design { what: what.into() });
        }
        let repeats = matches!(self.layout, Layout::Repeats) || self.repeat_share > 0.0;
        if needs_pushes && repeats && self.n_repeated == 0 {
            let what = "repeats need at least one push that is repeated";
            return Err(PlantError::Design { what: what.into() });
        }
        let ranges = [
            ("repeat_share", self.repeat_share, "", 0.0, 1.0),
            ("travel", self.travel, "m", 1e-4, 1.0),
            ("steepest", self.steepest, "rad", 0.0, 0.49 * PI),
            ("spread", self.spread, "m", 0.0, 10.0),
            ("acceleration", self.acceleration, "m/s²", 0.01, 1000.0),
            ("the rest before", self.rests[0], "s", 0.0, 60.0),
            ("the rest after", self.rests[1], "s", 0.0, 60.0),
        ];
        ranges.into_iter().try_for_each(|(name, value, unit, low, high)| {
            check_range(name, value, unit, (low, high))
        })
    }
}

/// Name of a push, and of its recording.
pub(crate) fn push_name(index: usize) -> String {
    format!("push-{index:04}")
}

struct Planner<'a> {
    design: &'a Design,
    shape: &'a Shape,
    radius: f64,
    random: Random,
}

impl Planner<'_> {
    fn grid(&self) -> Vec<PlannedPush> {
        let n_edges = self.shape.n_edges();
        let edges: Vec<_> = if n_edges <= MOST_EDGES {
            (0..n_edges).collect()
        } else {
            (0..4).map(|k| k * n_edges / 4).collect()
        };
        let mut pushes = Vec::new();
        for &speed in self.design.speeds() {
            for &edge in &edges {
                for place in 0..N_PLACES {
                    for turn in 0..N_ANGLES {
                        let share = turn as f64 / (N_ANGLES - 1) as f64;
                        let p = place as f64 / (N_PLACES - 1) as f64;
                        let angle = THESIS_STEEPEST * (2.0 * share - 1.0);
                        pushes.push(self.push(edge, p, angle, speed, [0.0; 3]));
                    }
                }
            }
        }
        pushes
    }

    fn drawn(&mut self) -> Result<Vec<PlannedPush>, PlantError> {
        let n_repeats = (self.design.repeat_share * self.design.n_pushes as f64).round() as usize;
        let mut pushes = self.repeats(n_repeats)?;
        while pushes.len() < self.design.n_pushes {
            pushes.push(self.draw()?);
        }
        Ok(pushes)
    }

    fn repeats(&mut self, n: usize) -> Result<Vec<PlannedPush>, PlantError> {
        if n == 0 {
            return Ok(Vec::new());
        }
        let name = |index: usize, push: PlannedPush| PlannedPush {
            repeat: format!("repeat-{index}"),
            ..push
        };
        let repeated = (0..self.design.n_repeated)
            .map(|index| Ok(name(index, self.draw()?)))
            .collect::<Result<Vec<_>, PlantError>>()?;
        Ok(repeated.iter().cycle().take(n).cloned().collect())
    }

    /// A push of the layout that does not begin inside the object.
    fn draw(&mut self) -> Result<PlannedPush, PlantError> {
        for _ in 0..MAX_DRAWS {
            let design = self.design;
            let angle = self.random.uniform(-design.steepest, design.steepest);
            let p = self.random.uniform(0.01, 0.99);
            let push = if let Layout::Narrow { edge } = design.layout {
                self.push(edge, p, angle, design.speeds()[0], [0.0; 3])
            } else {
                let edge = self.edge();
                let mut axis = || self.random.uniform(-design.spread, design.spread);
                let (x, y) = (axis(), axis());
                let place = [x, y, self.random.uniform(-PI, PI)];
                let speeds = design.speeds();
                let speed = speeds[self.random.below(speeds.len())];
                self.push(edge, p, angle, speed, place)
            };
            push.check(self.shape)?;
            if self.is_free(&push) {
                return Ok(push);
            }
        }
        let what = format!("{MAX_DRAWS} pushes in a row would begin inside the object");
        Err(PlantError::Design { what })
    }

    /// An edge, the longer the likelier.
    fn edge(&mut self) -> usize {
        let Shape::Polygon(polygon) = self.shape else { return 0 };
        let mut left = self.random.uniform(0.0, polygon.perimeter());
        for (index, (from, to)) in polygon.edges().enumerate() {
            left -= (to - from).norm();
            if left < 0.0 {
                return index;
            }
        }
        0
    }

    fn push(&self, edge: usize, p: f64, angle: f64, speed: f64, place: [f64; 3]) -> PlannedPush {
        let (travel, session, repeat) = (self.design.travel, 0, String::new());
        PlannedPush { edge, p, angle, speed, travel, place, session, repeat }
    }

    /// Whether the tip starts outside of the nominal outline.
    fn is_free(&self, push: &PlannedPush) -> bool {
        let Ok(outline) = Outline::new(self.shape, &Wear::default()) else { return false };
        let at_origin = PlannedPush { place: [0.0; 3], ..push.clone() };
        let design = self.design;
        let path = at_origin.path(self.shape, self.radius, design.acceleration, design.rests);
        let start = path.position(0.0);
        !self.shape.contains(&start) && outline.touch(&start, self.radius).gap > CLEARANCE
    }

    fn shuffle(&mut self, pushes: &mut [PlannedPush]) {
        for last in (1..pushes.len()).rev() {
            pushes.swap(last, self.random.below(last + 1));
        }
    }
}
