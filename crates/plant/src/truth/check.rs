//! Which numbers a truth may have.

use super::Truth;
use crate::PlantError;
use crate::error::check_range;

/// Name, value, unit, and least and largest value of a number.
type Range = (&'static str, f64, &'static str, f64, f64);

impl Truth {
    /// Refuses numbers that no rig has.
    ///
    /// # Errors
    /// `OutOfRange` with the name, value, unit and range of the first of them.
    pub fn check(&self) -> Result<(), PlantError> {
        let parts = [&self.table_ranges()[..], &self.rig_ranges(), &self.ground_ranges()];
        let mut all = parts.concat().into_iter().chain(self.vector_ranges());
        all.try_for_each(|(name, value, unit, low, high)| {
            check_range(name, value, unit, (low, high))
        })?;
        for (name, texture, unit, most) in [
            ("height_map.texture", &self.height_map.texture, "m", 0.01),
            ("underside.texture", &self.underside.texture, "m", 0.01),
            ("friction_map.texture", &self.friction_map.texture, "", 2.0),
            ("tip_friction.texture", &self.tip_friction.texture, "", 2.0),
        ] {
            texture.check(name, unit, most)?;
        }
        Ok(())
    }

    /// Of what is between object and table.
    fn table_ranges(&self) -> [Range; 26] {
        let (support, rate) = (&self.support_friction, &self.support_friction.rate);
        let (spot, groove) = (&self.friction_map.spot, &self.height_map.groove);
        [
            ("support_friction.coefficient", support.coefficient, "", 0.0, 10.0),
            ("support_friction.drift", support.drift, "", -1.5, 1.5),
            ("rate.log_slope", rate.log_slope, "", -0.2, 2.0),
            ("rate.log_speed", rate.log_speed, "m/s", 1e-4, 10.0),
            ("rate.breakaway_ratio", rate.breakaway_ratio, "", 0.2, 5.0),
            ("rate.stribeck_speed", rate.stribeck_speed, "m/s", 1e-4, 1.0),
            ("rate.film_dip", rate.film_dip, "", -1.0, 0.95),
            ("rate.film_speed", rate.film_speed, "m/s", 1e-4, 10.0),
            ("pressure.radius_ratio", self.pressure.radius_ratio, "", 0.2, 2.0),
            ("pressure.patch_share", self.pressure.patch_share, "", 0.0, 1.0),
            ("pressure.rim_share", self.pressure.rim_share, "", 0.0, 1.0),
            ("pressure.feet.share", self.pressure.feet.share, "", 0.0, 1.0),
            ("pressure.feet.reach", self.pressure.feet.reach, "", 0.05, 0.98),
            ("pressure.feet.direction", self.pressure.feet.direction, "rad", -7.0, 7.0),
            ("table_grain.ratio", self.table_grain.ratio, "", 0.1, 10.0),
            ("table_grain.direction", self.table_grain.direction, "rad", -7.0, 7.0),
            ("body_grain.ratio", self.body_grain.ratio, "", 0.1, 10.0),
            ("body_grain.direction", self.body_grain.direction, "rad", -7.0, 7.0),
            ("friction_map.spot.radius", spot.radius, "m", 1e-3, 1.0),
            ("friction_map.spot.increase", spot.increase, "", -1.0, 10.0),
            ("groove.depth", groove.depth, "m", 0.0, 0.01),
            ("groove.width", groove.width, "m", 5e-4, 0.5),
            ("groove.polish", groove.polish, "", 0.0, 1.0),
            ("groove.direction", groove.direction, "rad", -7.0, 7.0),
            ("magnet.pull", self.magnet.pull, "N", 0.0, 100.0),
            ("magnet.reach", self.magnet.reach, "m", 5e-3, 10.0),
        ]
    }

