//! The manifest of the recordings: the one that is there, or a draft, with what was stated in it.

use std::fmt::Write as _;
use std::io;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use dataset::{MANIFEST_NAME, Manifest, find_recordings};
use toml::Table;

use super::Args;
use super::asked::{Asked, ask, is_open, missing};
use super::stated::{Stated, value};
use crate::tool::commands::init::drafted;
use crate::tool::destination::{Force, Inputs};
use crate::tool::origin::{Origin, readable};
use crate::tool::terminal::Terminal;

/// A manifest that may leave something open.
pub(super) struct Draft {
    path: PathBuf,
    text: String,
    /// Whether no file has it yet.
    is_new: bool,
    /// What a new one is drafted from.
    origin: Origin,
}

/// What became of the manifest.
pub(super) enum Filled {
    /// It told all, and is as it was.
    AsItWas,
    /// It was written, or completed.
    Written,
}

impl Draft {
    /// Of a folder of recordings.
    ///
    /// # Errors
    /// If it has neither a manifest nor recordings, or one that cannot be read.
    pub(super) fn of(folder: &Path) -> Result<Self> {
        let path = folder.join(MANIFEST_NAME);
        let mut origin = Origin::new("run").path(folder);
        let is_new = !path.exists();
        let text = if is_new {
            drafted(folder, &mut origin)?.0
        } else {
            readable(&path)?;
            let text = std::fs::read_to_string(&path);
            text.with_context(|| format!("cannot read {}", path.display()))?
        };
        Ok(Self { path, text, is_new, origin })
    }

    /// What a draft was made from; a manifest says it itself.
    ///
    /// # Errors
    /// If the folder cannot be read.
    pub(super) fn recordings(&self, folder: &Path) -> Result<Vec<PathBuf>> {
        Ok(if self.is_new { find_recordings(folder)?.2 } else { Vec::new() })
    }

    /// Writes what the arguments and a person at the terminal state into the manifest; recordings are not
    /// looked at again.
    ///
    /// # Errors
    /// All that is missing, if nobody is there to be asked; what contradicts the manifest, or is no value
    /// of it; if it cannot be written.
    pub(super) fn filled_in(self, args: &Args, terminal: &Terminal) -> Result<Filled> {
        let mut stated = Vec::new();
        let mut text = self.text.clone();
        for one in &args.set {
            text = self.with(&text, one)?;
            stated.push(one.clone());
        }
        if self.left_open(&text, &stated)?.is_empty() && text == self.text && !self.is_new {
            return Ok(Filled::AsItWas);
        }
        let destination = Force::typed(!self.is_new).file(&self.path, &Inputs::default())?;
        loop {
            let open = self.left_open(&text, &stated)?;
            let Some(first) = open.first() else { break };
            if !terminal.is_answered() {
                bail!(self.told_missing(args, &open));
            }
            let tell = |question: &str| terminal.tell(question);
            let answer = ask(first, &mut io::stdin().lock(), &tell)?;
            text = self.with(&text, &answer)?;
            stated.push(answer);
        }
        Manifest::parse(&text, &self.path)?;
        if self.is_new {
            let comment = self.origin.option("set", &stated).comment();
            text = format!("{}\n\n{comment}", text.trim_end());
        }
        destination.write(&text)?;
        Ok(Filled::Written)
    }

    fn left_open(&self, text: &str, stated: &[Stated]) -> Result<Vec<Asked>> {
        // What is no manifest is told by its reader, with the line.
        let Ok(table) = text.parse::<Table>() else {
            Manifest::parse(text, &self.path)?;
            return Ok(Vec::new());
        };
        Ok(missing(&table, self.is_new, stated))
    }

    /// The text with a value, where it leaves that open or has it.
    fn with(&self, text: &str, stated: &Stated) -> Result<String> {
        let path = self.path.display();
        let table = text.parse::<Table>().with_context(|| format!("cannot read {path}"))?;
        match stated.found(&table) {
            Some(found) if stated.is(found) => return Ok(text.to_owned()),
            Some(found) if !self.is_new && !is_open(Some(found)) => {
                bail!("{path} has {} = {found}, and {stated} is stated: edit it there", stated.key)
            }
            _ => {}
        }
        let filled = with_value(text, stated);
        let holds = filled.parse::<Table>().is_ok_and(|filled| {
            value(&filled, &stated.key) == Some(&stated.value)
                && without(filled, &stated.key) == without(table, &stated.key)
        });
        ensure!(holds, "cannot put {stated} into {path}: write it there by hand");
        Ok(filled)
    }

