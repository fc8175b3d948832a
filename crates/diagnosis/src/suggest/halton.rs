//! Points that fill a cube evenly.

const BASES: [u32; 6] = [2, 3, 5, 7, 11, 13];

/// Halton's sequence, shifted modulo 1: coordinates in [0, 1).
///
/// # Source
/// Halton (1960); Cranley & Patterson (1976) for the shift.
pub(super) fn point(index: u32, shift: &[f64; 6]) -> [f64; 6] {
    std::array::from_fn(|k| (radical_inverse(index + 1, BASES[k]) + shift[k]).fract())
}

/// The digits of a number in a base, mirrored at the point.
fn radical_inverse(mut index: u32, base: u32) -> f64 {
    let (mut value, mut digit) = (0.0, 1.0);
    while index > 0 {
        digit /= f64::from(base);
        value += digit * f64::from(index % base);
        index /= base;
    }
    value
}

#[cfg(test)]
mod tests {
    use super::{point, radical_inverse};

    #[test]
    fn digits_are_mirrored() {
        assert_eq!([1, 2, 3, 6].map(|k| radical_inverse(k, 2)), [0.5, 0.25, 0.75, 0.375]);
        assert!((radical_inverse(5, 3) - (2.0 / 3.0 + 1.0 / 9.0)).abs() < 1e-15);
    }

    #[test]
    fn every_eighth_of_each_coordinate_is_met_about_equally_often() {
        let points: Vec<_> = (0..800).map(|k| point(k, &[0.3; 6])).collect();
        for k in 0..6 {
            for eighth in 0..8 {
                let is_in = |x: &&[f64; 6]| (8.0 * x[k]) as usize == eighth;
                let n = points.iter().filter(is_in).count();
                assert!((90..=110).contains(&n), "coordinate {k}: {n}");
            }
        }
    }
}
