//! How an object stands on an uneven table.

use nalgebra::{Matrix3, Vector2, Vector3};

const MAX_ITERATIONS: usize = 60;
const MAX_HALVINGS: usize = 30;
/// What may be left over of weight and moments, as a share of the weight.
const GOAL: f64 = 1e-10;
/// Depth over which a pad comes to bear, over that to which the object sinks on a flat table.
const ONSET: f64 = 0.05;

/// A rigid bottom of pads on elastic ground.
///
/// A pad that is pressed in by d bears k·(d + √(d² + onset²))/2: all of k·d where it is deep, nothing
/// where it is off the table, never less than nothing.
#[derive(Clone, Debug)]
pub(crate) struct Bottom {
    /// Places of the pads over the radius, from the center of mass, in the body's axes.
    pub(crate) places: Vec<Vector2<f64>>,
    /// Share of each pad in the bottom's stiffness, 1 in all.
    pub(crate) shares: Vec<f64>,
    /// Depth to which the object sinks on a flat table, in m.
    pub(crate) depth: f64,
}

/// How deep and how tilted a bottom stands, and what its pads bear.
#[derive(Clone, Debug)]
pub(crate) struct Stand {
    /// Depth at the center of mass, and its rise to the radius along x and y, in m.
    posture: Vector3<f64>,
    /// Share of the weight on each pad, 1 in all.
    pub(crate) loads: Vec<f64>,
}

impl Bottom {
    /// The stand in which the pads bear the weight, with its center under a point.
    ///
    /// The energy is convex in depth and tilt, so there is one such stand at most, whatever it is
    /// looked for from.
    ///
    /// - `bumps`: height of the table under each pad above the bottom's, in m; - `center`: in units
    ///   of the radius, from the center of mass; - `from`: a stand to begin with, best the last one.
    ///
    /// # Errors
    /// If there is none: the point is not above the pads.
    pub(crate) fn stand(
        &self,
        bumps: &[f64],
        center: &Vector2<f64>,
        from: Option<&Stand>,
    ) -> Result<Stand, &'static str> {
        let goal = Vector3::new(1.0, center.x, center.y);
        let start = || {
            let lowest = bumps.iter().copied().fold(f64::INFINITY, f64::min);
            Vector3::new(self.depth - lowest, 0.0, 0.0)
        };
        let mut posture = from.map_or_else(start, |stand| stand.posture);
        let (mut borne, mut slope) = self.borne(bumps, &posture, &mut |_| {});
        for _ in 0..MAX_ITERATIONS {
            let left_over = borne - goal;
            if left_over.amax() <= GOAL {
                let mut loads = Vec::with_capacity(bumps.len());
                self.borne(bumps, &posture, &mut |load| loads.push(load));
                return Ok(Stand { posture, loads });
            }
            let step = slope.try_inverse().ok_or("the object tips over")? * left_over;
            let mut share = 1.0;
            let better = (0..MAX_HALVINGS).find_map(|_| {
                let next = posture - share * step;
                let (borne, slope) = self.borne(bumps, &next, &mut |_| {});
                let is_better = (borne - goal).norm() < (1.0 - 1e-4 * share) * left_over.norm();
                share *= 0.5;
                is_better.then_some((next, borne, slope))
            });
            (posture, borne, slope) = better.ok_or("the object tips over")?;
        }
        Err("the object tips over")
    }

    /// Weight and moments that the pads bear, over the weight, and their derivative by the posture;
    /// `each` is told what each pad bears.
    fn borne(
        &self,
        bumps: &[f64],
        posture: &Vector3<f64>,
        each: &mut impl FnMut(f64),
    ) -> (Vector3<f64>, Matrix3<f64>) {
        let floor = (ONSET * self.depth) * (ONSET * self.depth);
        let (mut sum, mut slope) = (Vector3::zeros(), [0.0; 6]);
        for ((place, share), bump) in self.places.iter().zip(&self.shares).zip(bumps) {
            let depth = posture.x + posture.y * place.x + posture.z * place.y + bump;
            let root = (depth * depth + floor).sqrt();
            // What is lost where both terms nearly cancel is written without a difference.
            let pressed = if depth > 0.0 { depth + root } else { floor / (root - depth) };
            let load = 0.5 * share / self.depth * pressed;
            let rise = load / root;
            each(load);
            sum += load * Vector3::new(1.0, place.x, place.y);
            let (x, y) = (rise * place.x, rise * place.y);
            let terms = [rise, x, y, x * place.x, x * place.y, y * place.y];
            slope.iter_mut().zip(terms).for_each(|(total, term)| *total += term);
        }
        let [one, x, y, xx, xy, yy] = slope;
        (sum, Matrix3::new(one, x, y, x, xx, xy, y, xy, yy))
    }
}

