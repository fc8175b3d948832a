//! The page: numbers side by side, and in words how far they are apart.

use std::fmt::Write as _;

use nalgebra::Vector3;

use super::cells::{BETA_BORDERS, Cell, P_BORDERS, Paired};
use super::described::{COUNTS, Described, OUTPUTS, SHARES};

/// The whole page.
pub(super) fn page(data: &str, both: &[Described; 2], cells: &[Cell], paired: &Paired) -> String {
    format!(
        "# Simulated and real pushes

The figures are drawn from a simulated rig ([plant](../crates/plant)). How near is that to a real
one? Here the table of the thesis' design, simulated at 20 mm/s with steps of 4 mm, stands beside one
of the same kind that was measured and is public, but no part of this project:
*{data}* of the MIT push data set. Everything on this page is made by one command:

```sh
cargo xtask simulated-and-real --data mit-push-table
```

![Outputs of measured and simulated steps over the push direction at three places, and learning
curves](simulated-and-real.svg)

*Mean and one standard deviation of the outputs in bins of β, at three places of the edge: measured
(points with bars) and simulated (lines with bands). Bottom right: learning curves, measured (solid)
and simulated (dashed).*

## In words

{}
## In numbers

{}
Quantiles depend on which pushes were made: the thesis' grid is not the measured one. The next two
comparisons do not. Errors are squared, over the variance of the outputs, mean of the three, on steps
not used for training, medians over splits. The scatter of steps that begin alike is that of nearest
neighbors within 0.01 in p and 2° in β (simulated: on different edges of the square).

Each measured step against the simulated one that begins most alike ({} pairs):

| simulated less measured | mean | root mean square |
|---|---|---|
{}
Cell by cell, measured; simulated, where both tables have ten steps or more:

{}",
        in_words(both, cells),
        table(both),
        paired.n,
        pairs(paired),
        cell_table(cells),
    )
}

/// How far apart the tables are, and why.
fn in_words(both: &[Described; 2], cells: &[Cell]) -> String {
    let [measured, simulated] = both;
    let ratio = |k: usize| format!("{:.1}", measured.neighbor_sd[k] / simulated.neighbor_sd[k]);
    let length = |data: &Described| {
        format!("{:+.1}", 100.0 * (data.length.value / data.uniform_length - 1.0))
    };
    let overtakes = |data: &Described| {
        let count = (0..COUNTS.len()).find(|&i| data.gp_nmse[i] < data.fitted_nmse);
        count.map_or_else(|| "none of the numbers of".to_owned(), |i| COUNTS[i].to_string())
    };
    let hybrid =
        |data: &Described, i: usize| format!("{:.2}", data.hybrid_nmse[i] / data.gp_nmse[i]);
    let last = COUNTS.len() - 1;
    let items = [
        format!(
            "**The same mechanics.** Signs, shapes and sizes of all three outputs agree over p and β. \
             Cell by cell the means differ by {} (root mean square over the cells), while they \
             range over the cells with standard deviations of {}. {}",
            spread(cells, |cell| cell.mean[1] - cell.mean[0]),
            spread(cells, |cell| cell.mean[0] - mean_of(cells)),
            worst(cells),
        ),
        format!(
            "**The real rig scatters far more.** Steps that begin alike differ {}, {} and {} times as \
             much in Δx, Δy and Δθ as simulated ones. The simulated rig has one even table, 2 % of \
             scatter in friction, 0.2 mm in the center of pressure and motion capture with 20 µm of \
             noise; a real plate on a real table meets wear, dust and a pressure that changes with \
             every placing, and one and the same push ends in more than one way.",
            ratio(0),
            ratio(1),
            ratio(2),
        ),
        format!(
            "**Therefore every model looks better on simulated steps.** The fitted analytical model's \
             error is {:.4} there and {:.4} on the measured table, that of a GP with {} steps {:.4} \
             and {:.4}. On the measured table the scatter of steps that begin alike makes an error of \
             {:.4} by itself, which no model of p and β avoids; on the simulated one {:.4}.",
            simulated.fitted_nmse,
            measured.fitted_nmse,
            COUNTS[last],
            simulated.gp_nmse[last],
            measured.gp_nmse[last],
            measured.scatter_nmse,
            simulated.scatter_nmse,
        ),
        format!(
            "**What carries over and what does not.** A GP overtakes the fitted analytical model with \
             {} measured and {} simulated steps. The hybrid's error over the GP's is {} and {} with {} \
             steps, {} and {} with {} (measured and simulated): both need fewer steps with the \
             mechanics known, but how long that lasts depends on the noise.",
            overtakes(measured),
            overtakes(simulated),
            hybrid(measured, 0),
            hybrid(simulated, 0),
            COUNTS[0],
            hybrid(measured, last),
            hybrid(simulated, last),
            COUNTS[last],
        ),
        format!(
            "**Parameters.** The fitted c is {} % off that of uniform pressure on the measured table \
             and {} % on the simulated one. Simulated pads are uniform, and an ellipsoid fitted to \
             their exact limit surface comes out small; the measured table does not show this, so its \
             pressure or its friction is not that of the simulated one. The fitted friction of the tip \
             is {:.3} measured and {:.3} simulated, where it is 0.25.",
            length(measured),
            length(simulated),
            measured.friction.value,
            simulated.friction.value,
        ),
        "**What follows.** A limit of the models (the ellipsoid, few training steps, speed) shows \
         better on simulated pushes, whose truth is known. How wrong a model is on a table in the lab \
         has to be measured there: `pushlab compare`."
            .to_owned(),
    ];
    let item = |text: &String| wrapped(&format!("- {}", text.replace(" -", " \u{2212}")), "  ");
    items.iter().map(item).collect()
}

