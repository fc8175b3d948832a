//! In words: how far apart the tables are. Every sentence that concludes something checks it first, and
//! says the opposite where the check fails; the tolerance stands in the sentence.

use nalgebra::Vector3;

use super::cells::{BETA_BORDERS, Cell, P_BORDERS};
use super::described::{COUNTS, Described, OUTPUTS};

const LAST: usize = COUNTS.len() - 1;
/// Fewer cells show no pattern.
const FEWEST_CELLS: usize = 5;
/// Ratios of errors within this of one are level: medians over few splits tell no more.
const LEVEL: f64 = 0.05;
/// Standard errors that a difference has to exceed, for 95 %.
const SURE: f64 = 1.96;

/// The items of the list.
pub(super) fn in_words([measured, simulated]: &[Described; 2], cells: &[Cell]) -> String {
    let items = [
        mechanics(cells),
        scatter(measured, simulated),
        errors(measured, simulated),
        floors(measured, simulated),
        curves(measured, simulated),
        parameters(measured, simulated),
    ];
    let item = |text: &String| wrapped(&format!("- {}", text.replace(" -", " \u{2212}")), "  ");
    items.iter().map(item).collect()
}

fn mechanics(cells: &[Cell]) -> String {
    if cells.len() < FEWEST_CELLS {
        let n = cells.len();
        return format!("**Too few cells.** Both tables have steps in {n}, which show no pattern.");
    }
    let apart = root_mean_square(cells, |cell| cell.mean[1] - cell.mean[0]);
    let range = root_mean_square(cells, |cell| cell.mean[0] - mean_of(cells));
    let far = (0..3).filter(|&k| apart[k] * 3.0 >= range[k]).map(|k| OUTPUTS[k].0);
    let far: Vec<&str> = far.collect();
    let opposite = |cell: &Cell, k: usize| {
        let [own, other] = [0, 1].map(|i| cell.mean[i][k]);
        own.abs() > 0.5 * range[k] && own * other <= 0.0
    };
    let signs = cells.iter().flat_map(|cell| (0..3).map(move |k| opposite(cell, k)));
    let n_opposite = signs.filter(|is_opposite| *is_opposite).count();
    let (headline, how) = match (far.is_empty(), n_opposite) {
        (true, 0) => ("The same mechanics", "less in each than a third of".to_owned()),
        (true, _) => ("Not the same signs", "less in each than a third of".to_owned()),
        (false, _) => {
            let names = far.join(" and ");
            ("Not the same mechanics", format!("in {names} not less than a third of"))
        }
    };
    let signs = match n_opposite {
        0 => "no measured mean that is larger than half of these has".to_owned(),
        n => format!("{n} measured means that are larger than half of these have"),
    };
    format!(
        "**{headline}.** Cell by cell of p and β the means differ by {} (root mean square over the \
         cells), {how} the standard deviations over the cells, {}; {signs} the other sign in the \
         simulation. {}",
        spread(&apart),
        spread(&range),
        worst(cells),
    )
}

fn scatter(measured: &Described, simulated: &Described) -> String {
    let ratios = [0, 1, 2].map(|k| measured.neighbor_sd[k] / simulated.neighbor_sd[k]);
    let all = |low: f64, high: f64| ratios.iter().all(|ratio| (low..=high).contains(ratio));
    let headline = match () {
        () if ratios.iter().any(|ratio| !ratio.is_finite()) => {
            return "**Scatter cannot be compared.** A table has no steps that begin alike.".into();
        }
        () if all(2.0, f64::MAX) => "The real rig scatters far more",
        () if all(1.25, f64::MAX) => "The real rig scatters more",
        () if all(0.8, 1.25) => "Both rigs scatter alike",
        () if all(0.0, 0.8) => "The real rig scatters less",
        () => "Which rig scatters more depends on the output",
    };
    let [x, y, turn] = ratios.map(|ratio| format!("{ratio:.1}"));
    format!(
        "**{headline}.** Steps that begin alike differ {x}, {y} and {turn} times as much in Δx, Δy \
         and Δθ as simulated ones (more: 1.25 times in each, far more: twice)."
    )
}

