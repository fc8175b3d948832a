//! Loops over slices in the widest vector registers of the machine, with the same bits on each.
//!
//! No operation is fused, so a value does not depend on the registers that computed it.

/// Makes of a function one that is compiled for each kind of vector registers and picks its own at
/// run time.
///
/// What its body calls must be marked `inline(always)`: a closure given to `dispatch` would often be
/// compiled apart from it, for the least registers.
macro_rules! vectorized {
    (
        $(#[$attribute:meta])*
        $visibility:vis fn $name:ident $(<$generic:ident: $bound:path>)?
        ($($argument:ident: $type:ty),* $(,)?) $(-> $output:ty)? $body:block
    ) => {
        $(#[$attribute])*
        $visibility fn $name $(<$generic: $bound>)? ($($argument: $type),*) $(-> $output)? {
            struct Loop<A, G>(A, std::marker::PhantomData<G>);

            impl $(<$generic: $bound>)? pulp::WithSimd
                for Loop<($($type,)*), $crate::vector::vectorized!(@or_unit $($generic)?)>
            {
                type Output = $crate::vector::vectorized!(@or_unit $($output)?);

                #[inline(always)]
                fn with_simd<S: pulp::Simd>(self, _registers: S) -> Self::Output {
                    let Self(($($argument,)*), _) = self;
                    $body
                }
            }

            let generic = std::marker::PhantomData;
            pulp::Arch::new().dispatch(
                Loop::<_, $crate::vector::vectorized!(@or_unit $($generic)?)>(
                    ($($argument,)*),
                    generic,
                ),
            )
        }
    };
    (@or_unit) => { () };
    (@or_unit $type:ty) => { $type };
}
pub(crate) use vectorized;

/// eˣ within 2 units in the last place; 0 where it is below the smallest normal number.
///
/// x = k ln 2 + r with |r| ≤ ½ ln 2, and eʳ by a polynomial of degree 11.
#[inline(always)]
pub fn exp(x: f64) -> f64 {
    let bounded = x.clamp(LOWEST, HIGHEST);
    let shifted = bounded * std::f64::consts::LOG2_E + ROUNDER;
    let multiple = shifted - ROUNDER;
    let rest = (bounded - multiple * LN_2_HIGH) - multiple * LN_2_LOW;
    let polynomial = polynomial(&EXPONENTIAL, rest);
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

vectorized! {
    /// Σᵢ aᵢ bᵢ, in lanes and always in the same order.
    pub fn dot(a: &[f64], b: &[f64]) -> f64 {
        let mut lanes = [0.0; LANES];
        let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
        for (a, b) in a.iter().zip(b) {
            for lane in 0..LANES {
                lanes[lane] += a[lane] * b[lane];
            }
        }
        let mut rest = 0.0;
        for (a, b) in a_rest.iter().zip(b_rest) {
            rest += a * b;
        }
        total(lanes) + rest
    }
}

vectorized! {
    /// Σᵢ wᵢ uᵢ and Σᵢ wᵢ uᵢ² with uᵢ = (xᵢ − center)·scale; in lanes and always in the same order.
    pub fn weighted_sums(x: &[f64], weights: &[f64], center: f64, scale: f64) -> (f64, f64) {
        let (mut first, mut second) = ([0.0; LANES], [0.0; LANES]);
        let (x, x_rest) = x.as_chunks::<LANES>();
        let (weights, weights_rest) = weights.as_chunks::<LANES>();
        for (x, w) in x.iter().zip(weights) {
            for lane in 0..LANES {
                let scaled = (x[lane] - center) * scale;
                let weighted = w[lane] * scaled;
                first[lane] += weighted;
                second[lane] += weighted * scaled;
            }
        }
        let (mut first_rest, mut second_rest) = (0.0, 0.0);
        for (x, w) in x_rest.iter().zip(weights_rest) {
            let scaled = (x - center) * scale;
            let weighted = w * scaled;
            first_rest += weighted;
            second_rest += weighted * scaled;
        }
        (total(first) + first_rest, total(second) + second_rest)
    }
}

vectorized! {
    /// values ← values·factors.
    pub fn multiply(values: &mut [f64], factors: &[f64]) {
        for (value, factor) in values.iter_mut().zip(factors) {
            *value *= factor;
        }
    }
}

vectorized! {
    /// sums ← sums + factor·a.
    pub fn add_multiple(sums: &mut [f64], factor: f64, a: &[f64]) {
        for (sum, a) in sums.iter_mut().zip(a) {
            *sum += factor * a;
        }
    }
}

vectorized! {
    /// values ← factor·a − factors·values.
    pub fn subtract_from_multiple(values: &mut [f64], factors: &[f64], factor: f64, a: &[f64]) {
        for ((value, own), a) in values.iter_mut().zip(factors).zip(a) {
            *value = factor * a - own * *value;
        }
    }
}

vectorized! {
    /// sums ← sums + factor·a².
    pub fn add_square(sums: &mut [f64], factor: f64, a: &[f64]) {
        for (sum, a) in sums.iter_mut().zip(a) {
            *sum += factor * (a * a);
        }
    }
}

vectorized! {
    /// sums ← sums + a·b.
    pub fn add_products(sums: &mut [f64], a: &[f64], b: &[f64]) {
        for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
            *sum += a * b;
        }
    }
}

vectorized! {
    /// sums ← sums − a·b.
    pub fn subtract_products(sums: &mut [f64], a: &[f64], b: &[f64]) {
        for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
            *sum -= a * b;
        }
    }
}

vectorized! {
    /// sums ← sums + terms, with what rounding loses added to the remainders.
    pub fn add_compensated(sums: &mut [f64], remainders: &mut [f64], terms: &[f64]) {
        for ((sum, remainder), term) in sums.iter_mut().zip(remainders).zip(terms) {
            let total = *sum + term;
            let added = total - *sum;
            *remainder += (*sum - (total - added)) + (term - added);
            *sum = total;
        }
    }
}

vectorized! {
    /// angles ← amplitude·cos, sines ← amplitude·sin, for angles up to [`SIN_COS_LIMIT`].
    pub fn turn(angles: &mut [f64], sines: &mut [f64], amplitude: f64) {
        for (angle, sine) in angles.iter_mut().zip(sines) {
            let (s, c) = sin_cos(*angle);
            *sine = amplitude * s;
            *angle = amplitude * c;
        }
    }
}

/// The sum of lanes, by halves.
#[inline(always)]
fn total(mut lanes: [f64; LANES]) -> f64 {
    let mut width = LANES;
    while width > 1 {
        width /= 2;
        for lane in 0..width {
            lanes[lane] += lanes[lane + width];
        }
    }
    lanes[0]
}

/// Sums side by side: enough that an addition need not wait for the one before.
const LANES: usize = 16;

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

/// 1, 1, and the polynomial that equals (eʳ − 1 − r)/r² at the Chebyshev nodes of |r| ≤ ½ ln 2: within
/// 2·10⁻¹⁷ of eʳ.
const EXPONENTIAL: [[f64; 4]; 3] = [
    [
        2.480_152_129_595_437_6e-5,
        2.755_726_845_999_706_4e-6,
        2.762_008_844_540_974_6e-7,
        2.510_038_549_551_032e-8,
    ],
    [
        0.041_666_666_666_624_13,
        0.008_333_333_333_330_062,
        0.001_388_888_891_721_371_7,
        0.000_198_412_698_630_536_18,
    ],
    [1.0, 1.0, 0.500_000_000_000_000_1, 0.166_666_666_666_666_69],
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
    use super::{dot, exp, sin_cos};

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

    vectorized! {
        fn replace_by_exp(values: &mut [f64]) {
            for value in values {
                *value = exp(*value);
            }
        }
    }

    #[test]
    fn wide_registers_change_no_bit() {
        let x: Vec<f64> = (0..1003).map(|i| (f64::from(i) * 0.37).sin() * 30.0).collect();
        let mut wide = x.clone();
        replace_by_exp(&mut wide);
        assert!(wide.iter().zip(&x).all(|(wide, x)| wide.to_bits() == exp(*x).to_bits()));
        let expected: f64 = x.iter().map(|x| x * x).sum();
        assert!((dot(&x, &x) / expected - 1.0).abs() < 1e-14);
    }
}
