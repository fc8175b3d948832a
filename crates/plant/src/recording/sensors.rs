//! What the sensors make of a push.

use dataset::{PoseStream, WrenchStream};
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use crate::dynamics::state::rotation;
use crate::error::check_range;
use crate::random::{Purpose, Random};
use crate::{Plant, PlantError, Trajectory, Variation};

/// The sensors of the rig.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Sensors {
    /// The robot's report of where it holds the tip.
    pub robot: Sensor,
    /// Motion capture of the object.
    pub object: Sensor,
    /// The sensor of force and torque at the tip; each reading is the mean since the one before.
    /// The torque is that about the tip's axis.
    pub force: Sensor,
    /// Turns that the motion capture takes for others.
    pub flips: Flips,
}

/// Stretches in which an object is tracked as if it were turned.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Flips {
    /// How many begin in a second.
    pub rate: f64,
    /// Mean length, in s.
    pub length: f64,
    /// Least and largest turn, to either side, in rad.
    pub turn: [f64; 2],
}

impl Default for Flips {
    fn default() -> Self {
        Self { rate: 0.0, length: 0.3, turn: [60.0_f64.to_radians(), 130.0_f64.to_radians()] }
    }
}

impl Flips {
    /// From when to when, in s, and by what turn, in rad.
    fn drawn(&self, random: &mut Random, duration: f64) -> Vec<(f64, f64, f64)> {
        let mut flips = Vec::new();
        let mut time = 0.0;
        if self.rate == 0.0 {
            return flips;
        }
        loop {
            let mut wait = |mean: f64| -mean * libm::log(1.0 - random.uniform(0.0, 1.0));
            time += wait(1.0 / self.rate);
            if time > duration {
                return flips;
            }
            let end = time + wait(self.length);
            flips.push((time, end, random.sign() * random.uniform(self.turn[0], self.turn[1])));
            time = end;
        }
    }
}

/// One sensor with a clock of its own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Sensor {
    /// Samples in a second, in Hz; 0 for no sensor.
    pub rate: f64,
    /// Standard deviation of the noise along each axis, in m or N.
    pub noise_sd: f64,
    /// Standard deviation of the yaw in rad, or of the torque in N·m.
    pub yaw_noise_sd: f64,
    /// Share of samples with a wider noise.
    pub outlier_share: f64,
    /// Width of that noise over the usual one.
    pub outlier_ratio: f64,
    /// Standard deviation of the stamps about even ones, in s.
    pub jitter_sd: f64,
    /// Relative error of the clock's rate, its standard deviation over the pushes.
    pub clock_drift_sd: f64,
    /// Gaps in a second.
    pub gap_rate: f64,
    /// Mean length of a gap, in s.
    pub gap_length: f64,
    /// Share of samples that are written again.
    pub duplicate_share: f64,
    /// Share of samples that are written after the next ones.
    pub late_share: f64,
}

impl Default for Sensor {
    fn default() -> Self {
        Self {
            rate: 100.0,
            noise_sd: 0.0,
            yaw_noise_sd: 0.0,
            outlier_share: 0.0,
            outlier_ratio: 5.0,
            jitter_sd: 0.0,
            clock_drift_sd: 0.0,
            gap_rate: 0.0,
            gap_length: 0.05,
            duplicate_share: 0.0,
            late_share: 0.0,
        }
    }
}

impl Default for Sensors {
    fn default() -> Self {
        let clock = Sensor { jitter_sd: 2e-4, clock_drift_sd: 1e-5, ..Sensor::default() };
        Self {
            robot: Sensor { rate: 86.0, noise_sd: 3e-5, ..clock },
            object: Sensor { noise_sd: 6e-5, yaw_noise_sd: 1e-3, ..clock },
            force: Sensor { noise_sd: 0.03, yaw_noise_sd: 3e-4, ..clock },
            flips: Flips::default(),
        }
    }
}

impl Sensors {
    /// Sensors without noise, on perfect clocks.
    #[must_use]
    pub fn ideal() -> Self {
        let sensor = Sensor::default();
        Self {
            robot: Sensor { rate: 86.0, ..sensor },
            object: sensor,
            force: sensor,
            flips: Flips::default(),
        }
    }

    /// The default with gaps, outliers, duplicates and late samples, as real logs have them.
    #[must_use]
    pub fn dirty() -> Self {
        let dirty = |sensor: Sensor| Sensor {
            outlier_share: 0.02,
            gap_rate: 0.3,
            duplicate_share: 0.01,
            late_share: 0.01,
            jitter_sd: 1e-3,
            ..sensor
        };
        let Self { robot, object, force, flips } = Self::default();
        Self { robot: dirty(robot), object: dirty(object), force: dirty(force), flips }
    }
}

