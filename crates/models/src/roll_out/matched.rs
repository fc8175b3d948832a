//! A whole push without particles: moments matched step by step.

use filter::{FilterError, Gaussian, Mixture, Rule};
use nalgebra::{DMatrix, DVector, Matrix3, Rotation2, Vector3};
use planar::{Pose, perpendicular};

use super::settle::{Holding, moved_by};
use super::{PushMotion, PushParticle, RollOut, StepErrors};
use crate::step_correlation::root;
use crate::{ModelError, PushPath, Slip, StepInput, StepObservation, StepPrediction};

/// The state of a push: x and y in m, the angle in rad, the gap that contact holds beyond the nominal
/// one in m, and three numbers that neighboring steps share, of pushes of every size.
const N_STATES: usize = 7;
const N_POSE: usize = 3;
const N_SHARED: usize = 3;

/// One way that a state may go: which, how probably, and the pose with its covariance in W.
type Way = (usize, f64, Pose, Matrix3<f64>);

impl RollOut<'_> {
    /// The push without particles: at the start and after each step, a mixture of at most
    /// `n_components` Gaussians over x, y in m and the angle in rad.
    ///
    /// Every component is carried through a step by the points of a rule, each with the model's
    /// Gaussian conditioned on the contact that holds; it splits where its points stick and slip, or
    /// where a [`crate::SlipMixture`] goes several ways, and the nearest components are joined again.
    /// With one component these are matched moments. A point touches where its gap is within the
    /// tolerance; what steps share is taken for a Gaussian of the variance that it has.
    ///
    /// # Errors
    /// As [`RollOut::run`]; `Filter` for no components.
    pub fn matched(
        &self,
        start_wb: &Pose,
        path: &PushPath,
        rule: &dyn Rule,
        n_components: usize,
    ) -> Result<Vec<Mixture>, ModelError> {
        let steps = path.steps(self.settings.step)?;
        self.check()?;
        self.check_steps(&steps)?;
        let first = self.first(start_wb, path)?;
        let mut state = Mixture::new(vec![(self.start_gaussian(start_wb)?, 1.0)])?;
        let mut poses = vec![pose_of(&state)?];
        for step in &steps {
            let motion = self.motion(step);
            let moved = state.propagated(rule, |point| motion.ways_of_point(&first, point))?;
            state = moved.reduced(n_components)?;
            poses.push(pose_of(&state)?);
        }
        Ok(poses)
    }

    fn start_gaussian(&self, start_wb: &Pose) -> Result<Gaussian, FilterError> {
        let [place_sd, angle_sd] = self.settings.start_sd;
        let held_variance = match &self.settings.errors {
            StepErrors::Held(correlation) => correlation.mean_square_size(),
            StepErrors::None | StepErrors::Independent => 0.0,
        };
        let gap_sd = self.settings.gap.sd;
        let Pose { position, angle } = start_wb;
        let mean = DVector::from_vec(vec![position.x, position.y, *angle, 0.0, 0.0, 0.0, 0.0]);
        let mut variances = vec![held_variance; N_STATES];
        let known = [place_sd, place_sd, angle_sd, gap_sd].map(|sd| sd * sd);
        variances[..known.len()].copy_from_slice(&known);
        Gaussian::new(mean, DMatrix::from_diagonal(&DVector::from_vec(variances)))
    }
}