    fn told_missing(&self, args: &Args, open: &[Asked]) -> String {
        let folder = args.folder.display();
        let mut told = format!("no recording of {folder} tells, and nothing was written:");
        for Asked { key, what, .. } in open {
            let _ = write!(told, "\n  {key:20} {what}");
        }
        let is_plain = |c: char| c.is_alphanumeric() || "=._-/…".contains(c);
        let quoted = |one: String| match shlex::try_quote(&one) {
            Ok(quoted) if !one.chars().all(is_plain) => format!(" --set {quoted}"),
            _ => format!(" --set {one}"),
        };
        let stated = args.set.iter().map(ToString::to_string);
        let stated = stated.chain(open.iter().map(|one| format!("{}=…", one.key))).map(quoted);
        let (output, stated) = (args.output.display(), stated.collect::<String>());
        told + &format!("\nstate it: pushlab run {folder} -o {output}{stated}")
    }
}

/// A manifest's text with a value of a key: in the place of the one that is there or commented out, with
/// the comment beside it, else as the first of its table.
fn with_value(text: &str, stated: &Stated) -> String {
    let (table, key) = stated.place();
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let header = format!("[{table}]");
    let of_header = |line: &String| line.split('#').next().unwrap_or_default().trim() == header;
    let Some(start) = lines.iter().position(of_header) else {
        return format!("{}\n\n{header}\n{key} = {}\n", text.trim_end(), stated.value);
    };
    let rest = lines[start + 1..].iter();
    let n_own = rest.take_while(|line| !line.trim_start().starts_with('[')).count();
    let own = start + 1..start + 1 + n_own;
    let is_of_key = |line: &str| line.split_once('=').is_some_and(|(name, _)| name.trim() == key);
    let bare = |line: &str| line.trim_start().trim_start_matches('#').to_owned();
    let live = own.clone().find(|&index| is_of_key(&lines[index]));
    let place = live.or_else(|| own.clone().find(|&index| is_of_key(&bare(&lines[index]))));
    let new = format!("{key} = {}", stated.value);
    match place {
        Some(index) => {
            let line = bare(&lines[index]);
            let comment = line.split_once('#').map(|(_, comment)| comment);
            lines[index] = comment.map_or(new.clone(), |comment| format!("{new:28}#{comment}"));
        }
        None => lines.insert(start + 1, new),
    }
    lines.join("\n") + "\n"
}

/// A table without a key of one of its tables, and without those of them that are empty then.
fn without(mut manifest: Table, key: &str) -> Table {
    match key.split_once('.') {
        Some((name, rest)) => {
            let inner = manifest.remove(name).and_then(|inner| inner.as_table().cloned());
            let inner = without(inner.unwrap_or_default(), rest);
            if !inner.is_empty() {
                manifest.insert(name.to_owned(), inner.into());
            }
        }
        None => {
            manifest.remove(key);
        }
    }
    manifest
}

#[cfg(test)]
mod tests {
    use super::with_value;

    #[test]
    fn values_go_to_their_place_with_the_comments_beside_them() {
        let text = "name = \"a\"\n[object]\nshape = \"TODO\"   # one\n# side_m = 0.09  # two\n\n[pusher]\nfriction = 1\n";
        let set = |text: &str, stated: &str| with_value(text, &stated.parse().unwrap());
        let filled = set(text, "object.shape=square");
        assert!(filled.contains("\nshape = \"square\"            # one\n"), "{filled}");
        let filled = set(&filled, "object.side_m=0.1");
        assert!(filled.contains("\nside_m = 0.1                # two\n"), "{filled}");
        let filled = set(&filled, "object.mass_kg=2");
        assert!(filled.contains("[object]\nmass_kg = 2\nshape"), "{filled}");
        let filled = set(&filled, "streams.robot.topic=/tip");
        assert!(
            filled.ends_with("friction = 1\n\n[streams.robot]\ntopic = \"/tip\"\n"),
            "{filled}"
        );
        assert!(filled.parse::<toml::Table>().is_ok());
    }
}
