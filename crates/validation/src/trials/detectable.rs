//! The smallest detectable sizes that the tool tells, beside those of the oracle.

use effects::by_id;

use super::case::{Asked, Family, Sessions, Setup};
use super::oracle::Oracle;
use super::record::Record;
use super::truth::TrueEffect;

/// One effect's sizes, as shares of its typical departure from "off".
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Detectable {
    pub(super) id: &'static str,
    /// Median over sets where nothing is hidden.
    pub(super) told: f64,
    pub(super) oracle: f64,
}

/// Of every effect that sets without a hidden effect bound.
pub(super) fn detectable(records: &[Record], oracle: &Oracle) -> Vec<Detectable> {
    let catalogue = effects::tested().iter().map(|effect| effect.info().id);
    catalogue.filter_map(|id| of(id, records, oracle)).collect()
}

fn of(id: &'static str, records: &[Record], oracle: &Oracle) -> Option<Detectable> {
    let nothing = records.iter().filter(|record| record.family == Family::Nothing);
    let mut pairs: Vec<(f64, f64)> = nothing
        .filter_map(|record| {
            // What the pushes of one session share is in them, and may be found, whatever it comes from.
            let sessions = match record.setup.sessions {
                Sessions::One => Sessions::Alike,
                sessions => sessions,
            };
            let sizes = oracle.sizes(id, &Setup { sessions, ..record.setup }).ok()?;
            Some((told(id, record)?, sizes.detectable))
        })
        .collect();
    pairs.sort_by(|a, b| (a.0 / a.1).total_cmp(&(b.0 / b.1)));
    let (told, oracle) = *pairs.get(pairs.len() / 2)?;
    Some(Detectable { id, told, oracle })
}

/// Along the typical departure, from the sizes along each coordinate.
fn told(id: &str, record: &Record) -> Option<f64> {
    let told = record.outcome.answer()?.told(id)?;
    let typical = coordinates(id, 1.0)?;
    let off = coordinates(id, 0.0)?;
    let mut inverse_square = 0.0;
    for ((on, off), parameter) in typical.iter().zip(&off).zip(&told.parameters) {
        if on != off {
            inverse_square += ((on - off) / parameter.detection_limit?).powi(2);
        }
    }
    (inverse_square > 0.0).then(|| inverse_square.sqrt().recip())
}

/// The catalogue's coordinates of a hidden effect at a share of its typical size.
fn coordinates(id: &str, share: f64) -> Option<Vec<f64>> {
    let effect = by_id(id).ok()?;
    let asked = Asked::typical(effect.info().id);
    let values = asked.hidden(share).ok()?.values;
    let values = values.into_iter().map(|(name, value)| (name.to_owned(), value)).collect();
    let parameters = TrueEffect { id: id.to_owned(), values }.parameters();
    let mut values: Vec<f64> = parameters.iter().map(|(_, value)| *value).collect();
    if id == "pusher-compliance" {
        // A stiff arm has some: the catalogue's departure is from the nuisance's size.
        values[0] -= 2e-5;
    }
    Some(effect.info().to_coordinates(&values))
}