    /// Of what stands on the textures.
    fn ground_ranges(&self) -> [Range; 7] {
        [
            ("underside.stiffness", self.underside.stiffness, "N/m", 0.0, 1e9),
            ("underside.hollow", self.underside.hollow, "m", -0.01, 0.01),
            ("underside.twist", self.underside.twist, "m", -0.01, 0.01),
            ("tip.height", self.tip.height, "m", 0.0, 1.0),
            ("wear.edge_break", self.wear.edge_break, "m", 0.0, 1.0),
            ("wear.burr.friction", self.wear.burr.friction, "", 0.0, 10.0),
            ("wear.burr.reach", self.wear.burr.reach, "m", 1e-4, 1.0),
        ]
    }

    /// Of object, tip and sensors.
    fn rig_ranges(&self) -> [Range; 22] {
        let (tip, friction) = (&self.tip, &self.tip_friction);
        [
            ("wobble.share", self.wobble.share, "", 0.0, 0.9),
            ("wobble.force", self.wobble.force, "N", 1e-3, 100.0),
            ("wobble.direction", self.wobble.direction, "rad", -7.0, 7.0),
            ("body.mass_ratio", self.body.mass_ratio, "", 0.01, 100.0),
            ("wear.corner_radius", self.wear.corner_radius, "m", 0.0, 1.0),
            ("wear.chip_size", self.wear.chip_size, "m", 0.0, 1.0),
            ("cable.tension", self.cable.tension, "N", 0.0, 100.0),
            ("cable.stiffness", self.cable.stiffness, "N/m", 0.0, 1e3),
            ("tip.radius", tip.radius, "m", 0.0, 1.0),
            ("tip.compliance", tip.compliance, "m/N", 1e-6, 0.01),
            ("tip.damping_ratio", tip.damping_ratio, "", 0.05, 5.0),
            ("tip.bias", tip.bias, "m", -0.1, 0.1),
            ("tip.hysteresis.stiffness", tip.hysteresis.stiffness, "N/m", 0.0, 1e6),
            ("tip.hysteresis.yield_force", tip.hysteresis.yield_force, "N", 1e-3, 100.0),
            ("tip_friction.coefficient", friction.coefficient, "", 0.0, 10.0),
            ("tip_friction.asymmetry", friction.asymmetry, "", -2.0, 2.0),
            ("tip_friction.static_ratio", friction.static_ratio, "", 0.5, 5.0),
            ("tip_friction.stribeck_speed", friction.stribeck_speed, "m/s", 1e-5, 1.0),
            ("markers.yaw", self.markers.yaw, "rad", -7.0, 7.0),
            ("clocks.object_latency", self.clocks.object_latency, "s", -1.0, 1.0),
            ("clocks.force_latency", self.clocks.force_latency, "s", -1.0, 1.0),
            ("force_sensor.rotation", self.force_sensor.rotation, "rad", -7.0, 7.0),
        ]
    }

    /// Of everything with two components.
    fn vector_ranges(&self) -> impl Iterator<Item = Range> + use<> {
        let (map, sensor) = (&self.friction_map, &self.force_sensor);
        let vectors = [
            ("pressure.center_shift", self.pressure.center_shift, "m", 0.5),
            ("body.center_shift", self.body.center_shift, "m", 0.5),
            ("friction_map.gradient", map.gradient, "1/m", 100.0),
            ("friction_map.spot.center", map.spot.center, "m", 10.0),
            ("height_map.downhill", self.height_map.downhill, "m/s²", 5.0),
            ("groove.point", self.height_map.groove.point, "m", 10.0),
            ("cable.attachment", self.cable.attachment, "m", 1.0),
            ("cable.anchor", self.cable.anchor, "m", 100.0),
            ("magnet.place", self.magnet.place, "m", 10.0),
            ("markers.shift", self.markers.shift, "m", 0.5),
            ("cameras.shift", self.cameras.shift, "m", 0.5),
            ("force_sensor.bias", sensor.bias, "N", 100.0),
            ("force_sensor.loaded_bias", sensor.loaded_bias, "N", 100.0),
            ("force_sensor.lost_zero", sensor.lost_zero, "N", 100.0),
        ];
        vectors.into_iter().flat_map(|(name, values, unit, size)| {
            values.map(|value| (name, value, unit, -size, size))
        })
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
