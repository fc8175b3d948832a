//! Four numbers side by side in a vector register.

use std::ops::{Add, Mul, Sub};

use pulp::Simd;

use crate::dynamics::pads::LANES;

/// Numbers that are worked on together, each as if it were alone: nothing is fused. For registers of four.
#[derive(Clone, Copy)]
pub(crate) struct Quad<S: Simd> {
    simd: S,
    numbers: S::f64s,
}

impl<S: Simd> Quad<S> {
    /// The same number in every place.
    #[inline(always)]
    pub(crate) fn all(simd: S, number: f64) -> Self {
        Self { simd, numbers: simd.splat_f64s(number) }
    }

    #[inline(always)]
    pub(crate) fn new(simd: S, numbers: &[f64; LANES]) -> Self {
        const { assert!(S::F64_LANES == LANES) };
        Self { simd, numbers: S::as_simd_f64s(numbers).0[0] }
    }

    #[inline(always)]
    pub(crate) fn numbers(self) -> [f64; LANES] {
        let mut numbers = [0.0; LANES];
        S::as_mut_simd_f64s(&mut numbers).0[0] = self.numbers;
        numbers
    }

    #[inline(always)]
    pub(crate) fn sqrt(self) -> Self {
        Self { numbers: self.simd.sqrt_f64s(self.numbers), ..self }
    }

    /// 1 over each.
    #[inline(always)]
    pub(crate) fn inverse(self) -> Self {
        let one = self.simd.splat_f64s(1.0);
        Self { numbers: self.simd.div_f64s(one, self.numbers), ..self }
    }

    /// The sum of the two halves' sums.
    #[inline(always)]
    pub(crate) fn sum(self) -> f64 {
        let [a, b, c, d] = self.numbers();
        (a + b) + (c + d)
    }
}

impl<S: Simd> Add for Quad<S> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { numbers: self.simd.add_f64s(self.numbers, other.numbers), ..self }
    }
}

impl<S: Simd> Sub for Quad<S> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { numbers: self.simd.sub_f64s(self.numbers, other.numbers), ..self }
    }
}

impl<S: Simd> Mul for Quad<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self { numbers: self.simd.mul_f64s(self.numbers, other.numbers), ..self }
    }
}
