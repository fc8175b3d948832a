//! Which crate may import which: the table of `ARCHITECTURE.md`.

use std::collections::{BTreeMap, BTreeSet};

use super::Rule;
use super::project::{Crate, Finding, Project};

pub(super) const RULE: Rule = Rule {
    name: "crate-edges",
    demand: "crates import what the table of ARCHITECTURE.md says, no more and no less",
    check,
};

const PAGE: &str = "ARCHITECTURE.md";
/// The heading of the table's last column.
const COLUMN: &str = "imports (ours)";

/// The simulator, and what it may not reach: a diagnosis tested on its own formulas proves nothing.
const SIMULATOR: &str = "plant";
const FORMULAS: [&str; 4] = ["mechanics", "effects", "models", "diagnosis"];

/// A row of the table.
struct Row {
    /// Counted from 1.
    line: usize,
    /// Imports that are named one by one: the manifest has them.
    named: BTreeSet<String>,
    /// Those that it may have: `all above`, ``as `NAME` ``, `` `gp-*` ``.
    allowed: BTreeSet<String>,
}

fn check(project: &Project) -> Vec<Finding> {
    // A project without crates has no table.
    if project.crates().is_empty() {
        return Vec::new();
    }
    let rows = rows(project.text(PAGE).unwrap_or_default());
    let of_crates = project.crates().iter().flat_map(|one| check_crate(project, one, &rows));
    of_crates.chain(stale(project, &rows)).chain(reached_formulas(project)).collect()
}

/// The rows by crate, from a page of Markdown.
fn rows(page: &str) -> BTreeMap<String, Row> {
    let mut rows: BTreeMap<String, Row> = BTreeMap::new();
    let lines = page.lines().enumerate();
    let table = lines.skip_while(|(_, line)| !line.contains(COLUMN)).skip(2);
    for (index, line) in table.take_while(|(_, line)| line.starts_with('|')) {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let (Some(name), Some(imports)) = (cells.first(), cells.last()) else { continue };
        let mut row = Row { line: index + 1, named: BTreeSet::new(), allowed: BTreeSet::new() };
        for part in imports.split(", ") {
            let above = || rows.keys().cloned();
            match (part, part.strip_prefix("as ").map(bare), bare(part).strip_suffix('*')) {
                ("–", ..) => {}
                ("all above", ..) => row.allowed.extend(above()),
                (_, Some(other), _) => {
                    let other = rows.get(other).into_iter();
                    row.allowed.extend(other.flat_map(|row| row.allowed.iter().cloned()));
                }
                (.., Some(start)) => {
                    row.allowed.extend(above().filter(|name| name.starts_with(start)));
                }
                _ => drop(row.named.insert(bare(part).to_owned())),
            }
        }
        row.allowed.extend(row.named.iter().cloned());
        rows.insert(bare(name).to_owned(), row);
    }
    rows
}

fn bare(name: &str) -> &str {
    name.trim_matches('`')
}

fn check_crate(project: &Project, member: &Crate, rows: &BTreeMap<String, Row>) -> Vec<Finding> {
    let manifest = member.manifest();
    let Some(row) = rows.get(&member.name) else {
        let fault = format!("`{}` is not in the table of crates", member.name);
        let remedy = "decide what it may import and add it to the table of ARCHITECTURE.md";
        return vec![Finding::new(&manifest, 1, fault, remedy)];
    };
    let forbidden = member.imports.iter().filter(|&import| !row.allowed.contains(import));
    let forbidden = forbidden.map(|import| {
        let declares = |line: &str| line.split(['.', '=', ' ']).next() == Some(import);
        let text = project.text(&manifest).unwrap_or_default();
        let line = text.lines().position(declares).map_or(1, |index| index + 1);
        let fault = format!("`{}` may not import `{import}`", member.name);
        Finding::new(&manifest, line, fault, "move the code that needs it to a crate that may")
    });
    let absent = row.named.iter().filter(|&import| !member.imports.contains(import));
    let absent = absent.map(|import| {
        let fault = format!("`{}` does not import `{import}`", member.name);
        Finding::new(PAGE, row.line, fault, "take it out of the table")
    });
    forbidden.chain(absent).collect()
}

/// Rows of crates that there are not.
fn stale(project: &Project, rows: &BTreeMap<String, Row>) -> Vec<Finding> {
    let is_there = |name: &str| project.crates().iter().any(|member| member.name == name);
    let stale = rows.iter().filter(|(name, _)| !is_there(name));
    let finding = |(name, row): (&String, &Row)| {
        Finding::new(PAGE, row.line, format!("there is no crate `{name}`"), "take its row out")
    };
    stale.map(finding).collect()
}

