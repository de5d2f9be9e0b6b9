//! Starters: they are sound, their campaigns calibrate, and nothing is overwritten.

use serde_json::Value;

use crate::cli::run;

const URDF: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/kuka-kr270.urdf");

#[test]
fn starters_run_at_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let odd = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/urdf/arm.urdf");
    let cases: &[&[&str]] = &[
        &["init", "a"],
        &["init", "b", "--kind", "parallelogram"],
        &["init", "c", "--kind", "urdf", URDF],
        &["init", "d", URDF],
        &["init", "e", odd],
    ];
    for arguments in cases {
        let name = arguments[1];
        let made = run(folder.path(), arguments);
        assert_eq!(made.status, 0, "{arguments:?}: {}", made.err);
        let check = run(folder.path(), &["check", &format!("{name}/robot.yaml")]);
        assert_eq!(check.status, 0, "{arguments:?}: {}", check.err);
        assert!(name == "e" || check.err.is_empty(), "only the odd arm has warnings, its URDF's: {}", check.err);
        let fitted = format!("{name}/calibrated.yaml");
        let ran = run(folder.path(), &["identify", name, "--save", &fitted, "--format", "json"]);
        assert_eq!(ran.status, 0, "{arguments:?}: {}", ran.err);
        let json: Value = serde_json::from_str(&ran.out).expect("JSON");
        let rms = |what: &str| json["residuals"][what]["rms"].as_f64().expect("a number");
        // The made-up errors are millimetres, the made-up noise is 0.03 mm in each coordinate: 0.052 mm in length.
        assert!(rms("check_registration") > 0.5, "{arguments:?}: {}", rms("check_registration"));
        assert!(rms("check_after") < 0.12, "{arguments:?}: {}", rms("check_after"));
        for command in [&["diagnose", name][..], &["report", name], &["residuals", fitted.as_str(), name]] {
            let ran = run(folder.path(), command);
            assert_eq!(ran.status, 0, "{command:?}: {}", ran.err);
        }
        // What an editor asks for stands where the first line names it, also in files written later.
        for file in ["robot.yaml", "campaign.yaml", "calibrated.yaml"] {
            let text = std::fs::read_to_string(folder.path().join(name).join(file)).expect("a file");
            let line = text.lines().next().unwrap_or_default();
            let schema = line.strip_prefix("# yaml-language-server: $schema=").expect("a schema line");
            assert!(folder.path().join(name).join(schema).is_file(), "{file}: {line}");
        }
    }
}

#[test]
fn nothing_is_overwritten_and_bad_names_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::create_dir(folder.path().join("full")).expect("made");
    std::fs::create_dir(folder.path().join("empty")).expect("made");
    std::fs::write(folder.path().join("full/mine.txt"), "mine").expect("written");
    std::fs::write(folder.path().join("file"), "mine").expect("written");
    std::fs::write(folder.path().join("bad.urdf"), "<robot>").expect("written");
    let fixed = "<robot name='r'><link name='a'/><link name='b'/><joint name='j' type='fixed'><parent link='a'/>\
                 <child link='b'/></joint></robot>";
    std::fs::write(folder.path().join("fixed.urdf"), fixed).expect("written");
    let cases: &[(&[&str], &str)] = &[
        (&["init", "full"], "`full` is not empty; nothing is overwritten"),
        (&["init", "file"], "`file` is a file; nothing is overwritten"),
        (&["init", "a b"], "is no name"),
        (&["init", ".."], "is no name"),
        (&["init", ""], "is no name"),
        (&["init", ".hidden"], "is no name"),
        (&["init", "nowhere/new"], "there is no folder `nowhere`"),
        (&["init", "new", "--kind", "urdf"], "init NAME --kind urdf FILE"),
        (&["init", "new", "--kind", "serial", "bad.urdf"], "only --kind urdf starts from a file"),
        (&["init", "new", "--kind", "seriel"], "serial"),
        (&["init", "new", "none.urdf"], "there is no file `none.urdf`"),
        (&["init", "new", "full/mine.txt"], "give a .urdf file"),
        (&["init", "new", "bad.urdf"], "bad.urdf"),
        (&["init", "new", "fixed.urdf"], "fixed.urdf"),
    ];
    for (arguments, expected) in cases {
        let ran = run(folder.path(), arguments);
        assert_eq!((ran.status, ran.out.as_str()), (2, ""), "{arguments:?}: {}", ran.err);
        assert!(ran.err.contains(expected), "{arguments:?}: {}", ran.err);
        assert!(!folder.path().join("new").exists(), "{arguments:?}");
    }
    assert_eq!(run(folder.path(), &["init", "empty"]).status, 0);
}

#[test]
fn bundled_files_name_their_schemas() {
    for folder in ["robots", "campaigns", "processes"] {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
        let mut files = vec![root];
        let mut seen = 0;
        while let Some(path) = files.pop() {
            if path.is_dir() {
                files.extend(std::fs::read_dir(&path).expect("a folder").map(|entry| entry.expect("an entry").path()));
            } else if path.extension().is_some_and(|extension| extension == "yaml") {
                let text = std::fs::read_to_string(&path).expect("a file");
                let schema = text.lines().next().and_then(|line| line.split_once("$schema=")).expect("a schema line").1;
                assert!(path.parent().expect("a folder").join(schema).is_file(), "{}", path.display());
                seen += 1;
            }
        }
        assert!(seen > 0, "{folder}");
    }
}