#[cfg(test)]
mod tests {
    use super::{Bottom, Stand};
    use nalgebra::Vector2;
    use proptest::prelude::{ProptestConfig, prop_assert, proptest};

    /// 8 × 8 pads from −1 to 1.
    fn bottom() -> Bottom {
        let place = |k: usize| f64::from(k as u32) / 3.5 - 1.0;
        let places = (0..64).map(|k| Vector2::new(place(k % 8), place(k / 8))).collect();
        Bottom { places, shares: vec![1.0 / 64.0; 64], depth: 1e-5 }
    }

    fn bears(bottom: &Bottom, stand: &Stand, center: &Vector2<f64>) {
        assert!(stand.loads.iter().all(|load| *load >= 0.0));
        assert!((stand.loads.iter().sum::<f64>() - 1.0).abs() < 1e-9);
        let moments = bottom.places.iter().zip(&stand.loads).map(|(place, load)| *load * place);
        assert!((moments.sum::<Vector2<f64>>() - center).norm() < 1e-9);
    }

    #[test]
    fn a_flat_table_bears_evenly_and_leans_with_the_center() {
        let bottom = bottom();
        let even = bottom.stand(&[0.0; 64], &Vector2::zeros(), None).unwrap();
        assert!(even.loads.iter().all(|load| (load * 64.0 - 1.0).abs() < 1e-9));
        let center = Vector2::new(0.1, 0.0);
        let leaning = bottom.stand(&[0.0; 64], &center, None).unwrap();
        bears(&bottom, &leaning, &center);
        assert!(leaning.loads[7] > 1.1 / 64.0 && leaning.loads[0] < 0.9 / 64.0);
    }

    #[test]
    fn three_high_pads_bear_by_statics() {
        let bottom = bottom();
        let mut bumps = [0.0; 64];
        // At (−1, −1), (1, −1) and (−1, 1); on a table as hard as this, nothing else bears.
        for k in [0, 7, 56] {
            bumps[k] = 0.01;
        }
        let center = Vector2::new(-0.4, -0.6);
        let stand = bottom.stand(&bumps, &center, None).unwrap();
        bears(&bottom, &stand, &center);
        for (k, load) in [(0, 0.5), (7, 0.3), (56, 0.2)] {
            assert!((stand.loads[k] - load).abs() < 1e-3, "{k}: {}", stand.loads[k]);
        }
    }

    #[test]
    fn a_center_beside_the_pads_tips_the_object_over() {
        let beside = Vector2::new(1.01, 0.0);
        assert_eq!(bottom().stand(&[0.0; 64], &beside, None).unwrap_err(), "the object tips over");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn weight_and_moments_are_borne_from_any_start_and_alike_in_a_mirror(
            bumps in proptest::collection::vec(-1e-4..1e-4f64, 64), x in -0.5..0.5f64, y in -0.5..0.5f64,
        ) {
            let (bottom, center) = (bottom(), Vector2::new(x, y));
            let stand = bottom.stand(&bumps, &center, None).unwrap();
            bears(&bottom, &stand, &center);
            let flat = bottom.stand(&[0.0; 64], &Vector2::zeros(), None).unwrap();
            let again = bottom.stand(&bumps, &center, Some(&flat)).unwrap();
            let mirrored: Vec<f64> = (0..64).map(|k| bumps[8 * (7 - k / 8) + k % 8]).collect();
            let mirror = bottom.stand(&mirrored, &Vector2::new(x, -y), None).unwrap();
            for k in 0..64 {
                prop_assert!((stand.loads[k] - again.loads[k]).abs() < 1e-8);
                prop_assert!((stand.loads[k] - mirror.loads[8 * (7 - k / 8) + k % 8]).abs() < 1e-8);
            }
        }
    }
}
