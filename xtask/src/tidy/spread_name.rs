//! A spread is named a variance or a standard deviation.

use super::Rule;
use super::project::{Finding, Project, RustFile};

pub(super) const RULE: Rule = Rule {
    name: "spread-name",
    demand: "a spread is named `_variance` or `_sd`, never a bare `sigma`",
    check,
};

fn check(project: &Project) -> Vec<Finding> {
    let words =
        project.rust_files().iter().flat_map(|file| file.words().map(move |word| (file, word)));
    let finding = |(file, (line, word)): (&RustFile, (usize, &str))| {
        let fault = format!("`{word}` leaves open whether it is squared");
        Finding::new(&file.path, line, fault, "end the name in `_variance` or `_sd`")
    };
    words.filter(|(_, (_, word))| is_ambiguous(word)).map(finding).collect()
}

/// `sigma` with nothing but an index: `sigma`, `sigma_n`, `noise_sigma`, `sigma2`; not `sigma_points`.
fn is_ambiguous(word: &str) -> bool {
    let lower = word.to_ascii_lowercase();
    let Some((_, index)) = lower.rsplit_once("sigma") else { return false };
    let index =
        index.trim_start_matches('_').trim_end_matches(|digit: char| digit.is_ascii_digit());
    let begins_a_word = lower.starts_with("sigma") || lower.contains("_sigma");
    begins_a_word && (index.len() <= 1 || index == "sq" || index == "squared")
}

#[cfg(test)]
mod tests {
    use super::super::project::Project;
    use super::check;

    #[test]
    fn every_bare_sigma_is_found() {
        for name in ["sigma", "SIGMA", "sigma_n", "sigma2", "noise_sigma", "sigma_sq"] {
            let code = format!("//! A.\nlet {name} = 1.0;\n");
            let findings = check(&Project::in_memory(&[("a.rs", &code)]));
            let expected = format!(
                "a.rs:2: r: `{name}` leaves open whether it is squared; \
                 end the name in `_variance` or `_sd`"
            );
            assert_eq!(findings[0].message("r"), expected);
        }
    }

    #[test]
    fn names_that_say_what_they_are_are_fine() {
        let code = "// sigma\nlet noise_variance = sigma_points(noise_sd, \"sigma\");\n";
        assert_eq!(check(&Project::in_memory(&[("a.rs", code)])), []);
    }
}
