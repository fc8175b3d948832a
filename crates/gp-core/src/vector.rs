//! Loops over slices in the widest vector registers of the machine, with the same bits on each.
//!
//! No operation is fused, so a value does not depend on the registers that computed it.

use pulp::{Arch, Simd, WithSimd};

/// Runs a loop compiled for the machine's vector registers.
///
/// Only what is inlined into `body` is: write plain loops over functions marked `inline(always)`,
/// since a closure within is often left outside.
#[inline(always)]
pub fn vectorized<R>(body: impl FnOnce() -> R) -> R {
    Arch::new().dispatch(Body(body))
}

struct Body<F>(F);

impl<R, F: FnOnce() -> R> WithSimd for Body<F> {
    type Output = R;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _registers: S) -> R {
        (self.0)()
    }
}

/// eˣ within 2 units in the last place; 0 where it is below the smallest normal number.
///
/// x = k ln 2 + r with |r| ≤ ½ ln 2, and eʳ by its Taylor polynomial of degree 15.
#[inline(always)]
pub fn exp(x: f64) -> f64 {
    let bounded = x.clamp(LOWEST, HIGHEST);
    let shifted = bounded * std::f64::consts::LOG2_E + ROUNDER;
    let multiple = shifted - ROUNDER;
    let rest = (bounded - multiple * LN_2_HIGH) - multiple * LN_2_LOW;
    let polynomial = polynomial(&TAYLOR, rest);
    // The low bits of `shifted` hold the multiple; from 1023 on it would not fit the exponent.
    let half = f64::from_bits(shifted.to_bits().wrapping_add(1022) << 52);
    let value = polynomial * half * 2.0;
    let value = if x < LOWEST { 0.0 } else { value };
    if x > HIGHEST { f64::INFINITY } else { value }
}

/// (sin x, cos x) within 2 units in the last place of the larger one, for |x| ≤ 10⁵; beyond that
/// the library's own.
///
/// x = k π/2 + r with |r| ≤ π/4, and both by their Taylor polynomials.
#[inline(always)]
pub fn sin_cos(x: f64) -> (f64, f64) {
    let shifted = x * std::f64::consts::FRAC_2_PI + ROUNDER;
    let multiple = shifted - ROUNDER;
    let rest = ((x - multiple * HALF_PI_HIGH) - multiple * HALF_PI_MIDDLE) - multiple * HALF_PI_LOW;
    let square = rest * rest;
    let (sine_part, cosine_part) = (polynomial(&SINE, square), polynomial(&COSINE, square));
    let sine = rest + rest * square * sine_part;
    let cosine = 1.0 - 0.5 * square + square * square * cosine_part;
    let quarter = shifted.to_bits();
    let (first, second) = if quarter & 1 == 0 { (sine, cosine) } else { (cosine, sine) };
    let sine_sign = (quarter & 2) << 62;
    let cosine_sign = (quarter.wrapping_add(1) & 2) << 62;
    (f64::from_bits(first.to_bits() ^ sine_sign), f64::from_bits(second.to_bits() ^ cosine_sign))
}

/// A polynomial, with its coefficients in blocks of four, the block of the highest powers first.
///
/// Terms of a block do not wait for each other, as they would in Horner's scheme.
#[inline(always)]
fn polynomial<const N: usize>(blocks: &[[f64; 4]; N], x: f64) -> f64 {
    let square = x * x;
    let fourth = square * square;
    let mut sum = cubic(&blocks[0], x, square);
    for block in &blocks[1..] {
        sum = sum * fourth + cubic(block, x, square);
    }
    sum
}

#[inline(always)]
fn cubic(block: &[f64; 4], x: f64, square: f64) -> f64 {
    (block[3] * x + block[2]) * square + (block[1] * x + block[0])
}

/// The largest argument of `sin_cos` that keeps its digits.
pub const SIN_COS_LIMIT: f64 = 1e5;

/// Σᵢ aᵢ bᵢ, in eight lanes and always in the same order.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    vectorized(|| dot_in_lanes(a, b))
}

#[inline(always)]
fn dot_in_lanes(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; LANES];
    let (a_chunks, b_chunks) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let mut rest = 0.0;
    for (a, b) in a_chunks.remainder().iter().zip(b_chunks.remainder()) {
        rest += a * b;
    }
    for (a, b) in a_chunks.zip(b_chunks) {
        for lane in 0..LANES {
            lanes[lane] += a[lane] * b[lane];
        }
    }
    lanes.iter().sum::<f64>() + rest
}

/// Σᵢ wᵢ uᵢ and Σᵢ wᵢ uᵢ² with uᵢ = (xᵢ − center)·scale; in eight lanes and always in the same order.
pub fn weighted_sums(x: &[f64], weights: &[f64], center: f64, scale: f64) -> (f64, f64) {
    vectorized(|| weighted_in_lanes(x, weights, center, scale))
}

#[inline(always)]
fn weighted_in_lanes(x: &[f64], weights: &[f64], center: f64, scale: f64) -> (f64, f64) {
    let (mut first, mut second) = ([0.0; LANES], [0.0; LANES]);
    let (x_chunks, w_chunks) = (x.chunks_exact(LANES), weights.chunks_exact(LANES));
    let (mut first_rest, mut second_rest) = (0.0, 0.0);
    for (x, w) in x_chunks.remainder().iter().zip(w_chunks.remainder()) {
        let scaled = (x - center) * scale;
        first_rest += w * scaled;
        second_rest += w * scaled * scaled;
    }
    for (x, w) in x_chunks.zip(w_chunks) {
        for lane in 0..LANES {
            let scaled = (x[lane] - center) * scale;
            let weighted = w[lane] * scaled;
            first[lane] += weighted;
            second[lane] += weighted * scaled;
        }
    }
    (first.iter().sum::<f64>() + first_rest, second.iter().sum::<f64>() + second_rest)
}

