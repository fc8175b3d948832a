//! A hidden effect that nobody chose.

use super::spec::SURPRISE;
use super::{Hidden, HiddenEffect, Quantity, surprising};
use crate::PlantError;
use crate::random::{Purpose, Random};

/// Sizes of a surprise, over the typical size.
const SIZES: (f64, f64) = (0.6, 1.8);

const MAX_DRAWS: usize = 1000;

impl Hidden {
    /// The effect, drawn if it is a surprise until one is possible; `number` tells the surprises of
    /// a set apart.
    pub(crate) fn resolved(
        &self,
        (seed, number): (u64, usize),
        is_possible: impl Fn(&HiddenEffect) -> bool,
    ) -> Result<HiddenEffect, PlantError> {
        let Self::Effect(effect) = self else {
            let mut draws = (0..MAX_DRAWS).map(|attempt| draw(seed, MAX_DRAWS * number + attempt));
            let what = "no effect is possible on this object with this design".to_owned();
            return draws
                .find(is_possible)
                .ok_or(PlantError::Hidden { text: SURPRISE.into(), what });
        };
        Ok(effect.clone())
    }
}

/// Draws any effect, its size around the typical one, to either side where there are two.
fn draw(seed: u64, number: usize) -> HiddenEffect {
    let mut random = Random::new(seed, Purpose::Surprise, number as u64);
    let kinds: Vec<_> = surprising().collect();
    let kind = kinds[random.below(kinds.len())];
    let size = random.uniform(SIZES.0, SIZES.1);
    HiddenEffect::of(kind, |parameter| {
        let (low, high) = parameter.range;
        let value = match parameter.off {
            Some(off) => {
                let side = if low == -high { random.sign() } else { 1.0 };
                off + side * size * (parameter.typical - off)
            }
            None if parameter.quantity == Quantity::Angle => random.uniform(low, high),
            None => parameter.typical,
        };
        value.clamp(low, high)
    })
}

#[cfg(test)]
mod tests {
    use super::draw;
    use crate::{Design, Truth};
    use std::collections::BTreeSet;

    #[test]
    fn surprises_are_repeatable_possible_and_of_many_kinds() {
        assert_eq!(draw(7, 0), draw(7, 0));
        let mut ids = BTreeSet::new();
        for seed in 0..300 {
            let effect = draw(seed, 0);
            ids.insert(effect.id);
            let (mut truth, mut design) = (Truth::default(), Design::default());
            effect.apply(&mut truth, &mut design).unwrap();
            truth.check().unwrap();
        }
        assert!(ids.len() > 25, "{ids:?}");
    }
}
