//! Sources of error of a push, and how each shows in the numbers of the push.

use effects::{Parameter, Spread, by_id};
use models::Description;
use nalgebra::{DMatrix, DVector, Vector2};
use planar::perpendicular;

use crate::predict::secants::{Direction, Linearisation};
use crate::statistics::variances::LogNormal;
use crate::{DiagnosisError, Observations};

/// A source of error; its variance is to be learnt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Source {
    /// Name, for people: the effect's id and coordinate where it is one.
    pub(crate) name: &'static str,
    /// SI unit of its standard deviation.
    pub(crate) unit: &'static str,
    /// Median of what is expected of its standard deviation.
    pub(crate) usual_sd: f64,
    pub(crate) kind: Kind,
}

/// How a source acts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    /// On the object's position at each end of a step; a factor on the sd that the table states.
    ObjectPosition,
    /// On the object's yaw, likewise.
    ObjectYaw,
    /// On the pusher's position at each end of a step.
    PusherPosition,
    /// On each component of a step's force.
    Force,
    /// The same, relative to the force.
    ForceShare,
    /// On each step's displacement and turn (times the characteristic length), relative to the
    /// pusher's way.
    MotionShare,
    /// Coordinates of an effect that differ from push to push: of a vector, so that turned axes
    /// change nothing, both alike.
    Push { coordinates: &'static [usize] },
}

/// How far what is expected may be off, as standard deviation of the logarithm of the variance: a
/// factor of e, either way, in the standard deviation.
const LOG_SD: f64 = 2.0;
/// Few repeats show some parameters of pushes weakly, and then through the model's faults.
const LOG_SD_PUSH: f64 = 1.0;
/// The table's standard deviations come from the samples themselves.
const LOG_SD_KNOWN: f64 = 0.5;
/// Secants over so many usual standard deviations to either side: they reach pushes that are not
/// quite at the edge of sticking.
const SECANT: f64 = 4.0;
/// Secants over so many standard deviations of what differs by more: their mean square is that of any cubic
/// of a normal number (three points of Gauss and Hermite).
pub(crate) const SECANT_OF_OWN: f64 = 1.732_050_807_568_877_2;

/// What stands for a standard deviation that the table does not state: m and rad.
const UNKNOWN_SD: [f64; 2] = [2e-5, 4e-4];

pub(crate) const SOURCES: [Source; 12] = [
    source("object position, as a factor", "1", 1.0, Kind::ObjectPosition),
    source("object yaw, as a factor", "1", 1.0, Kind::ObjectYaw),
    source("pusher position", "m", 1e-5, Kind::PusherPosition),
    source("force", "N", 0.01, Kind::Force),
    source("force, relative", "1", 5e-3, Kind::ForceShare),
    source("motion, relative", "1", 2e-3, Kind::MotionShare),
    source("support-friction", "1", 5e-3, Kind::Push { coordinates: &[0] }),
    source("pusher-friction", "1", 5e-3, Kind::Push { coordinates: &[0] }),
    source("pressure-radius", "1", 1e-2, Kind::Push { coordinates: &[0] }),
    source("friction-center-offset", "m", 2e-4, Kind::Push { coordinates: &[0, 1] }),
    source("contact-bias", "m", 1e-4, Kind::Push { coordinates: &[0] }),
    source("force-bias", "N", 1e-2, Kind::Push { coordinates: &[0, 1] }),
];

const fn source(name: &'static str, unit: &'static str, usual_sd: f64, kind: Kind) -> Source {
    Source { name, unit, usual_sd, kind }
}

impl Source {
    /// What is known beforehand of its variance where a standard deviation is expected.
    pub(crate) fn prior(&self, expected_sd: f64) -> LogNormal {
        let log_sd = match self.kind {
            Kind::ObjectPosition | Kind::ObjectYaw => LOG_SD_KNOWN,
            Kind::Push { .. } => LOG_SD_PUSH,
            _ => LOG_SD,
        };
        // What was dropped may be back.
        let sd = if expected_sd > 0.0 { expected_sd } else { self.usual_sd };
        LogNormal { median: sd * sd, log_sd, largest: f64::INFINITY }
    }
}

