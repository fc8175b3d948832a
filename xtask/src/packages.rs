//! What cargo knows of the workspace's packages.
//!
//! Read as plain JSON: with derived types, a check of the sources would wait nearly twice as long for its compiler.

use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use serde_json::Value;

use crate::cargo::{cargo, output};

/// A member of the workspace, as `cargo metadata` describes it.
pub(crate) struct Package(Value);

/// A library, program or test of a package, as `cargo metadata` and cargo's messages describe it.
pub(crate) struct Target<'a>(pub(crate) &'a Value);

/// The members of the workspace.
///
/// # Errors
/// If cargo fails, or prints no metadata.
pub(crate) fn packages() -> Result<Vec<Package>> {
    let text = output(&mut cargo(&["metadata", "--no-deps", "--format-version", "1"]))?;
    read(&text).context("cannot read cargo metadata")
}

fn read(text: &str) -> Result<Vec<Package>> {
    let mut metadata: Value = serde_json::from_str(text)?;
    let packages = metadata.get_mut("packages").map(Value::take);
    let Some(Value::Array(packages)) = packages else { bail!("it lists no packages") };
    ensure!(!packages.is_empty(), "its list of packages is empty");
    Ok(packages.into_iter().map(Package).collect())
}

impl Package {
    pub(crate) fn name(&self) -> &str {
        text(&self.0["name"])
    }

    /// Absolute path of its manifest.
    pub(crate) fn manifest(&self) -> &Path {
        Path::new(text(&self.0["manifest_path"]))
    }

    pub(crate) fn targets(&self) -> impl Iterator<Item = Target<'_>> {
        list(&self.0["targets"]).iter().map(Target)
    }

    /// Names of the packages that it depends on, in any dependency table.
    pub(crate) fn dependencies(&self) -> impl Iterator<Item = &str> {
        list(&self.0["dependencies"]).iter().map(|dependency| text(&dependency["name"]))
    }

    /// Whether its manifest leaves a key unset, or empty.
    pub(crate) fn is_unset(&self, key: &str) -> bool {
        let value = &self.0[key];
        value.is_null() || value.as_array().is_some_and(Vec::is_empty)
    }

    /// A package with an empty list of registries is published nowhere.
    pub(crate) fn is_published(&self) -> bool {
        !self.0["publish"].as_array().is_some_and(Vec::is_empty)
    }
}

impl<'a> Target<'a> {
    /// Absolute path of its root file.
    pub(crate) fn root(&self) -> &'a Path {
        Path::new(text(&self.0["src_path"]))
    }

    /// Whether it is of a kind, such as `lib`, `bin` or `test`.
    pub(crate) fn is(&self, kind: &str) -> bool {
        list(&self.0["kind"]).iter().any(|own| own == kind)
    }

    pub(crate) fn has_doctests(&self) -> bool {
        self.0["doctest"] == true
    }
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

#[cfg(test)]
mod tests {
    use super::{packages, read};

    #[test]
    fn members_are_told_with_what_they_are_made_of() {
        let packages = packages().unwrap();
        let named = |name: &str| packages.iter().find(|package| package.name() == name).unwrap();
        let (planar, xtask) = (named("pushlab-planar"), named("xtask"));
        assert!(planar.is_published() && !xtask.is_published());
        assert!(planar.manifest().ends_with("crates/planar/Cargo.toml"));
        assert!(planar.targets().any(|target| target.is("lib") && target.has_doctests()));
        assert!(xtask.targets().all(|target| target.is("bin") && !target.has_doctests()));
        assert!(xtask.targets().any(|target| target.root().ends_with("xtask/src/main.rs")));
        assert!(xtask.dependencies().any(|name| name == "clap"));
        assert!(!planar.is_unset("keywords") && xtask.is_unset("keywords"));
        assert!(!planar.is_unset("rust_version") && xtask.is_unset("categories"));
    }

    /// Rules would hold on a workspace of nothing.
    #[test]
    fn metadata_without_packages_is_an_error() {
        for text in ["", "{}", r#"{"packages": null}"#, r#"{"packages": []}"#, "[1]"] {
            assert!(read(text).is_err(), "{text}");
        }
    }
}
