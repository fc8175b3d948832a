//! What dependencies may be: permissively licensed, and each in one version.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::{Context, Result, bail};
use spdx::{Expression, LicenseReq, ParseMode};

use crate::cargo::{cargo, output};

/// Permissive licenses, which go with ours.
const ALLOWED: [&str; 7] =
    ["Apache-2.0", "BSD-2-Clause", "BSD-3-Clause", "MIT", "Unicode-3.0", "Zlib", "bzip2-1.0.6"];

/// Older versions that a dependency of ours still asks for, with the one that does.
const OLDER: [(&str, &str, &str); 9] = [
    ("cpufeatures", "0.2", "sha2 0.10"),
    ("equator", "0.2", "faer"),
    ("equator-macro", "0.2", "faer"),
    ("equator", "0.4", "faer"),
    ("equator-macro", "0.4", "faer"),
    ("getrandom", "0.3", "ahash of parquet"),
    ("miniz_oxide", "0.8", "png"),
    ("syn", "1", "a macro that builds private-gemm-x86 of faer"),
    ("syn", "2", "derive macros that have not moved on"),
];

/// A package of others.
struct Dependency {
    name: String,
    version: String,
    license: String,
}

/// What stands between a package and its license.
const BETWEEN: &str = " | ";

/// Checks all that is compiled on Linux, with all features.
///
/// # Errors
/// Every dependency whose license is not allowed, or that is there in a version too many.
pub(crate) fn run() -> Result<()> {
    let mut tree = cargo(&["tree", "--workspace", "--all-features", "--no-dedupe"]);
    tree.args(["--target", "x86_64-unknown-linux-gnu", "--prefix", "none"]);
    tree.args(["--format", &format!("{{p}}{BETWEEN}{{l}}")]);
    let found = dependencies(&output(&mut tree)?)?;
    let complaints = complaints(&found);
    if complaints.is_empty() {
        println!("{} dependencies, all permissive and in one version", found.len());
        return Ok(());
    }
    bail!("{}", complaints.join("\n"))
}

/// Each package of others once, from lines such as `libm v0.2.1 (proc-macro) | MIT`; ours have a path.
fn dependencies(tree: &str) -> Result<Vec<Dependency>> {
    let lines: BTreeSet<&str> = tree.lines().filter(|line| !line.is_empty()).collect();
    let of_others = lines.into_iter().filter(|line| !line.contains(" (/"));
    let dependency = |line: &str| {
        let (package, license) = line.split_once(BETWEEN)?;
        let mut words = package.split(' ');
        let (name, version) = (words.next()?, words.next()?.strip_prefix('v')?);
        Some(Dependency { name: name.into(), version: version.into(), license: license.into() })
    };
    of_others
        .map(|line| dependency(line).with_context(|| format!("no package is told by `{line}`")))
        .collect()
}

fn complaints(dependencies: &[Dependency]) -> Vec<String> {
    let mut complaints = Vec::new();
    let mut versions: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for Dependency { name, version, license } in dependencies {
        if !is_allowed(license) {
            complaints.push(format!(
                "{name} {version}: its license, {license}, is not among {ALLOWED:?}"
            ));
        }
        let is_known = OLDER.iter().any(|(known, start, _)| {
            known == name && version.strip_prefix(start).is_some_and(|rest| rest.starts_with('.'))
        });
        if !is_known {
            versions.entry(name).or_default().push(version);
        }
    }
    let several = versions.iter().filter(|(_, versions)| versions.len() > 1);
    complaints.extend(several.map(|(name, versions)| {
        format!(
            "{name} is there in {}: use one, or name the older in `OLDER`",
            versions.join(" and ")
        )
    }));
    complaints
}

/// Whether the terms can be met by allowed licenses alone. An exception permits more than its license does.
fn is_allowed(license: &str) -> bool {
    let is_allowed =
        |required: &LicenseReq| required.license.id().is_some_and(|id| ALLOWED.contains(&id.name));
    Expression::parse_mode(license, ParseMode::LAX).is_ok_and(|terms| terms.evaluate(is_allowed))
}

#[cfg(test)]
mod tests {
    use super::{complaints, dependencies, is_allowed};

    #[test]
    fn terms_are_met_by_allowed_licenses_alone() {
        for terms in [
            "MIT",
            "MIT OR GPL-3.0-only",
            "MIT/Apache-2.0",
            "(MIT OR Apache-2.0) AND Unicode-3.0",
            "Apache-2.0 WITH LLVM-exception",
        ] {
            assert!(is_allowed(terms), "{terms}");
        }
        for terms in ["GPL-3.0-only", "MIT AND MPL-2.0", "none", ""] {
            assert!(!is_allowed(terms), "{terms}");
        }
    }

    #[test]
    fn a_license_and_a_version_too_many_are_named_and_packages_of_ours_are_not() {
        let tree = "ours v0.1.0 (/ours) | MIT\na v1.0.0 | MIT\na v2.0.0 | MIT\nsyn v1.0.9 | MIT\n\n\
                    syn v3.0.1 (proc-macro) | MIT\nb v1.0.0 | AGPL-3.0-only\na v1.0.0 | MIT\n";
        let found = dependencies(tree).unwrap();
        let said = complaints(&found);
        assert_eq!(found.len(), 5);
        assert_eq!(said.len(), 2);
        assert!(
            said[0].starts_with("b 1.0.0: its license, AGPL-3.0-only, is not among"),
            "{said:?}"
        );
        assert!(said[1].starts_with("a is there in 1.0.0 and 2.0.0"), "{said:?}");
        assert!(dependencies("a 1.0.0").is_err());
    }
}
