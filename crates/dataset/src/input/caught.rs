//! The border of a reader: a panic inside, also one of a library, becomes an error.

use std::{
    any::Any,
    cell::Cell,
    panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook},
    path::Path,
    sync::Once,
};

use crate::error::DatasetError;

thread_local! {
    /// Whether a panic of this thread is caught and told as an error.
    static IS_CAUGHT: Cell<bool> = const { Cell::new(false) };
}

/// Runs a reader; a panic becomes `ReaderFailed` and prints nothing.
pub(crate) fn caught<T>(
    path: &Path,
    read: impl FnOnce() -> Result<T, DatasetError>,
) -> Result<T, DatasetError> {
    let failed = |what| DatasetError::ReaderFailed { path: path.into(), what };
    caught_text(read).unwrap_or_else(|what| Err(failed(what)))
}

/// What a function returns, or what its panic said.
pub(crate) fn caught_text<T>(run: impl FnOnce() -> T) -> Result<T, String> {
    silence_what_is_caught();
    let outer = IS_CAUGHT.replace(true);
    let outcome = catch_unwind(AssertUnwindSafe(run));
    IS_CAUGHT.set(outer);
    outcome.map_err(|payload| text(payload.as_ref()))
}

/// Puts a hook before the program's own, once, that passes on the panics that nobody catches here.
fn silence_what_is_caught() {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = take_hook();
        set_hook(Box::new(move |panic| {
            if !IS_CAUGHT.get() {
                before(panic);
            }
        }));
    });
}

fn text(payload: &(dyn Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
    let text = text.or_else(|| payload.downcast_ref::<String>().cloned());
    text.unwrap_or_else(|| "it gave no reason".to_owned())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::{IS_CAUGHT, caught};
    use crate::error::DatasetError;

    #[test]
    fn a_panic_becomes_an_error_with_the_files_name() {
        for (n, what) in [(0, "index out of bounds"), (7, "seven is too many")] {
            let error = caught(Path::new("a.mcap"), || {
                assert!(n != 7, "seven is too many");
                Ok([1, 2][n + std::hint::black_box(2)])
            });
            let error = error.unwrap_err();
            assert!(matches!(error, DatasetError::ReaderFailed { .. }));
            let message = error.to_string();
            assert!(message.starts_with("a.mcap: the reader failed on this file"), "{message}");
            assert!(message.contains(what), "{message}");
            assert!(!IS_CAUGHT.get());
        }
        assert_eq!(caught(Path::new("a"), || Ok(3)).unwrap(), 3);
    }
}