/// Formulas that the simulator reaches, directly or by way of other crates.
fn reached_formulas(project: &Project) -> Vec<Finding> {
    let imports = |name: &str| {
        let member = project.crates().iter().find(|member| member.name == name);
        member.map_or(&[][..], |member| &member.imports)
    };
    let (mut reached, mut open) = (BTreeSet::new(), vec![SIMULATOR]);
    while let Some(name) = open.pop() {
        open.extend(imports(name).iter().map(String::as_str).filter(|name| reached.insert(*name)));
    }
    let finding = |formula: &&str| {
        let fault = format!("`{SIMULATOR}` reaches `{formula}`, which is tested on its recordings");
        let manifest = format!("crates/{SIMULATOR}/Cargo.toml");
        Finding::new(&manifest, 1, fault, "cut the path of imports between the two")
    };
    FORMULAS.iter().filter(|&formula| reached.contains(formula)).map(finding).collect()
}

#[cfg(test)]
mod tests {
    use super::super::project::{Crate, Project};
    use super::check;

    const TABLE: &str = "\
        | crate | job | imports (ours) |\n\
        |---|---|---|\n\
        | `planar` | geometry | – |\n\
        | `mechanics` | physics | `planar` |\n\
        | `gp-core` | learning | – |\n\
        | `plant` | simulates | `planar` |\n\
        | `models` | predicts | `gp-*`, `mechanics` |\n\
        | `pushlab` | the tool | all above |\n\
        | `studies` | figures | as `pushlab`, `pushlab` |\n";

    /// What is found where the table's crates import what it says, but for one that imports these.
    fn messages(name: &str, imports: &[&str]) -> Vec<String> {
        let said: [(&str, &[&str]); 7] = [
            ("planar", &[]),
            ("mechanics", &["planar"]),
            ("gp-core", &[]),
            ("plant", &["planar"]),
            ("models", &["mechanics", "gp-core"]),
            ("pushlab", &["models", "plant"]),
            ("studies", &["mechanics", "pushlab"]),
        ];
        let member = |name: &str, imports: &[&str]| Crate {
            name: name.into(),
            folder: format!("crates/{name}"),
            imports: imports.iter().map(|&import| import.into()).collect(),
            ..Crate::default()
        };
        let mut crates: Vec<Crate> =
            said.iter().filter(|row| row.0 != name).map(|row| member(row.0, row.1)).collect();
        crates.push(member(name, imports));
        let manifest = "[dependencies]\nplanar.workspace = true\nmechanics.workspace = true\n";
        let files = [("crates/plant/Cargo.toml", manifest), ("ARCHITECTURE.md", TABLE)];
        let project = Project::in_memory(&files).with_crates(crates);
        check(&project).iter().map(|found| found.message("r")).collect()
    }

    #[test]
    fn edges_of_the_table_are_fine() {
        assert_eq!(messages("mechanics", &["planar"]), Vec::<String>::new());
        assert_eq!(messages("pushlab", &[]), Vec::<String>::new());
        assert_eq!(messages("models", &["mechanics"]), Vec::<String>::new());
    }

    #[test]
    fn an_edge_outside_the_table_is_found_where_it_is_declared() {
        assert_eq!(
            messages("plant", &["planar", "mechanics"]),
            [
                "crates/plant/Cargo.toml:3: r: `plant` may not import `mechanics`; \
                 move the code that needs it to a crate that may",
                "crates/plant/Cargo.toml:1: r: `plant` reaches `mechanics`, which is tested on its \
                 recordings; cut the path of imports between the two"
            ]
        );
        assert!(messages("models", &["mechanics", "plant"])[0].contains("may not import `plant`"));
    }

    #[test]
    fn an_edge_that_only_the_table_has_is_found() {
        assert_eq!(
            messages("plant", &[]),
            ["ARCHITECTURE.md:6: r: `plant` does not import `planar`; take it out of the table"]
        );
    }

    #[test]
    fn crates_without_a_row_and_rows_without_a_crate_are_found() {
        assert!(messages("tools", &[])[0].contains("`tools` is not in the table"));
        let table = [("ARCHITECTURE.md", TABLE)];
        let one = Crate { name: "planar".into(), ..Crate::default() };
        let found = check(&Project::in_memory(&table).with_crates(vec![one]));
        assert_eq!(found.len(), 6);
        assert!(found[0].message("r").contains("there is no crate `gp-core`"));
    }
}