impl Sensors {
    /// Refuses numbers that no sensor has.
    ///
    /// # Errors
    /// `OutOfRange` with the first of them.
    pub(crate) fn check(&self) -> Result<(), PlantError> {
        for (name, sensor, unit, turn) in [
            ("robot", &self.robot, "m", "rad"),
            ("object", &self.object, "m", "rad"),
            ("force", &self.force, "N", "N·m"),
        ] {
            for (key, value, unit, high) in [
                ("rate", sensor.rate, "Hz", 1e5),
                ("noise_sd", sensor.noise_sd, unit, 100.0),
                ("yaw_noise_sd", sensor.yaw_noise_sd, turn, 10.0),
                ("outlier_share", sensor.outlier_share, "", 1.0),
                ("outlier_ratio", sensor.outlier_ratio, "", 1e4),
                ("jitter_sd", sensor.jitter_sd, "s", 1.0),
                ("clock_drift_sd", sensor.clock_drift_sd, "", 0.1),
                ("gap_rate", sensor.gap_rate, "1/s", 1e3),
                ("gap_length", sensor.gap_length, "s", 100.0),
                ("duplicate_share", sensor.duplicate_share, "", 1.0),
                ("late_share", sensor.late_share, "", 1.0),
            ] {
                check_range(&format!("sensors.{name}.{key}"), value, unit, (0.0, high))?;
            }
        }
        for (key, value, unit, high) in [
            ("rate", self.flips.rate, "1/s", 1e3),
            ("length", self.flips.length, "s", 100.0),
            ("turn[0]", self.flips.turn[0], "rad", self.flips.turn[1]),
            ("turn[1]", self.flips.turn[1], "rad", std::f64::consts::PI),
        ] {
            check_range(&format!("sensors.flips.{key}"), value, unit, (0.0, high))?;
        }
        // A set without poses is no recording of pushes.
        for (name, rate) in [("robot", self.robot.rate), ("object", self.object.rate)] {
            check_range(&format!("sensors.{name}.rate"), rate, "Hz", (1.0, 1e5))?;
        }
        Ok(())
    }
}

/// The streams of one push, in the order in which they are written.
pub(crate) struct Streams {
    pub(crate) robot: PoseStream,
    pub(crate) object: PoseStream,
    pub(crate) wrench: Option<WrenchStream>,
}

impl Sensors {
    /// Reads a push; stamps count from its beginning.
    pub(crate) fn read(
        &self,
        plant: &Plant,
        trajectory: &Trajectory,
        variation: &Variation,
        (seed, push): (u64, usize),
    ) -> Streams {
        let truth = plant.truth();
        let stream = |number: u64| Random::new(seed, Purpose::Sensors, 4 * push as u64 + number);
        let duration = trajectory.duration();
        let mut random = stream(0);
        let robot = self.robot.samples(&mut random, duration, 0.0, |time, _| {
            let tip = trajectory.tip_at(time);
            [tip.x, tip.y, 0.0]
        });
        let shift = Vector2::from(truth.markers.shift);
        let beside = Vector2::from(truth.cameras.shift);
        let latency = truth.clocks.object_latency;
        let flips = self.flips.drawn(&mut stream(3), duration);
        let flip = |time: f64| {
            let now = flips.iter().find(|(from, to, _)| (*from..*to).contains(&time));
            now.map_or(0.0, |(_, _, turn)| *turn)
        };
        let mut random = stream(1);
        let object = self.object.samples(&mut random, duration, latency, |time, _| {
            let pose = trajectory.pose_at(time);
            let origin = pose.position + rotation(pose.angle) * shift + beside;
            [origin.x, origin.y, pose.angle + truth.markers.yaw + flip(time)]
        });
        let mut sensor = truth.force_sensor;
        for (bias, extra) in sensor.loaded_bias.iter_mut().zip(variation.force_bias) {
            *bias += extra;
        }
        let latency = truth.clocks.force_latency;
        let zero_lost = variation.zero_kept * duration;
        let mut random = stream(2);
        let force = self.force.samples(&mut random, duration, latency, |time, before| {
            // The object pushes back at the tip.
            let mut reading = sensor.reading(&-trajectory.mean_force(before, time));
            if variation.zero_kept < 1.0 && time >= zero_lost {
                reading += Vector2::from(sensor.lost_zero);
            }
            [reading.x, reading.y, trajectory.mean_torque(before, time)]
        });
        Streams {
            robot: poses(&robot),
            object: poses(&object),
            wrench: (self.force.rate > 0.0).then(|| forces(&force)),
        }
    }
}

/// A stamp in s since the push began, and three readings.
type Sample = (f64, [f64; 3]);

