//! Where the workspace is, whose files the tasks read and write.

use std::env;
use std::path::{Path, PathBuf};

/// Folder of the workspace: two above the running package's, or the current folder where the
/// program was not started by cargo.
pub fn workspace_root() -> PathBuf {
    let package = env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from);
    let root = package.as_deref().and_then(|folder| folder.ancestors().nth(2));
    root.unwrap_or(Path::new(".")).to_path_buf()
}

#[cfg(test)]
mod tests {
    use super::workspace_root;

    #[test]
    fn the_workspace_is_where_the_lock_file_is() {
        assert!(workspace_root().join("Cargo.lock").is_file());
    }
}
