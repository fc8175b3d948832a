//! The distances of points to their neighbors in space.

/// Points in an order in which neighbors are found fast: halves on either side of a median, and so on.
pub(super) struct Neighbors {
    points: Vec<[f64; 3]>,
    /// The axis along which the points are halved at an index.
    axes: Vec<u8>,
}

/// Fewer points are looked at one by one.
const LEAF: usize = 12;
/// Most neighbors that are asked for.
const MOST: usize = 16;

impl Neighbors {
    /// Sorts points; O(N log N).
    pub(super) fn of(mut points: Vec<[f64; 3]>) -> Self {
        let mut axes = vec![0; points.len()];
        halve(&mut points, &mut axes);
        Self { points, axes }
    }

    pub(super) fn len(&self) -> usize {
        self.points.len()
    }

    /// The distance of a place to its neighbor of a rank, from 1 to 16; a place that is a point is the
    /// first itself. Infinite beyond the number of points.
    pub(super) fn distance(&self, at: [f64; 3], rank: usize) -> f64 {
        let mut nearest = [f64::INFINITY; MOST];
        let nearest = &mut nearest[..rank.min(MOST)];
        self.search(0..self.points.len(), at, nearest);
        nearest[nearest.len() - 1].sqrt()
    }

    fn search(&self, range: std::ops::Range<usize>, at: [f64; 3], nearest: &mut [f64]) {
        if range.len() <= LEAF {
            self.points[range].iter().for_each(|point| insert(nearest, square(point, &at)));
            return;
        }
        let middle = range.start + range.len() / 2;
        let point = &self.points[middle];
        let axis = usize::from(self.axes[middle]);
        let off = at[axis] - point[axis];
        let (below, above) = (range.start..middle, middle + 1..range.end);
        let (near, far) = if off < 0.0 { (below, above) } else { (above, below) };
        self.search(near, at, nearest);
        insert(nearest, square(point, &at));
        if off * off < nearest[nearest.len() - 1] {
            self.search(far, at, nearest);
        }
    }
}

/// Puts the median along the widest axis in the middle, the smaller before it, and so each half.
fn halve(points: &mut [[f64; 3]], axes: &mut [u8]) {
    if points.len() <= LEAF {
        return;
    }
    let width = |axis: usize| {
        let values = points.iter().map(|point| point[axis]);
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
        high - low
    };
    let widths = [width(0), width(1), width(2)];
    let axis = (1..3).fold(0, |best, axis| if widths[axis] > widths[best] { axis } else { best });
    let middle = points.len() / 2;
    points.select_nth_unstable_by(middle, |a, b| a[axis].total_cmp(&b[axis]));
    axes[middle] = axis as u8;
    let (below, above) = points.split_at_mut(middle);
    let (axes_below, axes_above) = axes.split_at_mut(middle);
    let (above, axes_above) = (&mut above[1..], &mut axes_above[1..]);
    rayon::join(|| halve(below, axes_below), || halve(above, axes_above));
}

fn square(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    let [x, y, z] = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    x * x + y * y + z * z
}

/// Keeps the smallest, in order.
fn insert(nearest: &mut [f64], value: f64) {
    let last = nearest.len() - 1;
    if value >= nearest[last] {
        return;
    }
    let place = nearest.partition_point(|known| *known <= value);
    nearest.copy_within(place..last, place + 1);
    nearest[place] = value;
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::{Neighbors, square};

    #[test]
    fn neighbors_are_those_found_by_looking_at_all() {
        let mut random = ChaCha8Rng::seed_from_u64(7);
        let mut place = |_| [random.random(), 0.1 * random.random::<f64>(), random.random()];
        let points: Vec<[f64; 3]> = (0..700).map(&mut place).collect();
        let tree = Neighbors::of(points.clone());
        for k in 0..100 {
            let at = if k < 50 { points[k] } else { place(k) };
            let mut all: Vec<f64> = points.iter().map(|point| square(point, &at)).collect();
            all.sort_by(f64::total_cmp);
            for rank in [1, 4, 11] {
                assert_eq!(tree.distance(at, rank), all[rank - 1].sqrt(), "{k} {rank}");
            }
        }
        assert_eq!(Neighbors::of(points[..3].to_vec()).distance([0.0; 3], 4), f64::INFINITY);
    }
}
