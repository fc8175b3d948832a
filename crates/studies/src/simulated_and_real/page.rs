//! The page: numbers side by side, and in words how far they are apart.

use std::fmt::Write as _;

use super::cells::{BETA_BORDERS, Cell, P_BORDERS, Paired};
use super::described::{COUNTS, Described, OUTPUTS, SHARES};
use super::words::in_words;

/// The whole page.
pub(super) fn page(data: &str, both: &[Described; 2], cells: &[Cell], paired: &Paired) -> String {
    format!(
        "# Simulated and real pushes

The figures are drawn from a simulated rig ([plant](../crates/plant)). How near is that to a real
one? Here the table of the thesis' design, simulated at 20 mm/s with steps of 4 mm, stands beside one
of the same kind that was measured and is public, but no part of this project:
*{data}* of the MIT push data set. [More numbers of more rigs](rig-calibration.md), repeats of a push among
them. Everything on this page is made by one command:

```sh
cargo xtask simulated-and-real --data mit-push-table/table.csv
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
