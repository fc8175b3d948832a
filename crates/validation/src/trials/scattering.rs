//! What trials let scatter from push to push.

use plant::Scatter;

/// A quantity that may scatter from push to push more than it usually does.
pub(super) struct Scattering {
    /// As the diagnosis names it.
    pub(super) name: &'static str,
    /// Of trials, in the unit that the diagnosis tells it in.
    pub(super) sd: f64,
    set: fn(&mut Scatter, f64),
}

impl Scattering {
    /// Lets it scatter so.
    pub(super) fn set(&self, scatter: &mut Scatter) {
        (self.set)(scatter, self.sd);
    }
}

/// Of table and tip, as trials claim it.
const NOMINAL_FRICTION: f64 = 0.25;

/// All that are tried.
pub(super) const SCATTERING: [Scattering; 6] = [
    Scattering {
        name: "support-friction",
        sd: 0.025,
        set: |scatter, sd| scatter.support_friction_sd = sd / NOMINAL_FRICTION,
    },
    Scattering {
        name: "pusher-friction",
        sd: 0.05,
        set: |scatter, sd| scatter.tip_friction_sd = sd / NOMINAL_FRICTION,
    },
    Scattering {
        name: "pressure-radius",
        sd: 0.1,
        set: |scatter, sd| scatter.pressure_radius_sd = sd,
    },
    Scattering {
        name: "friction-center-offset",
        sd: 3e-3,
        set: |scatter, sd| scatter.pressure_center_sd = sd,
    },
    Scattering { name: "contact-bias", sd: 1e-3, set: |scatter, sd| scatter.contact_sd = sd },
    Scattering { name: "force-bias", sd: 0.1, set: |scatter, sd| scatter.force_bias_sd = sd },
];
