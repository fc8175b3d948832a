//! A crate that is useful alone compiles nothing of plotting and file formats.

use super::Rule;
use super::project::{Finding, LIGHT, Project};

pub(super) const RULE: Rule = Rule {
    name: "crate-weight",
    demand: "light crates pull in nothing of plotting and file formats",
    check,
};

/// Packages that no light crate may pull in, by how their names begin.
const HEAVY: &[&str] = &["kuva", "mcap", "parquet", "arrow", "hdf5", "prost", "rosbag"];

fn check(project: &Project) -> Vec<Finding> {
    let light = project.crates().iter().filter(|member| LIGHT.contains(&member.name.as_str()));
    let pairs =
        light.flat_map(|member| member.pulls_in.iter().map(move |package| (member, package)));
    let heavy = pairs.filter(|(_, package)| HEAVY.iter().any(|name| package.starts_with(name)));
    heavy
        .map(|(member, package)| {
            let fault = format!("importing `{}` alone compiles `{package}`", member.name);
            let remedy = format!("see `cargo tree -p pushlab-{} -i {package}`", member.name);
            Finding::new(&member.manifest(), 1, fault, remedy)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::project::{Crate, Finding, Project};
    use super::check;

    fn findings(name: &str, pulls_in: &[&str]) -> Vec<Finding> {
        let pulls_in = pulls_in.iter().map(|&package| package.into()).collect();
        let folder = format!("crates/{name}");
        let member = Crate { name: name.into(), folder, pulls_in, ..Crate::default() };
        check(&Project::in_memory(&[]).with_crates(vec![member]))
    }

    #[test]
    fn a_file_format_under_a_light_crate_is_found() {
        assert_eq!(
            findings("gp-core", &["faer", "hdf5-pure"])[0].message("r"),
            "crates/gp-core/Cargo.toml:1: r: importing `gp-core` alone compiles `hdf5-pure`; \
             see `cargo tree -p pushlab-gp-core -i hdf5-pure`"
        );
    }

    #[test]
    fn algebra_under_a_light_crate_is_fine() {
        assert_eq!(findings("mechanics", &["nalgebra", "planar"]), []);
    }
}
