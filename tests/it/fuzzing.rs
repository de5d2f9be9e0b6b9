//! Spoiled files and flags through the command, from their text to a diagnosis: no panic, no other exit status than those
//! declared, every refusal with a place or a remedy, and no figure that is not a number where all went well.
//!
//! `cargo test fuzzing` runs some hundred inputs; `ELASTOGEO_FUZZ=5000 cargo test fuzzing` as many as it says, with
//! `ELASTOGEO_FUZZ_SEED=2` others. A failure prints the folder with the files, which is then kept, and the arguments.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::cli::PLANAR;

/// Longest that a command may take: the sound ones take a second.
const LONGEST: Duration = Duration::from_secs(120);
/// Inputs of a short run.
const BRIEF: u64 = 60;

const SPRINGS: &str = "gravity: [0, 0, -9.81]
bodies:
  2: {mass: 5, com: [200, 0, 0]}
joint_stiffness:
  1: {kar: {compliance: 5e-6, identifiable: true}}
  2: {kar: {compliance: 5e-6, identifiable: true}}
";

const RULES: &str = "inputs: [q1, q2]
at: tip
components:
  x.fx: {modes: [[-90, 90], [-90, 90]], conclusions: [1, 2, 3, 4]}
";

const PROCESS: &str = "process: strip
units: {length: mm, force: N, pressure: GPa}
strip: {clamp: [1200, 0, 5], along: [-1, 0, 0], push: [0, 0, -1], length: 800, width: 20, height: 5, young: 69.5, theory: large}
";

const URDF: &str = r#"<robot name="arm">
  <link name="base"/><link name="boom"/><link name="hand"/>
  <joint name="a" type="revolute">
    <parent link="base"/><child link="boom"/><origin xyz="0 0 0.5" rpy="0 0.1 0"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" effort="10" velocity="1"/>
  </joint>
  <joint name="b" type="prismatic">
    <parent link="boom"/><child link="hand"/><origin xyz="0.4 0 0" rpy="1.57 0 0"/><axis xyz="1 0 0"/>
    <limit lower="-0.2" upper="0.2" effort="10" velocity="1"/>
  </joint>
</robot>
"#;