/// The cell whose means differ most, and the one that mirrors it.
fn worst(cells: &[Cell]) -> String {
    let range = root_mean_square(cells, |cell| cell.mean[0] - mean_of(cells));
    let far = |cell: &Cell| (cell.mean[1] - cell.mean[0]).component_div(&range).norm();
    let Some(worst) = cells.iter().max_by(|a, b| far(a).total_cmp(&far(b))) else {
        return String::new();
    };
    let [p_width, beta_width] = [P_BORDERS[1] - P_BORDERS[0], BETA_BORDERS[1] - BETA_BORDERS[0]];
    let mirrored = cells.iter().find(|cell| {
        let p = (cell.p - (1.0 - worst.p - p_width)).abs();
        p < 1e-9 && (cell.beta + worst.beta + beta_width).abs() < 1e-9
    });
    let outputs = |cell: &Cell| {
        let of = |i: usize| {
            let [dx, dy, turn] = [0, 1, 2].map(|k| OUTPUTS[k].2 * cell.mean[i][k]);
            format!("({dx:.2} mm, {dy:.2} mm, {turn:.2}°)")
        };
        format!("{} measured and {} simulated", of(0), of(1))
    };
    let place = |cell: &Cell| {
        let (p, beta) = (cell.p, cell.beta);
        format!("p from {p:.1} to {:.1}, β from {beta}° to {}°", p + p_width, beta + beta_width)
    };
    let mut text = format!("They differ most at {}: {}", place(worst), outputs(worst));
    if let Some(cell) = mirrored {
        text += &format!(
            "; its mirror image, {}, has {}, and would have the same with the other signs of Δy and \
             Δθ on a rig that treats left and right alike",
            place(cell),
            outputs(cell)
        );
    }
    (text + ".").replace('-', "\u{2212}")
}

/// The text in lines of at most 100 characters; all but the first begin with `indent`.
fn wrapped(text: &str, indent: &str) -> String {
    let (mut lines, mut line) = (String::new(), String::new());
    for word in text.split_whitespace() {
        let is_full = line.chars().count() + 1 + word.chars().count() > 100;
        if is_full {
            lines += &format!("{line}\n");
            line = indent.to_owned();
        } else if !line.is_empty() {
            line.push(' ');
        }
        line += word;
    }
    lines + &line + "\n"
}

