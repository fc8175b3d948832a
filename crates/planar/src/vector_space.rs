//! Sums and multiples of twists and wrenches.

/// The operators of a vector space for a struct of a plane vector and a number.
macro_rules! vector_space {
    ($name:ident { $vector:ident, $number:ident }) => {
        vector_space!($name { $vector, $number } Add add +, AddAssign add_assign +=);
        vector_space!($name { $vector, $number } Sub sub -, SubAssign sub_assign -=);

        impl std::ops::Neg for $name {
            type Output = Self;

            #[inline]
            fn neg(self) -> Self {
                Self { $vector: -self.$vector, $number: -self.$number }
            }
        }

        impl std::ops::Mul<f64> for $name {
            type Output = Self;

            #[inline]
            fn mul(self, factor: f64) -> Self {
                Self { $vector: factor * self.$vector, $number: factor * self.$number }
            }
        }

        impl std::ops::Mul<$name> for f64 {
            type Output = $name;

            #[inline]
            fn mul(self, vector: $name) -> $name {
                $name { $vector: self * vector.$vector, $number: self * vector.$number }
            }
        }

        impl std::iter::Sum for $name {
            fn sum<I: Iterator<Item = Self>>(terms: I) -> Self {
                terms.fold(Self::default(), |sum, term| sum + term)
            }
        }
    };
    ($name:ident { $vector:ident, $number:ident }
     $trait:ident $method:ident $sign:tt, $assign_trait:ident $assign_method:ident $assign:tt) => {
        impl std::ops::$trait for $name {
            type Output = Self;

            #[inline]
            fn $method(self, other: Self) -> Self {
                Self {
                    $vector: self.$vector $sign other.$vector,
                    $number: self.$number $sign other.$number,
                }
            }
        }

        impl std::ops::$assign_trait for $name {
            #[inline]
            fn $assign_method(&mut self, other: Self) {
                self.$vector $assign other.$vector;
                self.$number $assign other.$number;
            }
        }
    };
}

pub(crate) use vector_space;

#[cfg(test)]
mod tests {
    use crate::{Twist, Wrench};

    #[test]
    fn twists_and_wrenches_add_and_scale_as_their_three_numbers_do() {
        macro_rules! check {
            ($name:ident) => {
                let (a, b) = ($name::new(1.0, -2.0, 3.0), $name::new(0.5, 0.25, -4.0));
                assert_eq!((a + b).to_vector(), a.to_vector() + b.to_vector());
                assert_eq!((a - b).to_vector(), a.to_vector() - b.to_vector());
                assert_eq!((-a).to_vector(), -a.to_vector());
                assert_eq!((a * 2.5).to_vector(), a.to_vector() * 2.5);
                assert_eq!(2.5 * a, a * 2.5);
                assert_eq!([a, b, a].into_iter().sum::<$name>(), a + b + a);
                let mut c = a;
                c += b;
                assert_eq!(c, a + b);
                c -= a;
                assert_eq!(c, b);
            };
        }
        check!(Twist);
        check!(Wrench);
    }
}
