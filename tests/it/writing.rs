//! Several files written whole or not at all, whatever fails on the way and whoever else writes.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use elastogeo::files::{settle, write_whole};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let mut names: Vec<String> =
        entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// The third of three files cannot be put in its place, which is found out when the others stand already: the old one is as
/// it was, the new one is gone.
#[test]
fn what_stood_before_is_put_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("old.csv"), "before").expect("written");
    // Longer than any name of a file; the file on its way has a short one.
    let impossible = at(&"x".repeat(300));
    let (old, new) = (at("old.csv"), at("new.csv"));
    let failed = write_whole(&[(&old, b"after"), (&new, b"after"), (&impossible, b"after")]);
    assert!(failed.is_err());
    assert_eq!(std::fs::read_to_string(&old).expect("read"), "before");
    assert_eq!(names(folder.path()), ["old.csv"]);
    write_whole(&[(&old, b"after"), (&new, b"after")]).expect("written");
    assert_eq!(std::fs::read_to_string(&old).expect("read"), "after");
    assert_eq!(names(folder.path()), ["new.csv", "old.csv"]);
}

/// What a killed process left on its way goes when the next one writes there; what is not ours stays.
#[test]
fn what_was_left_on_the_way_is_removed() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in [".elastogeo-Ab12.part", "mine.part"] {
        std::fs::write(folder.path().join(name), "half").expect("written");
    }
    write_whole(&[(&folder.path().join("a.csv"), b"whole")]).expect("written");
    assert_eq!(names(folder.path()), ["a.csv", "mine.part"]);
}

/// Writers of one folder take turns: its files are always those of one of them.
#[test]
fn writers_take_turns() {
    let folder = tempfile::tempdir().expect("a folder");
    let paths = ["a.csv", "b.csv", "c.csv"].map(|name| folder.path().join(name));
    for round in 0..20 {
        std::thread::scope(|scope| {
            for writer in 0..4 {
                let (paths, text) = (&paths, format!("{round} {writer}"));
                scope.spawn(move || {
                    let content = text.as_bytes();
                    let all: Vec<(&Path, &[u8])> = paths.iter().map(|path| (path.as_path(), content)).collect();
                    write_whole(&all).expect("written");
                });
            }
        });
        let texts = paths.each_ref().map(|path| std::fs::read_to_string(path).expect("read"));
        assert!(texts.iter().all(|text| *text == texts[0]), "{texts:?}");
    }
    assert_eq!(names(folder.path()), ["a.csv", "b.csv", "c.csv"]);
}

/// Files of a write that was killed when the first of two stood: what a journal says is undone, and only that.
#[test]
fn a_killed_write_is_undone() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let digest = |text: &str| elastogeo::blind::seal(text);
    let killed = |edited: &str| {
        std::fs::create_dir_all(at("inner")).expect("a folder");
        for (name, text) in [("a", "new"), ("b", "new"), ("inner/c", edited), (".elastogeo-1.old", "old"), ("d", "old")]
        {
            std::fs::write(at(name), text).expect("written");
        }
        let entry = |path: &str, old: Option<&str>| serde_json::json!({"path": path, "new": digest("new"), "old": old});
        let old = Some(".elastogeo-1.old");
        let files = [entry("a", old), entry("b", None), entry("inner/c", None), entry("d", None)];
        std::fs::write(at(".elastogeo-journal"), serde_json::json!({"files": files}).to_string()).expect("written");
    };
    killed("by hand");
    // Whoever reads below the folder finds what stood before.
    settle(&at("inner")).expect("settled");
    assert_eq!(names(folder.path()), ["a", "d", "inner"]);
    assert_eq!(std::fs::read_to_string(at("a")).expect("read"), "old");
    assert_eq!(names(&at("inner")), ["c"]);
    // Who writes, too.
    killed("new");
    write_whole(&[(&at("e"), b"whole")]).expect("written");
    assert_eq!(names(folder.path()), ["a", "d", "e", "inner"]);
    assert_eq!(names(&at("inner")), [""; 0]);
}

