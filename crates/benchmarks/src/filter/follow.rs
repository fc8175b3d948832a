//! A step and a measured pose, by filters of each kind.

use anyhow::{Context, Result};
use filter::{
    GaussHermite, Gaussian, LinearMeasurement, LinearMotion, MeasurementModel, MotionModel,
    ParticleFilter, RaoBlackwellized, Rule, Unscented,
};
use models::{
    ContactGap, GpPushModel, PathStep, PoseSeen, ProcessKind, PushParticle, PushVector, Pushed,
    RollOut, RollOutSettings, StepCorrelation, StepErrors, StepObservation, Training,
};
use nalgebra::{DMatrix, DVector};
use planar::Pose;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::super::timing::{Case, Row};
use super::push;

const N_PARTICLES: usize = 500;
/// Of the measured pose, in m and rad.
const SD: [f64; 2] = [2e-3, 0.04];

/// A step of a push, and a pose measured after it.
struct Follow<'a> {
    roll_out: RollOut<'a>,
    /// The same without errors.
    mean: RollOut<'a>,
    step: PathStep,
    seen: PoseSeen,
    particles: ParticleFilter<'static, PushParticle>,
    carried: ParticleFilter<'static, RaoBlackwellized<PushParticle>>,
    vector: PushVector<'a>,
    gaussian: Gaussian,
}

/// A filter by its name, whose step gives the log evidence of the pose.
type Filter = (&'static str, fn(&Follow<'_>) -> Result<f64>);

/// One row a filter, whose reference is as many particles.
pub(super) fn rows(pushed: &Pushed, steps: &[StepObservation]) -> Result<Vec<Row>> {
    let model = GpPushModel::train(steps, &Training::with(ProcessKind::Gp))?.0.tabulated()?.0;
    let settings = settings();
    let without_errors = RollOutSettings { errors: StepErrors::None, ..settings.clone() };
    let (path, steps) = push()?;
    let roll_out = RollOut { model: &model, pushed, settings: &settings };
    let start_wb = Pose::default();
    let vector = PushVector::new(roll_out, &start_wb, &path)?;
    let follow = Follow {
        roll_out,
        mean: RollOut { settings: &without_errors, ..roll_out },
        step: steps[0],
        seen: PoseSeen { pose_wb: Pose::new(2e-3, 0.0, 0.0), sd: SD },
        particles: roll_out.start(&start_wb, &path)?,
        carried: roll_out.start_carried(&start_wb, &path)?,
        gaussian: vector.start()?,
        vector,
    };
    let filters: [Filter; 5] = [
        ("auxiliary", |follow| follow.auxiliary()),
        ("Rao-Blackwellized", |follow| follow.rao_blackwellized()),
        ("extended", |follow| follow.extended()),
        ("unscented", |follow| follow.by_points(&Unscented)),
        ("Gauss-Hermite, 128 points", |follow| follow.by_points(&GaussHermite { order: 2 })),
    ];
    let mut rows = Vec::new();
    for (name, filter) in filters {
        filter(&follow).with_context(|| format!("the {name} filter"))?;
        follow.by_particles()?;
        let name = format!("{name} beside particles");
        let case = Case { name: &name, size: N_PARTICLES, threads: 1, rounds: 9, calls: 4 };
        rows.push(case.compare(|| filter(&follow), || follow.by_particles()));
    }
    Ok(rows)
}

fn settings() -> RollOutSettings {
    let correlation = StepCorrelation {
        held: [0.5; 3],
        length: 0.02,
        own: [0.5; 3],
        freedom: 6.0,
        measured: [0.0; 3],
        gap: ContactGap { sd: 1e-4, ..ContactGap::default() },
        n_pushes: 0,
        n_steps: 0,
        ends: None,
    };
    RollOutSettings {
        n_particles: N_PARTICLES,
        start_sd: [1e-4, 5e-3],
        touching: true,
        gap: correlation.gap,
        errors: StepErrors::Held(correlation),
        ..RollOutSettings::default()
    }
}

impl Follow<'_> {
    fn by_particles(&self) -> Result<f64> {
        let mut filter = self.particles.clone();
        filter.predict(&self.roll_out.motion(&self.step)?)?;
        Ok(filter.update(&self.seen)?.log_evidence)
    }

    fn auxiliary(&self) -> Result<f64> {
        let mean = self.mean.motion(&self.step)?;
        let ahead = |state: &PushParticle| {
            let (mut moved, mut random) = ([state.clone()], ChaCha8Rng::seed_from_u64(0));
            let is_moved = mean.advance(&mut moved, &mut random).is_ok();
            if is_moved { self.seen.log_likelihood(&moved[0]) } else { f64::NAN }
        };
        let (mut filter, motion) = (self.particles.clone(), self.roll_out.motion(&self.step)?);
        Ok(filter.auxiliary_step(&motion, &self.seen, ahead)?.log_evidence)
    }

    fn rao_blackwellized(&self) -> Result<f64> {
        let mut filter = self.carried.clone();
        let motion = self.roll_out.carried_motion(&self.step)?.context("errors are held")?;
        filter.predict(&motion)?;
        let of = |state: &RaoBlackwellized<PushParticle>| self.seen.log_likelihood(&state.drawn);
        let likelihoods: Vec<f64> = filter.particles().iter().map(of).collect();
        Ok(filter.update_by(&likelihoods)?.log_evidence)
    }

    fn by_points(&self, rule: &dyn Rule) -> Result<f64> {
        let after = |point: &DVector<f64>| self.vector.after(&self.step, point);
        self.measured(self.gaussian.predicted_by(rule, after)?.state())
    }

    fn extended(&self) -> Result<f64> {
        let slopes = self.vector.slopes(&self.step, &self.gaussian)?;
        let moved = self.vector.after(&self.step, self.gaussian.mean())?;
        let added = moved.mean() - &slopes * self.gaussian.mean();
        let motion = LinearMotion::new(slopes, Gaussian::new(added, moved.covariance().clone())?)?;
        self.measured(self.gaussian.predicted(&motion)?.state())
    }

    /// A state once the pose is measured.
    fn measured(&self, state: &Gaussian) -> Result<f64> {
        let Pose { position, angle } = self.seen.pose_wb;
        let noise = Gaussian::independent(DVector::zeros(3), &[SD[0], SD[0], SD[1]])?;
        let pose = DVector::from_vec(vec![position.x, position.y, angle]);
        let matrix = DMatrix::identity(3, state.mean().len());
        Ok(state.updated(&LinearMeasurement::new(pose, matrix, noise)?)?.log_evidence)
    }
}
