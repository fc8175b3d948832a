//! A whole push without particles: moments matched step by step.

use effects::deviations;
use filter::{FilterError, Gaussian, Mixture, Rule};
use nalgebra::{DMatrix, DVector, Matrix3, Rotation2, Vector3};
use planar::{Pose, perpendicular};

use super::exact::Exact;
use super::push_state::{N_POSE, N_STATES, SHARED, mean_square_size};
use super::settle::{Holding, moved_by};
use super::{PushMotion, PushParticle, RollOut, StepErrors};
use crate::steps::prediction::root;
use crate::{ModelError, PathStep, PushPath, Slip, StepInput, StepObservation, StepPrediction};

/// One way that a state may go: which, how probably, and the pose with its covariance in W.
type Way = (usize, f64, Pose, Matrix3<f64>);

/// How a Gaussian is carried through a step of a push.
#[derive(Clone, Copy)]
pub enum Matching<'a> {
    /// By the points of a rule: each goes through the contact and through the model, which gives it a
    /// Gaussian of its own. For any model.
    Points(&'a dyn Rule),
    /// Through the model in closed form, for processes of kind gp, spgp and rff and for mixtures of
    /// them: the mean and the covariance of what they say of a Gaussian over (p, β) are exact. What is
    /// not: the pose's map to (p, β), and the contact that holds at the end, which go by the points of a
    /// rule; and a step's own error has the expected variance, whatever the place. Where a part of a
    /// Gaussian may not touch, that Gaussian goes by the points alone.
    Exact(&'a dyn Rule),
}

impl RollOut<'_> {
    /// The push without particles: at the start and after each step, a mixture of at most
    /// `n_components` Gaussians over x, y in m and the angle in rad.
    ///
    /// Every component is carried through a step, with the contact that holds at its end; it splits
    /// where a [`crate::SlipMixture`] goes several ways and, by points, where they stick and slip, in
    /// closed form at an end of an edge; the nearest components are joined again. With one component
    /// these are matched moments. What a push draws once all its steps share: the push is carried through
    /// for each of a few places of the draw ([`effects::deviations`]), and is the mixture of these. A state touches where its gap is within the tolerance. The sizes of
    /// pushes, a Student t, begin as so many Gaussians of different widths.
    ///
    /// # Errors
    /// As [`RollOut::run`]; `NoClosedForm` for a model that has none; `Filter` for no components.
    pub fn matched(
        &self,
        start_wb: &Pose,
        path: &PushPath,
        matching: Matching<'_>,
        n_components: usize,
    ) -> Result<Vec<Mixture>, ModelError> {
        let steps = path.steps(self.settings.step)?;
        self.check()?;
        self.check_steps(&steps)?;
        let first = self.first(start_wb, path)?;
        if self.n_drawn() == 0 {
            return self.matched_from(&first, &steps, matching, n_components);
        }
        let mut moments: Vec<Vec<(Gaussian, f64)>> = vec![Vec::new(); steps.len() + 1];
        for (weight, numbers) in deviations(self.n_drawn()) {
            let first = self.with_draw(&first, path, numbers)?;
            let poses = self.matched_from(&first, &steps, matching, n_components)?;
            for (moment, pose) in moments.iter_mut().zip(poses) {
                let parts = pose.components().iter();
                moment.extend(parts.map(|(part, share)| (part.clone(), weight * share)));
            }
        }
        let moment = |parts| Ok(Mixture::new(parts)?.reduced(n_components)?);
        moments.into_iter().map(moment).collect()
    }

    /// The push of one start and one draw.
    fn matched_from(
        &self,
        first: &PushParticle,
        steps: &[PathStep],
        matching: Matching<'_>,
        n_components: usize,
    ) -> Result<Vec<Mixture>, ModelError> {
        let mut state = self.start_mixture(&first.pose_wb, n_components)?;
        let mut poses = vec![pose_of(&state)?];
        let exact = match matching {
            Matching::Points(_) => None,
            Matching::Exact(rule) => Some(Exact::of(self.model, first.clone(), rule)?),
        };
        for step in steps {
            let motion = self.motion(step)?;
            let moved = match (&exact, matching) {
                (Some(exact), _) => exact.moved(&motion, &state)?,
                (None, Matching::Points(rule) | Matching::Exact(rule)) => {
                    let mut moved = Vec::new();
                    for (part, weight) in state.components() {
                        let ways = motion.moved_by_points(first, part, rule)?;
                        moved.extend(ways.into_iter().map(|(part, share)| (part, weight * share)));
                    }
                    Mixture::new(moved)?
                }
            };
            state = motion.renewed(&moved.reduced(n_components)?)?;
            poses.push(pose_of(&state)?);
        }
        Ok(poses)
    }

    fn start_mixture(&self, start_wb: &Pose, n: usize) -> Result<Mixture, FilterError> {
        let held = match &self.settings.errors {
            StepErrors::Held(correlation) => scales(correlation.freedom, n),
            StepErrors::None | StepErrors::Independent => vec![(0.0, 1.0)],
        };
        let part = |(variance, share)| Ok((self.start_gaussian(start_wb, variance)?, share));
        Mixture::new(held.into_iter().map(part).collect::<Result<_, FilterError>>()?)
    }

    pub(super) fn start_gaussian(
        &self,
        start_wb: &Pose,
        held_variance: f64,
    ) -> Result<Gaussian, FilterError> {
        let [place_sd, angle_sd] = self.settings.start_sd;
        let gap_sd = self.settings.gap.sd;
        let Pose { position, angle } = start_wb;
        let mean = DVector::from_vec(vec![position.x, position.y, *angle, 0.0, 0.0, 0.0, 0.0]);
        let mut variances = vec![held_variance; N_STATES];
        let known = [place_sd, place_sd, angle_sd, gap_sd].map(|sd| sd * sd);
        variances[..known.len()].copy_from_slice(&known);
        Gaussian::new(mean, DMatrix::from_diagonal(&DVector::from_vec(variances)))
    }
}

