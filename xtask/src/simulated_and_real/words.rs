//! In words: how far apart the tables are, and why.

use nalgebra::Vector3;

use super::cells::{BETA_BORDERS, Cell, P_BORDERS};
use super::described::{COUNTS, Described, OUTPUTS};

const LAST: usize = COUNTS.len() - 1;

/// The items of the list.
pub(super) fn in_words([measured, simulated]: &[Described; 2], cells: &[Cell]) -> String {
    let follows = "**What follows.** A limit of the models (the ellipsoid, few training steps, speed) \
                   shows better on simulated pushes, whose truth is known. How wrong a model is on a \
                   table in the lab has to be measured there: `pushlab compare`.";
    let items = [
        mechanics(cells),
        scatter(measured, simulated),
        errors(measured, simulated),
        curves(measured, simulated),
        parameters(measured, simulated),
        follows.to_owned(),
    ];
    let item = |text: &String| wrapped(&format!("- {}", text.replace(" -", " \u{2212}")), "  ");
    items.iter().map(item).collect()
}

fn mechanics(cells: &[Cell]) -> String {
    format!(
        "**The same mechanics.** Signs, shapes and sizes of all three outputs agree over p and β. \
         Cell by cell the means differ by {} (root mean square over the cells), while they \
         range over the cells with standard deviations of {}. {}",
        spread(cells, |cell| cell.mean[1] - cell.mean[0]),
        spread(cells, |cell| cell.mean[0] - mean_of(cells)),
        worst(cells),
    )
}

fn scatter(measured: &Described, simulated: &Described) -> String {
    let ratio = |k: usize| format!("{:.1}", measured.neighbor_sd[k] / simulated.neighbor_sd[k]);
    format!(
        "**The real rig scatters far more.** Steps that begin alike differ {}, {} and {} times as \
         much in Δx, Δy and Δθ as simulated ones. The simulated rig has one even table, 2 % of \
         scatter in friction, 0.2 mm in the center of pressure and motion capture with 20 µm of \
         noise; a real plate on a real table meets wear, dust and a pressure that changes with \
         every placing, and one and the same push ends in more than one way.",
        ratio(0),
        ratio(1),
        ratio(2),
    )
}

fn errors(measured: &Described, simulated: &Described) -> String {
    format!(
        "**Therefore every model looks better on simulated steps.** The fitted analytical model's \
         error is {:.4} there and {:.4} on the measured table, that of a GP with {} steps {:.4} \
         and {:.4}. On the measured table the scatter of steps that begin alike makes an error of \
         {:.4} by itself, which no model of p and β avoids; on the simulated one {:.4}.",
        simulated.fitted_nmse,
        measured.fitted_nmse,
        COUNTS[LAST],
        simulated.gp_nmse[LAST],
        measured.gp_nmse[LAST],
        measured.scatter_nmse,
        simulated.scatter_nmse,
    )
}

fn curves(measured: &Described, simulated: &Described) -> String {
    let overtakes = |data: &Described| {
        let count = (0..COUNTS.len()).find(|&i| data.gp_nmse[i] < data.fitted_nmse);
        count.map_or_else(|| "none of the numbers of".to_owned(), |i| COUNTS[i].to_string())
    };
    let hybrid =
        |data: &Described, i: usize| format!("{:.2}", data.hybrid_nmse[i] / data.gp_nmse[i]);
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
        hybrid(measured, LAST),
        hybrid(simulated, LAST),
        COUNTS[LAST],
    )
}

fn parameters(measured: &Described, simulated: &Described) -> String {
    let length = |data: &Described| {
        format!("{:+.1}", 100.0 * (data.length.value / data.uniform_length - 1.0))
    };
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
    )
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
