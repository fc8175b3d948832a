//! What random splits scatter by: quartiles over them, drawn and tabled alike.

use report::{Band, Color, Line, Panel, Points, Table};

use crate::held_out::quantile;

/// Lower quartile, median and upper quartile over the splits, at each place of a curve.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Quartiles {
    low: Vec<f64>,
    median: Vec<f64>,
    high: Vec<f64>,
}

impl Quartiles {
    /// Of the value of each split at `n` places.
    pub(crate) fn of<S>(splits: &[S], n: usize, value: impl Fn(&S, usize) -> f64) -> Self {
        let at = |share: f64| {
            let over = |i: usize| splits.iter().map(|split| value(split, i)).collect();
            (0..n).map(|i| quantile(over(i), share)).collect()
        };
        Self { low: at(0.25), median: at(0.5), high: at(0.75) }
    }

    pub(crate) fn median(&self) -> &[f64] {
        &self.median
    }

    /// The lowest and the highest quartile of all places.
    pub(crate) fn span(&self) -> (f64, f64) {
        let low = self.low.iter().copied().fold(f64::INFINITY, f64::min);
        (low, self.high.iter().copied().fold(f64::NEG_INFINITY, f64::max))
    }

    /// The same in another unit.
    pub(crate) fn times(&self, factor: f64) -> Self {
        let [low, median, high] = [&self.low, &self.median, &self.high]
            .map(|values| values.iter().map(|value| factor * value).collect());
        Self { low, median, high }
    }

    /// Adds the medians as a line with points, and the quartiles as a band about them.
    pub(crate) fn draw(&self, panel: Panel, x: &[f64], color: Color, label: &str) -> Panel {
        panel
            .with(Band::new(x, &self.low, &self.high).color(color))
            .with(Line::new(x, &self.median).color(color).label(label))
            .with(Points::new(x, &self.median).color(color).radius(3.0))
    }

    /// Adds the medians alone as a dashed line: what a curve is held against.
    pub(crate) fn draw_level(&self, panel: Panel, x: &[f64], color: Color, label: &str) -> Panel {
        panel.with(Line::new(x, &self.median).color(color).dashed().label(label))
    }

    /// The three with their names in a table.
    pub(crate) fn named(&self, name: &str) -> [(String, &[f64]); 3] {
        let parts = [("lower", &self.low), ("median", &self.median), ("upper", &self.high)];
        parts.map(|(part, values)| (format!("{name}_{part}"), values.as_slice()))
    }

    /// Adds the three as columns of a name.
    pub(crate) fn columns(&self, table: Table, name: &str) -> Table {
        self.named(name).iter().fold(table, |table, (name, values)| table.column(name, values))
    }
}

#[cfg(test)]
mod tests {
    use super::Quartiles;

    #[test]
    fn every_place_has_the_quartiles_of_its_own_values() {
        let splits = [[1.0, 10.0], [3.0, 30.0], [2.0, 50.0], [4.0, 20.0], [5.0, 40.0]];
        let quartiles = Quartiles::of(&splits, 2, |split, i| split[i]);
        assert_eq!(quartiles.median(), [3.0, 30.0]);
        assert_eq!((&quartiles.low[..], &quartiles.high[..]), (&[2.0, 20.0][..], &[4.0, 40.0][..]));
        assert_eq!(quartiles.span(), (2.0, 40.0));
        assert_eq!(quartiles.times(2.0).median(), [6.0, 60.0]);
    }
}