/// A Student t of scale 1 as at most `n` Gaussians: their variances and shares. Half of the t, half of
/// the rest and so on are together, from the narrow ones to the tail.
///
/// A t is a Gaussian of variance ν/c with c from a χ² of ν degrees of freedom; each Gaussian has the mean
/// variance of its share, by sums over a fine grid of ln c.
fn scales(freedom: f64, n: usize) -> Vec<(f64, f64)> {
    let density = |c: f64| (0.5 * (freedom * (c / freedom).ln() - (c - freedom))).exp();
    // As far as the density falls on either side, from wide to narrow Gaussians and back.
    let grid = (0..=N_GRID).rev().map(|k| {
        let c = freedom * (GRID_REACH * (2.0 * k as f64 / N_GRID as f64 - 1.0)).exp();
        (freedom / c, density(c))
    });
    let grid: Vec<(f64, f64)> = grid.collect();
    let total: f64 = grid.iter().map(|(_, weight)| weight).sum();
    let mut parts = vec![(0.0, 0.0); n.max(1)];
    let mut below = 0.0;
    for (variance, weight) in grid {
        let share = weight / total;
        let middle = below + 0.5 * share;
        let part = (-(1.0 - middle).max(f64::MIN_POSITIVE).log2()) as usize;
        let (sum, own) = &mut parts[part.min(n.max(1) - 1)];
        *sum += share * variance;
        *own += share;
        below += share;
    }
    // Of many degrees of freedom the variance is 1 for all.
    let sound = parts.into_iter().filter(|(_, share)| *share > 0.0);
    sound.map(|(sum, share)| (sum / share, share)).collect()
}

const N_GRID: usize = 4000;
/// Of ln c about ln ν: of a t of three degrees of freedom all but 10⁻⁴ of the variance.
const GRID_REACH: f64 = 18.0;

