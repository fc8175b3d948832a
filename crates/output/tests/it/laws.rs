//! Outputs are whole or as before, whatever is at their place.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Barrier;
use std::thread;

use output::{Existing, OutputError, OutputFile, OutputFolder, write};

fn names(dir: &Path) -> Vec<String> {
    let entries = fs::read_dir(dir).unwrap();
    let mut names: Vec<_> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

fn refused(path: &Path) -> String {
    let text = OutputFile::new(path, Existing::Refuse).unwrap_err().to_string();
    text.replace(&path.parent().unwrap().display().to_string(), "DIR")
}

#[test]
fn a_file_is_written_whole_and_leaves_nothing_beside_it() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.txt");
    let first = OutputFile::new(&path, Existing::Refuse).unwrap();
    assert!(!path.exists());
    first.write("first").unwrap();
    write(&path, "second").unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "second");
    drop(OutputFile::new(&path, Existing::Replace).unwrap().begin().unwrap());
    assert_eq!(names(dir.path()), ["a.txt"]);
}

#[test]
fn a_folder_is_filled_whole_or_not_at_all() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("out");
    let fill = |existing, text: &str| {
        OutputFolder::new(&path, existing)?.fill(|part| -> Result<(), OutputError> {
            part.write("new", text)?;
            assert_ne!(fs::read_to_string(path.join("new")).ok().as_deref(), Some(text));
            Ok(())
        })
    };
    let failed = OutputFolder::new(&path, Existing::Refuse).unwrap().fill(|part| {
        part.write("a", "1").unwrap();
        Err::<(), _>(OutputError::Exists { path: "no".into() })
    });
    assert!(failed.is_err() && names(dir.path()).is_empty());
    fs::create_dir(&path).unwrap();
    fill(Existing::Refuse, "1").unwrap();
    let again = fill(Existing::Refuse, "2").unwrap_err();
    assert!(matches!(again, OutputError::NotEmpty { .. }), "{again}");
    assert_eq!(fs::read_to_string(path.join("new")).unwrap(), "1");
    fs::write(path.join("old"), "").unwrap();
    fill(Existing::Replace, "3").unwrap();
    assert_eq!(names(&path), ["new"]);
    assert_eq!(fs::read_to_string(path.join("new")).unwrap(), "3");
    assert_eq!(names(dir.path()), ["out"]);
}

#[test]
fn what_cannot_be_written_is_told_before_the_work() {
    let dir = tempfile::tempdir().unwrap();
    let path = |name: &str| dir.path().join(name);
    fs::create_dir(path("folder")).unwrap();
    fs::write(path("file"), "").unwrap();
    let there = "cannot write DIR/file: it exists; remove it or name another file";
    assert_eq!(refused(&path("file")), there);
    let folder = "cannot write DIR/folder: it is a folder; name a file";
    assert_eq!(refused(&path("folder")), folder);
    let missing = "cannot write DIR/a: there is no folder DIR; make it first";
    assert_eq!(refused(&path("none/a")), missing);
    assert_eq!(refused(&path("file/a")), missing);
    let unnamed = OutputFile::new(Path::new(".."), Existing::Refuse).unwrap_err();
    assert!(unnamed.to_string().contains("it needs a name"), "{unnamed}");
    let mut permissions = fs::metadata(path("file")).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(path("file"), permissions).unwrap();
    let protected = OutputFile::new(&path("file"), Existing::Replace).unwrap_err();
    assert!(protected.to_string().contains("it is read-only"), "{protected}");
    let a_file = OutputFolder::new(&path("file"), Existing::Replace).unwrap_err();
    assert!(a_file.to_string().contains("it is a file; name a new folder"), "{a_file}");
}

#[test]
#[cfg(target_os = "linux")]
fn devices_and_places_where_nothing_can_be_written_are_refused() {
    assert!(refused(Path::new("/dev/null")).contains("neither a file nor a folder"));
    // Not even the superuser makes files there.
    let error = OutputFile::new(Path::new("/proc/a"), Existing::Refuse).unwrap_err();
    assert!(error.to_string().starts_with("cannot write /proc/a: "), "{error}");
    assert!(matches!(error, OutputError::Io { .. }));
}

#[test]
fn what_was_written_meanwhile_is_not_overwritten() {
    let dir = tempfile::tempdir().unwrap();
    let file = OutputFile::new(&dir.path().join("file"), Existing::Refuse).unwrap();
    fs::write(dir.path().join("file"), "theirs").unwrap();
    let error = file.write("ours").unwrap_err();
    assert!(matches!(error, OutputError::Exists { .. }), "{error}");
    let folder = OutputFolder::new(&dir.path().join("folder"), Existing::Refuse).unwrap();
    fs::create_dir(dir.path().join("folder")).unwrap();
    fs::write(dir.path().join("folder/a"), "theirs").unwrap();
    let error = folder.fill(|_| Ok::<_, OutputError>(())).unwrap_err();
    assert!(matches!(error, OutputError::NotEmpty { .. }), "{error}");
    assert_eq!(fs::read_to_string(dir.path().join("file")).unwrap(), "theirs");
    assert_eq!(fs::read_to_string(dir.path().join("folder/a")).unwrap(), "theirs");
    assert_eq!(names(dir.path()), ["file", "folder"]);
}

