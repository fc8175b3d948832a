//! Rigs as they are found: what is true of them, how their pushes scatter, what records them.

use crate::{Burr, Flips, GenerateSettings, Nominal, Scatter, Sensor, Sensors, Texture, Truth};

/// A kind of rig.
#[derive(Debug)]
pub struct Profile {
    /// Its name.
    pub name: &'static str,
    /// What it is.
    pub about: &'static str,
    surface: Option<Surface>,
}

/// A table as pushes on it were published to be.
#[derive(Debug)]
struct Surface {
    /// Coefficient of friction in the middle of a set; none for what is nominally claimed.
    friction: Option<f64>,
    /// Relative rise of the friction over a set.
    drift: f64,
    /// Rise of the friction with the logarithm of the speed.
    log_slope: f64,
    /// Friction along one direction over that across it.
    grain: f64,
    /// Departures of the friction from place to place, relative.
    friction_sd: f64,
    /// Bumps of the table, in m.
    height_sd: f64,
}

/// Every profile; the first is a rig that nothing disturbs.
const PROFILES: &[Profile] = &[
    Profile { name: "quiet", about: "even friction and load, little scatter", surface: None },
    Profile {
        name: "rough",
        about: "friction and load that vary from place to place, as on real tables",
        surface: Some(Surface {
            friction: None,
            drift: 0.0,
            log_slope: 0.0,
            grain: 1.0,
            friction_sd: 0.15,
            height_sd: 1e-5,
        }),
    },
    Profile {
        name: "abs",
        about: "rough, as hard plastic: friction 0.15 falling to 0.13",
        surface: Some(Surface {
            friction: Some(0.14),
            drift: -0.143,
            log_slope: 0.0,
            grain: 1.0,
            friction_sd: 0.4,
            height_sd: 2e-5,
        }),
    },
    Profile {
        name: "delrin",
        about: "rough, as smooth plastic: friction 0.16 falling to 0.12",
        surface: Some(Surface {
            friction: Some(0.14),
            drift: -0.286,
            log_slope: 0.0,
            grain: 1.0,
            friction_sd: 0.2,
            height_sd: 1e-5,
        }),
    },
    Profile {
        name: "plywood",
        about: "rough, as wood: friction 0.28 falling to 0.24",
        surface: Some(Surface {
            friction: Some(0.26),
            drift: -0.154,
            log_slope: 0.0,
            grain: 1.0,
            friction_sd: 0.6,
            height_sd: 4e-5,
        }),
    },
    Profile {
        name: "pu",
        about: "rough, as rubber: friction 0.29 to 0.28, more at speed and 3:2 along a direction",
        surface: Some(Surface {
            friction: Some(0.285),
            drift: -0.035,
            log_slope: 0.1,
            grain: 1.5,
            friction_sd: 0.8,
            height_sd: 6e-5,
        }),
    },
];

/// Stiffness of the table under an object, in N/m.
const STIFFNESS: f64 = 1e6;
/// How much lower the rim of a bottom is than its center, and two corners than two others, in m.
const HOLLOW: f64 = 1e-5;
const TWIST: f64 = 4e-6;
/// What varies over table, bottom and sides: sizes in m, and how fast smaller ones fade.
const TABLE_HEIGHT: Texture = Texture { sd: 0.0, longest: 0.2, shortest: 0.006, persistence: 0.7 };
const TABLE_FRICTION: Texture =
    Texture { sd: 0.0, longest: 0.2, shortest: 0.005, persistence: 0.8 };
const BOTTOM: Texture = Texture { sd: 3e-6, longest: 0.1, shortest: 0.01, persistence: 0.6 };
const SIDES: Texture = Texture { sd: 0.15, longest: 0.03, shortest: 0.002, persistence: 0.8 };

/// Vertices at which a tip is caught.
const BURR: Burr = Burr { n_vertices: 1, friction: 0.75, reach: 0.007 };

impl Profile {
    /// Name of the profile that is used where none is asked for: as real rigs are.
    pub const DEFAULT: &'static str = "rough";