/// The standard deviation of each source in [`SOURCES`] from push to push, of one session and between sessions, that
/// a model states, of a vector the larger one; 0 where it states none.
///
/// # Errors
/// `Model` if the catalogue does not know one, or refuses the model's values.
pub(crate) fn stated_sds(model: &Description) -> Result<Vec<f64>, DiagnosisError> {
    let stated = |source: &Source| -> Result<f64, DiagnosisError> {
        let Kind::Push { coordinates } = source.kind else { return Ok(0.0) };
        let carried = model.effects.iter().find(|effect| effect.id == source.name);
        let Some(carried) = carried else { return Ok(0.0) };
        let about = by_id(source.name).map_err(models::ModelError::from)?.info();
        let values = carried.setting().values(about).map_err(models::ModelError::from)?;
        let of = |k: usize| {
            let Parameter { name, range, .. } = &about.parameters[k];
            let square = |spread: &Spread| {
                let [low, high] = [-1.0, 1.0].map(|deviations| {
                    let mut moved = values.clone();
                    moved[k] = spread.at(values[k], deviations, *range);
                    about.to_coordinates(&moved)[k]
                });
                (0.5 * (high - low)).powi(2)
            };
            let spreads = [&carried.per_push, &carried.per_session].map(|of| of.get(*name));
            spreads.into_iter().flatten().map(square).sum::<f64>().sqrt()
        };
        Ok(coordinates.iter().map(|k| of(*k)).fold(0.0, f64::max))
    };
    SOURCES.iter().map(stated).collect()
}

/// What is known beforehand of the variance of each source in [`SOURCES`], where these standard deviations are
/// expected. No parameter differs by more from push to push than it is from the nearer end of its range.
pub(crate) fn priors(
    expected_sds: impl IntoIterator<Item = f64>,
    linearisation: &Linearisation,
) -> Vec<LogNormal> {
    let mut rooms = linearisation.rooms.iter();
    let of = |(source, expected): (&Source, f64)| {
        let prior = source.prior(expected);
        let Kind::Push { coordinates } = source.kind else { return prior };
        let own = rooms.by_ref().take(coordinates.len());
        let room = own.copied().fold(f64::INFINITY, f64::min);
        LogNormal { largest: room * room, ..prior }
    };
    SOURCES.iter().zip(expected_sds).map(of).collect()
}

/// The coordinates that differ from push to push, with secants for what is usual, or for what a model states.
///
/// # Errors
/// `Model` if the catalogue does not know one.
pub(crate) fn push_directions(model: &Description) -> Result<Vec<Direction>, DiagnosisError> {
    let mut directions = Vec::new();
    for (source, sd) in SOURCES.iter().zip(stated_sds(model)?) {
        let Kind::Push { coordinates } = source.kind else { continue };
        let effect = by_id(source.name).map_err(models::ModelError::from)?;
        let size = f64::max(SECANT * source.usual_sd, SECANT_OF_OWN * sd);
        let of = |coordinate: &usize| Direction {
            effect: effect.clone(),
            coordinate: *coordinate,
            size,
        };
        directions.extend(coordinates.iter().map(of));
    }
    Ok(directions)
}

/// A root Z of each source's share Z Zᵀ in the covariance of one push's numbers.
#[derive(Clone, Debug)]
pub(crate) struct ErrorShapes {
    /// Each as (step, index in [`effects::Channels`]).
    pub(crate) numbers: Vec<(usize, usize)>,
    pub(crate) roots: Vec<Root>,
}

#[derive(Clone, Debug)]
pub(crate) enum Root {
    Columns(DMatrix<f64>),
    Diagonal(DVector<f64>),
}

impl ErrorShapes {
    /// Of the numbers of one push; the linearisation's first slopes are [`push_directions`].
    pub(crate) fn of(
        observations: &Observations,
        linearisation: &Linearisation,
        numbers: Vec<(usize, usize)>,
    ) -> Self {
        let ends = Ends::of(observations, linearisation, &numbers);
        let mut curves = linearisation.slopes.iter().zip(&linearisation.bends);
        let root = |source: &Source| match source.kind {
            Kind::ObjectPosition => Root::Columns(ends.position.clone()),
            Kind::ObjectYaw => Root::Columns(ends.yaw.clone()),
            Kind::PusherPosition => Root::Columns(ends.pusher.clone()),
            Kind::Push { coordinates } => {
                // x and |x| of a normal number x are not correlated.
                let own = curves.by_ref().take(coordinates.len()).flat_map(|(s, b)| [s, b]);
                let of = |curve: &Vec<[f64; 7]>| {
                    let values = numbers.iter().map(|(step, number)| curve[*step][*number]);
                    DVector::from_iterator(numbers.len(), values)
                };
                Root::Columns(DMatrix::from_columns(&own.map(of).collect::<Vec<_>>()))
            }
            kind => {
                let size = |&(step, number): &(usize, usize)| {
                    independent(observations, linearisation, kind, step, number)
                };
                Root::Diagonal(DVector::from_iterator(numbers.len(), numbers.iter().map(size)))
            }
        };
        let roots = SOURCES.iter().map(root).collect();
        Self { numbers, roots }
    }