/// A journal that came with a download reaches nothing outside its folder.
#[cfg(unix)]
#[test]
fn a_journal_stays_in_its_folder() {
    let outside = tempfile::tempdir().expect("a folder");
    let victim = outside.path().join("mine");
    std::fs::write(&victim, "mine").expect("written");
    for path in [victim.display().to_string(), "../mine".into(), "link/mine".into()] {
        let folder = outside.path().join("download");
        std::fs::create_dir(&folder).expect("a folder");
        std::os::unix::fs::symlink(outside.path(), folder.join("link")).expect("a link");
        let files = [serde_json::json!({"path": path, "new": elastogeo::blind::seal("mine"), "old": null})];
        let text = serde_json::json!({"files": files}).to_string();
        std::fs::write(folder.join(".elastogeo-journal"), text).expect("written");
        settle(&folder).expect("nothing to do");
        assert!(victim.exists(), "{path}");
        std::fs::remove_dir_all(&folder).expect("removed");
    }
}

fn started(folder: &Path, arguments: &[&str]) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_elastogeo"));
    command.args(arguments).current_dir(folder).stdout(Stdio::null()).stderr(Stdio::null());
    command.spawn().expect("the command starts")
}

/// Killed at any moment: the campaign is that of the one seed or of the other, whole, as soon as the next command reads it.
#[cfg(unix)]
#[test]
fn a_killed_command_leaves_all_or_none() {
    let folder = tempfile::tempdir().expect("a folder");
    let made = |seed: &str, into: &str| {
        started(folder.path(), &["simulate", "universal-ur5", "--poses", "20", "--seed", seed, "--into", into])
    };
    let texts = |into: &str| {
        let into = folder.path().join(into);
        ["campaign.yaml", "measurements.csv", "truth.json"].map(|name| std::fs::read_to_string(into.join(name)).ok())
    };
    for (seed, into) in [("1", "one"), ("2", "two")] {
        assert!(made(seed, into).wait().expect("ended").success());
    }
    let [one, two] = ["one", "two"].map(texts);
    assert!(one != two && one.iter().chain(&two).all(Option::is_some));
    let begun = std::time::Instant::now();
    assert!(made("1", "t").wait().expect("ended").success());
    let whole = begun.elapsed().as_micros().try_into().expect("a number");
    let random = &mut ChaCha8Rng::seed_from_u64(1);
    let (mut ones, mut twos) = (0, 0);
    for round in 0..60 {
        let before = names(&folder.path().join("t"));
        let mut child = made(if round % 2 == 0 { "2" } else { "1" }, "t");
        std::thread::sleep(Duration::from_micros(random.random_range(whole / 4..whole)));
        let signal = if round % 3 == 0 { "-TERM" } else { "-KILL" };
        let sent = Command::new("kill").args([signal, &child.id().to_string()]).stderr(Stdio::null()).status();
        drop(sent);
        child.wait().expect("ended");
        if round % 3 == 0 {
            let left = names(&folder.path().join("t"));
            // A kill in an earlier round may have left what was kept of old files.
            let is_left = |name: &String| name.starts_with(".elastogeo-") && !before.contains(name);
            assert!(!left.iter().any(is_left), "after a signal to end: {left:?}");
        }
        assert!(started(folder.path(), &["check", "t"]).wait().expect("ended").success());
        let now = texts("t");
        assert!(now == one || now == two, "round {round}: neither of the two");
        if now == one {
            ones += 1
        } else {
            twos += 1
        };
    }
    println!("killed 60 times: {ones} of the one, {twos} of the other");
    assert!(made("1", "t").wait().expect("ended").success());
    assert_eq!(names(&folder.path().join("t")), ["campaign.yaml", "measurements.csv", "truth.json"]);
}

/// As many files as a process may have open, and more.
#[test]
fn many_files_are_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let paths: Vec<_> = (0..3000).map(|k| folder.path().join(format!("{k}.csv"))).collect();
    let files: Vec<(&Path, &[u8])> = paths.iter().map(|path| (path.as_path(), b"whole".as_slice())).collect();
    write_whole(&files).expect("written");
    assert_eq!(names(folder.path()).len(), 3000);
}