/// All errors of a table's models, in one order.
fn all_errors(data: &Described) -> Vec<f64> {
    let learned = data.gp_nmse.iter().chain(&data.hybrid_nmse);
    [data.nominal_nmse, data.fitted_nmse].iter().chain(learned).copied().collect()
}

fn errors(measured: &Described, simulated: &Described) -> String {
    let pairs = all_errors(measured).into_iter().zip(all_errors(simulated));
    let ratios: Vec<f64> = pairs.map(|(measured, simulated)| measured / simulated).collect();
    let least = ratios.iter().copied().fold(f64::INFINITY, f64::min);
    let most = ratios.iter().copied().fold(0.0, f64::max);
    let headline = if least > 1.0 + LEVEL {
        "Every model looks better on simulated steps"
    } else if most < 1.0 - LEVEL {
        "Every model looks worse on simulated steps"
    } else {
        "Not every model looks better on simulated steps"
    };
    format!(
        "**{headline}.** On the measured table an error is {least:.1} to {most:.1} times the same \
         model's on simulated steps (analytical, nominal and fitted; GP and hybrid at every number of \
         steps; 5 % count as none): the fitted analytical model's {:.4} and {:.4}, that of a GP with \
         {} steps {:.4} and {:.4}. How wrong a model is on another table has to be measured there: \
         `pushlab compare`.",
        measured.fitted_nmse,
        simulated.fitted_nmse,
        COUNTS[LAST],
        measured.gp_nmse[LAST],
        simulated.gp_nmse[LAST],
    )
}

fn floors(measured: &Described, simulated: &Described) -> String {
    let lowest = |data: &Described| all_errors(data).into_iter().fold(f64::INFINITY, f64::min);
    let is_floor = |data: &Described| lowest(data) >= data.scatter_nmse;
    let headline = match (is_floor(measured), is_floor(simulated)) {
        (true, true) => "No model errs less than the scatter",
        (false, false) => "Some models err less than the scatter on both tables",
        (true, false) => "Some models err less than the scatter on simulated steps",
        (false, true) => "Some models err less than the scatter on measured steps",
    };
    format!(
        "**{headline}.** The scatter of steps that begin alike makes an error of {:.4} by itself on \
         the measured table, where the lowest of all models is {:.4}, and of {:.4} on the simulated \
         one, where it is {:.4}.",
        measured.scatter_nmse,
        lowest(measured),
        simulated.scatter_nmse,
        lowest(simulated),
    )
}

fn curves(measured: &Described, simulated: &Described) -> String {
    let overtakes = |data: &Described| {
        let is_below = |&i: &usize| data.gp_nmse[i..].iter().all(|nmse| *nmse < data.fitted_nmse);
        let count = (0..COUNTS.len()).find(is_below);
        count.map_or_else(
            || format!("with none up to {}", COUNTS[LAST]),
            |i| format!("from {} steps on", COUNTS[i]),
        )
    };
    let ratio = |data: &Described, i: usize| data.hybrid_nmse[i] / data.gp_nmse[i];
    let gains = |i: usize| [measured, simulated].map(|data| ratio(data, i) < 1.0 - LEVEL);
    let on = |gains: [bool; 2]| match gains {
        [true, true] => "on both tables",
        [true, false] => "on the measured table alone",
        [false, true] => "on the simulated table alone",
        [false, false] => "on neither table",
    };
    let headline = if gains(0) == gains(LAST) {
        format!("The mechanics save steps {}", on(gains(0)))
    } else {
        format!("The mechanics save steps {}, and in the end {}", on(gains(0)), on(gains(LAST)))
    };
    format!(
        "**{headline}.** The hybrid's error over the GP's is {:.2} measured and {:.2} simulated with \
         {} steps, {:.2} and {:.2} with {} (a gain: below 0.95). A GP stays below the fitted analytical \
         model {} (measured) and {} (simulated).",
        ratio(measured, 0),
        ratio(simulated, 0),
        COUNTS[0],
        ratio(measured, LAST),
        ratio(simulated, LAST),
        COUNTS[LAST],
        overtakes(measured),
        overtakes(simulated),
    )
}

