//! The same pushes by the diagnosis alone: what it claims of each half, and the error with that on the other.

use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};
use diagnosis::{DiagnoseSettings, diagnose};
use planar::MIT_NAMES;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use super::folds::folds;
use super::pushes::{Error, errors, pushes};
use crate::real_comparison::page::claimed;

/// What the diagnoses of an object's halves lead to.
pub(in crate::real_comparison) struct Diagnosed {
    name: String,
    /// Of each push, without and with what was claimed of the other half.
    before: Vec<Error>,
    after: Vec<Error>,
    /// What was claimed of each half.
    claims: Vec<String>,
}

/// Diagnoses two halves of the pushes of every object in a file of end points.
///
/// # Errors
/// A file that cannot be read; a diagnosis that fails; a model that cannot predict an object's pushes.
pub(in crate::real_comparison) fn diagnosed(path: &Path) -> Result<Vec<Diagnosed>> {
    MIT_NAMES.par_iter().map(|name| of(path, name).with_context(|| name.to_string())).collect()
}

fn of(path: &Path, name: &str) -> Result<Diagnosed> {
    let (all, nominal) = pushes(path, name)?;
    let started = Instant::now();
    let (mut before, mut after, mut claims) = (Vec::new(), Vec::new(), Vec::new());
    for (half, other) in folds(&all)? {
        let found = diagnose(&half, &nominal, &DiagnoseSettings::default())?;
        before.extend(errors(&nominal, &other)?);
        after.extend(errors(&found.description, &other)?);
        claims.push(claimed(&found.diagnosis));
    }
    println!("{name}: two halves diagnosed in {} s", started.elapsed().as_secs());
    Ok(Diagnosed { name: name.to_owned(), before, after, claims })
}

/// The section of the page.
pub(in crate::real_comparison) fn diagnosed_text(shapes: &[Diagnosed]) -> String {
    let mean = |of: &[Error]| Error::mean(of.iter().copied());
    let mut page = HEAD.to_owned();
    for Diagnosed { name, before, after, claims } in shapes {
        let (n_pushes, claims) = (before.len(), claims.join(" | "));
        page +=
            &format!("| {name} ({n_pushes}) | {} | {} | {claims} |\n", mean(before), mean(after));
    }
    let of_shapes =
        |of: fn(&Diagnosed) -> &[Error]| Error::mean(shapes.iter().map(|shape| mean(of(shape))));
    let (before, after) = (of_shapes(|shape| &shape.before), of_shapes(|shape| &shape.after));
    page + &format!("| mean of the objects | {before} | {after} | | |\n")
}

const HEAD: &str = "
## Long pushes of every shape by the diagnosis alone

The pushes of the section above, dealt to two halves in turn. Each half is diagnosed from the nominal model, as by
`pushlab diagnose`, and the mean error with all that it claims is taken on the other half. **Bold** is what
is identified; of the rest the error falls with it, though the cause may be another.

```text
cargo xtask real-comparison --data DIR --only diagnosed-shapes
```

| object (pushes) | nominal | with what is claimed | of one half | of the other |
|---|---|---|---|---|
";
