//! `cargo xtask effects-atlas`: what each effect does to a push, as docs/effects.md and its figures,
//! and the names of effects and limit surfaces in docs/model.schema.json.

mod page;
mod schema;
mod signature;

use std::fs;

use anyhow::{Context, Result};
use effects::all;

use fixtures::workspace_root;

/// Draw each effect's signature into docs/effects, write docs/effects.md, and list the names in
/// docs/model.schema.json.
#[derive(clap::Args)]
pub struct Args {
    /// Draw only these effects, by id
    #[arg(long, value_delimiter = ',', value_name = "ID")]
    only: Vec<String>,
}

/// Writes the page, one figure for each effect, and the schema's names.
///
/// # Errors
/// An unknown id, a push that cannot be predicted, or a file that cannot be written, by its name.
pub fn run(args: &Args) -> Result<()> {
    let docs = workspace_root().join("docs");
    let folder = docs.join("effects");
    fs::create_dir_all(&folder).with_context(|| format!("cannot create {}", folder.display()))?;
    let chosen: Vec<_> = match args.only.as_slice() {
        [] => all().iter().collect(),
        ids => ids.iter().map(|id| effects::by_id(id)).collect::<Result<_, _>>()?,
    };
    for effect in chosen {
        let id = effect.info().id;
        let svg = signature::figure(effect).with_context(|| format!("effect `{id}`"))?.svg()?;
        let path = folder.join(format!("{id}.svg"));
        output::write(&path, &svg)?;
        println!("{} ({} kB)", path.display(), svg.len() / 1000);
    }
    output::write(&docs.join("effects.md"), page::text())?;
    let path = docs.join(SCHEMA);
    let text =
        fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
    Ok(output::write(&path, schema::with_names(&text)?)?)
}

const SCHEMA: &str = "model.schema.json";

#[cfg(test)]
mod tests {
    use std::fs;

    use super::{SCHEMA, page, schema};
    use fixtures::workspace_root;

    #[test]
    fn the_page_says_what_the_effects_say_of_themselves() {
        let text = fs::read_to_string(workspace_root().join("docs/effects.md")).unwrap();
        assert!(text == page::text(), "make docs/effects.md anew: cargo xtask effects-atlas");
    }

    #[test]
    fn the_schema_names_the_effects_and_surfaces_that_there_are() {
        let text = fs::read_to_string(workspace_root().join("docs").join(SCHEMA)).unwrap();
        let named = schema::with_names(&text).unwrap();
        assert!(text == named, "make docs/{SCHEMA} anew: cargo xtask effects-atlas");
    }
}