impl PushMotion<'_> {
    /// What becomes of one point of a rule; `first` is the push's start.
    fn ways_of_point(
        &self,
        first: &PushParticle,
        point: &DVector<f64>,
    ) -> Result<Vec<(usize, f64, Gaussian)>, ModelError> {
        let pose_wb = Pose::new(point[0], point[1], point[2]);
        let held = Vector3::new(point[4], point[5], point[6]);
        let nominal = first.contact_gap.unwrap_or(0.0);
        let mut state = first.moved(pose_wb, held, point[3]);
        let off = self.pushed.gap(&pose_wb, &self.step.start_w) - (nominal + point[3]);
        state.contact_gap = (off <= self.settings.tolerance).then_some(nominal + point[3]);
        let (kept, renewed_variance) = match &self.settings.errors {
            StepErrors::Held(correlation) => {
                let kept = correlation.kept(self.step.distance());
                (kept, correlation.mean_square_size() * (1.0 - kept * kept))
            }
            StepErrors::None | StepErrors::Independent => (1.0, 0.0),
        };
        let ways = self.ways(&state)?.into_iter().map(|(way, share, pose_wb, covariance)| {
            let mut mean = point.clone();
            mean[0] = pose_wb.position.x;
            mean[1] = pose_wb.position.y;
            mean[2] = pose_wb.angle;
            let mut spread = DMatrix::zeros(N_STATES, N_STATES);
            for shared in N_STATES - N_SHARED..N_STATES {
                mean[shared] *= kept;
                spread[(shared, shared)] = renewed_variance;
            }
            spread.view_mut((0, 0), (N_POSE, N_POSE)).copy_from(&covariance);
            Ok((way, share, Gaussian::new(mean, spread)?))
        });
        ways.collect()
    }

    /// The ways that a state may go in the step.
    fn ways(&self, state: &PushParticle) -> Result<Vec<Way>, ModelError> {
        let still = || vec![(Slip::ALL.len(), 1.0, state.pose_wb, Matrix3::zeros())];
        let Some(along_w) = self.direction_w() else { return Ok(still()) };
        let Some(begin) = self.begins(state, &along_w) else { return Ok(still()) };
        let Some(input) = self.input(state, &begin, &along_w)? else { return Ok(still()) };
        let held = Holding {
            center_w: self.step.end_w,
            along_w,
            gap: begin.gap,
            tolerance: self.settings.tolerance,
        };
        let axes = Rotation2::from_basis_unchecked(&[along_w, perpendicular(&along_w)]);
        let axes = axes.matrix().to_homogeneous();
        let way = |(slip, share, said): (Slip, f64, StepPrediction)| {
            let (mean, covariance) = self.with_shared(state, &said);
            let drawn_wb = moved_by(&state.pose_wb, &along_w, mean.into());
            let (pose_wb, covariance) = self
                .pushed
                .settled_gaussian(&drawn_wb, &held, &covariance, &axes)
                .unwrap_or_else(|| (drawn_wb, axes * covariance * axes.transpose()));
            (slip as usize, share, pose_wb, covariance)
        };
        Ok(self.said(&input)?.into_iter().map(way).collect())
    }

    /// What the model says of a step, by the ways that the contact goes.
    fn said(&self, input: &StepInput) -> Result<Vec<(Slip, f64, StepPrediction)>, ModelError> {
        let (one, noise) = (std::slice::from_ref(input), self.noise());
        if let Some(mixture) = self.model.as_mixture() {
            return Ok(mixture.ways(one, noise)?.remove(0).modes);
        }
        let said = self.model.predict(one, noise)?[0];
        let slip = Slip::of(&StepObservation { input: input.clone(), outputs: said.mean });
        Ok(vec![(slip, 1.0, said)])
    }

    /// A step's mean and covariance given what the push's steps share.
    fn with_shared(
        &self,
        state: &PushParticle,
        said: &StepPrediction,
    ) -> (Vector3<f64>, Matrix3<f64>) {
        match &self.settings.errors {
            StepErrors::None => (said.mean, Matrix3::zeros()),
            StepErrors::Independent => (said.mean, said.covariance),
            StepErrors::Held(correlation) => {
                let root = root(&said.covariance);
                let own_variance = correlation.mean_square_size() * Vector3::from(correlation.own);
                let own = root * Matrix3::from_diagonal(&own_variance.map(f64::sqrt));
                let shared = correlation.drawn(&state.held, &Vector3::zeros());
                (said.mean + root * shared, own * own.transpose())
            }
        }
    }
}

