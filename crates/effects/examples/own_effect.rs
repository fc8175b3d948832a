//! An effect of one's own that carries data: a measured map of the table's friction.
//! `cargo run -p pushlab-effects --example own_effect`

use std::error::Error;
use std::sync::Arc;

use effects::{
    Channel, Effect, EffectInfo, Nuisance, Object, Origin, Parameter, PushPhysics, Rig, Sliding,
    Stage, StepInput, Surface, Track,
};
use nalgebra::{DMatrix, Vector2};
use planar::{Pose, Shape, Twist};

/// Friction over the table relative to its mean, as a tribometer found it: a line for each y, from
/// the smallest, a column for each x.
const MEASURED: &str = "\
    0.95, 0.97, 1.00, 1.04\n\
    0.96, 0.99, 1.05, 1.12\n\
    0.94, 0.98, 1.02, 1.08\n";

/// A map of friction over the table, relative to its mean.
#[derive(Debug)]
struct FrictionMap {
    /// Where the first number was measured, in m, frame W.
    corner_w: Vector2<f64>,
    /// From one to the next along either axis, in m.
    spacing: f64,
    /// A row for each y, a column for each x.
    relative: DMatrix<f64>,
}

static INFO: EffectInfo = EffectInfo {
    id: "friction-map",
    title: "Measured friction map",
    physics: "Friction differs from place to place as it was measured.",
    equation: "μ(x) = μs (1 + g (m(x) − 1)), with m(x) the map, 1 in the mean, and g its gain",
    source: "a tribometer on the table",
    stages: &[Stage::Local],
    origin: Origin::Table,
    reaches: &[Channel::Motion, Channel::Force],
    parameters: &[Parameter::number("gain", "1", "1 for the map as it is", (0.0, 1.0), (0.0, 3.0))],
    confounders: &[],
    nuisance: Nuisance::No,
    shown_by: &["pushes over the whole table"],
};

impl Effect for FrictionMap {
    fn info(&self) -> &EffectInfo {
        &INFO
    }

    fn local_friction(&self, values: &[f64], sliding: &Sliding) -> f64 {
        values[0] * (self.at(&sliding.place_w) - 1.0)
    }
}

impl FrictionMap {
    /// From lines of numbers between commas.
    fn from_csv(text: &str, corner_w: Vector2<f64>, spacing: f64) -> Result<Self, Box<dyn Error>> {
        let numbers = |line: &str| line.split(',').map(|x| x.trim().parse()).collect();
        let rows: Vec<Vec<f64>> = text.lines().map(numbers).collect::<Result<_, _>>()?;
        let n_columns = rows.first().map_or(0, Vec::len);
        if rows.len() < 2 || n_columns < 2 || rows.iter().any(|row| row.len() != n_columns) {
            return Err("a friction map needs two lines or more of two numbers or more each".into());
        }
        let relative = DMatrix::from_fn(rows.len(), n_columns, |row, column| rows[row][column]);
        Ok(Self { corner_w, spacing, relative })
    }

    /// Bilinear between the places where it was measured, and as at the rim beyond them.
    fn at(&self, place_w: &Vector2<f64>) -> f64 {
        let cell = |along: f64, n: usize| {
            let first = along.floor().clamp(0.0, (n - 2) as f64);
            (first as usize, (along - first).clamp(0.0, 1.0))
        };
        let place = (place_w - self.corner_w) / self.spacing;
        let (row, up) = cell(place.y, self.relative.nrows());
        let (column, right) = cell(place.x, self.relative.ncols());
        let along_x = |row: usize| {
            let [left, next] = [column, column + 1].map(|column| self.relative[(row, column)]);
            (1.0 - right) * left + right * next
        };
        (1.0 - up) * along_x(row) + up * along_x(row + 1)
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let map = FrictionMap::from_csv(MEASURED, Vector2::new(0.0, 0.0), 0.1)?; // m
    let object = Arc::new(Object::uniform(Arc::new(Shape::square(0.09)?), 0.84)?);
    let physics = PushPhysics::new(Rig::new(Surface::Ellipsoid, 0.25, 0.25)?);
    let mapped = physics.clone().with(map, &[1.0])?;
    println!("x of the object in m, normal force in N and turn in °: without, with the map");
    for x in [0.1, 0.15, 0.2, 0.25] {
        let start = Vector2::new(x - 0.05, 0.07);
        let step = StepInput {
            object: object.clone(),
            pusher_radius: 0.005,
            pose_wb: Pose::new(x, 0.07, 0.0),
            twist_wb: Twist::default(),
            track: Track::straight(start, start + Vector2::new(0.01, 0.0), 0.5),
            touching: true,
            since_contact: 1.0,
            run_up: None,
            progress: 0.0,
            session: 0,
        };
        let (without, with) = (physics.predict(&step)?, mapped.predict(&step)?);
        let turns = [without.dtheta, with.dtheta].map(f64::to_degrees);
        let forces = [without.force_normal, with.force_normal];
        println!("{x:.2}  {forces:.3?}  {turns:.3?}");
    }
    Ok(())
}
