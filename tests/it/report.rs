//! The report: one file, whole, and its figures those of the commands that it names.

use serde_json::Value;

use crate::cli::run;

const SECTIONS: [&str; 10] = [
    "waterfall",
    "arrows",
    "parts",
    "patterns",
    "distribution",
    "parameters",
    "conditioning",
    "effects",
    "stiffness",
    "next",
];

fn parsed(text: &str) -> Value {
    serde_json::from_str(text).expect("JSON")
}

/// A result without its time, and without the diagnostics that a command adds to it: a report has its own.
fn timeless(mut value: Value) -> Value {
    let result = value.as_object_mut().expect("an object");
    result.remove("seconds");
    result.remove("diagnostics");
    value
}

/// Figures of a page: JSON pointer, value, text, digits, scale.
fn figures(html: &str) -> Vec<(String, f64, String, String, f64)> {
    let attribute = |tag: &str, name: &str| {
        let from = tag.find(&format!(" {name}=\""))? + name.len() + 3;
        Some(tag[from..].split('"').next()?.replace("&amp;", "&").replace("&lt;", "<"))
    };
    html.split("<data class=\"figure\"")
        .skip(1)
        .map(|piece| {
            let (tag, rest) = piece.split_once('>').expect("a tag");
            let text = rest.split('<').next().expect("a text").replace('\u{2212}', "-");
            let get = |name: &str| attribute(tag, name).unwrap_or_default();
            (
                get("data-path"),
                get("value").parse().expect("a number"),
                text,
                get("data-digits"),
                get("data-scale").parse().unwrap_or(1.0),
            )
        })
        .collect()
}

#[test]
fn reports_of_bundled_campaigns_are_whole_and_say_what_the_commands_say() {
    let folder = tempfile::tempdir().expect("a folder");
    for campaign in ["kr270-no-compensator", "kr270-simulated", "ir663-simulated"] {
        let ran = run(folder.path(), &["report", campaign, "--output", "r.html", "--json", "r.json"]);
        assert_eq!(ran.status, 0, "{campaign}: {}", ran.err);
        let html = std::fs::read_to_string(folder.path().join("r.html")).expect("a report");
        let json = parsed(&std::fs::read_to_string(folder.path().join("r.json")).expect("its data"));
        // Clip paths of charts are references within the file.
        let outward = html.replace("url(#", "");
        for forbidden in ["http://", "https://", "<link", " src=", "url(", "@import", "fetch(", "class=\"fault\""] {
            assert!(!outward.contains(forbidden), "{campaign}: {forbidden}");
        }
        for id in SECTIONS {
            assert!(html.contains(&format!("<details class=\"section\" id=\"{id}\"")), "{campaign}: {id}");
        }
        assert!(html.len() < 3_000_000, "{campaign}: {} bytes", html.len());
        for command in ["identify", "diagnose"] {
            let own = run(folder.path(), &[command, campaign, "--format", "json"]);
            assert_eq!(timeless(parsed(&own.out)), timeless(json[command].clone()), "{campaign}: {command}");
        }
        let all = figures(&html);
        assert!(all.len() > 60, "{campaign}: {} figures", all.len());
        for (path, value, text, digits, scale) in all {
            let told = json.pointer(&path).and_then(Value::as_f64);
            assert_eq!(told, Some(value), "{campaign}: {path}");
            let shown: f64 = text.parse().unwrap_or_else(|_| panic!("{path}: {text}"));
            let error = (shown - value * scale).abs();
            let allowed = match digits.parse::<i32>() {
                Ok(digits) => 0.5000001 * 10f64.powi(-digits),
                Err(_) => 5.1e-4 * value.abs(),
            };
            assert!(error <= allowed.max(1e-12), "{campaign}: {path} is {value}, shown as {text}");
        }
        let answer = json["answer"].as_str().expect("an answer");
        assert!(ran.out.contains(answer), "{}", ran.out);
        let rms = json["diagnose"]["gap"]["noise"].as_f64().expect("noise");
        assert!(answer.contains(&format!("{rms:.4} mm")), "{answer}");
    }
}

