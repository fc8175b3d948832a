//! How builders ask for hyperparameters by name.

/// Implements `fix`, `start`, `bound`, `tie` and `prior` of a builder with a field `constraints`, which are
/// [`Constraints`](crate::Constraints).
#[macro_export]
macro_rules! hyperparameters_by_name {
    ($builder:ty) => {
        impl $builder {
            /// Holds a hyperparameter at a value.
            pub fn fix(mut self, name: &str, value: f64) -> Self {
                self.constraints.fix(name, value);
                self
            }

            /// Begins the first start of `fit` at a value, which `condition` takes as it is.
            pub fn start(mut self, name: &str, value: f64) -> Self {
                self.constraints.start(name, value);
                self
            }

            /// Keeps a hyperparameter in a range, which may be open at an end.
            pub fn bound(mut self, name: &str, range: impl ::std::ops::RangeBounds<f64>) -> Self {
                self.constraints.bound(name, range);
                self
            }

            /// Keeps two hyperparameters equal; with the same name twice, all that have an index behind it.
            pub fn tie(mut self, first: &str, second: &str) -> Self {
                self.constraints.tie(first, second);
                self
            }

            /// Adds what is known of a hyperparameter before the data, in place of what the options
            /// know of all.
            pub fn prior(mut self, name: &str, prior: impl $crate::Prior + 'static) -> Self {
                self.constraints.prior(name, prior);
                self
            }
        }
    };
}