impl PushMotion<'_> {
    /// One point of a rule as a particle; `first` is the push's start.
    pub(super) fn particle(&self, first: &PushParticle, point: &DVector<f64>) -> PushParticle {
        let pose_wb = Pose::new(point[0], point[1], point[2]);
        let held = Vector3::new(point[4], point[5], point[6]);
        let nominal = first.contact_gap.unwrap_or(0.0);
        let mut state = first.moved(pose_wb, held, point[3]);
        let off = self.outline_of(&state).gap(&pose_wb, &self.step.start_w) - (nominal + point[3]);
        state.contact_gap = (off <= self.settings.tolerance).then_some(nominal + point[3]);
        state
    }

    /// A Gaussian after the step, by the points of a rule: its parts, and their shares.
    pub(super) fn moved_by_points(
        &self,
        first: &PushParticle,
        part: &Gaussian,
        rule: &dyn Rule,
    ) -> Result<Vec<(Gaussian, f64)>, ModelError> {
        let first = PushParticle { size: mean_square_size(part).sqrt(), ..first.clone() };
        let alone = Mixture::new(vec![(part.clone(), 1.0)])?;
        let moved = alone.propagated(rule, |point| self.ways_of_point(&first, point))?;
        Ok(moved.components().to_vec())
    }

    /// What goes on to the next step of the numbers that steps share; the rest is new, as large as they are.
    fn renewed(&self, state: &Mixture) -> Result<Mixture, FilterError> {
        let StepErrors::Held(correlation) = &self.settings.errors else { return Ok(state.clone()) };
        let kept = correlation.kept(self.step.distance());
        let part = |(part, weight): &(Gaussian, f64)| {
            let (mut mean, mut covariance) = (part.mean().clone(), part.covariance().clone());
            let new_variance = (1.0 - kept * kept) * mean_square_size(part);
            for k in SHARED {
                mean[k] *= kept;
                covariance.row_mut(k).scale_mut(kept);
                covariance.column_mut(k).scale_mut(kept);
                covariance[(k, k)] += new_variance;
            }
            Ok((Gaussian::new(mean, covariance)?, *weight))
        };
        Mixture::new(state.components().iter().map(part).collect::<Result<_, FilterError>>()?)
    }

    /// What becomes of one point of a rule.
    pub(super) fn ways_of_point(
        &self,
        first: &PushParticle,
        point: &DVector<f64>,
    ) -> Result<Vec<(usize, f64, Gaussian)>, ModelError> {
        let state = self.particle(first, point);
        let ways = self.ways(&state)?.into_iter().map(|(way, share, pose_wb, covariance)| {
            let mut mean = point.clone();
            mean[0] = pose_wb.position.x;
            mean[1] = pose_wb.position.y;
            mean[2] = pose_wb.angle;
            let mut spread = DMatrix::zeros(N_STATES, N_STATES);
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
            outline: self.outline_of(state),
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
            let (pose_wb, covariance) = held
                .settled_gaussian(&drawn_wb, &covariance, &axes)
                .unwrap_or_else(|| (drawn_wb, axes * covariance * axes.transpose()));
            (slip as usize, share, pose_wb, covariance)
        };
        Ok(self.said_ways(state, &input)?.into_iter().map(way).collect())
    }

    /// What the model says of a step, by the ways that the contact goes.
    fn said_ways(
        &self,
        state: &PushParticle,
        input: &StepInput,
    ) -> Result<Vec<(Slip, f64, StepPrediction)>, ModelError> {
        let (one, noise) = (std::slice::from_ref(input), self.noise());
        if let Some(mixture) = self.model.as_mixture() {
            return Ok(mixture.ways(one, noise)?.remove(0).modes);
        }
        let said = self.said(std::iter::once(state), one)?[0];
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
                let own = Vector3::from(correlation.own).map(f64::sqrt);
                let own = root * Matrix3::from_diagonal(&(state.size * own));
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

    use super::scales;
    use crate::{
        Analytical, CharacteristicLength, ContactGap, Estimate, Matching, PushPath, Pushed,
        RollOut, RollOutSettings, StepCorrelation, StepErrors,
    };

    fn push(
        settings: &RollOutSettings,
        matching: Matching<'_>,
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
        let matched = roll_out.matched(&Pose::default(), &path, matching, n).unwrap();
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
            let (means, covariances) = push(&settings, Matching::Points(rule), n);
            let sd = covariances[0].diagonal().map(f64::sqrt);
            let off = (means[0] - means[1]).component_div(&sd).amax();
            assert!(off < within, "{off}");
            let ratio = covariances[1].diagonal().component_div(&covariances[0].diagonal());
            assert!(ratio.iter().all(|ratio| (ratio - 1.0).abs() < 0.1), "{ratio}");
        }
    }

    #[test]
    fn what_goes_on_from_step_to_step_widens_matched_moments_as_it_does_the_particles() {
        for (length, freedom) in [(1e-3, 1e6), (8e-3, 1e6), (1e3, 1e6), (8e-3, 8.0)] {
            let errors = StepErrors::Held(StepCorrelation {
                held: [0.5; 3],
                length,
                own: [0.3; 3],
                freedom,
                measured: [0.0; 3],
                gap: ContactGap::default(),
                n_pushes: 1,
                n_steps: 1,
                ends: None,
            });
            let settings = RollOutSettings { errors, ..settings() };
            for n in [1, 4] {
                let (_, covariances) = push(&settings, Matching::Points(&Unscented), n);
                let ratio = covariances[1].diagonal().component_div(&covariances[0].diagonal());
                assert!(ratio.iter().all(|ratio| (ratio - 1.0).abs() < 0.15), "{length} {ratio}");
            }
        }
    }

    #[test]
    fn gaussians_of_different_widths_are_together_as_a_student_t_is() {
        for freedom in [3.0, 6.0, 40.0] {
            for n in [1, 2, 4, 8] {
                let parts = scales(freedom, n);
                let total: f64 = parts.iter().map(|(_, share)| share).sum();
                let variance: f64 = parts.iter().map(|(variance, share)| variance * share).sum();
                assert!((total - 1.0).abs() < 1e-12 && parts.len() == n);
                assert!((variance / (freedom / (freedom - 2.0)) - 1.0).abs() < 1e-3, "{variance}");
            }
        }
        // What a t of three degrees of freedom has beyond 3: 0.0577.
        let beyond = |n| -> f64 {
            let tail =
                |(variance, share): (f64, f64)| share * libm::erfc(3.0 / (2.0 * variance).sqrt());
            scales(3.0, n).into_iter().map(tail).sum()
        };
        assert!((beyond(8) - 0.0577).abs() < 0.003, "{}", beyond(8));
        assert!((beyond(1) - 0.0577).abs() > 0.02, "{}", beyond(1));
    }

    #[test]
    fn without_errors_the_one_way_is_that_of_a_particle() {
        let still = RollOutSettings {
            n_particles: 1,
            errors: crate::StepErrors::None,
            touching: true,
            ..RollOutSettings::default()
        };
        let (means, covariances) = push(&still, Matching::Points(&Unscented), 1);
        assert!((means[0] - means[1]).amax() < 1e-12, "{means:?}");
        assert!(covariances[1].amax() < 1e-20);
    }
}
