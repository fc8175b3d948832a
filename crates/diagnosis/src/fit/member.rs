//! An effect whose parameters a fit moves.

mod resting;

use std::sync::Arc;

use effects::{Coordinate, Effect, Object, Parameter, Rig, Role, StepInput};
use nalgebra::DMatrix;

use self::resting::is_part;

/// Why an effect is moved, and what becomes of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// It was asked for: it is written, with its tests.
    Asked,
    /// The model carries it with a standard error: it is written.
    Carried,
    /// Its nominal value is not exact: it is reported.
    Nuisance,
}

/// An effect with its start and its prior, moved in its coordinates, which are smooth at "off".
#[derive(Clone, Debug)]
pub(super) struct Member {
    pub(super) effect: Arc<dyn Effect>,
    pub(super) part: Part,
    /// Values when the effect is not there.
    pub(super) off: Vec<f64>,
    /// Values of a size that is met.
    pub(super) typical: Vec<f64>,
    /// Values to start from.
    pub(super) start: Vec<f64>,
    pub(super) coordinates: Vec<Coordinate>,
    /// Of the prior, in coordinates.
    pub(super) center: Vec<f64>,
    /// Of the prior, in coordinates.
    pub(super) prior_sd: Vec<f64>,
    /// By how much the model's errors are larger than the noise, for a prior that has to hold against them.
    pub(super) noise: f64,
    /// Smallest and largest of each value.
    ranges: Vec<(f64, f64)>,
    /// Of what it says where it rests.
    object: Option<Arc<Object>>,
    /// Whether its parts of the weight balance the object.
    is_by_statics: bool,
}

impl Member {
    /// An effect with the weak prior of its coordinates about "off".
    pub(super) fn new(effect: &Arc<dyn Effect>, part: Part, start: &[f64], rig: &Rig) -> Self {
        let about = effect.info();
        let coordinates = about.coordinates(rig);
        Self {
            effect: effect.clone(),
            part,
            off: about.off(rig),
            typical: about.typical(rig),
            start: start.to_vec(),
            center: coordinates.iter().map(|coordinate| coordinate.off).collect(),
            prior_sd: coordinates.iter().map(|coordinate| coordinate.prior_sd).collect(),
            coordinates,
            noise: 1.0,
            ranges: about.parameters.iter().map(|parameter| parameter.range).collect(),
            object: None,
            is_by_statics: false,
        }
    }

