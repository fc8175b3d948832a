//! Settings of the way from recordings to rows, with their limits.

use serde::{Deserialize, Serialize};

use crate::curves::spline::EndCondition;
use crate::error::DatasetError;

/// How recordings become rows; SI units throughout.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct IngestSettings {
    /// Length of a step.
    pub step: StepLength,
    /// A rest shorter than this makes no row of its own, in s.
    pub shortest_step: f64,
    /// A step by the way of the pusher goes on to the next multiple of the way until it has taken
    /// this time, in s; 0 for steps of exactly that way.
    pub least_step_time: f64,
    /// The curve through the samples of a pose stream.
    pub curve: Curve,
    /// Nothing is evaluated across a longer gap between samples, in s.
    pub longest_gap: f64,
    /// A longer way between neighboring samples counts as a jump, in m.
    pub jump_position: f64,
    /// A larger turn between neighboring samples counts as a jump, in rad.
    pub jump_angle: f64,
    /// A jump faster than this is no motion: nothing is evaluated across it, in m/s.
    pub fastest_speed: f64,
    /// A turn faster than this is no motion: nothing is evaluated across it, in rad/s.
    pub fastest_turn: f64,
    /// A recording whose object is tilted by more than this is excluded, in rad.
    pub largest_tilt: f64,
    /// A push with fewer object samples in contact is excluded.
    pub fewest_object_samples: usize,
    /// A push that lacks a stream for a larger share of its contact is excluded, 0 to 1.
    pub largest_gap_share: f64,
    /// What tells contact from no contact.
    pub contact: ContactSettings,
    /// What tells rest from motion.
    pub rest: RestSettings,
    /// Rows with a contact closer than this to a vertex are flagged, in m.
    pub vertex_distance: f64,
    /// Rows that start within this time of the first contact are flagged, in s.
    pub first_touch_time: f64,
    /// Rows that start within this way of the pusher from the first contact are flagged, in m.
    pub first_touch_way: f64,
    /// Rows whose pusher and outline overlap by more are flagged, in m.
    pub penetration: f64,
}

/// Length of a step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum StepLength {
    /// A time, in s.
    Time(f64),
    /// A way of the pusher, in m. After the contact one row reaches to the rest.
    Distance(f64),
}

/// The curve through the samples of a pose stream.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Curve {
    /// A cubic spline through every sample.
    Interpolate(EndCondition),
    /// A smoothing spline, fitted to contact and to what follows apart from each other, so that the
    /// kinks of first touch and stop stay out of it. Its noise is each push's own, as estimated.
    Smooth,
    /// The same with known noise.
    SmoothKnown {
        /// Standard deviation of positions, per axis, in m.
        position_sd: f64,
        /// Standard deviation of yaws, in rad.
        angle_sd: f64,
    },
}

/// What tells contact from no contact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ContactSettings {
    /// Contact begins when the force exceeds this many standard deviations of its noise.
    pub force_on: f64,
    /// Contact ends when the force falls below this many standard deviations of its noise.
    pub force_off: f64,
    /// Contact never begins below this force, in N: some sensors repeat a value without any noise.
    pub least_force: f64,
    /// By geometry, contact begins at a gap of at most this, in m.
    pub touch_gap: f64,
    /// By geometry, contact ends at a gap above this, in m.
    pub release_gap: f64,
    /// The pusher is free, and the force zero, at a gap above this, in m.
    pub free_gap: f64,
    /// Time after a contact that does not count as free, in s.
    pub settle_time: f64,
    /// Contacts closer in time are one, in s.
    pub rejoin_time: f64,
    /// Fewest force samples from which a zero is estimated.
    pub fewest_free_samples: usize,
    /// A change of the force's zero above this makes it untrusted, in N.
    pub zero_jump: f64,
}

/// What tells rest from motion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RestSettings {
    /// Way below which an object counts as at rest, in m (or 5 sd of its noise, if more).
    pub position: f64,
    /// Turn below which an object counts as at rest, in rad (or 5 sd of its noise, if more).
    pub angle: f64,
    /// Speed below which the pusher counts as at rest, in m/s.
    pub pusher_speed: f64,
}

impl Default for IngestSettings {
    fn default() -> Self {
        Self {
            step: StepLength::Time(0.2),
            shortest_step: 0.05,
            least_step_time: 0.0,
            curve: Curve::Interpolate(EndCondition::Natural),
            longest_gap: 0.05,
            jump_position: 0.005,
            jump_angle: 0.1,
            fastest_speed: 2.0,
            fastest_turn: 20.0,
            largest_tilt: 0.1,
            fewest_object_samples: 6,
            largest_gap_share: 0.5,
            contact: ContactSettings::default(),
            rest: RestSettings::default(),
            vertex_distance: 1.5e-3,
            first_touch_time: 0.1,
            first_touch_way: 2e-3,
            penetration: 1e-3,
        }
    }
}

