//! A number, or as many as a register of the machine holds.

use std::ops::{Add, Mul, Neg, Sub};

use pulp::Simd;

use super::SIZE;

/// Numbers that are worked on together, each as if it were alone: nothing is fused.
pub(super) trait Lane:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self>
{
    /// The same number in every place.
    fn alike(self, number: f64) -> Self;
    fn at_least(self, least: f64) -> Self;
    /// 1/√.
    fn inverse_root(self) -> Self;
}

impl Lane for f64 {
    #[inline(always)]
    fn alike(self, number: f64) -> Self {
        number
    }

    #[inline(always)]
    fn at_least(self, least: f64) -> Self {
        if self > least { self } else { least }
    }

    #[inline(always)]
    fn inverse_root(self) -> Self {
        1.0 / self.sqrt()
    }
}

/// A register of numbers.
#[derive(Clone, Copy)]
pub(super) struct Register<S: Simd> {
    simd: S,
    numbers: S::f64s,
}

impl<S: Simd> Register<S> {
    #[inline(always)]
    pub(super) fn all(simd: S, number: f64) -> Self {
        Self { simd, numbers: simd.splat_f64s(number) }
    }

    /// One of the registers that a block's numbers fill.
    #[inline(always)]
    pub(super) fn of(simd: S, numbers: &[f64; SIZE], register: usize) -> Self {
        Self { simd, numbers: S::as_simd_f64s(numbers).0[register] }
    }

    #[inline(always)]
    pub(super) fn root(self) -> Self {
        Self { numbers: self.simd.sqrt_f64s(self.numbers), ..self }
    }

    #[inline(always)]
    pub(super) fn put(self, numbers: &mut [f64; SIZE], register: usize) {
        S::as_mut_simd_f64s(numbers).0[register] = self.numbers;
    }
}

impl<S: Simd> Add for Register<S> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { numbers: self.simd.add_f64s(self.numbers, other.numbers), ..self }
    }
}

impl<S: Simd> Sub for Register<S> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { numbers: self.simd.sub_f64s(self.numbers, other.numbers), ..self }
    }
}

impl<S: Simd> Mul for Register<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self { numbers: self.simd.mul_f64s(self.numbers, other.numbers), ..self }
    }
}

impl<S: Simd> Neg for Register<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self { numbers: self.simd.neg_f64s(self.numbers), ..self }
    }
}

impl<S: Simd> Lane for Register<S> {
    #[inline(always)]
    fn alike(self, number: f64) -> Self {
        Self::all(self.simd, number)
    }

    #[inline(always)]
    fn at_least(self, least: f64) -> Self {
        let numbers = self.simd.max_f64s(self.numbers, self.simd.splat_f64s(least));
        Self { numbers, ..self }
    }

    #[inline(always)]
    fn inverse_root(self) -> Self {
        let one = self.simd.splat_f64s(1.0);
        Self { numbers: self.simd.div_f64s(one, self.simd.sqrt_f64s(self.numbers)), ..self }
    }
}