    /// Every profile, the quiet one first.
    #[must_use]
    pub fn all() -> &'static [Self] {
        PROFILES
    }

    /// The profile of a name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        PROFILES.iter().find(|profile| profile.name == name)
    }

    /// What a manifest claims of it, where it claims no more than is usual.
    #[must_use]
    pub fn nominal(&self) -> Nominal {
        let mut nominal = Nominal::default();
        if let Some(friction) = self.surface.as_ref().and_then(|surface| surface.friction) {
            nominal.support_friction = friction;
        }
        nominal
    }

    /// Settings with all that it says, and what is usual for the rest.
    #[must_use]
    pub fn settings(&self) -> GenerateSettings {
        let nominal = self.nominal();
        GenerateSettings {
            nominal,
            truth: self.truth(&nominal),
            scatter: self.scatter(),
            sensors: self.sensors(),
            ..GenerateSettings::default()
        }
    }

    /// What is true of a rig of this kind of which so much is claimed.
    #[must_use]
    pub fn truth(&self, nominal: &Nominal) -> Truth {
        let mut truth = nominal.truth();
        let Some(surface) = &self.surface else { return truth };
        truth.support_friction.drift = surface.drift;
        truth.support_friction.rate.log_slope = surface.log_slope;
        truth.table_grain.ratio = surface.grain;
        truth.friction_map.texture = Texture { sd: surface.friction_sd, ..TABLE_FRICTION };
        truth.height_map.texture = Texture { sd: surface.height_sd, ..TABLE_HEIGHT };
        truth.underside.stiffness = STIFFNESS;
        truth.underside.hollow = HOLLOW;
        truth.underside.twist = TWIST;
        truth.underside.texture = BOTTOM;
        truth.tip_friction.texture = SIDES;
        truth.tip.height = 0.006;
        truth.wear.edge_break = 3e-4;
        truth.wear.burr = BURR;
        truth.force_sensor.lost_zero = [-1.55, -0.55];
        truth
    }

    /// How its pushes scatter.
    #[must_use]
    pub fn scatter(&self) -> Scatter {
        if self.surface.is_none() {
            return Scatter::default();
        }
        Scatter {
            support_friction_sd: 0.04,
            contact_sd: 2e-4,
            placing_sd: 2e-4,
            turning_sd: 3e-3,
            tip_friction_log_sd: 0.35,
            site_sd: 0.02,
            widest_gap: 2.5e-3,
            lost_zero_share: 0.5,
            ..Scatter::default()
        }
    }

    /// What records it.
    #[must_use]
    pub fn sensors(&self) -> Sensors {
        let usual = Sensors::default();
        if self.surface.is_none() {
            return usual;
        }
        Sensors {
            robot: Sensor { noise_sd: 5e-7, ..usual.robot },
            object: Sensor { noise_sd: 2e-5, yaw_noise_sd: 5e-4, gap_rate: 0.05, ..usual.object },
            force: Sensor { noise_sd: 0.015, ..usual.force },
            flips: Flips { rate: 1e-3, ..usual.flips },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Profile;
    use crate::{
        Design, GenerateSettings, Nominal, PushedObject, Scatter, Sensors, Truth, simulate,
    };
    use std::collections::BTreeSet;

    /// Three pushes of an object on a rig.
    fn settings(profile: &Profile, object: PushedObject) -> GenerateSettings {
        let design = Design { n_pushes: 3, travel: 0.02, ..Design::default() };
        GenerateSettings { object, design, ..profile.settings() }
    }

    #[test]
    fn names_differ_and_are_found() {
        let names: BTreeSet<_> = Profile::all().iter().map(|profile| profile.name).collect();
        assert_eq!(names.len(), Profile::all().len());
        for profile in Profile::all() {
            assert_eq!(Profile::named(profile.name).unwrap().about, profile.about);
        }
        assert!(Profile::named("ice").is_none());
    }

    #[test]
    fn quiet_is_the_plain_rig() {
        let quiet = Profile::named("quiet").unwrap();
        let nominal = Nominal { support_friction: 0.3, ..Nominal::default() };
        assert_eq!(quiet.truth(&nominal), nominal.truth());
        assert_eq!(quiet.truth(&quiet.nominal()), Truth::default());
        assert_eq!((quiet.scatter(), quiet.sensors()), (Scatter::default(), Sensors::default()));
    }

    #[test]
    fn every_profile_pushes_every_kind_of_object_and_again_alike() {
        for profile in Profile::all() {
            for name in ["rect1", "ellip2", "butter"] {
                let settings = settings(profile, PushedObject::Mit { name: name.into() });
                let pushes = simulate(&settings).unwrap();
                assert_eq!(pushes, simulate(&settings).unwrap(), "{} {name}", profile.name);
            }
        }
    }

    #[test]
    fn a_rough_rig_stands_on_other_spots_with_another_seed() {
        let rough = settings(Profile::named("rough").unwrap(), PushedObject::default());
        let mut other = rough.clone();
        other.truth.texture_seed = 12;
        let ends = [rough, other].map(|own| simulate(&own).unwrap()[0].trajectory.end_pose());
        assert!((ends[0].position - ends[1].position).norm() > 1e-5);
    }
}
