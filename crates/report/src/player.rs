//! A player of planar motions: as measured, and as each model predicts them.

use std::fmt::Write;

use serde_json::{Value, json};

use crate::error::{ReportError, check_finite, check_some};
use crate::html::escape;
use crate::played::{LENGTH, PlayedPush, Sizes, coded};

/// Pushes of flat objects to be played on a page, in m, rad and s, frame of the table.
///
/// The pushes are embedded as JSON, in units of 10 µm, 0.1 mrad and 1 ms, numbers of their steps in
/// thousandths. Where they exceed `limit` bytes, those of the groups fill up to half of it, in turn one
/// of each; then come the first of the list, and an even choice of the rest, and the page says so.
#[derive(Clone, Debug, PartialEq)]
pub struct Player {
    /// Radius of the pusher.
    pub pusher_radius: f64,
    /// Names of the models.
    pub models: Vec<String>,
    /// Outlines in their body frames.
    pub outlines: Vec<Vec<[f64; 2]>>,
    /// What steps are told apart by.
    pub axes: Vec<PlayerAxis>,
    /// What is known of a step.
    pub numbers: Vec<PlayerNumber>,
    /// The pushes, the most important first.
    pub pushes: Vec<PlayedPush>,
    /// What the order of the pushes is, such as `the worst first`.
    pub order: String,
    /// What each group of pushes is, such as `each cell of the maps`.
    pub groups_are: String,
    /// Groups of pushes by their index, each of which should have some; the best of each first.
    pub groups: Vec<Vec<usize>>,
    /// Most bytes of the pushes.
    pub limit: usize,
}

/// Something that steps differ by, in cells.
#[derive(Clone, Debug, PartialEq)]
pub struct PlayerAxis {
    /// What links call it: letters, digits, `_`.
    pub key: String,
    /// What people call it, with its unit.
    pub name: String,
    /// The same in a word or two.
    pub short: String,
    /// Its unit, as it stands behind a value.
    pub unit: String,
    /// What each cell is called without the unit, such as `0.2 to 0.4`.
    pub cells: Vec<String>,
}

/// A number of a step.
#[derive(Clone, Debug, PartialEq)]
pub struct PlayerNumber {
    /// What links call it: letters, digits, `_`.
    pub key: String,
    /// What people call it.
    pub name: String,
    /// Its unit, as it stands behind a value.
    pub unit: String,
    /// How it is drawn over the time.
    pub shown: Shown,
}

/// How a number of a step is drawn over the time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// Observed less predicted.
    Error,
    /// As observed, and as predicted.
    Values,
    /// Not: it is another number, by its place in the list, in the sense of a model.
    As(usize),
}

impl Player {
    /// How many pushes fit the limit.
    pub fn n_embedded(&self) -> usize {
        self.chosen(&self.embedded()).pushes.len()
    }

    pub(crate) fn push(&self, out: &mut String) -> Result<(), ReportError> {
        self.check()?;
        let texts = self.embedded();
        let chosen = self.chosen(&texts);
        let pushes: Vec<&str> = chosen.pushes.iter().map(|index| texts[*index].as_str()).collect();
        let outlines: Vec<Value> = self
            .outlines
            .iter()
            .map(|outline| json!(coded(outline.as_flattened().iter().map(|v| v * LENGTH))))
            .collect();
        let radius = (self.pusher_radius * LENGTH).round();
        let _ = write!(
            out,
            "<div class=\"player\" data-player tabindex=\"-1\">\n{}<script type=\"application/json\">\
             {{\"radius\":{radius},\"all\":{},\"models\":{},\"outlines\":{},\"axes\":{},\"numbers\":{},\
             \"pushes\":[\n{}\n]}}</script>\n\
             <noscript><p>The player needs JavaScript.</p></noscript>\n</div>\n",
            self.frame(&chosen),
            self.pushes.len(),
            in_script(&json!(self.models)),
            in_script(&json!(outlines)),
            in_script(&json!(self.axes.iter().map(PlayerAxis::to_json).collect::<Vec<_>>())),
            in_script(&json!(self.numbers.iter().map(PlayerNumber::to_json).collect::<Vec<_>>())),
            pushes.join(",\n")
        );
        Ok(())
    }

    fn check(&self) -> Result<(), ReportError> {
        check_some("player", self.pushes.len())?;
        check_finite("player", "pusher radius", &[self.pusher_radius])?;
        for outline in &self.outlines {
            check_finite("player", "outlines (x, y)", outline.as_flattened())?;
        }
        let beyond = self.groups.iter().flatten().find(|index| **index >= self.pushes.len());
        if let Some(index) = beyond {
            return Err(ReportError::Parameter {
                mark: "player".to_owned(),
                field: "groups",
                expected: "indices of pushes",
                value: *index as f64,
            });
        }
        let sizes = Sizes {
            n_models: self.models.len(),
            n_outlines: self.outlines.len(),
            n_axes: self.axes.len(),
            n_numbers: self.numbers.len(),
        };
        self.pushes.iter().try_for_each(|push| push.check(sizes))
    }

