//! By how much a parameter differs, as a number that a fit moves.

use effects::{EffectError, Parameter, PushPhysics, Spread};

/// The spread of an effect's parameters over pushes and places together. Motions change by its square, which is
/// what is moved.
#[derive(Clone, Debug)]
pub(super) struct FreeSpread {
    id: &'static str,
    parameters: &'static [Parameter],
    /// That of size 1.
    unit: Spread,
    start: f64,
    largest: f64,
}

/// Least start of the square of a size: no slope is wider than that.
const LEAST: f64 = 0.1;
const LARGEST_SIZE: f64 = 10.0;

impl FreeSpread {
    /// The spread of an effect's parameters, in `unit`, from a size that is near.
    pub(super) fn new(
        id: &'static str,
        parameters: &'static [Parameter],
        unit: Spread,
        size: f64,
    ) -> Self {
        let is_allowed =
            |size: f64| parameters.iter().all(|one| sized(unit, size).check(one).is_ok());
        let mut largest = LARGEST_SIZE.max(size);
        while !is_allowed(largest) {
            largest *= 0.9;
        }
        Self { id, parameters, unit, start: size * size, largest: largest * largest }
    }

    pub(super) fn start(&self) -> f64 {
        self.start
    }

    pub(super) fn range(&self) -> (f64, f64) {
        (0.0, self.largest)
    }

    pub(super) fn secant(&self) -> f64 {
        0.5 * self.start.max(LEAST)
    }

    pub(super) fn name(&self) -> String {
        format!("{} spread", self.id)
    }

    /// The model whose parameters differ by a size.
    pub(super) fn put(
        &self,
        physics: PushPhysics,
        square: f64,
    ) -> Result<PushPhysics, EffectError> {
        let spread = sized(self.unit, square.sqrt());
        self.parameters.iter().try_fold(physics, |physics, parameter| {
            physics
                .with_spread_of_places(self.id, parameter.name, sized(self.unit, 0.0))?
                .with_spread(self.id, parameter.name, spread)
        })
    }
}

/// So many times a spread.
pub(super) fn sized(unit: Spread, size: f64) -> Spread {
    match unit {
        Spread::Sd(sd) => Spread::Sd(size * sd),
        Spread::RelativeSd(sd) => Spread::RelativeSd(size * sd),
    }
}
