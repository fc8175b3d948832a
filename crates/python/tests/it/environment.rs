//! A Python with the package and all that its tests need, below the target folder.

use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

const CRATE: &str = env!("CARGO_MANIFEST_DIR");

/// A Python of its own, and the folder that it is in.
pub(crate) struct Environment {
    pub(crate) python: PathBuf,
    folder: PathBuf,
    /// What cargo has built.
    built: PathBuf,
}

/// Why there is none.
pub(crate) struct Missing(pub(crate) String);

impl Environment {
    /// Installs what is not there yet.
    ///
    /// # Errors
    /// `Missing` without a Python of 3.9 or newer with venv and pip, or where packages cannot be installed.
    pub(crate) fn found() -> Result<Self, Missing> {
        let program = std::env::current_exe().map_err(|error| Missing(error.to_string()))?;
        let built = program.parent().and_then(Path::parent).unwrap_or(&program).to_owned();
        let folder = built.parent().unwrap_or(&built).join("python");
        let python = installed(&folder)?;
        Ok(Self { python, folder, built })
    }

    /// Puts the package together, and returns the folder to import it from.
    ///
    /// # Errors
    /// If it cannot be written, or was not built.
    pub(crate) fn package(&self) -> io::Result<PathBuf> {
        let folder = self.folder.join("package");
        staged(&self.built, &folder.join("pushlab"))?;
        Ok(folder)
    }
}

/// An environment with the packages of `requirements.txt`, as it was left by an earlier run if it is the same.
fn installed(target: &Path) -> Result<PathBuf, Missing> {
    let (system, version) = system_python()?;
    let list = Path::new(CRATE).join("tests/requirements.txt");
    let wanted = format!("{version}\n{}", fs::read_to_string(&list).unwrap_or_default());
    let (folder, stamp) = (target.join("venv"), target.join("installed"));
    let python = folder.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    if fs::read_to_string(&stamp).is_ok_and(|found| found == wanted) && python.exists() {
        return Ok(python);
    }
    eprintln!("     Installing what the tests of the Python package need in {}", folder.display());
    let _ = fs::remove_dir_all(&folder);
    ran(Command::new(system).args(["-m", "venv"]).arg(&folder))?;
    let quiet = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-r"];
    ran(Command::new(&python).args(quiet).arg(&list))?;
    fs::write(&stamp, wanted).map_err(|error| Missing(error.to_string()))?;
    Ok(python)
}

/// The first Python that is new enough, and its version.
fn system_python() -> Result<(&'static str, String), Missing> {
    const ASK: &str =
        "import sys, venv, ensurepip; assert sys.version_info >= (3, 9); print(sys.version)";
    let version = |program: &str| {
        let output = Command::new(program).args(["-c", ASK]).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    ["python3", "python"]
        .into_iter()
        .find_map(|program| Some((program, version(program)?)))
        .ok_or_else(|| Missing("there is no Python of 3.9 or newer with venv and pip".to_owned()))
}

fn ran(command: &mut Command) -> Result<(), Missing> {
    let output = command.output().map_err(|error| Missing(error.to_string()))?;
    if output.status.success() {
        return Ok(());
    }
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8_lossy(&said);
    Err(Missing(format!("{command:?} failed:\n{}", said.trim_end())))
}

/// Puts the extension module that cargo has built beside the package's Python.
fn staged(built: &Path, package: &Path) -> io::Result<()> {
    let _ = fs::remove_dir_all(package);
    fs::create_dir_all(package)?;
    for entry in fs::read_dir(Path::new(CRATE).join("python/pushlab"))? {
        let path = entry?.path();
        let is_source = |ending| ["py", "pyi", "typed"].iter().any(|known| ending == *known);
        if let (true, Some(name)) = (path.extension().is_some_and(is_source), path.file_name()) {
            fs::copy(&path, package.join(name))?;
        }
    }
    let library = format!("{DLL_PREFIX}pushlab_python{DLL_SUFFIX}");
    let places = [built.join(&library), built.join("deps").join(&library)];
    let newest = |path: &&PathBuf| fs::metadata(path).and_then(|about| about.modified()).ok();
    let module = places.iter().filter(|path| path.exists()).max_by_key(newest);
    let module = module.ok_or_else(|| {
        io::Error::other(format!("{library} is not in {}: cargo has not built it", built.display()))
    })?;
    let name = if cfg!(windows) { "_native.pyd" } else { "_native.abi3.so" };
    fs::copy(module, package.join(name)).map(drop)
}