    /// Each push as JSON.
    fn embedded(&self) -> Vec<String> {
        self.pushes.iter().map(|push| in_script(&push.to_json())).collect()
    }

    /// The pushes that fit the limit, in their order.
    fn chosen(&self, texts: &[String]) -> Chosen {
        let total: usize = texts.iter().map(String::len).sum();
        if total <= self.limit {
            return Chosen { pushes: (0..texts.len()).collect(), of_each: 0 };
        }
        let mut is_chosen = vec![false; texts.len()];
        let mut left = self.limit;
        let mut of_each = 0;
        let longest = self.groups.iter().map(Vec::len).max().unwrap_or(0);
        let mut take = |index: usize, least: usize| {
            let fits = is_chosen[index] || texts[index].len() + least <= left;
            if fits && !is_chosen[index] {
                is_chosen[index] = true;
                left -= texts[index].len();
            }
            fits
        };
        for round in 0..longest {
            let mut members = self.groups.iter().filter_map(|group| group.get(round));
            if !members.all(|index| take(*index, self.limit / 2)) {
                break;
            }
            of_each = round + 1;
        }
        let keep = if of_each > 0 { self.limit / 4 } else { self.limit / 2 };
        let _ = (0..texts.len()).all(|index| take(index, keep));
        let rest: Vec<usize> = (0..texts.len()).filter(|index| !is_chosen[*index]).collect();
        let average =
            rest.iter().map(|index| texts[*index].len()).sum::<usize>() / rest.len().max(1);
        let n_even = (left / average.max(1)).min(rest.len());
        for k in 0..n_even {
            let index = rest[k * rest.len() / n_even];
            if texts[index].len() <= left {
                is_chosen[index] = true;
                left -= texts[index].len();
            }
        }
        let pushes = (0..texts.len()).filter(|index| is_chosen[*index]).collect();
        Chosen { pushes, of_each }
    }

    /// What is there before the script fills it.
    fn frame(&self, chosen: &Chosen) -> String {
        let mut options = String::new();
        for index in &chosen.pushes {
            let _ = writeln!(options, "<option>{}</option>", escape(&self.pushes[*index].name));
        }
        let mut rows = String::new();
        for (index, model) in self.models.iter().enumerate() {
            let _ = writeln!(
                rows,
                "<tr class=\"model-{}\"><th scope=\"row\"><span class=\"key\"></span>{}</th>\
                 <td data-now></td><td data-end></td></tr>",
                index % 6,
                escape(model)
            );
        }
        let (n, all) = (chosen.pushes.len(), self.pushes.len());
        let share = match chosen.of_each {
            _ if n == all => format!("All {n} pushes"),
            0 => format!(
                "{n} of {all} pushes: the first of the list, and an even choice of the rest"
            ),
            k => format!(
                "{n} of {all} pushes: up to {k} of {}, the first of the list, and an even choice of \
                 the rest",
                escape(&self.groups_are)
            ),
        };
        format!(
            include_str!("player.html"),
            options = options,
            rows = rows,
            share = share,
            order = escape(&self.order)
        )
    }
}

/// The pushes that a page holds.
struct Chosen {
    pushes: Vec<usize>,
    /// How many of each group are there, if it has so many.
    of_each: usize,
}

impl PlayerAxis {
    fn to_json(&self) -> Value {
        let Self { key, name, short, unit, cells } = self;
        json!({ "key": key, "name": name, "short": short, "unit": unit, "cells": cells })
    }
}

impl PlayerNumber {
    fn to_json(&self) -> Value {
        let (shown, of) = match self.shown {
            Shown::Error => ("error", None),
            Shown::Values => ("values", None),
            Shown::As(number) => ("as", Some(number)),
        };
        json!({ "key": self.key, "name": self.name, "unit": self.unit, "shown": shown, "of": of })
    }
}

/// JSON that no text can end its script element with.
fn in_script(value: &Value) -> String {
    value.to_string().replace('<', "\\u003c")
}

#[cfg(test)]
mod tests {
    use super::{Player, coded};
    use crate::error::ReportError;
    use crate::played::{PlayedPush, PlayedSteps};

