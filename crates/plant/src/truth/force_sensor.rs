//! Calibration of the force sensor.

use libm::sincos;
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

/// How the force that is read differs from the force that acts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ForceSensor {
    /// Added to every reading while the tip is loaded, in N, world frame.
    ///
    /// A sensor is set to zero while it is unloaded, so a plain zero offset is gone by then.
    pub loaded_bias: [f64; 2],
    /// Added to every reading, in N, world frame.
    pub bias: [f64; 2],
    /// Added to every reading once a push has lost the sensor's zero, in N, world frame.
    pub lost_zero: [f64; 2],
    /// Turn of the sensor's axes, in rad.
    pub rotation: f64,
}

impl ForceSensor {
    /// What is read for a force, in N, world frame.
    pub(crate) fn reading(&self, force: &Vector2<f64>) -> Vector2<f64> {
        let mut reading = *force;
        if self.rotation != 0.0 {
            let (sin, cos) = sincos(self.rotation);
            reading = Vector2::new(cos * force.x - sin * force.y, sin * force.x + cos * force.y);
        }
        if *force != Vector2::zeros() {
            reading += Vector2::from(self.loaded_bias);
        }
        reading + Vector2::from(self.bias)
    }
}

#[cfg(test)]
mod tests {
    use super::ForceSensor;
    use nalgebra::Vector2;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn a_turned_sensor_reads_a_turned_force_and_its_bias() {
        let sensor = ForceSensor {
            rotation: FRAC_PI_2,
            bias: [0.5, 0.0],
            loaded_bias: [0.0, 0.25],
            ..ForceSensor::default()
        };
        let reading = sensor.reading(&Vector2::new(2.0, 0.0));
        assert!((reading - Vector2::new(0.5, 2.25)).norm() < 1e-15);
        assert_eq!(sensor.reading(&Vector2::zeros()), Vector2::new(0.5, 0.0));
    }
}