    /// The same within what every one of some steps allows.
    pub(super) fn inside<'a>(
        mut self,
        steps: impl Iterator<Item = &'a StepInput>,
        rig: &Rig,
    ) -> Self {
        let mut last: Option<(*const Object, f64)> = None;
        for step in steps {
            let now = Some((Arc::as_ptr(&step.object), step.pusher_radius));
            if now == last {
                continue;
            }
            last = now;
            let allowed = self.effect.coordinates_in(rig, step);
            for (coordinate, allowed) in self.coordinates.iter_mut().zip(allowed) {
                let ((low, high), (least, most)) = (coordinate.range, allowed.range);
                coordinate.range = (low.max(least), high.min(most));
            }
            for (k, range) in self.ranges.iter_mut().enumerate() {
                let (least, most) = self.effect.range_in(k, step);
                *range = (range.0.max(least), range.1.min(most));
            }
        }
        self
    }

    /// The same with a normal prior about its start, of these standard errors of its values.
    pub(super) fn with_prior(mut self, se: &[f64]) -> Self {
        let about = self.effect.info();
        self.center = about.to_coordinates(&self.start);
        self.prior_sd = vec![0.0; self.center.len()];
        for (value, se) in se.iter().enumerate().filter(|(_, se)| **se > 0.0) {
            let mut moved = self.start.clone();
            moved[value] += NUDGE * se;
            let moved = about.to_coordinates(&moved);
            for ((sd, moved), center) in self.prior_sd.iter_mut().zip(moved).zip(&self.center) {
                *sd = sd.hypot((moved - center) / NUDGE);
            }
        }
        self
    }

    pub(super) fn id(&self) -> &'static str {
        self.effect.info().id
    }

    pub(super) fn parameters(&self) -> &'static [Parameter] {
        self.effect.info().parameters
    }

    pub(super) fn len(&self) -> usize {
        self.coordinates.len()
    }

    /// The effect's values at a place, within their ranges.
    pub(super) fn values(&self, x: &[f64]) -> Vec<f64> {
        let values = self.effect.info().from_coordinates(x);
        let inside =
            |((parameter, value), range): ((&Parameter, f64), &(f64, f64))| match parameter.role {
                Role::Direction(_) => value.rem_euclid(std::f64::consts::PI),
                _ => value.max(range.0).min(range.1),
            };
        self.parameters().iter().zip(values).zip(&self.ranges).map(inside).collect()
    }

    /// The place of values.
    ///
    /// Parts of the whole weight have room to either side: they stay in proportion while all but the
    /// largest are moved.
    pub(super) fn place(&self, values: &[f64]) -> Vec<f64> {
        let mut place = self.effect.info().to_coordinates(values);
        let parts: Vec<usize> =
            (0..place.len()).filter(|k| is_part(&self.parameters()[*k])).collect();
        if parts.iter().map(|k| place[*k]).sum::<f64>() > 1.0 - ROUNDING {
            parts.into_iter().for_each(|k| place[k] *= ROOM);
        }
        place
    }

    /// How values follow the numbers in which the effect is moved.
    pub(super) fn value_slopes(&self, x: &[f64]) -> DMatrix<f64> {
        let values = self.values(x);
        let mut slopes = DMatrix::zeros(values.len(), x.len());
        for (k, coordinate) in self.coordinates.iter().enumerate() {
            let size = CHART_STEP * coordinate.secant;
            // Values stay within their ranges: at the upper end a step leads back.
            let step = if x[k] + size > coordinate.range.1 { -size } else { size };
            let mut moved = x.to_vec();
            moved[k] += step;
            let pairs = self.values(&moved).into_iter().zip(&values);
            for (row, (parameter, (moved, value))) in
                self.parameters().iter().zip(pairs).enumerate()
            {
                let change = match parameter.role {
                    Role::Direction(_) => 0.5 * planar::wrap_angle(2.0 * (moved - value)),
                    _ => moved - value,
                };
                slopes[(row, k)] = change / step;
            }
        }
        slopes
    }

    /// Which numbers are limits, whose slopes are none.
    pub(super) fn thresholds(&self) -> Vec<usize> {
        let is = |k: &usize| self.parameters()[*k].role == Role::Threshold;
        (0..self.len()).filter(is).collect()
    }

    /// (coordinate − center)/sd of the prior, times the noise; 0 where there is none. Then what is not balanced.
    pub(super) fn prior_residual(&self, values: &[f64]) -> Vec<f64> {
        let coordinates = self.effect.info().to_coordinates(values);
        let priors = self.center.iter().zip(&self.prior_sd);
        let prior_residual = |(x, (center, sd)): (f64, (&f64, &f64))| match *sd > 0.0 {
            true => self.noise * (x - center) / sd,
            false => 0.0,
        };
        let mut residuals: Vec<f64> =
            coordinates.into_iter().zip(priors).map(prior_residual).collect();
        self.add_strains_outside(values, &mut residuals);
        residuals.extend(self.unbalanced(values));
        residuals
    }

    /// The size of what each number of a place of the coordinates is part of: of a number its own, of
    /// the components of a vector or an axis that of the whole, whatever the axes.
    pub(super) fn sizes(&self, x: &[f64]) -> Vec<f64> {
        let mut sizes: Vec<f64> = x.iter().map(|x| x.abs()).collect();
        for (first, parameter) in self.parameters().iter().enumerate() {
            if let (Role::X(_) | Role::Ratio(_), Some(two)) =
                (parameter.role, sizes.get_mut(first..first + 2))
            {
                two.fill(two[0].hypot(two[1]));
            }
        }
        sizes
    }

    /// The bounds of the coordinates.
    pub(super) fn ranges(&self) -> Vec<(f64, f64)> {
        self.coordinates.iter().map(|coordinate| coordinate.range).collect()
    }

    /// Smallest and largest of a value, within what object and pusher allow; a direction goes on beyond the
    /// ends of a half turn.
    pub(super) fn range_of(&self, value: usize) -> (f64, f64) {
        match self.parameters()[value].role {
            Role::Direction(_) => (f64::NEG_INFINITY, f64::INFINITY),
            _ => self.ranges[value],
        }
    }

    /// Steps that reach over the kinks of sticking and sliding.
    pub(super) fn secants(&self) -> Vec<f64> {
        self.coordinates.iter().map(|coordinate| coordinate.secant).collect()
    }

    /// Which numbers are not moved by slopes: switches, limits, and what is held without a prior.
    pub(super) fn frozen(&self) -> Vec<bool> {
        let has_no_slope =
            |parameter: &Parameter| matches!(parameter.role, Role::Switch | Role::Threshold);
        let numbers = self.parameters().iter().zip(&self.prior_sd);
        numbers.map(|(parameter, sd)| has_no_slope(parameter) || *sd == 0.0).collect()
    }

    /// Which numbers are shares, whose ranges end where nothing more is.
    pub(super) fn shares(&self) -> Vec<bool> {
        self.parameters().iter().map(|parameter| parameter.role == Role::Share).collect()
    }

    /// Which numbers are sizes that mean nothing where the effect is off.
    pub(super) fn scales(&self) -> Vec<usize> {
        let is = |parameter: &Parameter| {
            parameter.off == effects::Off::Undefined && parameter.role == Role::Even
        };
        (0..self.len()).filter(|k| is(&self.parameters()[*k])).collect()
    }

    /// Which numbers are 0 or 1.
    pub(super) fn switches(&self) -> Vec<bool> {
        self.parameters().iter().map(|parameter| parameter.role == Role::Switch).collect()
    }
}

