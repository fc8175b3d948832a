//! A file's text, to name lines and keys in it.

use std::path::Path;

use serde_spanned::Spanned;

use crate::ModelError;

pub(super) struct Source<'a> {
    pub path: &'a Path,
    pub text: &'a str,
}

impl Source<'_> {
    /// The error for `key`, whose value or table starts at the byte `offset`.
    pub(super) fn invalid(
        &self,
        offset: usize,
        key: &str,
        problem: impl Into<String>,
    ) -> ModelError {
        let (path, line) = (self.path.into(), self.line(offset));
        ModelError::Invalid { path, line, key: key.to_owned(), problem: problem.into() }
    }

    /// What the parser refused: TOML's own rules, unknown keys and values of another type.
    pub(super) fn syntax(&self, error: &toml::de::Error) -> ModelError {
        let offset = error.span().map_or(0, |span| span.start);
        let line = self.text[..offset.min(self.text.len())].rfind('\n').map_or(0, |at| at + 1);
        let content = self.text[line..].lines().next().unwrap_or_default();
        let key = content.split('=').next().unwrap_or_default().trim().to_owned();
        self.invalid(offset, &key, error.message())
    }

    /// Refuses a word that is not among the allowed ones.
    pub(super) fn expect(
        &self,
        value: &Spanned<String>,
        key: &str,
        allowed: &[&str],
    ) -> Result<(), ModelError> {
        if allowed.contains(&value.get_ref().as_str()) {
            return Ok(());
        }
        Err(self.unknown(value, key, allowed))
    }

    /// The error for a word that is not among the allowed ones.
    pub(super) fn unknown(
        &self,
        value: &Spanned<String>,
        key: &str,
        allowed: &[&str],
    ) -> ModelError {
        let problem =
            format!("`{}` is not known; allowed: {}", value.get_ref(), allowed.join(", "));
        self.invalid(value.span().start, key, problem)
    }

    fn line(&self, offset: usize) -> usize {
        1 + self.text.bytes().take(offset).filter(|byte| *byte == b'\n').count()
    }
}
