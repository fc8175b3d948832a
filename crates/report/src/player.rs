//! A player of planar motions: as measured, and as each model predicts them.

use std::fmt::Write;

use serde_json::{Value, json};

use crate::error::{ReportError, check_finite, check_length, check_some};
use crate::html::escape;

/// Pushes of flat objects to be played on a page, in m, rad and s, frame of the table.
///
/// The pushes are embedded as JSON, in units of 10 µm, 0.1 mrad and 1 ms. Where they exceed
/// `limit` bytes, the first of the list fill half of it and an even choice of the rest the other
/// half, and the page says so.
#[derive(Clone, Debug, PartialEq)]
pub struct Player {
    /// Radius of the pusher.
    pub pusher_radius: f64,
    /// Names of the models.
    pub models: Vec<String>,
    /// Outlines in their body frames.
    pub outlines: Vec<Vec<[f64; 2]>>,
    /// The pushes, the most important first.
    pub pushes: Vec<PlayedPush>,
    /// What the order of the pushes is, such as `the worst first`.
    pub order: String,
    /// Most bytes of the pushes.
    pub limit: usize,
}

/// One push at a few times, between which the player interpolates.
#[derive(Clone, Debug, PartialEq)]
pub struct PlayedPush {
    /// Its name, with what tells it from others.
    pub name: String,
    /// Which outline.
    pub outline: usize,
    /// Times from the start.
    pub times: Vec<f64>,
    /// Measured x, y and angle of the body frame at each time.
    pub measured: Vec<[f64; 3]>,
    /// Center of the pusher at each time.
    pub pusher: Vec<[f64; 2]>,
    /// The same of the body frame by each model; none where it has no answer.
    pub predicted: Vec<Option<Vec<[f64; 3]>>>,
}

/// Parts of a meter, a radian and a second in the embedded numbers.
const LENGTH: f64 = 1e5;
const ANGLE: f64 = 1e4;
const TIME: f64 = 1e3;

impl Player {
    /// How many pushes fit the limit.
    pub fn n_embedded(&self) -> usize {
        self.chosen(&self.embedded()).len()
    }

