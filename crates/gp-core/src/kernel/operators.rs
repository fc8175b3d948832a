//! Sums, products and multiples of kernels by `+` and `*`.

use std::ops::{Add, Mul};

use super::{
    ActiveInputs, Constant, Coregionalization, Cosine, Kernel, Linear, Periodic, Polynomial,
    Product, Profile, Radial, RationalQuadratic, Sum, White,
};

/// `+` and `*` with any kernel on the right, one of yours too, a variance times the kernel, and the
/// kernel over some of the inputs.
macro_rules! operators {
    ($kernel:ty => $scaled:ty, $scale:expr $(; $($bound:tt)*)?) => {
        impl<$($($bound)*,)? K: Kernel + 'static> Add<K> for $kernel {
            type Output = Sum;

            fn add(self, other: K) -> Sum {
                Sum::new(self, other)
            }
        }

        impl<$($($bound)*,)? K: Kernel + 'static> Mul<K> for $kernel {
            type Output = Product;

            fn mul(self, other: K) -> Product {
                Product::new(self, other)
            }
        }

        impl$(<$($bound)*>)? $kernel {
            /// The kernel over some of the inputs only: those of `columns`, from zero.
            pub fn active(self, columns: &[usize]) -> ActiveInputs {
                ActiveInputs::new(self, columns)
            }
        }

        impl$(<$($bound)*>)? Mul<$kernel> for f64 {
            type Output = $scaled;

            fn mul(self, kernel: $kernel) -> $scaled {
                let scale: fn(f64, $kernel) -> $scaled = $scale;
                scale(self, kernel)
            }
        }
    };
}

operators!(Radial<P> => Radial<P>, |variance, kernel| kernel.scaled(variance); P: Profile);
operators!(RationalQuadratic => RationalQuadratic, |variance, kernel| kernel.scaled(variance));
operators!(Polynomial => Polynomial, |variance, kernel| kernel.scaled(variance));
operators!(Cosine => Cosine, |variance, kernel| kernel.scaled(variance));
operators!(Linear => Linear, |variance, kernel| kernel.scaled(variance));
operators!(Constant => Constant, |variance, kernel| Constant::new(variance * kernel.variance()));
operators!(White => White, |variance, kernel| White::new(variance * kernel.variance()));
operators!(Coregionalization => Product, |variance, kernel| Constant::new(variance) * kernel);
operators!(Periodic => Product, |variance, kernel| Constant::new(variance) * kernel);
operators!(Sum => Product, |variance, kernel| Constant::new(variance) * kernel);
operators!(Product => Product, |variance, kernel| Constant::new(variance) * kernel);
operators!(ActiveInputs => Product, |variance, kernel| Constant::new(variance) * kernel);
