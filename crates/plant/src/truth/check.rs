//! Which numbers a truth may have.

use super::Truth;
use crate::PlantError;

impl Truth {
    /// Refuses numbers that no rig has.
    ///
    /// # Errors
    /// `OutOfRange` with the name, value, unit and range of the first of them.
    pub fn check(&self) -> Result<(), PlantError> {
        let rate = &self.support_friction.rate;
        let (tip, groove) = (&self.tip, &self.height_map.groove);
        let ranges = [
            ("support_friction.coefficient", self.support_friction.coefficient, "", 0.0, 10.0),
            ("support_friction.drift", self.support_friction.drift, "", -1.5, 1.5),
            ("rate.log_slope", rate.log_slope, "", -0.2, 2.0),
            ("rate.log_speed", rate.log_speed, "m/s", 1e-4, 10.0),
            ("rate.breakaway_ratio", rate.breakaway_ratio, "", 0.2, 5.0),
            ("rate.stribeck_speed", rate.stribeck_speed, "m/s", 1e-4, 1.0),
            ("rate.film_dip", rate.film_dip, "", -1.0, 0.95),
            ("rate.film_speed", rate.film_speed, "m/s", 1e-4, 10.0),
            ("pressure.radius_ratio", self.pressure.radius_ratio, "", 0.2, 2.0),
            ("pressure.patch_share", self.pressure.patch_share, "", 0.0, 1.0),
            ("table_grain.ratio", self.table_grain.ratio, "", 0.1, 10.0),
            ("body_grain.ratio", self.body_grain.ratio, "", 0.1, 10.0),
            ("friction_map.spot.radius", self.friction_map.spot.radius, "m", 1e-3, 1.0),
            ("friction_map.spot.increase", self.friction_map.spot.increase, "", -1.0, 10.0),
            ("groove.depth", groove.depth, "m", 0.0, 0.01),
            ("groove.width", groove.width, "m", 5e-4, 0.5),
            ("groove.polish", groove.polish, "", 0.0, 1.0),
            ("wobble.share", self.wobble.share, "", 0.0, 0.9),
            ("wobble.force", self.wobble.force, "N", 1e-3, 100.0),
            ("body.mass_ratio", self.body.mass_ratio, "", 0.01, 100.0),
            ("wear.corner_radius", self.wear.corner_radius, "m", 0.0, 1.0),
            ("wear.chip_size", self.wear.chip_size, "m", 0.0, 1.0),
            ("cable.tension", self.cable.tension, "N", 0.0, 100.0),
            ("cable.stiffness", self.cable.stiffness, "N/m", 0.0, 1e3),
            ("magnet.pull", self.magnet.pull, "N", 0.0, 100.0),
            ("magnet.reach", self.magnet.reach, "m", 5e-3, 10.0),
            ("tip.radius", tip.radius, "m", 1e-5, 1.0),
            ("tip.compliance", tip.compliance, "m/N", 1e-6, 0.01),
            ("tip.damping_ratio", tip.damping_ratio, "", 0.05, 5.0),
            ("tip.bias", tip.bias, "m", -0.1, 0.1),
            ("tip.hysteresis.stiffness", tip.hysteresis.stiffness, "N/m", 0.0, 1e6),
            ("tip.hysteresis.yield_force", tip.hysteresis.yield_force, "N", 1e-3, 100.0),
            ("tip_friction.coefficient", self.tip_friction.coefficient, "", 0.0, 10.0),
            ("tip_friction.asymmetry", self.tip_friction.asymmetry, "", -2.0, 2.0),
            ("tip_friction.static_ratio", self.tip_friction.static_ratio, "", 0.5, 5.0),
            ("tip_friction.stribeck_speed", self.tip_friction.stribeck_speed, "m/s", 1e-5, 1.0),
            ("markers.yaw", self.markers.yaw, "rad", -7.0, 7.0),
            ("clocks.object_latency", self.clocks.object_latency, "s", -1.0, 1.0),
            ("clocks.force_latency", self.clocks.force_latency, "s", -1.0, 1.0),
            ("force_sensor.rotation", self.force_sensor.rotation, "rad", -7.0, 7.0),
        ];
        let vectors = [
            ("pressure.center_shift", self.pressure.center_shift, "m", 0.5),
            ("body.center_shift", self.body.center_shift, "m", 0.5),
            ("friction_map.gradient", self.friction_map.gradient, "1/m", 100.0),
            ("friction_map.spot.center", self.friction_map.spot.center, "m", 10.0),
            ("height_map.downhill", self.height_map.downhill, "m/s²", 5.0),
            ("groove.point", groove.point, "m", 10.0),
            ("cable.attachment", self.cable.attachment, "m", 1.0),
            ("cable.anchor", self.cable.anchor, "m", 100.0),
            ("magnet.place", self.magnet.place, "m", 10.0),
            ("markers.shift", self.markers.shift, "m", 0.5),
            ("force_sensor.bias", self.force_sensor.bias, "N", 100.0),
            ("force_sensor.loaded_bias", self.force_sensor.loaded_bias, "N", 100.0),
        ];
        let vectors = vectors.into_iter().flat_map(|(name, values, unit, size)| {
            values.map(|value| (name, value, unit, -size, size))
        });
        let directions = [
            ("table_grain.direction", self.table_grain.direction),
            ("body_grain.direction", self.body_grain.direction),
            ("groove.direction", groove.direction),
            ("wobble.direction", self.wobble.direction),
        ]
        .map(|(name, value)| (name, value, "rad", -7.0, 7.0));
        let mut all = ranges.into_iter().chain(vectors).chain(directions);
        match all.find(|(_, value, _, low, high)| !(low..=high).contains(&value)) {
            None => Ok(()),
            Some((name, value, unit, low, high)) => Err(PlantError::OutOfRange {
                name: name.into(),
                value,
                unit,
                allowed: format!("a number from {low} to {high}"),
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::{PlantError, Truth};

    #[test]
    fn the_plain_rig_is_allowed_and_impossible_numbers_are_named() {
        Truth::default().check().unwrap();
        let mut truth = Truth::default();
        truth.tip.radius = -0.001;
        let error = truth.check().unwrap_err();
        assert!(matches!(&error, PlantError::OutOfRange { name, .. } if name == "tip.radius"));
        let mut truth = Truth::default();
        truth.markers.shift[1] = f64::NAN;
        assert!(truth.check().unwrap_err().to_string().starts_with("markers.shift = NaN m"));
    }
}
