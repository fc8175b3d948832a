//! Pages of the workspace whose examples are tests.

#[doc = include_str!("../../../docs/from-gpytorch.md")]
struct FromGpytorch;

#[doc = include_str!("../../../docs/from-gpy.md")]
struct FromGpy;

#[doc = include_str!("../../../docs/from-gpflow.md")]
struct FromGpflow;

#[doc = include_str!("../../../docs/from-scikit-learn.md")]
struct FromScikitLearn;

#[doc = include_str!("../../../docs/from-egobox.md")]
struct FromEgobox;
