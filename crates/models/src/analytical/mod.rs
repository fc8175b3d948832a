//! A step goes in, the quasi-static push on a limit surface comes out: the analytical model.

pub(crate) mod effective;
pub(crate) mod estimate;
pub(crate) mod fit;
pub(crate) mod least_squares;
pub(crate) mod surface_kind;

use std::sync::Arc;

use mechanics::{PathSettings, Pusher, Slider, StraightPath, StraightPush, push_along};
use nalgebra::{Matrix3, Vector3};
use planar::{Pose, Shape};
use serde::{Deserialize, Serialize};

use crate::analytical::surface_kind::Support;
use crate::error::{not_negative, within};
use crate::{Estimate, ModelError, Noise, StepInput, SurfaceKind};

/// The quasi-static push of an object under uniform pressure, integrated over the step.
///
/// Two parameters: the pusher's friction μp, and for an ellipsoid (the usual limit surface) the
/// characteristic length c = Mmax/Fmax, which follows from uniform pressure unless it is given.
/// What their standard errors leave open is part of a prediction, without their correlation.
///
/// The ellipsoid stands at the centroid, as in the thesis' section 2.4. The exact surface does so
/// for point-symmetric outlines alone: under a triangle the other kinds see the difference.
#[derive(Clone, Debug, PartialEq)]
pub struct Analytical {
    surface: SurfaceKind,
    pusher_friction: Estimate,
    length: CharacteristicLength,
    scatter: Matrix3<f64>,
}

/// Where the characteristic length c = Mmax/Fmax comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum CharacteristicLength {
    /// The mean distance of the outline's area to its centroid.
    UniformPressure,
    /// A length for one object, in m.
    Given(Estimate),
}

/// Of the coefficient between pusher and object: rubber on rubber has about 1.2.
pub(crate) const FRICTION_RANGE: (f64, f64) = (0.0, 10.0);
/// Of the characteristic length, in m: it is below the object's size.
pub(crate) const LENGTH_RANGE: (f64, f64) = (1e-6, 10.0);

/// Whether a matrix can be a covariance. An eigenvalue of zero may come back from the digits of a file as a rounding
/// below it.
pub(crate) fn is_covariance(matrix: &Matrix3<f64>) -> bool {
    let eigenvalues = matrix.symmetric_eigenvalues();
    *matrix == matrix.transpose() && eigenvalues.min() >= -1e-12 * eigenvalues.max()
}

impl Analytical {
    /// The nominal model: μp from the manifest, c from uniform pressure, no scatter.
    ///
    /// # Errors
    /// `InvalidValue` if μp is negative or not finite.
    pub fn nominal(pusher_friction: f64) -> Result<Self, ModelError> {
        Self::new(
            Estimate::exact(pusher_friction, "manifest"),
            CharacteristicLength::UniformPressure,
            Matrix3::zeros(),
        )
    }

    /// A model on an ellipsoid with the given parameters.
    ///
    /// `scatter` is the covariance of an observed step about the prediction, per meter of the
    /// pusher's way squared: for a way d the predicted covariance is d² · scatter.
    ///
    /// # Errors
    /// `InvalidValue` if μp, its standard error or that of c is not from 0 to 10, c not from 1e-6 m
    /// to 10 m, or a variance negative or not finite.
    pub fn new(
        pusher_friction: Estimate,
        length: CharacteristicLength,
        scatter: Matrix3<f64>,
    ) -> Result<Self, ModelError> {
        let (range, unit) = (FRICTION_RANGE, "(dimensionless)");
        within("pusher friction", pusher_friction.value, range, "from 0 to 10", unit)?;
        within("se of the pusher friction", pusher_friction.se, range, "from 0 to 10", unit)?;
        if let CharacteristicLength::Given(Estimate { value, se, .. }) = &length {
            let (low, high) = LENGTH_RANGE;
            within("characteristic length", *value, (low, high), "from 1e-6 to 10", "m")?;
            within("se of the characteristic length", *se, (0.0, high), "from 0 to 10", "m")?;
        }
        for variance in scatter.diagonal().iter() {
            not_negative("variance of the scatter", *variance, "(m or rad per m)²")?;
        }
        Ok(Self { surface: SurfaceKind::Ellipsoid, pusher_friction, length, scatter })
    }

    /// The same model on another limit surface.
    ///
    /// # Errors
    /// `LengthOfAnotherSurface` if c is given and the surface is no ellipsoid: its c follows from
    /// the pressure; `InvalidValue` for fewer than four points.
    pub fn with_surface(self, surface: SurfaceKind) -> Result<Self, ModelError> {
        if let (SurfaceKind::Points { n_points }, name) = (surface, "number of points")
            && n_points < 4
        {
            let (expected, value, unit) = ("at least 4", n_points as f64, "points");
            return Err(ModelError::InvalidValue { name, expected, value, unit });
        }
        let given = self.length != CharacteristicLength::UniformPressure;
        if given && surface != SurfaceKind::Ellipsoid {
            return Err(ModelError::LengthOfAnotherSurface { surface: surface.name() });
        }
        Ok(Self { surface, ..self })
    }