    /// Σ θₖ Zₖ Zₖᵀ.
    pub(crate) fn covariance(&self, variances: &[f64]) -> DMatrix<f64> {
        let n = self.numbers.len();
        let mut sum = DMatrix::zeros(n, n);
        self.roots.iter().zip(variances).for_each(|(root, theta)| root.add_to(&mut sum, *theta));
        sum
    }

    /// The same of some rows alone.
    pub(crate) fn rows(&self, rows: &[usize]) -> Self {
        let numbers = rows.iter().map(|row| self.numbers[*row]).collect();
        let pick = |root: &Root| match root {
            Root::Columns(columns) => Root::Columns(columns.select_rows(rows)),
            Root::Diagonal(values) => Root::Diagonal(values.select_rows(rows)),
        };
        Self { numbers, roots: self.roots.iter().map(pick).collect() }
    }
}

impl Root {
    /// The diagonal of Z Zᵀ.
    pub(crate) fn squares(&self) -> Box<dyn Iterator<Item = f64> + '_> {
        match self {
            Self::Columns(columns) => Box::new(columns.row_iter().map(|row| row.norm_squared())),
            Self::Diagonal(values) => Box::new(values.iter().map(|value| value * value)),
        }
    }

    pub(crate) fn add_to(&self, sum: &mut DMatrix<f64>, theta: f64) {
        match self {
            Self::Columns(columns) => sum.gemm(theta, columns, &columns.transpose(), 1.0),
            Self::Diagonal(values) => {
                for (k, value) in values.iter().enumerate() {
                    sum[(k, k)] += theta * value * value;
                }
            }
        }
    }
}

/// Size of an error that is each number's own, for a source of size 1.
fn independent(
    observations: &Observations,
    linearisation: &Linearisation,
    kind: Kind,
    step: usize,
    number: usize,
) -> f64 {
    let observed = &observations.steps[step];
    let is_force = number == 3 || number == 4;
    match kind {
        Kind::Force if is_force => 1.0,
        Kind::ForceShare if is_force => {
            linearisation.predicted[step][3].hypot(linearisation.predicted[step][4])
        }
        Kind::MotionShare if number < 3 => {
            let track = &observed.input.track;
            let way = (track.end() - track.start()).norm();
            if number < 2 { way } else { way / observed.input.object.mean_distance() }
        }
        _ => 0.0,
    }
}

/// How errors of pose and pusher at the ends of steps show; an end that two steps share is one.
struct Ends {
    position: DMatrix<f64>,
    yaw: DMatrix<f64>,
    pusher: DMatrix<f64>,
}

impl Ends {
    fn of(
        observations: &Observations,
        linearisation: &Linearisation,
        numbers: &[(usize, usize)],
    ) -> Self {
        let n = numbers.len();
        let steps = numbers.chunk_by(|a, b| a.0 == b.0).map(|own| own[0].0);
        // The column of each step's start; its end has the next one.
        let (mut start, mut next) = (std::collections::HashMap::new(), 0);
        for step in steps {
            let goes_on = observations.goes_on(step) && start.contains_key(&(step - 1));
            let column = if goes_on { next - 1 } else { next };
            start.insert(step, column);
            next = column + 2;
        }
        let mut ends = Self {
            position: DMatrix::zeros(n, 2 * next),
            yaw: DMatrix::zeros(n, next),
            pusher: DMatrix::zeros(n, 2 * next),
        };
        for (row, (step, number)) in numbers.iter().enumerate() {
            let moved = AtEnds::of(observations, linearisation, *step);
            for end in 0..2 {
                let (column, sd) = (start[step] + end, observations.places[*step].pose_sd[end]);
                let sd: [f64; 2] =
                    std::array::from_fn(|k| if sd[k] > 0.0 { sd[k] } else { UNKNOWN_SD[k] });
                let (position, yaw, pusher) = moved.by(*number, end);
                for axis in 0..2 {
                    ends.position[(row, 2 * column + axis)] = sd[0] * position[axis];
                    ends.pusher[(row, 2 * column + axis)] = pusher[axis];
                }
                ends.yaw[(row, column)] = sd[1] * yaw;
            }
        }
        ends
    }
}

/// A step's geometry at its two ends, as far as errors need it.
struct AtEnds {
    along: Vector2<f64>,
    /// For both ends: the contact normal in W, and the lever of a yaw on the gap.
    contacts: [(Vector2<f64>, f64); 2],
    by_pusher: [[f64; 7]; 2],
}