#[test]
fn sessions_and_files_have_their_figures() {
    let folder = tempfile::tempdir().expect("a folder");
    let made = ["simulate", "universal-ur5", "--poses", "40", "--seed", "1", "--unknown-base", "--unknown-tool"];
    let made = run(folder.path(), &[&made[..], &["--sessions", "monday,friday", "--into", "both"]].concat());
    assert_eq!(made.status, 0, "{}", made.err);
    let truth = parsed(&std::fs::read_to_string(folder.path().join("both/truth.json")).expect("the truth"));
    let base = |session: &str| truth["parameters"][format!("base@{session}.x")]["true"].as_f64().expect("a place");
    assert!((base("monday") - base("friday")).abs() > 1e-3, "{truth}");
    let ran = run(folder.path(), &["report", "both", "--output", "r.html", "--json", "r.json"]);
    assert_eq!(ran.status, 0, "{}", ran.err);
    let html = std::fs::read_to_string(folder.path().join("r.html")).expect("a report");
    let json = parsed(&std::fs::read_to_string(folder.path().join("r.json")).expect("its data"));
    let parts = json["identify"]["parts"].as_array().expect("a list");
    for (part, name) in [("session", "monday"), ("session", "friday")] {
        let at = parts.iter().position(|own| own["part"] == part && own["name"] == name).expect("a part");
        assert!(html.contains(&format!("<td>{part}</td><td><code>{}</code>", name.replace('/', "&#x2f;"))), "{name}");
        let all = figures(&html);
        let path = format!("/identify/parts/{at}/rms");
        let told = all.iter().find(|(own, ..)| *own == path).map(|(_, value, ..)| *value);
        assert_eq!(told, parts[at]["rms"].as_f64(), "{path}");
    }
    // Each session's base is found where it was put, and one for both would not do.
    let all = json["identify"]["parameters"].as_array().expect("a list");
    let found = |name: &str| all.iter().find(|own| own["name"] == name).and_then(|own| own["value"].as_f64());
    for session in ["monday", "friday"] {
        let found = found(&format!("base@{session}.x")).expect("estimated");
        assert!((found - 1e3 * base(session)).abs() < 20.0, "{session}: {found} {}", base(session));
    }
    let rms = json["identify"]["residuals"]["check_after"]["rms"].as_f64().expect("a figure");
    assert!(rms < 0.1, "{rms}");
    assert!(html.contains("colours: monday blue, friday orange"), "no chart of the readings");
    assert!(html.contains("data-path=\"/identify/worst/0/error\""), "no worst reading");
    assert!(!html.contains("class=\"fault\""));
}

#[test]
fn waterfall_ends_at_what_the_diagnosis_leaves() {
    let folder = tempfile::tempdir().expect("a folder");
    let ran = run(folder.path(), &["report", "kr270-no-compensator", "--format", "json"]);
    assert_eq!(ran.status, 0, "{}", ran.err);
    assert!(std::fs::read_dir(folder.path()).expect("a folder").next().is_none(), "JSON alone writes no page");
    let json = parsed(&ran.out);
    let steps = json["waterfall"].as_array().expect("steps");
    let keys: Vec<&str> = steps.iter().map(|step| step["key"].as_str().expect("a key")).collect();
    assert_eq!(keys, ["described", "calibrated", "effect", "noise"]);
    assert_eq!(steps[0]["rms"], json["identify"]["residuals"]["check_before"]["rms"]);
    assert_eq!(steps[1]["rms"], json["identify"]["residuals"]["check_after"]["rms"]);
    assert_eq!(steps[2]["rms"], json["diagnose"]["after_all"]["rms"]);
    // Errors of single readings are those that `residuals` prints, and what the effect takes out is the difference.
    let own = parsed(&run(folder.path(), &["residuals", "kuka-kr270", "kr270-no-compensator", "--format", "json"]).out);
    for (row, other) in json["readings"].as_array().expect("rows").iter().zip(own["readings"].as_array().expect("rows"))
    {
        for k in 0..3 {
            let at = |key: &str| row["errors"][key][k].as_f64().expect("a number");
            // The campaign leaves the compensator out; so does its `residuals`.
            assert!((at("described") - other["error"][k].as_f64().expect("a number")).abs() < 1e-6);
            assert!((at("competed") - at("explained") - row["pattern"][k].as_f64().expect("a number")).abs() < 3e-6);
        }
    }
    let alike = &json["diagnose"]["look_alikes"];
    let overlap = alike["overlap"].as_array().expect("rows");
    assert_eq!(alike["hypotheses"][0]["effect"], "gravity-compensator");
    for (i, row) in overlap.iter().enumerate() {
        for (j, share) in row.as_array().expect("a row").iter().enumerate() {
            let share = share.as_f64().expect("a share");
            assert!((0.0..=1.0).contains(&share));
            assert!(i != j || (share - 1.0).abs() < 1e-9, "a hypothesis imitates itself");
        }
    }
}