/// sums ← sums + factor·a.
pub fn add_multiple(sums: &mut [f64], factor: f64, a: &[f64]) {
    vectorized(|| {
        for (sum, a) in sums.iter_mut().zip(a) {
            *sum += factor * a;
        }
    });
}

/// sums ← sums + sign·a².
pub fn add_square(sums: &mut [f64], sign: f64, a: &[f64]) {
    vectorized(|| {
        for (sum, a) in sums.iter_mut().zip(a) {
            *sum += sign * (a * a);
        }
    });
}

const LANES: usize = 8;

/// Adding it rounds a number below 2⁵¹ to an integer that stands in the low bits.
const ROUNDER: f64 = 6_755_399_441_055_744.0;
/// ln of the smallest normal number, and ln of the largest.
const LOWEST: f64 = -708.396_418_532_264_1;
const HIGHEST: f64 = 709.782_712_893_384;
/// ln 2 in two parts, the first short enough that its products with k are exact.
const LN_2_HIGH: f64 = 6.931_471_803_691_238e-1;
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;
/// π/2 in three parts, the first two of 33 bits.
const HALF_PI_HIGH: f64 = 1.570_796_326_734_125_6;
const HALF_PI_MIDDLE: f64 = 6.077_100_506_303_966e-11;
const HALF_PI_LOW: f64 = 2.022_266_248_795_950_6e-21;

/// 1/n! for n = 12 to 15, 8 to 11, 4 to 7, and 0 to 3.
const TAYLOR: [[f64; 4]; 4] = [
    [1.0 / 479_001_600.0, 1.0 / 6_227_020_800.0, 1.0 / 87_178_291_200.0, 1.0 / 1_307_674_368_000.0],
    [1.0 / 40_320.0, 1.0 / 362_880.0, 1.0 / 3_628_800.0, 1.0 / 39_916_800.0],
    [1.0 / 24.0, 1.0 / 120.0, 1.0 / 720.0, 1.0 / 5_040.0],
    [1.0, 1.0, 1.0 / 2.0, 1.0 / 6.0],
];
/// (sin r − r)/r³ and (cos r − 1 + r²/2)/r⁴ as polynomials of r².
const SINE: [[f64; 4]; 2] = [
    [
        -1.0 / 39_916_800.0,
        1.0 / 6_227_020_800.0,
        -1.0 / 1_307_674_368_000.0,
        1.0 / 355_687_428_096_000.0,
    ],
    [-1.0 / 6.0, 1.0 / 120.0, -1.0 / 5_040.0, 1.0 / 362_880.0],
];
const COSINE: [[f64; 4]; 2] = [
    [
        1.0 / 479_001_600.0,
        -1.0 / 87_178_291_200.0,
        1.0 / 20_922_789_888_000.0,
        -1.0 / 6_402_373_705_728_000.0,
    ],
    [1.0 / 24.0, -1.0 / 720.0, 1.0 / 40_320.0, -1.0 / 3_628_800.0],
];

#[cfg(test)]
mod tests {
    use super::{dot, exp, sin_cos, vectorized};

    #[test]
    fn the_exponential_is_right_to_the_last_digits() {
        for i in -69_900..70_000 {
            let x = 0.010_123 * f64::from(i);
            let (found, expected) = (exp(x), x.exp());
            assert!((found - expected).abs() <= 2.5 * f64::EPSILON * expected, "{x}: {found}");
        }
        assert_eq!((exp(0.0), exp(-0.0)), (1.0, 1.0));
        assert_eq!((exp(-800.0), exp(f64::NEG_INFINITY)), (0.0, 0.0));
        assert_eq!((exp(710.0), exp(f64::INFINITY)), (f64::INFINITY, f64::INFINITY));
        assert!(exp(f64::NAN).is_nan());
        assert!((exp(709.7) / 709.7_f64.exp() - 1.0).abs() < 1e-15);
    }

    #[test]
    fn sine_and_cosine_are_right_to_the_last_digits() {
        for i in -100_000..100_000 {
            let x = 0.987_654_3 * f64::from(i) * if i % 3 == 0 { 1.0 } else { 1e-3 };
            let (sine, cosine) = sin_cos(x);
            assert!((sine - x.sin()).abs() <= 2.0 * f64::EPSILON, "{x}: {sine} {}", x.sin());
            assert!((cosine - x.cos()).abs() <= 2.0 * f64::EPSILON, "{x}: {cosine} {}", x.cos());
        }
    }

    #[test]
    fn wide_registers_change_no_bit() {
        let x: Vec<f64> = (0..1003).map(|i| (f64::from(i) * 0.37).sin() * 30.0).collect();
        let mut wide = x.clone();
        vectorized(|| wide.iter_mut().for_each(|value| *value = exp(*value)));
        assert!(wide.iter().zip(&x).all(|(wide, x)| wide.to_bits() == exp(*x).to_bits()));
        let expected: f64 = x.iter().map(|x| x * x).sum();
        assert!((dot(&x, &x) / expected - 1.0).abs() < 1e-14);
    }
}
