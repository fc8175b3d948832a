//! Figure M.10: a diagnosis at a glance, for the project's README.

use anyhow::{Context, Result};
use report::Figure;

use super::error_falls::{added, all_channels};
use super::which_effect::{Pair, Rows};
use crate::figures::inputs::Inputs;
use crate::figures::sketch::Sketch;

pub(crate) fn draw(inputs: &Inputs) -> Result<Sketch> {
    let study = inputs.study()?;
    let [.., without, with] = study.stages.as_slice() else {
        anyhow::bail!("no effect is identified");
    };
    let pair = Pair::of(study, without, with)?.context("no map has enough pushes a cell")?;
    let errors = all_channels(study)?;
    let figure = Figure::new(1, 3)
        .panel_size(400.0, 320.0)
        .with(pair.panel(1, with))
        .with(pair.panel(0, with))
        .with(errors.panel());
    let mut rows = Rows::default();
    pair.note(with, &mut rows);
    for (stage, bar) in study.stages.iter().zip(&errors.bars) {
        rows.push(stage, "rms_over_noise", "", "", bar.rms, bar.se);
    }
    let caption = format!(
        "{} simulated pushes; the diagnosis says: {} (a) What the model without the last effect misses. \
         (b) What that effect changes, as fitted, in the same colors. (c) Error on {} held-out pushes of \
         the nominal model and with each effect ({}); whiskers are one standard error, the dashed line \
         is the noise.",
        study.observations.pushes().len(),
        study.sentence,
        study.aside.pushes().len(),
        added(study),
    );
    let alt = "Two maps over yaw and push direction, of what the model misses and of what the effect \
               changes, in the same colors, and bars of an error that falls to its noise.";
    Ok(Sketch::new(figure, rows.table(), &caption, alt))
}