#[test]
fn readings_do_not_depend_on_threads() {
    let folder = tempfile::tempdir().expect("a folder");
    let page = |jobs: &str| {
        let ran = run(folder.path(), &["report", "ir663-simulated", "--format", "json", "--jobs", jobs]);
        let mut json = parsed(&ran.out);
        for command in ["identify", "diagnose"] {
            json[command].as_object_mut().expect("an object").remove("seconds");
        }
        json
    };
    assert_eq!(page("1"), page("2"));
}

#[test]
fn a_campaign_with_hostile_names_is_shown_as_text() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("arm.yaml"), crate::cli::PLANAR).expect("written");
    let made = run(folder.path(), &["simulate", "arm.yaml", "--poses", "30", "--into", "c"]);
    assert_eq!(made.status, 0, "{}", made.err);
    let file = folder.path().join("c/campaign.yaml");
    let text = std::fs::read_to_string(&file).expect("a campaign");
    let named: Vec<String> = text
        .lines()
        .map(|line| {
            if line.starts_with("campaign:") {
                "campaign: '</script><script>alert(1)</script> & \"x\"'".into()
            } else {
                line.to_string()
            }
        })
        .collect();
    std::fs::write(&file, named.join("\n") + "\n").expect("written");
    let ran = run(folder.path(), &["report", "c"]);
    assert_eq!(ran.status, 0, "{}", ran.err);
    let html = std::fs::read_to_string(folder.path().join("report.html")).expect("the usual name");
    assert!(!html.contains("<script>alert"), "escaped");
    assert!(html.contains("&lt;script&gt;alert"), "and shown");
    assert!(html.contains("declares nothing elastic"), "a rigid robot has no stiffness to draw");
}

#[test]
fn bad_input_is_refused_and_nothing_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let cases: &[(&[&str], i32, &str)] = &[
        (&["report", "kr270-simulate"], 2, "did you mean the bundled campaign `kr270-simulated`?"),
        (&["report", "kr270-simulated", "--output", "nowhere/r.html"], 2, "there is no folder `nowhere`"),
        (&["report", "kr270-simulated", "--json", "nowhere/r.json"], 2, "there is no folder `nowhere`"),
        (&["report", "kr270-simulated", "--json", "r", "--output", "r"], 2, "two results would go to `r`"),
        (&["report", "kr270-simulated", "--robot", "kuka-kr271"], 2, "did you mean"),
        (&["view", "universal-ur55"], 2, "did you mean `universal-ur5`?"),
        (&["view", "universal-ur5", "--joints", "q9=1"], 2, "unknown variable `q9`"),
        (&["view", "universal-ur5", "--look", "1"], 2, "give 2 finite numbers"),
        (&["view", "universal-ur5", "--svg", "nowhere/x.svg"], 2, "there is no folder `nowhere`"),
        (&["view", "universal-ur5", "--wrench", "0,0,-100"], 1, "nothing elastic"),
        (&["view", "kuka-ir663", "--joints", "stroke2=5000"], 1, "cannot close"),
        (&["view", "universal-ur5", "--svg", "v.html", "--output", "v.html"], 2, "two results would go to `v.html`"),
    ];
    for (arguments, status, expected) in cases {
        let ran = run(folder.path(), arguments);
        assert_eq!((ran.status, ran.out.as_str()), (*status, ""), "{arguments:?}: {}", ran.err);
        assert!(ran.err.contains(expected), "{arguments:?}: {}", ran.err);
    }
    assert!(std::fs::read_dir(folder.path()).expect("a folder").next().is_none());
}

/// A soft joint that others can imitate, in few readings.
const RIVALS: [&str; 14] = [
    "simulate",
    "kuka-kr270",
    "--poses",
    "24",
    "--noise",
    "0.1",
    "--conditions",
    "--unknown-base",
    "--unknown-tool",
    "--errors",
    "0.3",
    "--effect",
    "joint-compliance@joint:2:joint2.kar=2e-7",
    "--into",
];

#[test]
fn proposed_configurations_are_listed_and_drawn() {
    let folder = tempfile::tempdir().expect("a folder");
    assert_eq!(run(folder.path(), &[&RIVALS[..], &["c"]].concat()).status, 0);
    let ran = run(folder.path(), &["report", "c", "--json", "r.json"]);
    assert_eq!(ran.status, 0, "{}", ran.err);
    let html = std::fs::read_to_string(folder.path().join("report.html")).expect("a report");
    let json = parsed(&std::fs::read_to_string(folder.path().join("r.json")).expect("its data"));
    let proposed = json["diagnose"]["next_poses"].as_array().expect("proposals").len();
    assert!(proposed > 0, "this campaign leaves rivals");
    assert!(html.contains("data-shots=\"next\""));
    let data = html.split("id=\"scene\">").nth(1).and_then(|rest| rest.split("</script>").next()).expect("data");
    assert_eq!(parsed(data)["next"].as_array().expect("drawn").len(), proposed);
    // Angles are in deg: 0.5 rad is 28.65.
    let (path, value, text, _, scale) =
        figures(&html).into_iter().find(|f| f.0 == "/diagnose/next_poses/0/joints/q2").expect("told");
    assert!((text.parse::<f64>().expect(&path) - value.to_degrees()).abs() < 0.0051 && (scale - 57.29578).abs() < 1e-4);
    assert!(html.contains("Not distinguishable by these readings from"));
}