    fn player(n_pushes: usize, limit: usize) -> Player {
        let push = |k: usize| PlayedPush {
            name: format!("</script><b>push {k}"),
            outline: 0,
            times: vec![0.0, 0.2, 0.4],
            measured: vec![[0.1, 0.2, 0.3], [0.1, 0.21, 0.3], [0.1, 0.22, 0.31]],
            pusher: vec![[0.0, 0.2], [0.0, 0.21], [0.0, 0.22]],
            predicted: vec![Some(vec![[0.1, 0.2, 0.3]; 3]), None],
            steps: PlayedSteps { residuals: vec![Vec::new(); 2], ..PlayedSteps::default() },
        };
        Player {
            pusher_radius: 0.005,
            models: vec!["</script>".to_owned(), "b".to_owned()],
            outlines: vec![vec![[0.0, 0.0], [0.1, 0.0], [0.1, 0.1]]],
            axes: Vec::new(),
            numbers: Vec::new(),
            pushes: (0..n_pushes).map(push).collect(),
            groups_are: "each cell".to_owned(),
            groups: Vec::new(),
            order: "the worst first".to_owned(),
            limit,
        }
    }

    fn html(player: &Player) -> String {
        let mut out = String::new();
        player.push(&mut out).expect("the player is sound");
        out
    }

    #[test]
    fn differences_of_rounded_numbers_add_up_to_them() {
        let values: Vec<f64> = (0..200).map(|k| 1e3 * (f64::from(k) * 0.37).sin()).collect();
        let mut sum = 0;
        for (step, value) in coded(values.iter().copied()).into_iter().zip(&values) {
            sum += step;
            assert_eq!(sum, value.round() as i64);
        }
    }

    #[test]
    fn no_name_ends_the_script_or_becomes_markup() {
        let text = html(&player(2, 1 << 20));
        assert_eq!(text.matches("</script").count(), 1);
        assert!(!text.contains("<b>") && text.contains("&lt;/script&gt;&lt;b&gt;push 1"));
    }

    #[test]
    fn above_the_limit_the_first_and_an_even_choice_are_embedded() {
        let all = player(400, usize::MAX);
        let each = all.embedded()[0].len();
        let some = player(400, 40 * each);
        let chosen = some.chosen(&some.embedded()).pushes;
        assert_eq!(chosen[..20], (0..20).collect::<Vec<_>>());
        assert_eq!(chosen.len(), 40);
        let steps: Vec<usize> = chosen[20..].windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert!(steps.iter().all(|step| *step == 19), "{steps:?}");
        assert!(html(&some).contains("40 of 400 pushes"));
        assert!(html(&all).contains("All 400 pushes"));
        let embedded = html(&some).len() - html(&player(1, usize::MAX)).len();
        assert!(embedded < 40 * (each + 100), "{embedded}");
        assert_eq!(player(400, each / 2).n_embedded(), 0);
    }

    #[test]
    fn groups_have_their_pushes_before_any_others() {
        let each = player(1, usize::MAX).embedded()[0].len();
        let mut some = player(400, 40 * each);
        some.groups = (0..6).map(|k| (0..3).map(|n| 399 - 10 * k - n).collect()).collect();
        let chosen = some.chosen(&some.embedded());
        assert_eq!((chosen.of_each, chosen.pushes.len()), (3, 40));
        assert!(some.groups.iter().flatten().all(|index| chosen.pushes.contains(index)));
        assert_eq!(chosen.pushes[..12], (0..12).collect::<Vec<_>>());
        assert!(html(&some).contains("40 of 400 pushes: up to 3 of each cell, the first"));
        // Where not all fit, each group has as many as the others.
        some.groups = (0..15).map(|k| (0..20).map(|n| 20 * k + n).collect()).collect();
        assert_eq!(some.chosen(&some.embedded()).of_each, 1);
        some.groups[3][1] = 400;
        let beyond = some.push(&mut String::new());
        assert!(matches!(beyond, Err(ReportError::Parameter { field: "groups", .. })));
    }

    #[test]
    fn pushes_that_do_not_fit_together_are_refused() {
        let refused = |change: fn(&mut Player)| {
            let mut player = player(2, 1 << 20);
            change(&mut player);
            player.push(&mut String::new()).expect_err("the player is not sound")
        };
        let short = refused(|player| player.pushes[1].measured.truncate(2));
        assert!(matches!(short, ReportError::Length { expected: 3, found: 2, .. }));
        let other = refused(|player| player.pushes[0].outline = 1);
        assert!(matches!(other, ReportError::Parameter { field: "outline", .. }));
        let infinite = refused(|player| player.pushes[0].pusher[1][0] = f64::INFINITY);
        assert!(matches!(infinite, ReportError::NotFinite { .. }));
        let one_model = refused(|player| player.models.truncate(1));
        assert!(matches!(one_model, ReportError::Length { field: "predicted", .. }));
        assert!(matches!(refused(|player| player.pushes.clear()), ReportError::Empty { .. }));
    }
}