    /// The limit surface.
    pub fn surface(&self) -> SurfaceKind {
        self.surface
    }

    /// The coefficient of friction between pusher and object.
    pub fn pusher_friction(&self) -> &Estimate {
        &self.pusher_friction
    }

    /// Where c comes from.
    pub fn length(&self) -> &CharacteristicLength {
        &self.length
    }

    /// The covariance of an observed step about the prediction, per meter of way squared.
    pub fn scatter(&self) -> &Matrix3<f64> {
        &self.scatter
    }

    /// c for the object of a step, in m.
    pub fn characteristic_length(&self, step: &StepInput) -> f64 {
        match &self.length {
            CharacteristicLength::UniformPressure => {
                step.shape().mean_distance(&step.shape().centroid())
            }
            CharacteristicLength::Given(length) => length.value,
        }
    }

    /// The motion of B over the step, its end seen from its start.
    ///
    /// # Errors
    /// `Mechanics` for what the mechanics refuse.
    pub fn motion(&self, step: &StepInput) -> Result<Pose, ModelError> {
        let support = self.surface.under(step.shape(), self.characteristic_length(step))?;
        let pusher = Pusher { radius: step.pusher_radius(), friction: self.pusher_friction.value };
        match &support.at_edge {
            Some(at_edge) => at_edge.push(&pusher, &straight(step)),
            None => None,
        }
        .map_or_else(|| moved_generally(&support, &pusher, step), Ok)
    }

    /// (Δx, Δy, Δθ) of each step, on surfaces that steps of one shape share.
    pub(crate) fn outputs<'a>(
        &self,
        steps: impl IntoIterator<Item = &'a StepInput>,
    ) -> Result<Vec<Vector3<f64>>, ModelError> {
        let steps: Vec<&StepInput> = steps.into_iter().collect();
        let mut supports = Supports::default();
        self.outputs_with(self.pusher_friction.value, Place::Mean, &steps, &mut supports)
    }

    /// The covariance of each step.
    pub(crate) fn covariances(
        &self,
        steps: &[StepInput],
        noise: Noise,
    ) -> Result<Vec<Matrix3<f64>>, ModelError> {
        let scatter = match noise {
            Noise::Included => self.scatter,
            Noise::Excluded => Matrix3::zeros(),
        };
        let own = |step: &StepInput| scatter * step.distance().powi(2);
        let mut covariances: Vec<Matrix3<f64>> = steps.iter().map(own).collect();
        for changes in self.parameter_changes(steps)? {
            for (covariance, change) in covariances.iter_mut().zip(changes) {
                *covariance += change * change.transpose();
            }
        }
        Ok(covariances)
    }

    /// ∂f/∂θₖ seₖ of each step, a list for each parameter that has a standard error: by secants over
    /// ± one of it, since the derivative jumps where sticking turns into sliding.
    fn parameter_changes(&self, steps: &[StepInput]) -> Result<Vec<Vec<Vector3<f64>>>, ModelError> {
        let Estimate { value: friction, se, .. } = self.pusher_friction;
        let length = match &self.length {
            CharacteristicLength::Given(length) if length.se > 0.0 => Some(length),
            _ => None,
        };
        if se <= 0.0 && length.is_none() {
            return Ok(Vec::new());
        }
        let (steps, mut supports) = (steps.iter().collect::<Vec<_>>(), Supports::default());
        let mut secant = |se: f64, [low, high]: [(f64, Place); 2], width: f64| {
            let mut at =
                |(friction, place)| self.outputs_with(friction, place, &steps, &mut supports);
            let (low, high) = (at(low)?, at(high)?);
            // An error that the value's own rounding hides changes nothing.
            let slope = if width > 0.0 { se / width } else { 0.0 };
            let change = |(high, low): (Vector3<f64>, Vector3<f64>)| slope * (high - low);
            Ok::<_, ModelError>(high.into_iter().zip(low).map(change).collect())
        };
        let mut changes = Vec::new();
        if se > 0.0 {
            let ends = [(friction - se).max(0.0), friction + se];
            let width = ends[1] - ends[0];
            changes.push(secant(se, ends.map(|friction| (friction, Place::Mean)), width)?);
        }
        if let Some(length) = length {
            let [shorter, longer] = length_ends(length);
            let ends = [Place::Shorter, Place::Longer].map(|place| (friction, place));
            changes.push(secant(length.se, ends, longer - shorter)?);
        }
        Ok(changes)
    }

    /// (Δx, Δy, Δθ) of each step with a friction, and c at a place of its interval.
    fn outputs_with(
        &self,
        friction: f64,
        place: Place,
        steps: &[&StepInput],
        supports: &mut Supports,
    ) -> Result<Vec<Vector3<f64>>, ModelError> {
        let mut outputs = Vec::with_capacity(steps.len());
        let is_alike = |a: &&StepInput, b: &&StepInput| {
            Arc::ptr_eq(a.shared_shape(), b.shared_shape())
                && a.pusher_radius() == b.pusher_radius()
        };
        for alike in steps.chunk_by(is_alike) {
            let support = supports.of(self, alike[0])?.at(place);
            let pusher = Pusher { radius: alike[0].pusher_radius(), friction };
            outputs.extend(moved_on(support, &pusher, alike)?);
        }
        Ok(outputs)
    }
}

