//! What a user states of a set, as `object.mass_kg=0.8`.

use std::fmt;
use std::str::FromStr;

use toml::{Table, Value};

/// A key of the manifest with its value.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Stated {
    /// With its tables, as `object.mass_kg`.
    pub(super) key: String,
    pub(super) value: Value,
}

impl Stated {
    /// A key with what was typed for it: a number, a list, or a text without quotes.
    pub(super) fn new(key: &str, typed: &str) -> Self {
        let typed = typed.trim();
        let one_value = |mut table: Table| if table.len() == 1 { table.remove("x") } else { None };
        let value = format!("x = {typed}").parse().ok().and_then(one_value);
        let value = value.unwrap_or_else(|| Value::String(typed.to_owned()));
        Self { key: key.to_owned(), value }
    }

    /// The table of the key, and its name there.
    pub(super) fn place(&self) -> (&str, &str) {
        self.key.rsplit_once('.').unwrap_or(("", &self.key))
    }

    /// What a manifest has for the key.
    pub(super) fn found<'a>(&self, manifest: &'a Table) -> Option<&'a Value> {
        value(manifest, &self.key)
    }

    /// Whether a value is this one; 1 is 1.0.
    pub(super) fn is(&self, other: &Value) -> bool {
        let number = |value: &Value| value.as_float().or(value.as_integer().map(|n| n as f64));
        self.value == *other || number(&self.value).is_some_and(|own| number(other) == Some(own))
    }
}

/// What a table has for a key such as `object.mass_kg`.
pub(super) fn value<'a>(manifest: &'a Table, key: &str) -> Option<&'a Value> {
    match key.split_once('.') {
        Some((table, key)) => value(manifest.get(table)?.as_table()?, key),
        None => manifest.get(key),
    }
}

impl FromStr for Stated {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let is_name = |c: char| c.is_ascii_alphanumeric() || "_-.".contains(c);
        match text.split_once('=') {
            Some((key, typed))
                if key.contains('.')
                    && key.split('.').all(|part| !part.is_empty())
                    && key.chars().all(is_name)
                    && !typed.chars().any(char::is_control)
                    && !typed.trim().is_empty() =>
            {
                Ok(Self::new(key, typed))
            }
            _ => Err("expected KEY=VALUE with the key's table, such as object.mass_kg=0.8".into()),
        }
    }
}

impl fmt::Display for Stated {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.value {
            Value::String(text) => write!(f, "{}={text}", self.key),
            value => write!(f, "{}={value}", self.key),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Stated;

    #[test]
    fn numbers_lists_and_texts_are_told_apart() {
        let stated = |text: &str| text.parse::<Stated>();
        for (text, value) in [
            ("object.mass_kg=0.8", "0.8"),
            ("object.shape=rect1", "\"rect1\""),
            ("object.semi_axes_m=[0.05, 0.03]", "[0.05, 0.03]"),
            ("streams.robot.topic=/tip", "\"/tip\""),
        ] {
            let found = stated(text).unwrap();
            assert_eq!(found.value.to_string(), value);
            assert_eq!(found.to_string(), text);
        }
        assert_eq!(stated("streams.robot.topic=a").unwrap().place(), ("streams.robot", "topic"));
        for text in ["mass_kg=0.8", "object.mass_kg", "object.=1", "object.mass_kg=", "a b.c=1"] {
            assert!(stated(text).is_err(), "{text}");
        }
        let manifest = "[object]\nmass_kg = 1\n".parse().unwrap();
        let one = stated("object.mass_kg=1.0").unwrap();
        assert!(one.found(&manifest).is_some_and(|found| one.is(found)));
        assert!(stated("pusher.friction=1").unwrap().found(&manifest).is_none());
    }
}
