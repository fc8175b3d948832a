//! A random part of many things.

use rand::SeedableRng;
use rand::seq::index::sample;
use rand_chacha::ChaCha8Rng;

/// At most `most` of the items, drawn by a seed, in their order.
pub(crate) fn some_of<T: Clone>(items: &[T], most: usize, seed: u64) -> Vec<T> {
    if items.len() <= most {
        return items.to_vec();
    }
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut chosen = sample(&mut rng, items.len(), most).into_vec();
    chosen.sort_unstable();
    chosen.into_iter().map(|index| items[index].clone()).collect()
}

#[cfg(test)]
mod tests {
    use super::some_of;

    #[test]
    fn a_part_is_drawn_once_each_in_order_and_by_the_seed() {
        let items: Vec<u32> = (0..100).collect();
        let part = some_of(&items, 30, 7);
        assert_eq!(part.len(), 30);
        assert!(part.windows(2).all(|pair| pair[0] < pair[1]));
        assert_eq!(part, some_of(&items, 30, 7));
        assert_ne!(part, some_of(&items, 30, 8));
        assert_eq!(some_of(&items, 100, 7), items);
    }
}
