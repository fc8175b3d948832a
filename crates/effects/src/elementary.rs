//! Elementary functions of several numbers at once, in the machine's vector registers.
//!
//! No operation is fused, so the bits do not depend on the machine.

use std::f64::consts::{LOG2_E, SQRT_2};

use pulp::{Arch, Simd, WithSimd};

/// ln 2: what of it any exponent is exact with, and the rest.
const LN_2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10];
/// 1.5·2⁵²: added to a number it rounds it to an integer, which stands in its last bits.
const ROUNDS: f64 = 6_755_399_441_055_744.0;
/// Beyond these eˣ is taken to be that of the end.
const EXPONENTS: (f64, f64) = (-708.0, 709.0);
const MANTISSA_BITS: u32 = 52;
const BIAS: u64 = 1023;

/// Numbers that are worked on side by side.
const LANES: usize = 8;
type Lanes = [f64; LANES];

/// 1/k! of Taylor's series of eˣ, the last first.
const EXP: [f64; 14] = {
    let mut found = [1.0; 14];
    let mut k = 13;
    while k > 0 {
        let mut factor = 1;
        while factor <= k {
            found[13 - k] /= factor as f64;
            factor += 1;
        }
        k -= 1;
    }
    found
};

/// 1/(2k + 1) of the series of artanh x / x in x², the last first.
const ARTANH: [f64; 11] = {
    let mut found = [1.0; 11];
    let mut k = 0;
    while k < 11 {
        found[10 - k] = 1.0 / (2 * k + 1) as f64;
        k += 1;
    }
    found
};

/// eˣ in the place of each x, to a rounding error or two.
pub(crate) fn exp_each(numbers: &mut [f64]) {
    Arch::new().dispatch(Each { numbers, function: Exp });
}

/// ln(1 + x) in the place of each x ≥ 0, to a rounding error or two.
pub(crate) fn ln_1p_each(numbers: &mut [f64]) {
    Arch::new().dispatch(Each { numbers, function: Ln1p });
}

struct Each<'a, F> {
    numbers: &'a mut [f64],
    function: F,
}

/// A function that is compiled where it is called, for the registers that are there.
trait Function {
    fn of(&self, numbers: &Lanes) -> Lanes;
}

impl<F: Function> WithSimd for Each<'_, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let (whole, rest) = self.numbers.as_chunks_mut();
        for numbers in whole {
            *numbers = self.function.of(numbers);
        }
        if rest.is_empty() {
            return;
        }
        let mut last = [0.0; LANES];
        last[..rest.len()].copy_from_slice(rest);
        rest.copy_from_slice(&self.function.of(&last)[..rest.len()]);
    }
}

/// Its value at x less its nearest multiple of ln 2, by Taylor's series.
struct Exp;

impl Function for Exp {
    #[inline(always)]
    fn of(&self, numbers: &Lanes) -> Lanes {
        let (low, high) = EXPONENTS;
        let within = |x: f64| if x < low { low } else { x };
        let within = numbers.map(|x| if within(x) > high { high } else { within(x) });
        let rounded = within.map(|x| x * LOG2_E + ROUNDS);
        let power = rounded.map(|rounded| rounded - ROUNDS);
        let rest = each(|k| within[k] - power[k] * LN_2[0] - power[k] * LN_2[1]);
        let sum = series(&EXP, &rest);
        let exponent = |k: usize| rounded[k].to_bits().wrapping_sub(ROUNDS.to_bits());
        let scale = |k: usize| f64::from_bits(exponent(k).wrapping_add(BIAS) << MANTISSA_BITS);
        each(|k| sum[k] * scale(k))
    }
}

/// Its value at the part of 1 + x between √½ and √2, by the series of the inverse hyperbolic tangent.
struct Ln1p;

impl Function for Ln1p {
    #[inline(always)]
    fn of(&self, numbers: &Lanes) -> Lanes {
        let sum = numbers.map(|x| 1.0 + x);
        let lost = each(|k| (numbers[k] - (sum[k] - 1.0)) / sum[k]);
        let least = (0.5 * SQRT_2).to_bits();
        let exponent = sum.map(|sum| sum.to_bits().wrapping_sub(least) >> MANTISSA_BITS);
        let power = exponent.map(|exponent| f64::from_bits(exponent | ROUNDS.to_bits()) - ROUNDS);
        let part = |k: usize| f64::from_bits(sum[k].to_bits() - (exponent[k] << MANTISSA_BITS));
        let share = each(|k| (part(k) - 1.0) / (part(k) + 1.0));
        let series = series(&ARTANH, &share.map(|share| share * share));
        each(|k| power[k] * LN_2[0] + (2.0 * share[k] * series[k] + (power[k] * LN_2[1] + lost[k])))
    }
}

#[inline(always)]
fn each(of: impl Fn(usize) -> f64) -> Lanes {
    std::array::from_fn(of)
}

/// The polynomial with these coefficients, the highest first, by Horner's rule.
#[inline(always)]
fn series(coefficients: &[f64], x: &Lanes) -> Lanes {
    let mut sum = [0.0; LANES];
    for coefficient in coefficients {
        sum = each(|k| sum[k] * x[k] + coefficient);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::{exp_each, ln_1p_each};

    #[test]
    fn exponentials_are_those_of_the_library() {
        let numbers: Vec<f64> = (-70_000..=70_000).map(|k| 1.01e-2 * f64::from(k)).collect();
        let mut found = numbers.clone();
        exp_each(&mut found);
        for (x, found) in numbers.iter().zip(found) {
            assert!((found / x.exp() - 1.0).abs() < 5e-16, "{x} {found}");
        }
    }

    #[test]
    fn far_exponents_are_those_of_the_ends_and_nan_stays() {
        let mut found = [0.0, -1e9, f64::NEG_INFINITY, 1e9, f64::NAN];
        exp_each(&mut found);
        assert_eq!(found[..2], [1.0, found[2]]);
        assert!((found[1] / (-708.0_f64).exp() - 1.0).abs() < 5e-16, "{found:?}");
        assert!(found[3] > 8e307 && found[3].is_finite() && found[4].is_nan());
    }

    #[test]
    fn logarithms_are_those_of_the_library() {
        let numbers: Vec<f64> = (-3000..=3000).map(|k| (1e-2 * f64::from(k)).exp()).collect();
        let mut found = numbers.clone();
        ln_1p_each(&mut found);
        for (x, found) in numbers.iter().zip(found) {
            assert!((found / x.ln_1p() - 1.0).abs() < 5e-16, "{x} {found}");
        }
        let mut none = [0.0];
        ln_1p_each(&mut none);
        assert_eq!(none, [0.0]);
    }
}