/// The part of a mixture that is about the pose.
fn pose_of(state: &Mixture) -> Result<Mixture, FilterError> {
    let part = |(part, weight): &(Gaussian, f64)| {
        let mean = part.mean().rows(0, N_POSE).into_owned();
        let covariance = part.covariance().view((0, 0), (N_POSE, N_POSE)).into_owned();
        Ok((Gaussian::new(mean, covariance)?, *weight))
    };
    Mixture::new(state.components().iter().map(part).collect::<Result<_, FilterError>>()?)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use filter::{GaussHermite, Rule, Unscented};
    use nalgebra::{Matrix3, Vector2, Vector3};
    use planar::{Pose, Shape};

    use crate::{
        Analytical, CharacteristicLength, ContactGap, Estimate, PushPath, Pushed, RollOut,
        RollOutSettings,
    };

    fn push(
        settings: &RollOutSettings,
        rule: &dyn Rule,
        n: usize,
    ) -> ([Vector3<f64>; 2], [Matrix3<f64>; 2]) {
        let scatter = Matrix3::from_diagonal(&Vector3::new(2e-3, 2e-3, 1.0));
        let model = Analytical::new(
            Estimate::exact(0.25, ""),
            CharacteristicLength::UniformPressure,
            1e-1 * scatter,
        )
        .unwrap();
        let pushed = Pushed {
            shape: Arc::new(Shape::square(0.09).unwrap()),
            pusher_radius: 0.005,
            object: None,
        };
        let start = Vector2::new(-0.05, 0.012);
        let path = PushPath::straight(start, start + Vector2::new(0.02, 0.004), 0.02).unwrap();
        let roll_out = RollOut { model: &model, pushed: &pushed, settings };
        let moments = roll_out.run(&Pose::default(), &path, |_, _| {}).unwrap();
        let matched = roll_out.matched(&Pose::default(), &path, rule, n).unwrap();
        assert_eq!(moments.len(), matched.len());
        let (particles, last) = (&moments[moments.len() - 1].pose_wb, &matched[matched.len() - 1]);
        let last = last.moments().unwrap();
        let mean = Vector3::from_iterator(last.mean().iter().copied());
        let covariance = Matrix3::from_iterator(last.covariance().iter().copied());
        ([particles.mean, mean], [particles.covariance, covariance])
    }

    fn settings() -> RollOutSettings {
        RollOutSettings {
            n_particles: 40_000,
            touching: true,
            gap: ContactGap { sd: 1e-4, ..ContactGap::default() },
            start_sd: [2e-4, 5e-3],
            ..RollOutSettings::default()
        }
    }

    #[test]
    fn matched_moments_are_those_of_many_particles() {
        let settings = settings();
        for (rule, n, within) in [
            (&Unscented as &dyn Rule, 1, 0.05),
            (&GaussHermite { order: 3 }, 1, 0.05),
            (&Unscented, 4, 0.05),
        ] {
            let (means, covariances) = push(&settings, rule, n);
            let sd = covariances[0].diagonal().map(f64::sqrt);
            let off = (means[0] - means[1]).component_div(&sd).amax();
            assert!(off < within, "{off}");
            let ratio = covariances[1].diagonal().component_div(&covariances[0].diagonal());
            assert!(ratio.iter().all(|ratio| (ratio - 1.0).abs() < 0.1), "{ratio}");
        }
    }

    #[test]
    fn without_errors_the_one_way_is_that_of_a_particle() {
        let still = RollOutSettings {
            n_particles: 1,
            errors: crate::StepErrors::None,
            touching: true,
            ..RollOutSettings::default()
        };
        let (means, covariances) = push(&still, &Unscented, 1);
        assert!((means[0] - means[1]).amax() < 1e-12, "{means:?}");
        assert!(covariances[1].amax() < 1e-20);
    }
}