impl Default for ContactSettings {
    fn default() -> Self {
        Self {
            force_on: 8.0,
            force_off: 4.0,
            least_force: 0.05,
            touch_gap: 1e-3,
            release_gap: 2e-3,
            free_gap: 1.5e-3,
            settle_time: 0.05,
            rejoin_time: 0.1,
            fewest_free_samples: 4,
            zero_jump: 0.2,
        }
    }
}

impl Default for RestSettings {
    fn default() -> Self {
        Self { position: 1e-4, angle: 1e-3, pusher_speed: 1e-3 }
    }
}

impl IngestSettings {
    /// Checks every setting against its range.
    ///
    /// # Errors
    /// `Setting` with name, value, unit and range of the first that is out of it.
    pub fn validate(&self) -> Result<(), DatasetError> {
        let step = match self.step {
            StepLength::Time(time) => ("step.time", time, " s"),
            StepLength::Distance(way) => ("step.distance", way, " m"),
        };
        let contact = &self.contact;
        let positive = [
            step,
            ("shortest_step", self.shortest_step, " s"),
            ("longest_gap", self.longest_gap, " s"),
            ("jump_position", self.jump_position, " m"),
            ("jump_angle", self.jump_angle, " rad"),
            ("fastest_speed", self.fastest_speed, " m/s"),
            ("fastest_turn", self.fastest_turn, " rad/s"),
            ("largest_tilt", self.largest_tilt, " rad"),
            ("contact.force_off", contact.force_off, ""),
            ("contact.least_force", contact.least_force, " N"),
            ("contact.zero_jump", contact.zero_jump, " N"),
            ("rest.position", self.rest.position, " m"),
            ("rest.angle", self.rest.angle, " rad"),
            ("rest.pusher_speed", self.rest.pusher_speed, " m/s"),
            ("penetration", self.penetration, " m"),
        ];
        let not_negative = [
            ("least_step_time", self.least_step_time, " s"),
            ("contact.settle_time", contact.settle_time, " s"),
            ("contact.rejoin_time", contact.rejoin_time, " s"),
            ("vertex_distance", self.vertex_distance, " m"),
            ("first_touch_time", self.first_touch_time, " s"),
            ("first_touch_way", self.first_touch_way, " m"),
        ];
        for (name, value, unit) in positive {
            check(value > 0.0, name, value, unit, "positive and finite")?;
        }
        for (name, value, unit) in not_negative {
            check(value >= 0.0, name, value, unit, "finite and not negative")?;
        }
        self.contact.validate_order()?;
        let share = self.largest_gap_share;
        check((0.0..=1.0).contains(&share), "largest_gap_share", share, "", "from 0 to 1")?;
        if let Curve::SmoothKnown { position_sd, angle_sd } = self.curve {
            check(position_sd >= 0.0, "position_sd", position_sd, " m", "finite, not negative")?;
            check(angle_sd >= 0.0, "angle_sd", angle_sd, " rad", "finite, not negative")?;
        }
        Ok(())
    }
}

impl ContactSettings {
    /// Checks that pairs of thresholds are in order.
    fn validate_order(&self) -> Result<(), DatasetError> {
        let ordered = [
            ("contact.force_on", self.force_on, "", self.force_off, "above contact.force_off"),
            (
                "contact.release_gap",
                self.release_gap,
                " m",
                self.touch_gap,
                "above contact.touch_gap",
            ),
            ("contact.free_gap", self.free_gap, " m", self.touch_gap, "above contact.touch_gap"),
        ];
        for (name, value, unit, other, allowed) in ordered {
            check(value > other, name, value, unit, allowed)?;
        }
        Ok(())
    }
}

fn check(
    holds: bool,
    name: &'static str,
    value: f64,
    unit: &'static str,
    allowed: &'static str,
) -> Result<(), DatasetError> {
    if holds && value.is_finite() {
        Ok(())
    } else {
        Err(DatasetError::Setting { name, value, unit, allowed })
    }
}

#[cfg(test)]
mod tests {
    use super::{IngestSettings, StepLength};

    #[test]
    fn the_defaults_are_valid_and_survive_text() {
        let settings = IngestSettings::default();
        settings.validate().unwrap();
        let text = serde_json::to_string(&settings).unwrap();
        assert_eq!(serde_json::from_str::<IngestSettings>(&text).unwrap(), settings);
    }

    #[test]
    fn a_setting_out_of_range_is_named_with_value_and_unit() {
        let mut settings =
            IngestSettings { step: StepLength::Time(-0.2), ..IngestSettings::default() };
        let message = settings.validate().unwrap_err().to_string();
        assert_eq!(message, "step.time must be positive and finite, got -0.2 s");
        settings.step = StepLength::Time(0.2);
        settings.contact.release_gap = 0.0005;
        let message = settings.validate().unwrap_err().to_string();
        assert_eq!(message, "contact.release_gap must be above contact.touch_gap, got 0.0005 m");
        settings.contact.release_gap = f64::NAN;
        assert!(settings.validate().is_err());
    }
}
