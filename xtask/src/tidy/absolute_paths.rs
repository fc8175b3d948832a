//! No file names a folder of one machine.

use super::Rule;
use super::project::{Finding, Project};

pub(super) const RULE: Rule =
    Rule { name: "absolute-path", demand: "no text file names a path of one machine", check };

/// First folders of the paths meant.
const ROOTS: &[&str] = &["work", "root", "home"];

fn check(project: &Project) -> Vec<Finding> {
    let numbered = |(path, text): (&'_ str, &'_ str)| {
        let lines = text.lines().enumerate();
        let finding = |(index, line)| {
            let root = ROOTS.iter().find(|root| names_path(line, root))?;
            let fault = format!("a path under /{root} exists on one machine only");
            Some(Finding::new(path, index + 1, fault, "name it relative to the project"))
        };
        lines.filter_map(finding).collect::<Vec<_>>()
    };
    project.texts().flat_map(numbered).collect()
}

/// Whether the line has this folder where a path begins, not after a name as in `src/root/`.
fn names_path(line: &str, root: &str) -> bool {
    let is_name = |letter: char| letter.is_alphanumeric() || "._-~}*".contains(letter);
    let folder = format!("/{root}/");
    line.match_indices(&folder).any(|(at, _)| !line[..at].ends_with(is_name))
}

#[cfg(test)]
mod tests {
    use super::super::project::Project;
    use super::check;

    #[test]
    fn paths_of_one_machine_are_found() {
        let path = ["", "home", "ann", "data"].join("/");
        let project = Project::in_memory(&[("run.sh", &format!("set -e\ncd {path}\n"))]);
        let messages: Vec<_> = check(&project).iter().map(|found| found.message("r")).collect();
        assert_eq!(
            messages,
            ["run.sh:2: r: a path under /home exists on one machine only; \
              name it relative to the project"]
        );
    }

    #[test]
    fn relative_paths_are_fine() {
        let path = ["target", "work", "a"].join("/");
        let project = Project::in_memory(&[("run.sh", &format!("ls {path} ./{path}\n"))]);
        assert_eq!(check(&project), []);
    }
}