/// Commands that read a file, each run while the one before it succeeds.
type Commands = &'static [&'static [&'static str]];

/// Files that are spoiled, and the commands that read them; without a file a value among the arguments is spoiled.
const CASES: &[(&str, Commands)] = &[
    ("arm.yaml", &[&["check", "arm.yaml"], &["identify", "c"], &["diagnose", "c"]]),
    ("soft.yaml", &[&["check", "soft.yaml"], &["stiffness", "soft.yaml", "--joints", "q1=10,q2=20", "--at", "tip"]]),
    (
        "arm.urdf",
        &[&["check", "arm.urdf"], &["pose", "arm.urdf", "--joints", "a=10,b=20"], &["convert", "arm.urdf", "o.yaml"]],
    ),
    ("c/campaign.yaml", &[&["check", "c"], &["identify", "c"], &["diagnose", "c"]]),
    (
        "c/measurements.csv",
        &[&["check", "c"], &["identify", "c", "--save", "o.yaml"], &["check", "o.yaml"], &["diagnose", "c"]],
    ),
    ("process.yaml", &[&["simulate", "soft.yaml", "--poses", "path.csv", "--process", "process.yaml", "--into", "t"]]),
    (
        "rules.yaml",
        &[&["check", "ruled.yaml"], &["pose", "ruled.yaml", "--joints", "q1=10,q2=20", "--wrench", "9,0,0"]],
    ),
    ("", &[&["pose", "arm.yaml", "--joints", "q1=10,q2=20", "--wrench", "1,2,3"]]),
    ("", &[&["solve", "arm.yaml", "--target", "800,100,0", "--from", "q1=20"]]),
    (
        "",
        &[
            &[
                "simulate", "arm.yaml", "--poses", "8", "--noise", "0.03", "--errors", "1", "--share", "0.5", "--into",
                "t",
            ],
            &["identify", "t"],
        ],
    ),
    ("", &[&["plan", "arm.yaml", "--poses", "4", "--range", "q1=-10:20"]]),
    ("", &[&["identify", "c", "--loss", "huber", "--loss-scale", "2", "--hold", "2.d", "--train", "8"]]),
];

/// What stands in place of a number.
const NUMBERS: &[&str] = &[
    "0",
    "-0",
    "-1",
    "1",
    "1e308",
    "-1e308",
    "1e-308",
    "5e-324",
    "nan",
    "inf",
    "-inf",
    "1e999",
    "0x10",
    "1,5",
    "9007199254740993",
    "1e12",
    "-1e-12",
    "180",
    "90",
    "1e6",
    "",
    "~",
    "1 2",
    "0.5",
    "1e30",
];

/// What is put in anywhere.
const PIECES: &[&str] = &[
    "\u{0}",
    "\u{1b}[31m",
    "\u{202e}",
    "\u{feff}",
    "{",
    "}",
    "[",
    "]",
    ":",
    "- ",
    "&a",
    "*a",
    "<<: ",
    "!!float ",
    "\"",
    "'",
    "#",
    "\t",
    "\r",
    "\n\n",
    ",",
    ";",
    "é",
    "\u{1f916}",
    "<",
    "/>",
    "&amp;",
    "&x;",
    "<!DOCTYPE x>",
    "..",
    "../../x",
];

/// A text with one to three changes.
fn spoiled(text: &str, random: &mut ChaCha8Rng) -> String {
    let mut text = text.to_string();
    for _ in 0..random.random_range(1..=3) {
        text = changed(&text, random);
    }
    text
}

fn changed(text: &str, random: &mut ChaCha8Rng) -> String {
    let mut lines: Vec<&str> = text.split_inclusive('\n').collect();
    let line = random.random_range(0..lines.len().max(1));
    let mut at = random.random_range(0..=text.len());
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    match random.random_range(0..10) {
        0 if !lines.is_empty() => drop(lines.remove(line)),
        1 if !lines.is_empty() => lines.insert(line, lines[line]),
        2 if !lines.is_empty() => {
            let other = random.random_range(0..lines.len());
            lines.swap(line, other);
        }
        3 => return text[..at].to_string(),
        4 => return format!("{}{}{}", &text[..at], PIECES.choose(random).expect("pieces"), &text[at..]),
        5 => {
            // A word by another one.
            let words: Vec<(usize, &str)> = words(text, |c: char| c.is_alphanumeric() || c == '_');
            let (Some(&(at, old)), Some((_, new))) = (words.choose(random), words.choose(random)) else {
                return text.into();
            };
            return format!("{}{new}{}", &text[..at], &text[at + old.len()..]);
        }
        _ => {
            let is_number = |c: char| c.is_ascii_digit() || "+-.e".contains(c);
            let mut numbers = words(text, is_number);
            numbers.retain(|(_, word)| word.parse::<f64>().is_ok());
            let Some(&(at, old)) = numbers.choose(random) else { return text.into() };
            let factor = [-1.0, 1e3, 1e-3, 1e9, 0.1, 57.3].choose(random).expect("factors");
            let scaled = (old.parse::<f64>().unwrap_or(0.0) * factor).to_string();
            let new = if random.random_bool(0.5) { scaled.as_str() } else { NUMBERS.choose(random).expect("numbers") };
            return format!("{}{new}{}", &text[..at], &text[at + old.len()..]);
        }
    }
    lines.concat()
}

/// Runs of characters of a kind, and where they stand.
fn words(text: &str, is_part: impl Fn(char) -> bool) -> Vec<(usize, &str)> {
    let parts = text.split(|c| !is_part(c)).filter(|word| !word.is_empty());
    parts.map(|word| (word.as_ptr() as usize - text.as_ptr() as usize, word)).collect()
}

/// Files of a sound start, by name.
fn sound() -> BTreeMap<String, String> {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let written = [
        ("arm.yaml", PLANAR.to_string()),
        ("soft.yaml", format!("{PLANAR}{SPRINGS}")),
        ("ruled.yaml", format!("{PLANAR}fuzzy: {{file: rules.yaml}}\n")),
        ("rules.yaml", RULES.to_string()),
        ("process.yaml", PROCESS.to_string()),
        ("arm.urdf", URDF.to_string()),
        ("path.csv", "q1,q2\n10,20\n20,30\n30,10\n".to_string()),
    ];
    for (name, text) in &written {
        fs::write(at.join(name), text).expect("written");
    }
    let made = ["simulate", "arm.yaml", "--poses", "12", "--markers", "tip", "--conditions", "--into", "c"];
    assert_eq!(ended(at, &made.map(String::from)).0, Some(0), "a campaign");
    for (file, commands) in CASES {
        for command in *commands {
            let arguments: Vec<String> = command.iter().map(ToString::to_string).collect();
            let (status, out, err) = ended(at, &arguments);
            assert_eq!(status, Some(0), "{file} {command:?}: {out}{err}");
        }
    }
    let mut files: BTreeMap<String, String> = written.map(|(name, text)| (name.to_string(), text)).into();
    for name in ["c/campaign.yaml", "c/measurements.csv"] {
        files.insert(name.into(), fs::read_to_string(at.join(name)).expect("made"));
    }
    files
}

/// The command, with as much memory as it may take, kB: it is killed where a spoiled file asks for more.
fn bounded() -> Command {
    let program = env!("CARGO_BIN_EXE_elastogeo");
    if cfg!(unix) {
        let mut shell = Command::new("sh");
        shell.args(["-c", "ulimit -v 2000000 && exec \"$0\" \"$@\"", program]);
        shell
    } else {
        Command::new(program)
    }
}

/// Status, standard output and error of a command; no status where it took too long or was killed.
fn ended(folder: &Path, arguments: &[String]) -> (Option<i32>, String, String) {
    let [out, err] = ["out.txt", "err.txt"].map(|name| folder.join(name));
    let mut child = bounded()
        .args(arguments)
        .args(["--jobs", "1"])
        .current_dir(folder)
        .stdin(Stdio::null())
        .stdout(File::create(&out).expect("a file"))
        .stderr(File::create(&err).expect("a file"))
        .spawn()
        .expect("the command starts");
    let started = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().expect("a status") {
            break status.code();
        }
        if started.elapsed() > LONGEST {
            child.kill().expect("ended");
            child.wait().expect("ended");
            break None;
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    let text = |path| String::from_utf8_lossy(&fs::read(path).expect("written")).into_owned();
    (status, text(&out), text(&err))
}

/// What is wrong with how a command ended, if anything.
fn fault(status: Option<i32>, out: &str, err: &str, input: &str) -> Option<String> {
    let Some(status) = status else { return Some("took too long, or was killed".into()) };
    if err.contains("panicked") || !(0..=3).contains(&status) {
        return Some(format!("exit status {status}"));
    }
    let strange = |text: &str| {
        let words = text.split(|c: char| !c.is_alphanumeric()).map(str::to_lowercase);
        words.filter(|word| matches!(word.as_str(), "nan" | "inf" | "infinity")).count()
    };
    if status == 0 && strange(input) == 0 && strange(out) > 0 {
        return Some("a figure that is not a number".into());
    }
    let says = [" --> ", "= help: ", "--help", "tip: "].iter().any(|sign| err.contains(sign));
    (status != 0 && (!err.contains("error") || !says)).then(|| "a refusal without place or remedy".into())
}

/// One input: how many commands ended with success, or what is wrong.
fn tried(files: &BTreeMap<String, String>, seed: u64) -> Result<usize, String> {
    let random = &mut ChaCha8Rng::seed_from_u64(seed);
    let (spoil, commands) = CASES[usize::try_from(seed).expect("a number") % CASES.len()];
    let mut folder = tempfile::tempdir().expect("a folder");
    fs::create_dir(folder.path().join("c")).expect("a folder");
    let mut input = String::new();
    for (name, text) in files {
        let text = if name == spoil { spoiled(text, random) } else { text.clone() };
        if name == spoil {
            input.clone_from(&text);
        }
        fs::write(folder.path().join(name), text).expect("written");
    }
    for (done, command) in commands.iter().enumerate() {
        let mut arguments: Vec<String> = command.iter().map(ToString::to_string).collect();
        if spoil.is_empty() && done == 0 {
            let values: Vec<usize> = (2..arguments.len()).filter(|&k| arguments[k - 1].starts_with("--")).collect();
            let chosen = *values.choose(random).expect("values");
            // An argument of a process holds no zero byte.
            arguments[chosen] = spoiled(&arguments[chosen], random).replace('\0', "");
            input.clone_from(&arguments[chosen]);
        }
        let (status, out, err) = ended(folder.path(), &arguments);
        if let Some(fault) = fault(status, &out, &err, &input) {
            folder.disable_cleanup(true);
            return Err(format!("seed {seed}: {fault}: {arguments:?} in {}\n{out}{err}", folder.path().display()));
        }
        if status != Some(0) {
            return Ok(done);
        }
    }
    Ok(commands.len())
}

#[test]
fn spoiled_inputs_end_in_a_refusal_or_in_figures() {
    let number = |name: &str| std::env::var(name).ok().and_then(|value| value.parse::<u64>().ok());
    let (count, first) = (number("ELASTOGEO_FUZZ").unwrap_or(BRIEF), number("ELASTOGEO_FUZZ_SEED").unwrap_or(0));
    let files = sound();
    let all: Vec<Result<usize, String>> =
        (0..count).into_par_iter().map(|k| tried(&files, first * 1_000_000_000 + k)).collect();
    let faults: Vec<&String> = all.iter().filter_map(|found| found.as_ref().err()).collect();
    let refused = all.iter().filter(|found| **found == Ok(0)).count();
    println!("{count} inputs from seed {first}: {refused} refused at once, {} with faults", faults.len());
    assert!(
        faults.is_empty(),
        "{} of {count} inputs:\n{}",
        faults.len(),
        faults[..faults.len().min(20)].iter().map(|fault| format!("{fault}\n")).collect::<String>()
    );
    assert!(refused > 0 && refused < all.len(), "spoiled too much or too little: {refused} of {count} refused");
}

/// What counts as a fault.
#[test]
fn faults_are_seen() {
    assert!(fault(Some(0), "error 0.5 mm", "", "x").is_none());
    assert!(fault(Some(2), "", "error: no\n --> a.yaml:1:1\n", "").is_none());
    let faults = [
        (None, "", ""),
        (Some(101), "", "thread panicked"),
        (Some(0), "condition number NaN", ""),
        (Some(0), "stiffness inf N/m", ""),
        (Some(2), "", "error: no"),
        (Some(1), "", ""),
    ];
    for (status, out, err) in faults {
        assert!(fault(status, out, err, "").is_some(), "{status:?} {out} {err}");
    }
}