/// Numbers of each table in a column of its own.
pub(super) fn table(tables: &[Described]) -> String {
    let names: Vec<_> = tables.iter().map(|data| data.name).collect();
    let mut text = format!("| | {} |\n|---|{}\n", names.join(" | "), "---|".repeat(names.len()));
    let mut row = |name: String, value: &dyn Fn(&Described) -> String| {
        let values: Vec<_> = tables.iter().map(value).collect();
        // Writing to a string cannot fail.
        let _ = writeln!(text, "| {name} | {} |", values.join(" | ").replace('-', "\u{2212}"));
    };
    row("steps".into(), &|data| data.n_steps.to_string());
    let shares = SHARES.map(|share| format!("{:.0}", 100.0 * share)).join(", ");
    for (k, (name, unit, _)) in OUTPUTS.iter().enumerate() {
        row(format!("{name}: {shares} % quantile / {unit}"), &|data| {
            data.quantiles[k].map(|value| format!("{value:.2}")).join(", ")
        });
    }
    for (k, (name, unit, _)) in OUTPUTS.iter().enumerate() {
        row(format!("{name}: scatter of steps that begin alike / {unit}"), &|data| {
            format!("{:.3}", data.neighbor_sd[k])
        });
    }
    row("error by this scatter alone".into(), &|data| format!("{:.4}", data.scatter_nmse));
    row("analytical, nominal: error (μp)".into(), &|data| {
        format!("{:.4} ({:.2})", data.nominal_nmse, data.nominal_friction)
    });
    row("analytical, fitted: error".into(), &|data| format!("{:.4}", data.fitted_nmse));
    row("fitted μp".into(), &|data| {
        format!("{:.3} ± {:.3}", data.friction.value, data.friction.se)
    });
    row("fitted c / mm (uniform pressure)".into(), &|data| {
        let [value, se, uniform] =
            [data.length.value, data.length.se, data.uniform_length].map(|length| 1e3 * length);
        format!("{value:.2} ± {se:.2} ({uniform:.2})")
    });
    for (i, count) in COUNTS.iter().enumerate() {
        row(format!("GP, hybrid with {count} steps: error"), &|data| {
            format!("{:.4}, {:.4}", data.gp_nmse[i], data.hybrid_nmse[i])
        });
    }
    text
}

fn pairs(paired: &Paired) -> String {
    let row = |k: usize| {
        let (name, unit, scale) = OUTPUTS[k];
        let [mean, rms] = [scale * paired.mean[k], scale * paired.rms[k]];
        format!("| {name} / {unit} | {mean:+.3} | {rms:.3} |\n").replace('-', "\u{2212}")
    };
    (0..3).map(row).collect()
}

fn cell_table(cells: &[Cell]) -> String {
    let [p_width, beta_width] = [P_BORDERS[1] - P_BORDERS[0], BETA_BORDERS[1] - BETA_BORDERS[0]];
    let mut text =
        "| p | β / ° | steps | Δx / mm | Δy / mm | Δθ / ° |\n|---|---|---|---|---|---|\n"
            .to_owned();
    for cell in cells {
        let outputs = [0, 1, 2].map(|k| {
            let scale = OUTPUTS[k].2;
            let of =
                |i: usize| format!("{:.2} ± {:.2}", scale * cell.mean[i][k], scale * cell.sd[i][k]);
            format!("{}; {}", of(0), of(1))
        });
        let (p, beta) = (cell.p, cell.beta);
        let line = format!(
            "| {p:.1} to {:.1} | {beta:.0} to {:.0} | {}; {} | {} |\n",
            p + p_width,
            beta + beta_width,
            cell.n[0],
            cell.n[1],
            outputs.join(" | ")
        );
        text += &line.replace('-', "\u{2212}");
    }
    text
}

fn mean_of(cells: &[Cell]) -> Vector3<f64> {
    cells.iter().map(|cell| cell.mean[0]).sum::<Vector3<f64>>() / cells.len().max(1) as f64
}

fn root_mean_square(cells: &[Cell], value: impl Fn(&Cell) -> Vector3<f64>) -> Vector3<f64> {
    let squares = cells.iter().map(|cell| value(cell).map(|x| x * x)).sum::<Vector3<f64>>();
    (squares / cells.len().max(1) as f64).map(f64::sqrt)
}

/// Root mean square of a vector over the cells, output by output, in words.
fn spread(cells: &[Cell], value: impl Fn(&Cell) -> Vector3<f64>) -> String {
    let rms = root_mean_square(cells, value);
    let of = |k: usize| {
        let (_, unit, scale) = OUTPUTS[k];
        format!("{:.2}{}{unit}", scale * rms[k], if unit == "°" { "" } else { " " })
    };
    format!("{}, {} and {}", of(0), of(1), of(2))
}