    pub(crate) fn push(&self, out: &mut String) -> Result<(), ReportError> {
        self.check()?;
        let texts = self.embedded();
        let chosen = self.chosen(&texts);
        let pushes: Vec<&str> = chosen.iter().map(|index| texts[*index].as_str()).collect();
        let outlines: Vec<Value> = self
            .outlines
            .iter()
            .map(|outline| json!(coded(outline.as_flattened().iter().map(|v| v * LENGTH))))
            .collect();
        let radius = (self.pusher_radius * LENGTH).round();
        let _ = write!(
            out,
            "<div class=\"player\" data-player>\n{}<script type=\"application/json\">\
             {{\"radius\":{radius},\"models\":{},\"outlines\":{},\"pushes\":[\n{}\n]}}</script>\n\
             <noscript><p>The player needs JavaScript.</p></noscript>\n</div>\n",
            self.frame(&chosen),
            in_script(&json!(self.models)),
            in_script(&json!(outlines)),
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
        self.pushes.iter().try_for_each(|push| push.check(self))
    }

    /// Each push as JSON.
    fn embedded(&self) -> Vec<String> {
        self.pushes.iter().map(|push| in_script(&push.to_json())).collect()
    }

    /// The pushes that fit the limit, in their order.
    fn chosen(&self, texts: &[String]) -> Vec<usize> {
        let total: usize = texts.iter().map(String::len).sum();
        if total <= self.limit {
            return (0..texts.len()).collect();
        }
        let (mut used, mut first) = (0, 0);
        while first < texts.len() && used + texts[first].len() <= self.limit / 2 {
            used += texts[first].len();
            first += 1;
        }
        let rest = texts.len() - first;
        let average = texts[first..].iter().map(String::len).sum::<usize>() / rest.max(1);
        let n_even = (self.limit - used) / average.max(1);
        let even = (0..n_even.min(rest)).map(|k| first + k * rest / n_even);
        let mut chosen: Vec<usize> = (0..first).collect();
        for index in even {
            used += texts[index].len();
            if used <= self.limit {
                chosen.push(index);
            }
        }
        chosen
    }

    /// What is there before the script fills it.
    fn frame(&self, chosen: &[usize]) -> String {
        let mut options = String::new();
        for index in chosen {
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
        let (n, all) = (chosen.len(), self.pushes.len());
        let share = if n == all {
            format!("All {n} pushes")
        } else {
            format!("{n} of {all} pushes: the first of the list, and an even choice of the rest")
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

impl PlayedPush {
    fn check(&self, player: &Player) -> Result<(), ReportError> {
        let mark = format!("push `{}`", self.name);
        let n = self.times.len();
        check_some(&mark, n)?;
        check_finite(&mark, "times", &self.times)?;
        check_length(&mark, "measured", n, self.measured.len())?;
        check_finite(&mark, "measured (x, y, angle)", self.measured.as_flattened())?;
        check_length(&mark, "pusher", n, self.pusher.len())?;
        check_finite(&mark, "pusher (x, y)", self.pusher.as_flattened())?;
        check_length(&mark, "predicted", player.models.len(), self.predicted.len())?;
        for poses in self.predicted.iter().flatten() {
            check_length(&mark, "predicted poses", n, poses.len())?;
            check_finite(&mark, "predicted (x, y, angle)", poses.as_flattened())?;
        }
        if self.outline < player.outlines.len() {
            return Ok(());
        }
        Err(ReportError::Parameter {
            mark,
            field: "outline",
            expected: "the index of an outline",
            value: self.outline as f64,
        })
    }

    fn to_json(&self) -> Value {
        let column = |values: &mut dyn Iterator<Item = f64>| coded(values);
        let pose = |poses: &[[f64; 3]]| {
            let scaled = |k: usize, scale: f64| column(&mut poses.iter().map(|p| p[k] * scale));
            json!([scaled(0, LENGTH), scaled(1, LENGTH), scaled(2, ANGLE)])
        };
        let pusher = |k: usize| column(&mut self.pusher.iter().map(|p| p[k] * LENGTH));
        json!({
            "o": self.outline,
            "t": column(&mut self.times.iter().map(|t| t * TIME)),
            "m": pose(&self.measured),
            "p": [pusher(0), pusher(1)],
            "r": self.predicted.iter().map(|r| r.as_deref().map(pose)).collect::<Vec<_>>(),
        })
    }
}

/// Rounded numbers, the first and the differences that follow, which do not drift.
fn coded(values: impl Iterator<Item = f64>) -> Vec<i64> {
    let mut last = 0;
    let difference = |value: f64| {
        let now = value.round() as i64;
        let step = now - last;
        last = now;
        step
    };
    values.map(difference).collect()
}

/// JSON that no text can end its script element with.
fn in_script(value: &Value) -> String {
    value.to_string().replace('<', "\\u003c")
}

#[cfg(test)]
mod tests {
    use super::{PlayedPush, Player, coded};
    use crate::error::ReportError;

    fn player(n_pushes: usize, limit: usize) -> Player {
        let push = |k: usize| PlayedPush {
            name: format!("</script><b>push {k}"),
            outline: 0,
            times: vec![0.0, 0.2, 0.4],
            measured: vec![[0.1, 0.2, 0.3], [0.1, 0.21, 0.3], [0.1, 0.22, 0.31]],
            pusher: vec![[0.0, 0.2], [0.0, 0.21], [0.0, 0.22]],
            predicted: vec![Some(vec![[0.1, 0.2, 0.3]; 3]), None],
        };
        Player {
            pusher_radius: 0.005,
            models: vec!["</script>".to_owned(), "b".to_owned()],
            outlines: vec![vec![[0.0, 0.0], [0.1, 0.0], [0.1, 0.1]]],
            pushes: (0..n_pushes).map(push).collect(),
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
        let chosen = some.chosen(&some.embedded());
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
