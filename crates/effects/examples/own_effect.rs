//! An effect of one's own: a sticky spot on the table. `cargo run -p pushlab-effects --example own_effect`

use effects::{
    Channel, Effect, EffectInfo, Object, Parameter, PushPhysics, Rig, Sliding, Stage, StepInput,
    Surface, Track,
};
use nalgebra::Vector2;
use planar::{Pose, Shape, Twist};
use std::sync::Arc;

#[derive(Debug)]
struct StickySpot;

const PLACE_W: Vector2<f64> = Vector2::new(0.3, 0.1);
const RADIUS: f64 = 0.03;

static INFO: EffectInfo = EffectInfo {
    id: "sticky-spot",
    title: "Sticky spot",
    physics: "Friction is larger around one place of the table.",
    equation: "μ(x) = μs (1 + s exp(−|x − x₀|²/(2 r²)))",
    source: "made up",
    stages: &[Stage::Local],
    reaches: &[Channel::Motion, Channel::Force],
    parameters: &[Parameter::number("surplus", "1", "At its middle", (0.0, 0.5), (0.0, 5.0))],
    look_alikes: &[],
};

impl Effect for StickySpot {
    fn info(&self) -> &EffectInfo {
        &INFO
    }

    fn local_friction(&self, values: &[f64], sliding: &Sliding) -> f64 {
        let distance = (sliding.place_w - PLACE_W).norm() / RADIUS;
        values[0] * (-0.5 * distance * distance).exp()
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let object = Arc::new(Object::uniform(Arc::new(Shape::square(0.09)?), 0.84)?);
    let physics = PushPhysics::new(Rig::new(Surface::Ellipsoid, 0.25, 0.25)?);
    let sticky = physics.clone().with(&StickySpot, &[0.5])?;
    println!("x of the object in m, normal force in N and turn in °: without, with the spot");
    for x in [0.1, 0.2, 0.25, 0.3] {
        let start = Vector2::new(x - 0.05, 0.07);
        let step = StepInput {
            object: object.clone(),
            pusher_radius: 0.005,
            pose_wb: Pose::new(x, 0.07, 0.0),
            twist_wb: Twist::default(),
            track: Track::straight(start, start + Vector2::new(0.01, 0.0), 0.5),
            touching: true,
            since_contact: 1.0,
            progress: 0.0,
            session: 0,
        };
        let (without, with) = (physics.predict(&step)?, sticky.predict(&step)?);
        let turns = [without.dtheta, with.dtheta].map(f64::to_degrees);
        let forces = [without.force_normal, with.force_normal];
        println!("{x:.2}  {forces:.2?}  {turns:.2?}");
    }
    Ok(())
}
