//! The steps of the data's first object, to train on and to be tested on.

use std::sync::Arc;

use anyhow::Result;
use dataset::{ObjectChoice, Table};
use models::{StepObservation, StepSelection};
use planar::Shape;

use crate::figures::inputs::Inputs;
use crate::held_out::quantile;

/// Fewer steps are too few to train on a half and be tested on the other.
const FEWEST: usize = 80;

/// Whole steps in contact of one object.
pub(crate) struct Steps {
    pub steps: Vec<StepObservation>,
    pub shape: Arc<Shape>,
    pub pusher_radius: f64,
    /// Between pusher and object, nominal.
    pub friction: f64,
    /// The pusher's, in the median of all rows, in m/s.
    pub speed: f64,
}

impl Steps {
    /// Of the object of the first row; those of others would need models of their own.
    pub(crate) fn of(inputs: &Inputs) -> Result<Self> {
        let found = Self::among(inputs, inputs.table()?)?;
        found.ok_or_else(|| inputs.lacking("at least 80 whole steps of one object"))
    }

    /// Those among the rows of another table of the same data; none if they are too few.
    pub(crate) fn among(inputs: &Inputs, table: &Table) -> Result<Option<Self>> {
        let pusher = inputs.pusher()?;
        let Some(first) = table.rows.first() else { return Ok(None) };
        let object = inputs.object(&first.recording)?;
        let rows = table.rows.iter().filter(|row| row.shape == first.shape).cloned().collect();
        let speed = quantile(table.rows.iter().map(|row| row.speed).collect(), 0.5);
        let table = Table { rows, provenance: table.provenance.clone() };
        let shape = Arc::new(object.shape.clone());
        let objects = ObjectChoice::Fixed(Box::new(object));
        let steps = StepSelection::default().observations(&table, &objects, pusher.radius)?.steps;
        let (pusher_radius, friction) = (pusher.radius, pusher.friction);
        let is_enough = steps.len() >= FEWEST;
        Ok(is_enough.then_some(Self { steps, shape, pusher_radius, friction, speed }))
    }
}