/// One reading 50 mm off: text, JSON and page have the same figures, before and after it is set aside, and name its line.
#[test]
fn one_wrong_reading_is_told_alike() {
    let folder = tempfile::tempdir().expect("a folder");
    let made = ["simulate", "universal-ur5", "--poses", "40", "--noise", "0.03", "--unknown-base", "--into", "o"];
    assert_eq!(run(folder.path(), &made).status, 0);
    let table = folder.path().join("o/measurements.csv");
    let text = std::fs::read_to_string(&table).expect("a table");
    let mut lines: Vec<Vec<String>> = text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect();
    let x = lines[0].iter().position(|name| name == "x").expect("a column");
    lines[21][x] = (lines[21][x].parse::<f64>().expect("a number") + 50.0).to_string();
    let text: String = lines.iter().map(|line| line.join(",") + "\n").collect();
    std::fs::write(&table, text).expect("written");
    let told = run(folder.path(), &["diagnose", "o"]).out;
    let made = run(folder.path(), &["report", "o", "--output", "r.html", "--json", "r.json", "--force"]);
    let html = std::fs::read_to_string(folder.path().join("r.html")).expect("a report");
    let json = parsed(&std::fs::read_to_string(folder.path().join("r.json")).expect("its data"));
    let own = parsed(&run(folder.path(), &["diagnose", "o", "--format", "json"]).out);
    assert_eq!(timeless(own), timeless(json["diagnose"].clone()));
    let number = |path: &str| json.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path}"));
    let [before, after] = ["/diagnose/gap/rms", "/diagnose/after_all/rms"].map(|path| format!("{:.4}", number(path)));
    let less = format!("{:.0}", 100.0 * number("/diagnose/after_all/shrinkage"));
    assert!(before.parse::<f64>().expect("a number") > 1.0 && after.parse::<f64>().expect("a number") < 0.1);
    assert!(told.contains(&format!("from {before} to {after} mm")), "{told}");
    assert!(told.contains(&format!("evidence  {before} -> {after} mm, {less} % less")), "{told}");
    assert!(made.out.contains(&format!("from {before} to {after} mm, {less} % less")), "{}", made.out);
    let first: Vec<String> = figures(&html)
        .into_iter()
        .filter(|(path, ..)| path.starts_with("/diagnose/causes/0/rms_"))
        .map(|(_, _, text, ..)| text)
        .collect();
    assert_eq!(first, [before, after]);
    assert!(told.contains("measurements.csv:22") && html.contains("measurements.csv:22"), "{told}");
}

/// Titles and names come from files: what is no letter in them does nothing on a terminal, nor in a page.
#[test]
fn titles_do_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = "robot: \"\\e]0;owned\\a\\e[2J\\u202Earm\\u009b<b>\"\n".to_string() + crate::cli::PLANAR;
    std::fs::write(folder.path().join("arm.yaml"), text).expect("written");
    let made = ["simulate", "arm.yaml", "--poses", "8", "--markers", "tip", "--into", "c"];
    assert_eq!(run(folder.path(), &made).status, 0);
    let is_active = |c: char| c != '\n' && (c.is_control() || c == '\u{202e}');
    for command in [
        &["check", "arm.yaml"][..],
        &["check", "c"],
        &["identify", "c"],
        &["report", "c", "--output", "r.html"],
        &["view", "arm.yaml", "--output", "v.html", "--svg", "v.svg"],
    ] {
        let ran = run(folder.path(), command);
        assert_eq!(ran.status, 0, "{}", ran.err);
        assert!(!(ran.out + &ran.err).contains(is_active), "{command:?}");
    }
    for page in ["r.html", "v.html", "v.svg"] {
        let html = std::fs::read_to_string(folder.path().join(page)).expect("a page");
        assert!(!html.contains(is_active) && !html.contains("\u{fffd}<b>"), "{page}");
        assert!(html.contains("owned"), "{page}");
    }
}