fn parameters(measured: &Described, simulated: &Described) -> String {
    let [c, c_simulated] =
        [measured, simulated].map(|data| data.length.value / data.uniform_length);
    let relative = |data: &Described| data.length.se / data.uniform_length;
    let differ = |a: f64, b: f64, se: f64| (a - b).abs() > SURE * se;
    let lengths = differ(c, c_simulated, relative(measured).hypot(relative(simulated)));
    let [friction, simulated_friction] = [&measured.friction, &simulated.friction];
    let se = friction.se.hypot(simulated_friction.se);
    let frictions = differ(friction.value, simulated_friction.value, se);
    let headline = match (lengths, frictions) {
        (true, true) => "Neither c nor the friction of the tip is the same",
        (true, false) => "The friction of the tip is the same, c is not",
        (false, true) => "c is the same, the friction of the tip is not",
        (false, false) => "c and the friction of the tip are the same",
    };
    let off = |ratio: f64| format!("{:+.1}", 100.0 * (ratio - 1.0));
    let percent = |se: f64| format!("{:.1}", 100.0 * se);
    format!(
        "**{headline}**, within 1.96 standard errors. The fitted c is {} ± {} % off that of uniform \
         pressure on the measured table and {} ± {} % on the simulated one. The fitted \
         friction of the tip is {:.3} ± {:.3} measured and {:.3} ± {:.3} simulated; nominal are \
         {:.2} and {:.2}.",
        off(c),
        percent(relative(measured)),
        off(c_simulated),
        percent(relative(simulated)),
        friction.value,
        friction.se,
        simulated_friction.value,
        simulated_friction.se,
        measured.nominal_friction,
        simulated.nominal_friction,
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

/// A vector output by output, in words.
fn spread(vector: &Vector3<f64>) -> String {
    let of = |k: usize| {
        let (_, unit, scale) = OUTPUTS[k];
        format!("{:.2}{}{unit}", scale * vector[k], if unit == "°" { "" } else { " " })
    };
    format!("{}, {} and {}", of(0), of(1), of(2))
}

#[cfg(test)]
mod tests {
    use models::Estimate;
    use nalgebra::Vector3;

    use super::{Cell, Described, in_words};

    fn estimate(value: f64, se: f64) -> Estimate {
        Estimate { value, se, source: "fit".into() }
    }

    /// A table in numbers like those of a rig with little scatter, times a factor.
    fn described(name: &'static str, factor: f64) -> Described {
        Described {
            name,
            n_steps: 1000,
            quantiles: [[0.0; 5]; 3],
            neighbor_sd: [0.03, 0.03, 0.05].map(|sd| factor * sd),
            scatter_nmse: 0.001 * factor,
            nominal_friction: 0.25,
            nominal_nmse: 0.014 * factor,
            fitted_nmse: 0.007 * factor,
            gp_nmse: [0.04, 0.014, 0.006, 0.003, 0.0016].map(|nmse| factor * nmse),
            hybrid_nmse: [0.006, 0.003, 0.002, 0.0014, 0.0012].map(|nmse| factor * nmse),
            friction: estimate(0.25, 0.002),
            length: estimate(0.0345, 0.0002),
            uniform_length: 0.0344,
        }
    }

    /// Cells with a measured pattern over β, and the simulated means that `simulated` makes of it.
    fn cells(simulated: impl Fn(Vector3<f64>) -> Vector3<f64>) -> Vec<Cell> {
        let cell = |k: usize| {
            let beta = -75.0 + 30.0 * (k % 5) as f64;
            let mean = Vector3::new(0.0034 - 4e-5 * beta.abs(), -2e-5 * beta, 5e-4 * beta);
            let sd = Vector3::repeat(1e-4);
            Cell { p: 0.2, beta, n: [20, 20], mean: [mean, simulated(mean)], sd: [sd, sd] }
        };
        (0..10).map(cell).collect()
    }

    fn words(measured: Described, cells: &[Cell]) -> String {
        let text = in_words(&[measured, described("simulated", 1.0)], cells);
        text.split_whitespace().collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn a_rig_that_is_alike_but_scatters_is_told_as_such() {
        let text = words(described("measured", 4.0), &cells(|mean| 1.05 * mean));
        for sentence in [
            "**The same mechanics.**",
            "no measured mean that is larger",
            "**The real rig scatters far more.** Steps that begin alike differ 4.0, 4.0 and 4.0",
            "**Every model looks better on simulated steps.**",
            "is 4.0 to 4.0 times",
            "**No model errs less than the scatter.**",
            "**The mechanics save steps on both tables.**",
            "from 100 steps on (measured) and from 100 steps on (simulated)",
            "**c and the friction of the tip are the same**",
        ] {
            assert!(text.contains(sentence), "{sentence}: {text}");
        }
    }

    #[test]
    fn other_patterns_are_not_the_same_mechanics() {
        let says = |simulated: fn(Vector3<f64>) -> Vector3<f64>, sentence: &str| {
            let text = words(described("measured", 4.0), &cells(simulated));
            assert!(!text.contains("The same mechanics") && text.contains(sentence), "{text}");
        };
        says(|mean| Vector3::new(mean.x, mean.y, 0.5 * mean.z), "**Not the same mechanics.**");
        says(|mean| Vector3::new(mean.x, mean.y, 0.5 * mean.z), "in Δθ not less than a third");
        says(|mean| mean + Vector3::new(0.0, 0.002, 0.0), "in Δy not less than a third");
        says(|mean| Vector3::new(mean.x, -mean.y, mean.z), "6 measured means");
        let text = words(described("measured", 4.0), &cells(|mean| mean)[..4]);
        assert!(text.contains("**Too few cells.**") && !text.contains("mechanics."), "{text}");
    }

    #[test]
    fn a_rig_that_scatters_less_or_errs_less_is_not_told_to_do_more() {
        let same = cells(|mean| mean);
        let text = words(described("measured", 0.5), &same);
        assert!(text.contains("**The real rig scatters less.**"), "{text}");
        assert!(text.contains("**Every model looks worse on simulated steps.**"), "{text}");
        let text = words(described("measured", 1.0), &same);
        assert!(text.contains("**Both rigs scatter alike.**"), "{text}");
        assert!(text.contains("**Not every model looks better on simulated steps.**"), "{text}");
        let mut mixed = described("measured", 4.0);
        mixed.neighbor_sd[1] = 0.01;
        mixed.gp_nmse[0] = 0.03;
        let text = words(mixed, &same);
        assert!(text.contains("**Which rig scatters more depends on the output.**"), "{text}");
        assert!(text.contains("**Not every model looks better on simulated steps.**"), "{text}");
        let silent = Described { neighbor_sd: [0.0; 3], ..described("measured", 1.0) };
        let both = [silent, Described { neighbor_sd: [0.0; 3], ..described("simulated", 1.0) }];
        assert!(in_words(&both, &same).contains("**Scatter cannot be compared.**"));
    }

    #[test]
    fn a_model_below_the_scatter_and_a_hybrid_that_does_not_gain_are_told() {
        let same = cells(|mean| mean);
        let low = Described { scatter_nmse: 0.01, ..described("measured", 4.0) };
        let text = words(low, &same);
        assert!(text.contains("**Some models err less than the scatter on measured"), "{text}");
        let mut level = described("measured", 4.0);
        level.hybrid_nmse[4] = level.gp_nmse[4];
        let text = words(level, &same);
        let sentence = "**The mechanics save steps on both tables, and in the end on the simulated \
                        table alone.**";
        assert!(text.contains(sentence), "{text}");
        let mut useless = described("measured", 4.0);
        useless.hybrid_nmse = useless.gp_nmse;
        useless.gp_nmse[4] = 1.0;
        let text = words(useless, &same);
        assert!(text.contains("on the simulated table alone"), "{text}");
        assert!(text.contains("with none up to 500 (measured)"), "{text}");
    }

    #[test]
    fn parameters_are_different_beyond_their_errors_alone() {
        let same = cells(|mean| mean);
        let with = |length: f64, friction: f64| Described {
            length: estimate(length, 0.0002),
            friction: estimate(friction, 0.002),
            ..described("measured", 4.0)
        };
        for (length, friction, headline) in [
            (0.0349, 0.251, "c and the friction of the tip are the same"),
            (0.0306, 0.251, "The friction of the tip is the same, c is not"),
            (0.0345, 0.215, "c is the same, the friction of the tip is not"),
            (0.0306, 0.215, "Neither c nor the friction of the tip is the same"),
        ] {
            let text = words(with(length, friction), &same);
            assert!(text.contains(&format!("**{headline}**")), "{text}");
        }
    }
}
