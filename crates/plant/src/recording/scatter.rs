//! How pushes and sessions scatter about the truth.

use libm::exp;
use serde::{Deserialize, Serialize};

use crate::error::check_range;
use crate::random::{Purpose, Random};
use crate::{PlantError, Variation};

/// Standard deviations from push to push, and their share from session to session.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Scatter {
    /// Of the support's friction, relative.
    pub support_friction_sd: f64,
    /// Of the tip's friction, relative.
    pub tip_friction_sd: f64,
    /// Of the pressure's mean distance from its center, relative.
    pub pressure_radius_sd: f64,
    /// Of the center of pressure along each axis, in m.
    pub pressure_center_sd: f64,
    /// Of the place where the tip's force acts, in m.
    pub contact_sd: f64,
    /// Of the loaded force sensor's bias along each axis, in N.
    pub force_bias_sd: f64,
    /// Of where the object is laid down, along each axis, in m.
    pub placing_sd: f64,
    /// Of how it is turned when it is laid down, in rad.
    pub turning_sd: f64,
    /// Scatter from session to session over that from push to push, for all of the above but the
    /// placing.
    pub session_share: f64,
    /// Of the logarithm of the tip's friction.
    pub tip_friction_log_sd: f64,
    /// Of where on the table a push takes place, object and path alike, along each axis, in m.
    pub site_sd: f64,
    /// How much further away than planned the tip starts at most, in m.
    pub widest_gap: f64,
    /// Share of the pushes in which the force sensor loses its zero, half of them from the start.
    pub lost_zero_share: f64,
}

impl Default for Scatter {
    fn default() -> Self {
        Self {
            support_friction_sd: 0.02,
            tip_friction_sd: 0.02,
            pressure_radius_sd: 0.01,
            pressure_center_sd: 2e-4,
            contact_sd: 1e-4,
            force_bias_sd: 0.01,
            placing_sd: 1e-4,
            turning_sd: 1e-3,
            session_share: 0.5,
            ..Self::NONE
        }
    }
}

impl Scatter {
    /// No scatter at all.
    pub const NONE: Self = Self {
        support_friction_sd: 0.0,
        tip_friction_sd: 0.0,
        pressure_radius_sd: 0.0,
        pressure_center_sd: 0.0,
        contact_sd: 0.0,
        force_bias_sd: 0.0,
        placing_sd: 0.0,
        turning_sd: 0.0,
        session_share: 0.0,
        tip_friction_log_sd: 0.0,
        site_sd: 0.0,
        widest_gap: 0.0,
        lost_zero_share: 0.0,
    };

    /// Refuses numbers that no rig scatters by.
    ///
    /// # Errors
    /// `OutOfRange` with the first of them.
    pub(crate) fn check(&self) -> Result<(), PlantError> {
        for (key, value, unit, high) in [
            ("support_friction_sd", self.support_friction_sd, "", 1.0),
            ("tip_friction_sd", self.tip_friction_sd, "", 1.0),
            ("pressure_radius_sd", self.pressure_radius_sd, "", 1.0),
            ("pressure_center_sd", self.pressure_center_sd, "m", 0.5),
            ("contact_sd", self.contact_sd, "m", 0.1),
            ("force_bias_sd", self.force_bias_sd, "N", 100.0),
            ("placing_sd", self.placing_sd, "m", 0.1),
            ("turning_sd", self.turning_sd, "rad", 1.0),
            ("session_share", self.session_share, "", 1e6),
            ("tip_friction_log_sd", self.tip_friction_log_sd, "", 2.0),
            ("site_sd", self.site_sd, "m", 1.0),
            ("widest_gap", self.widest_gap, "m", 0.1),
            ("lost_zero_share", self.lost_zero_share, "", 1.0),
        ] {
            check_range(&format!("scatter.{key}"), value, unit, (0.0, high))?;
        }
        Ok(())
    }

    /// The variation of one push.
    pub(crate) fn draw(&self, seed: u64, session: usize, push: usize) -> Variation {
        let mut of_session = Random::new(seed, Purpose::Session, session as u64);
        let mut of_push = Random::new(seed, Purpose::Push, push as u64);
        let mut draw = |sd: f64| of_push.normal(sd) + of_session.normal(sd * self.session_share);
        // Friction is never taken away as a whole, however wide the scatter.
        let factor = |relative: f64| (1.0 + relative).max(0.1);
        let mut rough = Random::new(seed, Purpose::Roughness, push as u64);
        let tip_friction = exp(rough.normal(self.tip_friction_log_sd));
        // A sum with 0, so that none is not −0.
        let shift = [rough.normal(self.site_sd) + 0.0, rough.normal(self.site_sd) + 0.0];
        let gap = rough.uniform(0.0, self.widest_gap);
        let zero_kept = match rough.happens(self.lost_zero_share) {
            true => rough.uniform(-1.0, 1.0).max(0.0),
            false => 1.0,
        };
        Variation {
            support_friction: factor(draw(self.support_friction_sd)),
            tip_friction: tip_friction * factor(draw(self.tip_friction_sd)),
            pressure_radius: factor(draw(self.pressure_radius_sd)),
            pressure_shift: [draw(self.pressure_center_sd), draw(self.pressure_center_sd)],
            contact_shift: draw(self.contact_sd),
            force_bias: [draw(self.force_bias_sd), draw(self.force_bias_sd)],
            zero_kept,
            gap,
            shift,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Scatter;
    use crate::Variation;

    #[test]
    fn without_scatter_nothing_varies_and_pushes_of_a_session_share_its_part() {
        assert_eq!(Scatter::NONE.draw(7, 1, 2), Variation::default());
        let session_alone = |session, push| {
            let wide = Scatter { session_share: 1e6, support_friction_sd: 1e-8, ..Scatter::NONE };
            wide.draw(7, session, push).support_friction
        };
        assert!((session_alone(1, 2) - session_alone(1, 3)).abs() < 1e-7);
        assert!((session_alone(1, 2) - session_alone(2, 2)).abs() > 1e-5);
    }

    #[test]
    fn roughness_is_as_wide_as_stated_and_leaves_the_rest_as_it_was() {
        let rough = Scatter {
            tip_friction_log_sd: 0.3,
            site_sd: 0.02,
            widest_gap: 0.003,
            lost_zero_share: 0.5,
            ..Scatter::default()
        };
        let all: Vec<_> = (0..4000).map(|push| rough.draw(7, 0, push)).collect();
        let plain = Scatter { tip_friction_sd: 0.0, ..rough };
        let logs = (0..4000).map(|push| plain.draw(7, 0, push).tip_friction.ln().powi(2));
        assert!(((logs.sum::<f64>() / 4e3).sqrt() / 0.3 - 1.0).abs() < 0.05);
        let shifts = all.iter().map(|own| own.shift[0] * own.shift[0]).sum::<f64>();
        assert!(((shifts / 4e3).sqrt() / 0.02 - 1.0).abs() < 0.05);
        assert!(all.iter().all(|own| (0.0..=0.003).contains(&own.gap)));
        let kept = all.iter().filter(|own| own.zero_kept == 1.0).count();
        let never = all.iter().filter(|own| own.zero_kept == 0.0).count();
        assert!((1880..2120).contains(&kept) && (890..1110).contains(&never), "{kept} {never}");
        let quiet = Scatter::default().draw(7, 0, 5);
        assert_eq!(all[5].support_friction, quiet.support_friction);
        assert_eq!(all[5].force_bias, quiet.force_bias);
        assert_eq!((quiet.shift, quiet.gap, quiet.zero_kept), ([0.0; 2], 0.0, 1.0));
    }
}
