//! Steps whose motion is hardly one of a push.

use effects::StepInput;
use nalgebra::Vector2;
use planar::perpendicular;
use serde::Serialize;

use crate::Observations;

/// Steps of a doubtful kind.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DoubtfulSteps {
    /// What is doubtful.
    pub what: Doubt,
    /// How many there are.
    pub n_steps: usize,
    /// Pushes that they are of.
    pub n_pushes: usize,
    /// Their share of the steps.
    pub step_share: f64,
    /// Their share of the squared error of the motion.
    pub error_share: f64,
}

/// What is doubtful in a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Doubt {
    /// The object does not move, though it is pushed.
    NoMotion,
    /// Along the contact's normal the object's velocity is off by more than 0.15 of the pusher's along it.
    OffNormal,
    /// The contact slides much faster than the pusher moves.
    FastSlide,
}

/// Least motion of the contact over the pusher's way.
const LEAST_MOTION: f64 = 0.05;
const OFF_NORMAL: f64 = 0.15;
/// Slide along the edge over the pusher's way: even on an edge without friction it is less, but for an
/// object that turns into the pusher.
const FASTEST_SLIDE: f64 = 1.5;
/// Standard deviations of the poses' noise that a doubt leaves room for.
const ROOM: f64 = 4.0;
impl Doubt {
    /// In words, of several steps.
    pub fn name(self) -> &'static str {
        match self {
            Self::NoMotion => "do not move the object",
            Self::OffNormal => {
                "leave or enter the pusher by more than 0.15 of its way along the normal"
            }
            Self::FastSlide => "slide much faster than the pusher moves",
        }
    }

    const ALL: [Self; 3] = [Self::NoMotion, Self::OffNormal, Self::FastSlide];
}

fn way(input: &StepInput) -> f64 {
    (input.track.end() - input.track.start()).norm()
}

impl Observations {
    /// What is doubtful in a step, if anything is.
    fn doubt(&self, index: usize) -> Option<Doubt> {
        let step = &self.steps[index];
        let [Some(dx), Some(dy), Some(dtheta), ..] = step.observed else { return None };
        let input = &step.input;
        // A whole push bends on its way.
        if !input.touching {
            return None;
        }
        let (along, way) = (input.direction_w(), way(input));
        let center_b = input.pose_wb.inverse_transform_point(&input.track.start());
        let contact = input.object.shape().contact(&center_b, input.pusher_radius);
        // Over a step the contact turns with the object: half of it is the mean.
        let mut middle_wb = input.pose_wb;
        middle_wb.angle += 0.5 * dtheta;
        let normal = middle_wb.rotate(&contact.normal);
        let lever: Vector2<f64> = middle_wb.rotate(&contact.point);
        let moved = dx * along + dy * perpendicular(&along);
        let of_contact = moved + 2.0 * (0.5 * dtheta).sin() * perpendicular(&lever);
        let slip = of_contact - way * along;
        let [start, end] = self.places[index].pose_sd;
        let noise = start[0].hypot(end[0]).hypot(lever.norm() * start[1].hypot(end[1]));
        let room = ROOM * noise;
        let edge = perpendicular(&normal);
        if of_contact.norm() + room < LEAST_MOTION * way {
            Some(Doubt::NoMotion)
        } else if slip.dot(&normal).abs() > OFF_NORMAL * way * along.dot(&normal).abs() + room {
            Some(Doubt::OffNormal)
        } else if slip.dot(&edge).abs() > FASTEST_SLIDE * way + room {
            Some(Doubt::FastSlide)
        } else {
            None
        }
    }

    /// The doubtful steps by kind, with what they hold of the error of a model's residuals.
    pub(crate) fn doubtful(&self, residuals: &[[Option<f64>; 7]]) -> Vec<DoubtfulSteps> {
        let doubts: Vec<Option<Doubt>> = (0..self.n_steps()).map(|step| self.doubt(step)).collect();
        let mut squares = [0.0; 3];
        for values in residuals {
            (0..3).for_each(|k| squares[k] += values[k].map_or(0.0, |value| value * value));
        }
        let n_known = squares.iter().filter(|square| **square > 0.0).count();
        let share = |step: &usize| {
            let of = |k: usize| residuals[*step][k].unwrap_or_default().powi(2) / squares[k];
            let known = (0..3).filter(|k| squares[*k] > 0.0);
            known.map(of).sum::<f64>() / n_known.max(1) as f64
        };
        let of_kind = |what: Doubt| {
            let steps: Vec<usize> =
                (0..doubts.len()).filter(|step| doubts[*step] == Some(what)).collect();
            DoubtfulSteps {
                what,
                n_steps: steps.len(),
                n_pushes: self.n_pushes_of(&steps),
                step_share: steps.len() as f64 / doubts.len() as f64,
                error_share: steps.iter().map(share).sum(),
            }
        };
        Doubt::ALL.into_iter().map(of_kind).filter(|found| found.n_steps > 0).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::Doubt;
    use crate::Predictions;
    use crate::synthetic::recorded;

    #[test]
    fn each_doubt_is_counted_with_its_share_of_the_error() {
        let (mut all, model) = recorded(11);
        let doubtful = |all: &crate::Observations| {
            let predictions = Predictions::of(&model, &[], all).unwrap();
            all.doubtful(&predictions.residuals(all).unwrap())
        };
        assert_eq!(doubtful(&all), []);
        let along = |dx: f64, dy: f64| [Some(dx), Some(dy), Some(0.0)];
        let way = |all: &crate::Observations, step: usize| all.way(step);
        // Straight pushes: along the normal or across it is along the pusher's way or across it.
        let straight: Vec<usize> =
            (0..all.n_steps()).filter(|step| all.places[*step].beta.abs() < 0.2).take(3).collect();
        let motions = [(0.0, 0.0), (0.6, 0.0), (1.0, 2.5)];
        for (step, (dx, dy)) in straight.iter().zip(motions) {
            let way = way(&all, *step);
            all.steps[*step].observed[..3].copy_from_slice(&along(dx * way, dy * way));
        }
        let found = doubtful(&all);
        let kinds: Vec<(Doubt, usize)> = found.iter().map(|one| (one.what, one.n_steps)).collect();
        assert!(kinds.contains(&(Doubt::NoMotion, 1)), "{found:?}");
        let n: usize = found.iter().map(|one| one.n_steps).sum();
        assert_eq!(n, 3, "{found:?}");
        let share: f64 = found.iter().map(|one| one.error_share).sum();
        assert!(0.1 < share && share <= 1.0, "{found:?}");
    }
}
