//! Several files written whole or not at all, whatever fails on the way and whoever else writes.

use std::path::Path;

use elastogeo::files::write_whole;

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