/// Parts that are together the whole stand at so many times themselves.
const ROOM: f64 = 2.0;
const ROUNDING: f64 = 1e-9;

/// Step of differences between charts, in secants.
pub(super) const CHART_STEP: f64 = 1e-4;
/// A difference of this many standard errors tells how coordinates follow values.
const NUDGE: f64 = 1e-3;

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use effects::{Rig, Role, Surface, all, by_id};
    use nalgebra::{DMatrix, DVector, Rotation2};

    use super::{Member, Part};

    /// An effect at some of its values, with the squares of its sizes.
    fn sized(id: &str, values: &[f64]) -> (Member, Vec<f64>, DMatrix<f64>) {
        let rig = Rig::new(Surface::Ellipsoid, 0.25, 0.3).unwrap();
        let member = Member::new(by_id(id).unwrap(), Part::Asked, values, &rig);
        let x = member.place(values);
        let squares = member.sizes(&x).into_iter().map(|size| size * size).collect();
        (member, x, DMatrix::from_diagonal(&DVector::from_vec(squares)))
    }

    #[test]
    fn a_search_stays_within_what_the_object_allows() {
        let square = std::sync::Arc::new(planar::Shape::square(0.1).unwrap());
        let step = effects::StepInput {
            object: std::sync::Arc::new(effects::Object::uniform(square, 1.0).unwrap()),
            pusher_radius: 0.0,
            pose_wb: planar::Pose::default(),
            twist_wb: planar::Twist::default(),
            track: effects::Track::straight(
                -0.05 * nalgebra::Vector2::x(),
                nalgebra::Vector2::zeros(),
                1.0,
            ),
            touching: true,
            since_contact: 0.0,
            run_up: None,
            progress: 0.5,
            session: 0,
        };
        let rig = Rig::new(Surface::Ellipsoid, 0.25, 0.3).unwrap();
        // A square's corner is 1.848 mean distances off.
        let (effect, end) = (by_id("pressure-radius").unwrap(), 1.848_172);
        let start = effect.info().off(&rig);
        let member = Member::new(effect, Part::Asked, &start, &rig);
        let inside = member.inside(std::iter::once(&step), &rig);
        assert!((inside.values(&[3.0])[0] - end).abs() < 1e-6);
        for (low, high) in [inside.ranges()[0], inside.range_of(0)] {
            assert!((high - end).abs() < 1e-6, "{low} {high}");
        }
    }

    #[test]
    fn the_size_of_an_axis_is_the_same_in_every_direction() {
        for id in ["table-anisotropy", "body-anisotropy"] {
            // What the sizes are for the ratio and the direction that people read.
            let of_values = |direction: f64| {
                let (member, x, squares) = sized(id, &[1.35, direction]);
                let values = |shift: [f64; 2]| member.values(&[x[0] + shift[0], x[1] + shift[1]]);
                let step = 1e-6;
                let slope = |k: usize, value: usize| {
                    let [above, below] = [step, -step].map(|step| {
                        let mut shift = [0.0; 2];
                        shift[k] = step;
                        values(shift)[value]
                    });
                    (above - below) / (2.0 * step)
                };
                let slopes = DMatrix::from_fn(2, 2, |value, k| slope(k, value));
                &slopes * squares * slopes.transpose()
            };
            let one = of_values(0.1);
            // A share of the exponent ln 1.35 of the ratio, and as much, halved, of a right angle.
            assert!((one[(0, 0)].sqrt() - 1.35 * 1.35_f64.ln()).abs() < 1e-6, "{one}");
            assert!((one[(1, 1)].sqrt() - 0.5).abs() < 1e-6, "{one}");
            for direction in [0.3, PI / 8.0, PI / 4.0, 1.1, 2.0, 3.0] {
                assert!((of_values(direction) - &one).norm() < 1e-6, "{id} {direction}");
            }
        }
    }

    #[test]
    fn the_size_of_a_vector_turns_with_the_axes_and_a_number_has_its_own() {
        for effect in all() {
            let about = effect.info();
            let rig = Rig::new(Surface::Ellipsoid, 0.25, 0.3).unwrap();
            let typical = about.typical(&rig);
            let (_, x, squares) = sized(about.id, &typical);
            for (k, parameter) in about.parameters.iter().enumerate() {
                match parameter.role {
                    Role::X(_) => {
                        let block = squares.view((k, k), (2, 2)).into_owned();
                        let turn = Rotation2::new(0.7);
                        let turn = turn.matrix();
                        let turned = turn * &block * turn.transpose();
                        assert!((turned - &block).norm() <= 1e-12 * block.norm(), "{}", about.id);
                    }
                    Role::Even
                    | Role::Odd
                    | Role::Part
                    | Role::Cell
                    | Role::Wave
                    | Role::Reference
                    | Role::Threshold
                    | Role::Share
                    | Role::Switch => {
                        assert!((squares[(k, k)].sqrt() - x[k].abs()).abs() < 1e-12);
                    }
                    Role::Y(_) | Role::Ratio(_) | Role::Direction(_) => {}
                }
            }
        }
    }
}
