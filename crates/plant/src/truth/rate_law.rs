//! How friction depends on the sliding speed.

use libm::{exp, log1p};
use serde::{Deserialize, Serialize};

/// Friction at a sliding speed over its Coulomb value: a product of three factors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RateLaw {
    /// k of the factor 1 + k ln(1 + v/v₀).
    pub log_slope: f64,
    /// v₀, in m/s.
    pub log_speed: f64,
    /// Friction at rest over friction at speed: r of 1 + (r − 1) exp(−(v/vₛ)²).
    pub breakaway_ratio: f64,
    /// vₛ, in m/s.
    pub stribeck_speed: f64,
    /// d of the factor 1 − d (v/v_f) exp(1 − v/v_f) of a liquid film: friction falls by the share d
    /// at v_f and comes back beyond it.
    pub film_dip: f64,
    /// v_f, in m/s.
    pub film_speed: f64,
}

impl Default for RateLaw {
    fn default() -> Self {
        Self {
            log_slope: 0.0,
            log_speed: 0.01,
            breakaway_ratio: 1.0,
            stribeck_speed: 0.002,
            film_dip: 0.0,
            film_speed: 0.02,
        }
    }
}

impl RateLaw {
    /// Whether friction is the same at all speeds.
    pub(crate) fn is_off(&self) -> bool {
        self.log_slope == 0.0 && self.breakaway_ratio == 1.0 && self.film_dip == 0.0
    }

    /// The factor at a speed (m/s) and its derivative, in s/m.
    pub(crate) fn factor(&self, speed: f64) -> (f64, f64) {
        const OFF: (f64, f64) = (1.0, 0.0);
        let by_log = if self.log_slope == 0.0 {
            OFF
        } else {
            let v = speed / self.log_speed;
            let slope = self.log_slope / (self.log_speed + speed);
            (1.0 + self.log_slope * log1p(v), slope)
        };
        let by_stribeck = if self.breakaway_ratio == 1.0 {
            OFF
        } else {
            let v = speed / self.stribeck_speed;
            let bell = (self.breakaway_ratio - 1.0) * exp(-v * v);
            (1.0 + bell, -2.0 * v * bell / self.stribeck_speed)
        };
        let by_film = if self.film_dip == 0.0 {
            OFF
        } else {
            let v = speed / self.film_speed;
            let dip = self.film_dip * exp(1.0 - v);
            (1.0 - v * dip, -(1.0 - v) * dip / self.film_speed)
        };
        let product = |a: (f64, f64), b: (f64, f64)| (a.0 * b.0, a.1 * b.0 + a.0 * b.1);
        product(product(by_log, by_stribeck), by_film)
    }
}

#[cfg(test)]
mod tests {
    use super::RateLaw;

    #[test]
    fn the_derivative_is_that_of_the_factor() {
        let law =
            RateLaw { log_slope: 0.1, breakaway_ratio: 1.3, film_dip: 0.2, ..RateLaw::default() };
        for speed in [1e-4, 1e-3, 0.01, 0.05, 0.4] {
            let step = 1e-4 * speed;
            let rise = law.factor(speed + step).0 - law.factor(speed - step).0;
            let slope = law.factor(speed).1;
            assert!((rise / (2.0 * step) - slope).abs() < 1e-6 * (1.0 + slope.abs()), "{speed}");
        }
    }

    #[test]
    fn each_factor_is_what_it_says() {
        let off = RateLaw::default();
        assert_eq!(off.factor(0.02), (1.0, 0.0));
        assert!(off.is_off());
        let log = RateLaw { log_slope: 0.1, ..off };
        assert!((log.factor(0.01).0 - (1.0 + 0.1 * 2.0_f64.ln())).abs() < 1e-15);
        let stiction = RateLaw { breakaway_ratio: 1.4, ..off };
        assert_eq!(stiction.factor(0.0).0, 1.4);
        let film = RateLaw { film_dip: 0.3, ..off };
        assert!((film.factor(0.02).0 - 0.7).abs() < 1e-15);
        assert!(film.factor(0.1).0 > 0.95 && film.factor(0.001).0 > 0.95);
    }
}
