//! Inside, quantities are in SI units and have no suffix.

use super::Rule;
use super::project::{Finding, Project, RustFile};

pub(super) const RULE: Rule = Rule {
    name: "unit-suffix",
    demand: "units other than SI stay at the edges, where files and people are",
    check,
};

/// Crates at the edges.
const EDGES: &[&str] = &[
    "dataset",
    "report",
    "pushlab",
    "fixtures",
    "studies",
    "validation",
    "fuzzing",
    "benchmarks",
    "xtask",
];

/// Endings of names that are not in SI units.
const SUFFIXES: &[&str] =
    &["_mm", "_cm", "_um", "_mm_s", "_cm_s", "_deg", "_deg_s", "_ms", "_us", "_ns", "_g", "_nmm"];

fn check(project: &Project) -> Vec<Finding> {
    let inner = project.rust_files().iter().filter(|file| !EDGES.contains(&file.crate_name()));
    inner.flat_map(check_file).collect()
}

fn check_file(file: &RustFile) -> Vec<Finding> {
    let finding = |(line, word): (usize, &str)| {
        let lower = word.to_ascii_lowercase();
        let suffix = SUFFIXES.iter().find(|suffix| lower.ends_with(*suffix))?;
        let fault = format!("`{word}` ends in `{suffix}`, which is not an SI unit");
        Some(Finding::new(&file.path, line, fault, "convert at the edge and drop the suffix"))
    };
    file.words().filter_map(finding).collect()
}

#[cfg(test)]
mod tests {
    use super::super::project::{Finding, Project};
    use super::check;

    fn findings(path: &str, text: &str) -> Vec<Finding> {
        check(&Project::in_memory(&[(path, text)]))
    }

    #[test]
    fn a_millimetre_inside_is_found() {
        assert_eq!(
            findings("crates/planar/src/a.rs", "//! A.\nlet side_mm = 90.0;\n")[0].message("r"),
            "crates/planar/src/a.rs:2: r: `side_mm` ends in `_mm`, which is not an SI unit; \
             convert at the edge and drop the suffix"
        );
        assert_eq!(findings("crates/mechanics/tests/a.rs", "const STEP_MS: f64 = 1.0;").len(), 1);
    }

    #[test]
    fn edges_text_and_frames_are_fine() {
        let code = "let side_mm = angle_deg;";
        assert_eq!(findings("crates/dataset/src/a.rs", code), []);
        assert_eq!(findings("xtask/src/a.rs", code), []);
        let code = "let pose_wg = twist_ws_s; // side_mm\nlet (error_rms, n) = f(\"x_mm\");";
        assert_eq!(findings("crates/planar/src/a.rs", code), []);
    }
}