/// Which c of what its standard error leaves open.
#[derive(Clone, Copy)]
enum Place {
    Mean,
    Shorter,
    Longer,
}

/// (Δx, Δy, Δθ) of steps on one surface: most at once, the others by the general push.
fn moved_on(
    support: &Support,
    pusher: &Pusher,
    steps: &[&StepInput],
) -> Result<Vec<Vector3<f64>>, ModelError> {
    let fast = match &support.at_edge {
        Some(at_edge) => {
            at_edge.push_all(pusher, &steps.iter().map(|step| straight(step)).collect::<Vec<_>>())
        }
        None => vec![None; steps.len()],
    };
    let output = |(step, fast): (&&StepInput, Option<Pose>)| {
        let pose_bb = fast.map_or_else(|| moved_generally(support, pusher, step), Ok)?;
        Ok(step.outputs(&pose_bb))
    };
    steps.iter().zip(fast).map(output).collect()
}

fn straight(step: &StepInput) -> StraightPush {
    StraightPush {
        edge: step.edge(),
        start_b: step.start_b(),
        direction_b: step.direction_b(),
        distance: step.distance(),
    }
}

fn moved_generally(
    support: &Support,
    pusher: &Pusher,
    step: &StepInput,
) -> Result<Pose, ModelError> {
    let Support { surface, pose_bs, .. } = support;
    let slider = Slider { shape: step.shape(), surface: &**surface, pose_bs: *pose_bs };
    // Quasi-static motion does not know time: the pusher moves at 1 m/s.
    let path = StraightPath {
        start_w: step.start_b(),
        velocity_w: step.direction_b(),
        duration: step.distance(),
    };
    let origin = Pose::default();
    Ok(push_along(&slider, pusher, &path, &origin, &PathSettings::default())?.pose_wb)
}

/// The ends of a secant over ± one standard error of c, in m.
fn length_ends(length: &Estimate) -> [f64; 2] {
    let Estimate { value, se, .. } = *length;
    [(value - se).max(0.1 * value), value + se]
}

/// Limit surfaces by shape, each made once.
#[derive(Default)]
struct Supports(Vec<(Arc<Shape>, SupportsOfShape)>);

/// The limit surface under a shape, and those at the ends of what its c leaves open.
struct SupportsOfShape {
    mean: Support,
    ends: Option<[Support; 2]>,
}

impl SupportsOfShape {
    fn new(model: &Analytical, step: &StepInput) -> Result<Self, ModelError> {
        let ends = match &model.length {
            CharacteristicLength::Given(length) if length.se > 0.0 => {
                let [shorter, longer] = length_ends(length);
                let under = |c| model.surface.under(step.shape(), c);
                Some([under(shorter)?, under(longer)?])
            }
            _ => None,
        };
        let mean = model.surface.under(step.shape(), model.characteristic_length(step))?;
        Ok(Self { mean, ends })
    }

    /// The mean's where c is known.
    fn at(&self, place: Place) -> &Support {
        match (place, &self.ends) {
            (Place::Shorter, Some([shorter, _])) => shorter,
            (Place::Longer, Some([_, longer])) => longer,
            _ => &self.mean,
        }
    }
}

impl Supports {
    fn of(&mut self, model: &Analytical, step: &StepInput) -> Result<&SupportsOfShape, ModelError> {
        let shape = step.shared_shape();
        let same = |known: &Arc<Shape>| Arc::ptr_eq(known, shape) || known == shape;
        let index = match self.0.iter().position(|(known, _)| same(known)) {
            Some(index) => index,
            None => {
                self.0.push((shape.clone(), SupportsOfShape::new(model, step)?));
                self.0.len() - 1
            }
        };
        Ok(&self.0[index].1)
    }
}