impl Sensor {
    /// Samples of a signal, which is asked for a time and the time of the sample before.
    fn samples(
        &self,
        random: &mut Random,
        duration: f64,
        latency: f64,
        signal: impl Fn(f64, f64) -> [f64; 3],
    ) -> Vec<Sample> {
        if self.rate == 0.0 {
            return Vec::new();
        }
        let period = 1.0 / self.rate;
        let first = random.uniform(0.0, period);
        let drift = random.normal(self.clock_drift_sd);
        let n = ((duration - first) / period).floor().max(0.0) as usize + 1;
        let mut samples = Vec::with_capacity(n);
        let mut gap_end = f64::NEG_INFINITY;
        for k in 0..n {
            let time = first + k as f64 * period;
            let noise_ratio =
                if random.happens(self.outlier_share) { self.outlier_ratio } else { 1.0 };
            let mut values = signal(time, time - period);
            for (value, sd) in
                values.iter_mut().zip([self.noise_sd, self.noise_sd, self.yaw_noise_sd])
            {
                *value += random.normal(sd * noise_ratio);
            }
            let jitter = random.normal(self.jitter_sd).clamp(-0.4 * period, 0.4 * period);
            if random.happens(self.gap_rate * period) {
                gap_end = time - self.gap_length * libm::log(1.0 - random.uniform(0.0, 1.0));
            }
            let is_late = random.happens(self.late_share);
            let is_double = random.happens(self.duplicate_share);
            if time < gap_end {
                continue;
            }
            let sample = (time * (1.0 + drift) + latency + jitter, values);
            let place = samples.len() - usize::from(is_late && !samples.is_empty());
            samples.insert(place, sample);
            if is_double {
                samples.push(sample);
            }
        }
        samples
    }
}

fn poses(samples: &[Sample]) -> PoseStream {
    let column = |k: usize| samples.iter().map(|(_, values)| values[k]).collect();
    PoseStream {
        t: samples.iter().map(|(stamp, _)| *stamp).collect(),
        x: column(0),
        y: column(1),
        theta: column(2),
        ..PoseStream::default()
    }
}

fn forces(samples: &[Sample]) -> WrenchStream {
    let column = |k: usize| samples.iter().map(|(_, values)| values[k]).collect();
    WrenchStream {
        t: samples.iter().map(|(stamp, _)| *stamp).collect(),
        fx: column(0),
        fy: column(1),
        tz: column(2),
        ..WrenchStream::default()
    }
}

#[cfg(test)]
mod tests {
    use super::{Flips, Sample, Sensor};
    use crate::random::{Purpose, Random};

    fn samples(sensor: Sensor) -> Vec<Sample> {
        let mut random = Random::new(7, Purpose::Sensors, 0);
        sensor.samples(&mut random, 20.0, 0.0, |time, before| [time, time - before, 1.0])
    }

    #[test]
    fn a_perfect_sensor_reads_the_signal_at_its_rate() {
        let samples = samples(Sensor { rate: 86.0, ..Sensor::default() });
        assert!((samples.len() as f64 - 20.0 * 86.0).abs() <= 1.0);
        for (stamp, [time, step, one]) in samples {
            assert_eq!((stamp, one), (time, 1.0));
            assert!((step - 1.0 / 86.0).abs() < 1e-12);
        }
    }

    #[test]
    fn every_fault_shows_in_the_stream() {
        let n = samples(Sensor::default()).len();
        let gaps = samples(Sensor { gap_rate: 0.5, ..Sensor::default() });
        assert!(gaps.len() < n - 5 && gaps.len() > n / 2);
        let doubles = samples(Sensor { duplicate_share: 0.05, ..Sensor::default() });
        assert!(doubles.windows(2).filter(|pair| pair[0] == pair[1]).count() > 50);
        let late = samples(Sensor { late_share: 0.05, ..Sensor::default() });
        assert_eq!(late.len(), n);
        assert!(late.windows(2).filter(|pair| pair[0].0 > pair[1].0).count() > 50);
        let jitter = samples(Sensor { jitter_sd: 1e-3, ..Sensor::default() });
        assert!(jitter.iter().any(|(stamp, values)| (stamp - values[0]).abs() > 1e-3));
    }

    #[test]
    fn flips_are_as_frequent_as_stated_and_of_the_turns_allowed() {
        let drawn = |flips: Flips| flips.drawn(&mut Random::new(7, Purpose::Sensors, 3), 1e4);
        assert!(drawn(Flips::default()).is_empty());
        let flips = drawn(Flips { rate: 0.1, ..Flips::default() });
        assert!((900..1040).contains(&flips.len()), "{}", flips.len());
        for (from, to, turn) in flips {
            assert!(from < to && (60.0..=130.0).contains(&turn.abs().to_degrees()));
        }
    }

    #[test]
    fn noise_is_as_wide_as_stated_and_outliers_are_wider() {
        let sd = |sensor: Sensor| {
            let samples = samples(sensor);
            let squares = samples.iter().map(|(_, v)| (v[1] - 0.01).powi(2)).sum::<f64>();
            (squares / samples.len() as f64).sqrt()
        };
        let plain = sd(Sensor { noise_sd: 1e-4, ..Sensor::default() });
        assert!((plain / 1e-4 - 1.0).abs() < 0.1, "{plain}");
        let wide = Sensor { noise_sd: 1e-4, outlier_share: 0.1, ..Sensor::default() };
        let expected = 1e-4 * (0.9_f64 + 0.1 * 25.0).sqrt();
        assert!((sd(wide) / expected - 1.0).abs() < 0.15);
    }
}
