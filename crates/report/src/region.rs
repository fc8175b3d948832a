//! Steps of pushes by the cells of maps, which a reader follows from one part of a page to another.

use std::fmt::Write;

use crate::html::escape;

/// What a drawing's cells are cells of.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CellsOf {
    /// The models whose residuals it shows, by their place in the [`Player`](crate::Player).
    pub models: Vec<usize>,
    /// The number of a step, by its key in the player.
    pub number: String,
    /// The axes, by their keys in the player.
    pub over: Vec<String>,
}

/// The steps of one model and number in some cells of each of some axes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Region {
    /// The model, by its place in the [`Player`](crate::Player).
    pub model: usize,
    /// The number of a step, by its key in the player.
    pub number: String,
    /// Cells of axes, by their keys in the player; every step for no axis.
    pub cells: Vec<(String, Vec<usize>)>,
    /// The drawing that shows it, for readers without scripts.
    pub anchor: String,
}

impl CellsOf {
    /// As attributes of an element.
    pub(crate) fn attributes(&self) -> String {
        let models: Vec<String> = self.models.iter().map(usize::to_string).collect();
        format!(
            " data-models=\"{}\" data-number=\"{}\" data-over=\"{}\"",
            models.join(" "),
            escape(&self.number),
            escape(&self.over.join(" "))
        )
    }
}

impl Region {
    /// As the page's address has it, after `#in/`.
    fn key(&self) -> String {
        let mut key = format!("{}/{}", self.model, self.number);
        for (axis, cells) in &self.cells {
            let cells: Vec<String> = cells.iter().map(usize::to_string).collect();
            let _ = write!(key, "/{axis}={}", cells.join(","));
        }
        key
    }

    pub(crate) fn link(&self) -> String {
        let (anchor, key) = (escape(&self.anchor), self.key());
        format!(" <a class=\"steps\" href=\"#{anchor}\" data-in=\"{}\">its steps</a>", escape(&key))
    }
}

#[cfg(test)]
mod tests {
    use super::Region;

    #[test]
    fn a_region_is_an_address_that_scripts_read_back() {
        let cells = vec![("p".to_owned(), vec![0, 1]), ("beta".to_owned(), vec![11])];
        let (number, anchor) = ("turn".to_owned(), "maps".to_owned());
        let region = Region { model: 1, number, cells, anchor };
        assert_eq!(region.key(), "1/turn/p=0,1/beta=11");
        assert!(region.link().contains("href=\"#maps\" data-in=\"1/turn/p=0,1/beta=11\""));
    }
}