#[test]
fn of_runs_at_a_time_one_writes_and_the_others_say_so() {
    let dir = tempfile::tempdir().unwrap();
    for (round, existing) in (0..50).map(|i| (i, [Existing::Refuse, Existing::Replace][i % 2])) {
        let path = dir.path().join(format!("{round}"));
        let start = Barrier::new(4);
        let end = Barrier::new(4);
        let run = || {
            start.wait();
            let output = OutputFile::new(&path, existing);
            end.wait();
            output.and_then(|output| output.write("whole"))
        };
        let results = thread::scope(|scope| {
            let runs: Vec<_> = (0..4).map(|_| scope.spawn(run)).collect();
            runs.into_iter().map(|run| run.join().unwrap()).collect::<Vec<_>>()
        });
        assert_eq!(results.iter().filter(|result| result.is_ok()).count(), 1);
        for error in results.into_iter().filter_map(Result::err) {
            assert!(matches!(error, OutputError::Busy { .. }), "{error}");
        }
        assert_eq!(fs::read_to_string(&path).unwrap(), "whole");
    }
    assert_eq!(names(dir.path()).len(), 50);
}

#[test]
fn writers_in_turn_never_find_half_a_lock() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a");
    let run = |text: &str| {
        let mut n_written = 0;
        while n_written < 100 {
            match write(&path, text) {
                Ok(()) => n_written += 1,
                Err(OutputError::Busy { .. }) => thread::yield_now(),
                Err(error) => panic!("{error}"),
            }
        }
    };
    let texts = ["1".repeat(5000), "2".repeat(5000)];
    thread::scope(|scope| {
        for text in &texts {
            scope.spawn(|| run(text));
        }
    });
    assert!(texts.contains(&fs::read_to_string(&path).unwrap()));
    assert_eq!(names(dir.path()), ["a"]);
}

#[test]
fn leftovers_of_a_killed_run_go_with_the_next_one() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.csv");
    for name in [".a.csv.lock", ".a.csv.Ab12Yz.part", ".a.csv.gz.Ab12Yz.part", "a.csv.part"] {
        fs::write(dir.path().join(name), "left").unwrap();
    }
    fs::create_dir(dir.path().join(".a.csv.000000.part")).unwrap();
    write(&path, "whole").unwrap();
    let kept = [".a.csv.gz.Ab12Yz.part", "a.csv", "a.csv.part"];
    assert_eq!(names(dir.path()), kept, "those of other outputs stay");
}

#[test]
fn an_output_is_none_of_the_inputs_under_whatever_name() {
    let dir = tempfile::tempdir().unwrap();
    let path = |name: &str| dir.path().join(name);
    fs::create_dir(path("push-0")).unwrap();
    fs::write(path("set.toml"), "").unwrap();
    fs::hard_link(path("set.toml"), path("same.toml")).unwrap();
    let inputs = [path("push-0"), path("set.toml"), path("none")];
    let is_input =
        |name: &str| match OutputFile::apart_from(&inputs, &path(name), Existing::Replace) {
            Err(OutputError::Input { .. }) => true,
            Ok(_) => false,
            Err(error) => panic!("{error}"),
        };
    for name in ["set.toml", "push-0/a.csv", "push-0/../push-0/a.csv", "same.toml"] {
        assert!(is_input(name), "{name}");
    }
    for name in ["push-0.csv", "none", "set.toml.bak"] {
        assert!(!is_input(name), "{name}");
    }
    let folder = OutputFolder::apart_from(&inputs, &path("push-0/out"), Existing::Refuse);
    assert!(matches!(folder, Err(OutputError::Input { .. })));
    assert!(names(&path("push-0")).is_empty());
}

#[cfg(unix)]
#[test]
fn links_are_followed_to_where_they_lead() {
    use std::os::unix::fs::symlink;
    let dir = tempfile::tempdir().unwrap();
    let path = |name: &str| dir.path().join(name);
    fs::create_dir(path("far")).unwrap();
    fs::write(path("far/a.txt"), "old").unwrap();
    symlink("far/a.txt", path("link.txt")).unwrap();
    symlink("far", path("near")).unwrap();
    symlink("nowhere", path("broken")).unwrap();
    assert!(refused(&path("link.txt")).contains("it exists"));
    assert!(refused(&path("broken")).contains("a link that leads nowhere"));
    let output = OutputFile::new(&path("link.txt"), Existing::Replace).unwrap();
    let part = output.begin().unwrap();
    assert_eq!(part.path().parent(), Some(path("far").canonicalize().unwrap().as_path()));
    output.finish(part).unwrap();
    assert!(path("link.txt").is_symlink());
    assert_eq!(fs::read_to_string(path("far/a.txt")).unwrap(), "");
    let inputs: [PathBuf; 1] = [path("far/a.txt")];
    let output = OutputFile::apart_from(&inputs, &path("near/a.txt"), Existing::Replace);
    assert!(matches!(output, Err(OutputError::Input { .. })));
}

#[cfg(unix)]
#[test]
fn permissions_are_those_of_any_new_file() {
    use std::os::unix::fs::PermissionsExt;
    let dir = tempfile::tempdir().unwrap();
    let mode = |name: &str| fs::metadata(dir.path().join(name)).unwrap().permissions().mode();
    fs::write(dir.path().join("plain"), "").unwrap();
    fs::create_dir(dir.path().join("folder")).unwrap();
    write(&dir.path().join("whole"), "").unwrap();
    let output = OutputFolder::new(&dir.path().join("filled"), Existing::Refuse).unwrap();
    output.fill(|_| Ok::<_, OutputError>(())).unwrap();
    assert_eq!(mode("whole"), mode("plain"));
    assert_eq!(mode("filled"), mode("folder"));
}
