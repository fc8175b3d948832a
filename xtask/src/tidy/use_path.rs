//! Paths within a crate, as its code names them.

/// Every path that begins with `crate`, `self` or `super`, as seen from the crate's root, with the
/// line on which it stands; groups are taken apart.
pub(super) fn paths(code: &str, module: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    for start in ["crate", "self", "super"] {
        for (at, _) in code.match_indices(start) {
            let is_part = |letter: char| letter.is_alphanumeric() || letter == '_' || letter == ':';
            if code[..at].ends_with(is_part) || !code[at + start.len()..].starts_with("::") {
                continue;
            }
            let line = 1 + code[..at].matches('\n').count();
            let mut names = Vec::new();
            expand(String::new(), &code[at..], &mut names);
            found.extend(names.iter().filter_map(|path| Some((line, absolute(path, module)?))));
        }
    }
    found
}

/// Names that a module hands on by `pub use`, or by a list such as `catalogue! { tilt::Tilt, }`, and
/// where each comes from.
pub(super) fn exports(code: &str, module: &str) -> Vec<(String, String)> {
    let uses = code.split("pub use ").skip(1).chain(code.split("pub(crate) use ").skip(1));
    let mut found: Vec<_> = listed(code)
        .filter_map(|path| Some((path.split_once("::")?.1.to_owned(), path)))
        .filter_map(|(name, path)| Some((name, absolute(&format!("self::{path}"), module)?)))
        .collect();
    for item in uses {
        let Some((path, _)) = item.split_once(';') else { continue };
        let mut names = Vec::new();
        expand(String::new(), path, &mut names);
        for path in names {
            let name = path.rsplit("::").next().unwrap_or_default().to_owned();
            let own = format!("self::{path}");
            let is_within =
                ["crate::", "self::", "super::"].iter().any(|word| path.starts_with(word));
            let path = if is_within { path } else { own };
            found.extend(absolute(&path, module).map(|from| (name, from)));
        }
    }
    found
}

/// The paths of lists that declare modules and hand on a name of each, one a line.
pub(super) fn listed(code: &str) -> impl Iterator<Item = &str> {
    let is_word = |word: &str| {
        !word.is_empty() && word.chars().all(|letter| letter.is_alphanumeric() || letter == '_')
    };
    let lists = code.split("! {\n").skip(1).filter_map(|rest| rest.split_once("\n}"));
    let entries = lists.flat_map(|(list, _)| list.split([',', '{', '}'])).map(str::trim);
    entries.filter(move |entry| {
        entry.split_once("::").is_some_and(|(file, name)| is_word(file) && is_word(name))
    })
}

/// Modules all of whose names a module hands on, by `pub use other::*`.
pub(super) fn globs(code: &str, module: &str) -> Vec<String> {
    let uses = code.split("pub use ").skip(1).filter_map(|rest| rest.split_once("::*;"));
    uses.filter_map(|(path, _)| absolute(path.trim_start_matches("crate::"), module)).collect()
}

/// Names of a module's own public items.
pub(super) fn items(code: &str) -> impl Iterator<Item = &str> {
    code.lines().filter_map(public_item)
}

fn public_item(line: &str) -> Option<&str> {
    let (kind, rest) = line.strip_prefix("pub ")?.split_once(' ')?;
    let end = rest.find(|letter: char| !(letter.is_alphanumeric() || letter == '_'))?;
    ["fn", "struct", "enum", "trait", "const", "type"].contains(&kind).then_some(&rest[..end])
}

/// A use tree from its first letter on: `a::{b, c::d}` gives `a::b` and `a::c::d`.
fn expand(before: String, tree: &str, found: &mut Vec<String>) {
    let tree = tree.trim_start();
    if let Some(group) = tree.strip_prefix('{') {
        for branch in branches(group) {
            expand(before.clone(), branch, found);
        }
        return;
    }
    let end = tree.find(|letter: char| !(letter.is_alphanumeric() || letter == '_'));
    let (name, rest) = tree.split_at(end.unwrap_or(tree.len()));
    let path = match (before.is_empty(), name) {
        (_, "self") if !before.is_empty() => before,
        (true, _) => name.to_owned(),
        (false, _) => format!("{before}::{name}"),
    };
    match rest.strip_prefix("::") {
        Some(rest) if rest.starts_with(|l: char| l == '{' || l == '_' || l.is_alphabetic()) => {
            expand(path, rest, found);
        }
        _ => found.push(path),
    }
}

/// The parts of a group up to its closing brace.
fn branches(group: &str) -> Vec<&str> {
    let (mut depth, mut from, mut found) = (0, 0, Vec::new());
    for (at, letter) in group.char_indices() {
        match letter {
            '{' => depth += 1,
            '}' if depth == 0 => {
                found.push(&group[from..at]);
                break;
            }
            '}' => depth -= 1,
            ',' if depth == 0 => {
                found.push(&group[from..at]);
                from = at + 1;
            }
            _ => {}
        }
    }
    found.retain(|branch| !branch.trim().is_empty());
    found
}

/// A path from the crate's root; none if it leaves the crate.
fn absolute(path: &str, module: &str) -> Option<String> {
    let mut base: Vec<&str> = module.split("::").filter(|part| !part.is_empty()).collect();
    let mut rest = Vec::new();
    for part in path.split("::") {
        match part {
            "crate" => base.clear(),
            "self" => {}
            "super" => {
                base.pop()?;
            }
            name => rest.push(name),
        }
    }
    base.extend(rest);
    Some(base.join("::"))
}

#[cfg(test)]
mod tests {
    use super::{exports, globs, items, paths};

    #[test]
    fn groups_are_taken_apart_and_seen_from_the_root() {
        let code =
            "use crate::{a::{B, c::D}, E};\nuse super::f;\nfn g() { self::h::i(); crate_x::y() }\n";
        let found = paths(code, "m::n");
        let expected = ["a::B", "a::c::D", "E", "m::n::h::i", "m::f"].map(str::to_owned);
        assert_eq!(found.iter().map(|(_, path)| path.clone()).collect::<Vec<_>>(), expected);
        assert_eq!(found.iter().map(|(line, _)| *line).collect::<Vec<_>>(), [1, 1, 1, 3, 2]);
    }

    #[test]
    fn what_is_handed_on_is_known_by_its_name() {
        let code = "pub use self::a::{B, C};\npub(crate) use crate::d::e;\npub use f::G;\n";
        let pairs = [("B", "m::a::B"), ("C", "m::a::C"), ("G", "m::f::G"), ("e", "d::e")];
        let expected = pairs.map(|(name, from)| (name.to_owned(), from.to_owned()));
        assert_eq!(exports(code, "m"), expected);
    }

    #[test]
    fn a_list_hands_on_what_it_declares() {
        let code = "effects! {\n    tilt::Tilt,\n    wind::Wind,\n}\nf! {\n    a + b::c(),\n}\n";
        let pairs = [("Tilt", "m::tilt::Tilt"), ("Wind", "m::wind::Wind")];
        let expected = pairs.map(|(name, from)| (name.to_owned(), from.to_owned()));
        assert_eq!(exports(code, "m"), expected);
    }

    #[test]
    fn all_names_of_a_module_are_its_items_and_what_it_hands_on() {
        assert_eq!(globs("pub use a::B;\npub use c::d::*;\n", ""), ["c::d"]);
        let code = "pub fn all() {}\nfn own() {}\npub struct S;\npub use a::B;\n";
        assert_eq!(items(code).collect::<Vec<_>>(), ["all", "S"]);
    }
}
