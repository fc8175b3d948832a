//! Limit surfaces fitted to measured wrench–twist pairs: how well each kind explains them.

use std::{collections::BTreeMap, path::Path};

use anyhow::{Context, Result};
use dataset::read_wrench_twists;
use mechanics::{
    Ellipsoid, Fit, LimitSurface, Patch, Quartic, WrenchTwist, fit_ellipsoid, fit_quartic, scored,
};
use planar::{Shape, mit_object};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use serde_json::{Map, Value, json};

use super::Section;
use super::row::{Reference, Row};

/// The surfaces of one object, fitted to its pairs.
pub(super) struct ObjectFits {
    pub(super) name: String,
    pub(super) n_pairs: usize,
    /// Uniform pressure, with the force that fits best: what is known without the pairs.
    pub(super) uniform: Fit<Patch>,
    pub(super) ellipsoid: Fit<Ellipsoid>,
    pub(super) quartic: Fit<Quartic>,
}

/// Fits all objects of a file of pairs, in the frame B of each, in order of their names.
pub(super) fn fits(path: &Path) -> Result<Vec<ObjectFits>> {
    let mut by_shape: BTreeMap<String, (f64, Vec<WrenchTwist>)> = BTreeMap::new();
    for row in read_wrench_twists(path)? {
        let pair = WrenchTwist { wrench: row.wrench, twist: row.twist };
        let entry = by_shape.entry(row.shape).or_insert((row.characteristic_length, Vec::new()));
        entry.1.push(pair);
    }
    let objects: Vec<_> = by_shape.into_iter().collect();
    objects
        .par_iter()
        .map(|(name, (length, pairs))| {
            fit(name, *length, pairs).with_context(|| format!("{}: {name}", path.display()))
        })
        .collect()
}

fn fit(name: &str, length: f64, pairs: &[WrenchTwist]) -> Result<ObjectFits> {
    let shape = mit_object(name)?.shape;
    Ok(ObjectFits {
        name: name.to_owned(),
        n_pairs: pairs.len(),
        uniform: uniform(&shape, length, pairs)?,
        ellipsoid: fit_ellipsoid(pairs, length)?,
        quartic: fit_quartic(pairs, length)?,
    })
}

/// Uniform pressure with its one free parameter, the force, by least squares.
fn uniform(shape: &Shape, length: f64, pairs: &[WrenchTwist]) -> Result<Fit<Patch>> {
    let unit = Patch::uniform(shape, 1.0)?;
    let (mut product, mut square) = (0.0, 0.0);
    for pair in pairs {
        let load = unit.wrench(&pair.twist)?;
        let moments = load.torque * pair.wrench.torque / (length * length);
        product += load.force.dot(&pair.wrench.force) + moments;
        square += load.force.norm_squared() + (load.torque / length).powi(2);
    }
    Ok(scored(Patch::uniform(shape, product / square)?, pairs, length, 0)?)
}

/// Force and twist errors of each kind, by object and averaged over the objects.
pub(super) fn section(fits: &[ObjectFits]) -> Section {
    let (mut rows, mut by_shape) = (Vec::new(), Map::new());
    let mut means: BTreeMap<&str, (f64, f64)> = BTreeMap::new();
    for object in fits {
        let mut entry = Map::from_iter([("pairs".to_owned(), json!(object.n_pairs))]);
        for (kind, force, twist) in object.errors() {
            let degrees = twist.to_degrees();
            let name = format!("pairs, {}, {kind}", object.name);
            rows.push(Row::new(format!("{name}: force error in N"), force, Reference::None));
            rows.push(Row::new(format!("{name}: twist error in deg"), degrees, Reference::None));
            entry.insert(kind.to_owned(), errors_json(force, degrees));
            let mean = means.entry(kind).or_default();
            *mean = (mean.0 + force / fits.len() as f64, mean.1 + degrees / fits.len() as f64);
        }
        by_shape.insert(object.name.clone(), Value::Object(entry));
    }
    let mut json_means = Map::new();
    for (kind, (force, degrees)) in means {
        let name = format!("pairs, mean of shapes, {kind}");
        rows.push(Row::new(format!("{name}: force error in N"), force, Reference::None));
        rows.push(Row::new(format!("{name}: twist error in deg"), degrees, Reference::None));
        json_means.insert(kind.to_owned(), errors_json(force, degrees));
    }
    let json = json!({ "by_shape": by_shape, "mean_of_shapes": json_means });
    Section { json: Map::from_iter([("limit_surface_fits".to_owned(), json)]), rows }
}

impl ObjectFits {
    /// Kind, root mean square of the force error in N, mean of the twist error in rad.
    fn errors(&self) -> [(&'static str, f64, f64); 3] {
        fn pair<S>(fit: &Fit<S>) -> (f64, f64) {
            (fit.force_error_rms, fit.twist_error_mean)
        }
        [
            ("uniform", pair(&self.uniform)),
            ("ellipsoid", pair(&self.ellipsoid)),
            ("quartic", pair(&self.quartic)),
        ]
        .map(|(kind, (force, twist))| (kind, force, twist))
    }
}

fn errors_json(force: f64, degrees: f64) -> Value {
    json!({ "force_error_n_rms": force, "twist_error_deg_mean": degrees })
}
