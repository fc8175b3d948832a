//! Statistics of the parts of one data set, merged to the same bits in whatever order they come.

use serde::{Deserialize, Serialize};

use crate::GpError;

/// Sums over rows: those of two sets of rows merge to those of both.
pub trait Mergeable {
    /// Takes in what another one has seen, of rows that come after its own.
    ///
    /// # Errors
    /// `Incompatible` where the two are not sums of the same.
    fn merge(&mut self, other: &Self) -> Result<(), GpError>;
}

/// Statistics of some parts of a data set, from one machine or from several.
///
/// Sums of floating-point numbers depend on their order. So parts are merged in pairs, neighbor with neighbor,
/// and then pairs of pairs: what comes out depends on the parts alone, not on which came first, nor on who
/// merged what. Neighbors are merged as soon as both are there: of parts that come in order, ln₂ of their
/// number are in memory.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parts<S> {
    /// How many parts there are in all.
    of: u64,
    /// In the order of their rows.
    merged: Vec<Node<S>>,
}

/// 2^`level` neighbors that have become one, the `place`-th of its level; fewer at the end of all.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Node<S> {
    level: u32,
    place: u64,
    statistics: S,
}

impl<S: Mergeable> Parts<S> {
    /// None yet of so many.
    pub fn new(of: u64) -> Self {
        Self { of, merged: Vec::new() }
    }

    /// Takes in one part.
    ///
    /// - `part`: which it is, from 0.
    ///
    /// # Errors
    /// `PartTwice` for a part that is there, `NoSuchPart` beyond the last; what merging says.
    pub fn add(&mut self, part: u64, statistics: S) -> Result<(), GpError> {
        if part >= self.of {
            return Err(GpError::NoSuchPart { part, of: self.of });
        }
        self.insert(Node { level: 0, place: part, statistics })
    }

    /// Takes in what another one has.
    ///
    /// # Errors
    /// As [`Parts::add`]; `Incompatible` for another number of parts.
    pub fn merge(&mut self, other: Self) -> Result<(), GpError> {
        if other.of != self.of {
            return Err(GpError::Incompatible { what: "numbers of parts" });
        }
        other.merged.into_iter().try_for_each(|node| self.insert(node))
    }

    /// All parts in one.
    ///
    /// # Errors
    /// `PartMissing`; what merging says.
    pub fn finish(self) -> Result<S, GpError> {
        let mut next = 0;
        for node in &self.merged {
            if node.first() != next {
                break;
            }
            next = node.end();
        }
        let mut nodes = self.merged.into_iter().rev();
        // What is left over at the end of all, from the last part on.
        let missing =
            GpError::PartMissing { part: next.min(self.of.saturating_sub(1)), of: self.of };
        let (Some(mut last), true) = (nodes.next(), next >= self.of) else { return Err(missing) };
        for mut node in nodes {
            node.statistics.merge(&last.statistics)?;
            last = node;
        }
        Ok(last.statistics)
    }

    fn insert(&mut self, mut node: Node<S>) -> Result<(), GpError> {
        let mut at = self.merged.partition_point(|other| other.end() <= node.first());
        if let Some(other) = self.merged.get(at)
            && other.first() < node.end()
        {
            return Err(GpError::PartTwice { part: other.first().max(node.first()), of: self.of });
        }
        loop {
            let is_pair =
                |other: &Node<S>| other.level == node.level && other.place / 2 == node.place / 2;
            if self.merged.get(at).is_some_and(is_pair) {
                let right = self.merged.remove(at);
                node.statistics.merge(&right.statistics)?;
            } else if at > 0 && self.merged.get(at - 1).is_some_and(is_pair) {
                at -= 1;
                let mut left = self.merged.remove(at);
                left.statistics.merge(&node.statistics)?;
                node = left;
            } else {
                self.merged.insert(at, node);
                return Ok(());
            }
            (node.level, node.place) = (node.level + 1, node.place / 2);
        }
    }
}

impl<S> Node<S> {
    fn first(&self) -> u64 {
        self.place << self.level
    }

    fn end(&self) -> u64 {
        (self.place + 1) << self.level
    }
}

#[cfg(test)]
mod tests {
    use super::{Mergeable, Parts};
    use crate::GpError;
    use proptest::prelude::{Just, Strategy, prop_assert_eq, proptest};

    /// A plain sum, whose bits depend on the order of adding.
    #[derive(Clone, Debug, PartialEq)]
    struct Sum(f64);

    impl Mergeable for Sum {
        fn merge(&mut self, other: &Self) -> Result<(), GpError> {
            self.0 += other.0;
            Ok(())
        }
    }

    fn value(part: u64) -> Sum {
        Sum((part as f64 + 0.3).sin() * 10f64.powi(part as i32 % 9))
    }

    fn shuffled() -> impl Strategy<Value = Vec<u64>> {
        (1_u64..40).prop_flat_map(|n| Just((0..n).collect::<Vec<_>>()).prop_shuffle())
    }

    proptest! {
        #[test]
        fn the_bits_are_the_same_in_whatever_order_and_by_whomever_parts_are_merged(
            order in shuffled(),
            cut in 0.0..1.0,
        ) {
            let of = order.len() as u64;
            let mut in_order = Parts::new(of);
            (0..of).for_each(|part| in_order.add(part, value(part)).unwrap());
            let (here, there) = order.split_at((cut * of as f64) as usize);
            let [mut one, mut other] = [here, there].map(|own| {
                let mut parts = Parts::new(of);
                own.iter().for_each(|part| parts.add(*part, value(*part)).unwrap());
                parts
            });
            let mut around = other.clone();
            around.merge(one.clone()).unwrap();
            one.merge(std::mem::replace(&mut other, Parts::new(of))).unwrap();
            prop_assert_eq!(&one, &around);
            prop_assert_eq!(one.finish().unwrap(), in_order.finish().unwrap());
        }

        #[test]
        fn a_part_that_is_missing_is_named(order in shuffled()) {
            let of = order.len() as u64;
            let mut parts = Parts::new(of);
            order[1..].iter().for_each(|part| parts.add(*part, value(*part)).unwrap());
            let error = parts.finish().unwrap_err();
            prop_assert_eq!(error, GpError::PartMissing { part: order[0], of });
        }
    }

    #[test]
    fn of_parts_that_come_in_order_few_are_in_memory() {
        let mut parts = Parts::new(1000);
        for part in 0..1000 {
            parts.add(part, value(part)).unwrap();
            assert!(parts.merged.len() <= 10);
        }
    }

    #[test]
    fn parts_that_cannot_be_are_errors() {
        let mut parts = Parts::new(4);
        (0..3).for_each(|part| parts.add(part, value(part)).unwrap());
        assert_eq!(parts.add(1, value(1)), Err(GpError::PartTwice { part: 1, of: 4 }));
        assert_eq!(parts.add(4, value(4)), Err(GpError::NoSuchPart { part: 4, of: 4 }));
        let other = GpError::Incompatible { what: "numbers of parts" };
        assert_eq!(parts.clone().merge(Parts::new(5)), Err(other));
        assert_eq!(parts.clone().merge(parts), Err(GpError::PartTwice { part: 0, of: 4 }));
    }
}
