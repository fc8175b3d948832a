//! A hyperparameter of a kernel: its name, value and role.

/// A kernel parameter: positive, in the user's units.
///
/// Its name is that of the kernel and its own, `matern52.signal_variance`, with the input behind it
/// where there is one for each: `matern52.lengthscale[0]`. The second kernel of a kind in a sum or
/// product is `matern52_2`, the third `matern52_3`.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// What it scales with.
    pub role: Role,
}

impl Parameter {
    /// A parameter of a kernel.
    pub fn new(name: impl Into<String>, value: f64, role: Role) -> Self {
        Self { name: name.into(), value, role }
    }

    /// Those of two kernels that are put together; kernels of the second are numbered on.
    pub(super) fn of_both(mut first: Vec<Self>, second: Vec<Self>) -> Vec<Self> {
        let n_first = first.len();
        for parameter in second {
            let (kernel, own) =
                parameter.name.split_once('.').unwrap_or(("kernel", &parameter.name));
            let (kind, number) = numbered(kernel);
            let used = first[..n_first].iter().filter_map(|p| {
                let (other, number) = numbered(p.name.split_once('.')?.0);
                (other == kind).then_some(number)
            });
            let name = match used.max().unwrap_or(0) + number {
                1 => format!("{kind}.{own}"),
                number => format!("{kind}_{number}.{own}"),
            };
            first.push(Self { name, ..parameter });
        }
        first
    }
}

/// A kernel's kind and which of its kind it is: `matern52_2` is the second `matern52`.
fn numbered(kernel: &str) -> (&str, usize) {
    let split = kernel.rsplit_once('_');
    let number = |(kind, number): (&'_ str, &str)| Some((kind.len(), number.parse().ok()?));
    match split.and_then(number) {
        Some((length, number)) => (&kernel[..length], number),
        None => (kernel, 1),
    }
}

/// What a parameter scales with; the optimiser takes starts and walls from it.
///
/// `inputs` are the columns of the inputs it belongs to; none are all.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Role {
    /// A length in the unit of the inputs.
    Lengthscale {
        /// The columns.
        inputs: Vec<usize>,
    },
    /// A period in the unit of the inputs.
    Period {
        /// The columns.
        inputs: Vec<usize>,
    },
    /// A variance in the squared unit of the output.
    Variance,
    /// A variance in the squared unit of the output over that of the inputs.
    SlopeVariance {
        /// The columns.
        inputs: Vec<usize>,
    },
    /// A number without unit.
    Shape,
    /// The odds (1 + ρ)/(1 − ρ) of a correlation ρ.
    Odds,
}

impl Role {
    /// Whether it carries the unit of the output.
    pub(super) fn is_variance(&self) -> bool {
        matches!(self, Self::Variance | Self::SlopeVariance { .. })
    }
}
