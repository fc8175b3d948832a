//! Histograms of where in its inputs a table has rows.

use std::f64::consts::{FRAC_PI_2, PI};

use planar::wrap_angle;
use serde::Serialize;

use crate::table::step::{Phase, StepRow};

/// Counts of values in equal bins.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Histogram {
    /// What is counted.
    pub quantity: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Lower end of the first bin.
    pub low: f64,
    /// Upper end of the last bin.
    pub high: f64,
    /// Values in each bin.
    pub counts: Vec<u64>,
    /// Values below the first bin.
    pub below: u64,
    /// Values above the last bin.
    pub above: u64,
}

impl Histogram {
    fn new(quantity: &'static str, unit: &'static str, low: f64, high: f64, bins: usize) -> Self {
        Self { quantity, unit, low, high, counts: vec![0; bins], below: 0, above: 0 }
    }

    fn add(&mut self, value: f64) {
        let bins = self.counts.len();
        let place = (value - self.low) / (self.high - self.low) * bins as f64;
        if place < 0.0 {
            self.below += 1;
        } else if value > self.high {
            self.above += 1;
        } else {
            self.counts[(place as usize).min(bins - 1)] += 1;
        }
    }

    /// One character a bin, from blank for none to a full block for the most.
    #[must_use]
    pub fn bars(&self) -> String {
        const BLOCKS: [char; 9] = [' ', '▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
        let most = self.counts.iter().copied().max().unwrap_or(0).max(1);
        self.counts.iter().map(|&count| BLOCKS[(count * 8).div_ceil(most) as usize]).collect()
    }
}

/// Where the contact rows of a table lie.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Coverage {
    /// Position along the edge.
    pub p: Histogram,
    /// Angle from the inward normal to the pusher's velocity.
    pub beta: Histogram,
    /// Speed of the pusher.
    pub speed: Histogram,
    /// Yaw of the object.
    pub orientation: Histogram,
    /// Rows on each edge.
    pub edges: Vec<u64>,
}

impl Default for Coverage {
    fn default() -> Self {
        Self {
            p: Histogram::new("p", "1", 0.0, 1.0, 20),
            beta: Histogram::new("beta", "rad", -FRAC_PI_2, FRAC_PI_2, 18),
            speed: Histogram::new("speed", "m/s", 0.0, 0.5, 20),
            orientation: Histogram::new("orientation", "rad", -PI, PI, 18),
            edges: Vec::new(),
        }
    }
}

impl Coverage {
    /// Counts one row; rows after the contact do not count.
    pub fn add(&mut self, row: &StepRow) {
        if row.phase != Phase::Contact {
            return;
        }
        self.p.add(row.p);
        self.beta.add(row.beta);
        self.speed.add(row.speed);
        self.orientation.add(wrap_angle(row.object_pose.angle));
        let edge = row.edge as usize;
        if self.edges.len() <= edge {
            self.edges.resize(edge + 1, 0);
        }
        self.edges[edge] += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::Histogram;

    #[test]
    fn every_value_is_counted_once() {
        let mut histogram = Histogram::new("x", "1", 0.0, 1.0, 4);
        for value in [-0.1, 0.0, 0.24, 0.25, 0.99, 1.0, 1.01] {
            histogram.add(value);
        }
        assert_eq!(histogram.counts, [2, 1, 0, 2]);
        assert_eq!((histogram.below, histogram.above), (1, 1));
        assert_eq!(histogram.bars(), "█▄ █");
    }
}