impl AtEnds {
    fn of(observations: &Observations, linearisation: &Linearisation, index: usize) -> Self {
        let step = &observations.steps[index];
        let predicted = &linearisation.predicted[index];
        let input = &step.input;
        let along = input.direction_w();
        let observed = |k: usize| step.observed[k].unwrap_or(predicted[k]);
        let mut end_wb = input.pose_wb;
        end_wb.position += observed(0) * along + observed(1) * perpendicular(&along);
        end_wb.angle += observed(2);
        let places = [(input.pose_wb, input.track.start()), (end_wb, input.track.end())];
        let contacts = places.map(|(pose_wb, center_w)| {
            let center_b = pose_wb.inverse_transform_point(&center_w);
            let contact = input.object.shape().contact(&center_b, input.pusher_radius);
            let lever = contact.normal.dot(&perpendicular(&contact.point));
            (pose_wb.rotate(&contact.normal), lever)
        });
        Self { along, contacts, by_pusher: linearisation.by_pusher[index] }
    }

    /// Change of a number, observed less predicted, by the position (m) and yaw (rad) of the object
    /// and the position of the pusher (m) at an end.
    fn by(&self, number: usize, end: usize) -> (Vector2<f64>, f64, Vector2<f64>) {
        let sign = if end == 0 { -1.0 } else { 1.0 };
        let (zero, (normal, lever)) = (Vector2::zeros(), self.contacts[end]);
        let pusher = sign * Vector2::new(self.by_pusher[0][number], self.by_pusher[1][number]);
        match number {
            0 => (sign * self.along, 0.0, pusher),
            1 => (sign * perpendicular(&self.along), 0.0, pusher),
            2 => (zero, sign, pusher),
            5 | 6 if number == 5 + end => (normal, lever, -normal),
            _ => (zero, 0.0, pusher),
        }
    }
}

#[cfg(test)]
mod tests {
    use effects::{Rig, Setting, Spread, Surface, by_id};
    use models::{Analytical, PushModel};

    use super::{SOURCES, priors, push_directions, stated_sds};
    use crate::predict::secants::Linearisation;
    use crate::synthetic::recorded;

    #[test]
    fn what_a_model_states_is_expected_in_the_coordinates_of_its_sources() {
        let rig = Rig::new(Surface::Ellipsoid, 0.25, 0.3).unwrap();
        let mut model = Analytical::nominal(0.25).unwrap().describe().unwrap();
        let usual = push_directions(&model).unwrap();
        assert!(stated_sds(&model).unwrap().iter().all(|sd| *sd == 0.0));
        let mut state = |id: &str, name: &str, [push, session]: [Spread; 2]| {
            let about = by_id(id).unwrap().info();
            let mut effect = models::ModelEffect::from(Setting::new(about, &about.off(&rig)));
            effect.per_push.insert(name.to_owned(), push);
            effect.per_session.insert(name.to_owned(), session);
            model.effects.push(effect);
        };
        let none = Spread::Sd(0.0);
        // A friction of 0.25 whose logarithm differs.
        state("pusher-friction", "friction", [0.3, 0.4].map(Spread::RelativeSd));
        state("friction-center-offset", "dy", [Spread::Sd(0.007), none]);
        state("contact-bias", "shift", [Spread::Sd(1e-6), none]);
        let found = stated_sds(&model).unwrap();
        let of = |name: &str| SOURCES.iter().position(|source| source.name == name).unwrap();
        let friction = 0.25 * 0.3_f64.sinh().hypot(0.4_f64.sinh());
        assert!((found[of("pusher-friction")] - friction).abs() < 1e-9, "{found:?}");
        assert!((found[of("friction-center-offset")] - 0.007).abs() < 1e-12, "{found:?}");
        // Slopes reach as far, and never less far than to what is usual.
        let reaching = push_directions(&model).unwrap();
        for (one, usual) in reaching.iter().zip(&usual) {
            let is_far = ["pusher-friction", "friction-center-offset"];
            let is_farther = is_far.contains(&one.effect.info().id);
            assert_eq!(one.size > usual.size, is_farther, "{}", one.effect.info().id);
            assert!(one.size >= usual.size);
        }
    }

    #[test]
    fn nothing_differs_by_more_than_to_the_end_of_its_range() {
        let (all, model) = recorded(1);
        let directions = push_directions(&model).unwrap();
        let linearisation = Linearisation::of(&model, &[], &all, &directions).unwrap();
        let priors = priors(SOURCES.map(|source| source.usual_sd), &linearisation);
        let largest = |name: &str| {
            let of = SOURCES.iter().position(|source| source.name == name).unwrap();
            priors[of].largest.sqrt()
        };
        for (id, value) in [("support-friction", all.support.friction), ("pusher-friction", 0.25)] {
            let (low, high) = by_id(id).unwrap().info().parameters[0].range;
            let expected = (value - low).min(high - value);
            assert!((largest(id) - expected).abs() < 1e-12, "{id}: {}", largest(id));
        }
        assert_eq!(largest("force"), f64::INFINITY);
    }
}
