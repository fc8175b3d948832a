//! Figure M.4: how often the regions of a roll-out hold the end of a push.

use anyhow::Result;
use report::{Axis, Color, Figure, LegendPlace, Line, Panel};
use serde_json::{Value, json};

use super::ends::{End, Ends, LEVELS, all_ends, coverage};
use super::pushes::turns;
use crate::figures::inputs::Inputs;
use crate::figures::sketch::Sketch;

/// With care, and quickly.
const N_PARTICLES: [usize; 2] = [200, 80];
/// Where the curves are read.
const N_LEVELS: usize = 51;

pub(crate) fn draw(inputs: &Inputs) -> Result<Sketch> {
    let pushes = inputs.whole_pushes()?;
    let setting = inputs.setting()?;
    let n_particles = N_PARTICLES[usize::from(inputs.quick())];
    let all = all_ends(&setting, &turns(&pushes), n_particles)?;
    let figure = Figure::new(1, 2)
        .panel_size(400.0, 340.0)
        .with(panel("steps taken for independent", &all, |ends| &ends.independent))
        .with(panel("errors held as measured", &all, |ends| &ends.held));
    let n = all.first().map_or(0, |ends| ends.held.len());
    let told: Vec<String> = all.iter().map(in_words).collect();
    let chance = LEVELS.map(|level| format!("{:.0}", 100.0 * binomial_sd(level, n))).join(", ");
    let caption = format!(
        "Ends of {n} pushes that no model has seen, each among {n_particles} particles: the share that \
         lies within the region of a level. A model that knows how sure it is follows the diagonal. \
         Neighboring steps of a push share errors, which a variance per step does not tell (left); \
         which part goes on over which way, and how unevenly pushes err, was measured on the pushes \
         learnt from, each by a model that left it out (right). Share within 50, 90 and 95 % regions in \
         percent (±{chance} of {n} ends are chance), mean standard deviation of the place, and negative \
         log density in nats, independent → held, and in brackets the shares of ends of the pushes learnt \
         from, by models that left them out: {}.",
        told.join("; ")
    );
    let alt = "Coverage curves of seven models, far below the diagonal at the left and near it at the \
               right.";
    let data: Vec<Value> = all.iter().map(numbers).collect();
    Ok(Sketch::new(figure, Value::Array(data), &caption, alt))
}

fn panel(title: &str, all: &[Ends], ends: fn(&Ends) -> &[End]) -> Panel {
    let grid: Vec<f64> = (0..N_LEVELS).map(|k| k as f64 / (N_LEVELS - 1) as f64).collect();
    let panel = Panel::new(
        Axis::new("level of the region").range(0.0, 1.0),
        Axis::new("share of the ends within").range(0.0, 1.0),
    )
    .title(title)
    .legend(LegendPlace::Below)
    .with(Line::new(&[0.0, 1.0], &[0.0, 1.0]).color(Color::GRAY).width(1.0));
    all.iter().fold(panel, |panel, model| {
        let shares: Vec<f64> = grid.iter().map(|level| coverage(ends(model), *level)).collect();
        panel.with(Line::new(&grid, &shares).color(model.color).label(model.name))
    })
}

fn in_words(ends: &Ends) -> String {
    let told = |ends: &[End]| {
        let percent =
            LEVELS.map(|level| format!("{:.0}", 100.0 * coverage(ends, level))).join(", ");
        let n = ends.len() as f64;
        let sd = ends.iter().map(|end| end.sd[0]).sum::<f64>() / n;
        let nlpd = ends.iter().map(|end| end.nlpd).sum::<f64>() / n;
        format!("{percent} ({:.2} mm, {nlpd:.1})", 1e3 * sd)
    };
    let left_out: Vec<_> = ends.correlations.iter().filter_map(|found| found.ends).collect();
    let n: usize = left_out.iter().map(|ends| ends.n_pushes).sum();
    let within = [0, 1, 2].map(|level| {
        let within: usize = left_out.iter().map(|ends| ends.n_within[level]).sum();
        format!("{:.0}", 100.0 * within as f64 / n.max(1) as f64)
    });
    let (independent, held) = (told(&ends.independent), told(&ends.held));
    format!("{} {independent} → {held} [{} of {n}]", ends.name, within.join(", "))
}

/// Standard deviation of the share of n ends within a region that holds each with a probability.
fn binomial_sd(level: f64, n: usize) -> f64 {
    (level * (1.0 - level) / n as f64).sqrt()
}

/// Everything that was measured of a model.
fn numbers(ends: &Ends) -> Value {
    let of = |ends: &[End]| {
        let n = ends.len() as f64;
        let rms =
            |of: &dyn Fn(&End) -> f64| (ends.iter().map(|e| of(e).powi(2)).sum::<f64>() / n).sqrt();
        json!({
            "coverage": LEVELS.map(|level| {
                let chance = binomial_sd(level, ends.len());
                json!({ "level": level, "share": coverage(ends, level), "chance_sd": chance })
            }),
            "end_error_rms_m": rms(&|end| end.error[0]),
            "end_error_rms_rad": rms(&|end| end.error[1]),
            "end_sd_rms_m": rms(&|end| end.sd[0]),
            "end_sd_rms_rad": rms(&|end| end.sd[1]),
            "nlpd": ends.iter().map(|end| end.nlpd).sum::<f64>() / n,
            "levels": ends.iter().map(|end| end.level).collect::<Vec<_>>(),
        })
    };
    json!({
        "model": ends.name,
        "independent": of(&ends.independent),
        "held": of(&ends.held),
        "correlations": ends.correlations,
        "unseen": ends.unseen,
    })
}

#[cfg(test)]
mod tests {
    use super::draw;
    use crate::figures::inputs::Inputs;

    #[test]
    fn held_errors_cover_more_of_the_ends_than_independent_ones() {
        let sketch = draw(&Inputs::fixtures(true).unwrap()).unwrap();
        let report::Data::Json(models) = &sketch.data else { panic!("numbers are in JSON") };
        let models = models.as_array().unwrap();
        assert_eq!(models.len(), 7);
        for model in models {
            let share = |kind: &str| model[kind]["coverage"][2]["share"].as_f64().unwrap();
            let (independent, held) = (share("independent"), share("held"));
            assert!(held > independent, "{}: {independent} {held}", model["model"]);
            for region in model["held"]["coverage"].as_array().unwrap() {
                let number = |key: &str| region[key].as_f64().unwrap();
                let off = (number("share") - number("level")) / number("chance_sd");
                // Seven models times three levels, three standard deviations.
                assert!(off.abs() < 3.0, "{}: {region}", model["model"]);
            }
            let nlpd = |kind: &str| model[kind]["nlpd"].as_f64().unwrap();
            assert!(nlpd("held") < nlpd("independent"), "{}", model["model"]);
        }
    }
}
