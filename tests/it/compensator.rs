//! Gravity compensator of the KR-270 paper: its printed numbers, and recovery of its mounting from simulated points.

use elastogeo::estimation::compensator::{
    Elasticity, JointCompliance, Triangle, Value, anchor, circle, elasticity, mounting,
};
use elastogeo::simulation::generator;
use nalgebra::{Matrix3, Rotation3, Vector3};
use rand_distr::{Distribution, StandardNormal};
use serde_json::Value as Json;

use crate::cli::run;
use crate::figures::recorded;
use crate::support::golden;

/// Table V.
const TABLE_V: Triangle = Triangle { lever: 0.18472, ax: 0.68593, ay: 0.1233 };
/// Angles of Table VI, deg.
const ANGLES: [f64; 5] = [-0.01, -25.2, -56.9, -99.8, -140.0];

fn printed() -> Elasticity {
    let exact = |value| Value { value, ci95: None };
    Elasticity { joint: exact(0.302e-6), spring: exact(0.144e-6), free_length: exact(0.458), rms: 0.0 }
}

fn compliances(values: [f64; 5]) -> Vec<JointCompliance> {
    let one = |(q, k): (&f64, f64)| JointCompliance { angle: q.to_radians(), compliance: k, ci95: None };
    ANGLES.iter().zip(values).map(one).collect()
}

#[test]
fn the_law_is_that_of_the_golden_values() {
    let golden = &golden()["kr270_compensator"];
    for sample in golden["samples"].as_array().expect("samples") {
        let number = |name: &str| sample[name].as_f64().expect("a number");
        let q = number("q2_deg").to_radians();
        assert!((TABLE_V.length(q) - number("s")).abs() < 1e-12);
        let k2 = printed().compliance(&TABLE_V, q);
        assert!((k2 / number("k2") - 1.0).abs() < 1e-9, "{k2} {}", number("k2"));
    }
    assert!((TABLE_V.phase().to_degrees() + 79.81).abs() < 0.005, "{}", TABLE_V.phase().to_degrees());
}

#[test]
fn table_ix_spans_table_vii() {
    let all: Vec<f64> =
        (0..=1450).map(|k| printed().compliance(&TABLE_V, -(k as f64 / 10.0).to_radians()) * 1e6).collect();
    let span = [all.iter().copied().fold(f64::INFINITY, f64::min), all.iter().copied().fold(0.0, f64::max)];
    println!("k2 over 0..-145 deg: {span:?}");
    assert!((span[0] - 0.278).abs() < 0.0005 && (span[1] - 0.297).abs() < 0.0005, "{span:?}");
}

#[test]
fn eq_13_returns_table_vii_from_what_it_predicts_and_within_its_intervals_from_table_vi() {
    let own = ANGLES.map(|q| printed().compliance(&TABLE_V, q.to_radians()));
    let found = elasticity(&TABLE_V, &compliances(own)).expect("found");
    for (found, expected) in [(found.joint, 0.302e-6), (found.spring, 0.144e-6), (found.free_length, 0.458)] {
        assert!(
            (found.value / expected - 1.0).abs() < 1e-9 && found.ci95.is_some_and(|ci95| ci95 < 1e-6 * expected),
            "{found:?}"
        );
    }
    // Table VI, ordinary least squares. The three numbers come out inside the intervals that Table VII prints, not at its
    // last digits: no weighting of Table VI's columns leads to those.
    let found = elasticity(&TABLE_V, &compliances([0.297e-6, 0.287e-6, 0.315e-6, 0.302e-6, 0.251e-6])).expect("found");
    println!("from Table VI: {found:?}");
    assert!((found.joint.value - 0.302e-6).abs() < 0.004e-6);
    assert!((found.spring.value - 0.144e-6).abs() < 0.031e-6);
    assert!((found.free_length.value - 0.458).abs() < 0.027);
    assert!((found.rms - 0.019e-6).abs() < 0.003e-6, "three parameters do not follow the five: {}", found.rms);
}

/// Table VII by the command from Table VI as printed, ordinary least squares of eq. (13): inside the printed intervals. What the
/// last digits of Table VI leave open holds the printed kc and s0, and k2_0 to 0.002.
#[test]
fn table_vii_is_fitted_to_table_vi() {
    let folder = tempfile::tempdir().expect("a folder");
    let fitted = |shift: [f64; 5]| -> [f64; 3] {
        let mut table = String::from("q,k2\n");
        for ((q, k), shift) in ANGLES.iter().zip([0.297, 0.287, 0.315, 0.302, 0.251]).zip(shift) {
            table += &format!("{q},{}\n", k + shift);
        }
        std::fs::write(folder.path().join("vi.csv"), table).expect("written");
        let arguments =
            ["compensator", "--mounting", "184.72,685.93,123.3", "--compliances", "vi.csv", "--format", "json"];
        let ran = run(folder.path(), &arguments);
        assert_eq!(ran.status, 0, "{}", ran.err);
        let json: Json = serde_json::from_str(&ran.out).expect("JSON");
        ["k2_0", "kc", "s0"].map(|name| json[name]["value"].as_f64().expect("a value"))
    };
    let found = fitted([0.0; 5]);
    let (mut least, mut most) = ([f64::INFINITY; 3], [0.0_f64; 3]);
    for corner in 0..32 {
        let at = fitted(std::array::from_fn(|k| if corner >> k & 1 == 1 { 0.0005 } else { -0.0005 }));
        (0..3).for_each(|k| (least[k], most[k]) = (least[k].min(at[k]), most[k].max(at[k])));
    }
    let printed = [("k2_0", 0.302, 0.004), ("kc", 0.144, 0.031), ("s0", 458.0, 27.0)];
    let mut lines = Vec::new();
    for (k, (name, value, width)) in printed.into_iter().enumerate() {
        assert!((found[k] - value).abs() < width, "{name}: {} {value}", found[k]);
        lines.push(format!(
            "{name}: {value} printed, {:.4} here, {:.4} to {:.4} by rounding of Table VI",
            found[k], least[k], most[k]
        ));
    }
    recorded("table-vii", "cargo test table_vii_is_fitted", &lines);
    assert!((least[1]..most[1]).contains(&0.144) && (least[2]..most[2]).contains(&458.0) && least[0] - 0.302 < 0.0025);
}

/// Positions at joint angles.
type Turned = Vec<(f64, Vector3<f64>)>;

/// Practice: P1 at six angles, four points of the spring's body, in a tracker's axes.
fn measured(sigma: f64, seed: u64) -> (Turned, Vec<Vec<Vector3<f64>>>) {
    let mut random = generator(seed);
    let mut noise = || {
        Vector3::from_fn(|_, _| -> f64 {
            sigma * <StandardNormal as Distribution<f64>>::sample(&StandardNormal, &mut random)
        })
    };
    let axes = Rotation3::new(Vector3::new(0.4, -1.2, 0.7)) * Rotation3::from_matrix_unchecked(Matrix3::identity());
    let centre = Vector3::new(3.1, -2.2, 0.9);
    let angles = [0.0_f64, -30.0, -60.0, -90.0, -120.0, -140.0].map(f64::to_radians);
    let at = |x: f64, y: f64, z: f64| axes * Vector3::new(x, y, z) + centre;
    let points = angles.map(|q| (q, at(0.18472 * q.cos(), 0.18472 * q.sin(), 0.0) + noise())).to_vec();
    let body = [[0.12, 0.05, 0.03], [0.35, -0.06, 0.03], [0.6, 0.04, 0.05], [0.8, 0.0, 0.04]];
    let arc = |[r, across, z]: [f64; 3]| {
        angles
            .iter()
            .map(|q| {
                // The spring's body points from P0 to P1.
                let (x, y) = (0.18472 * q.cos() + 0.1233, 0.18472 * q.sin() + 0.68593);
                let s = x.hypot(y);
                at(-0.1233 + (x * r - y * across) / s, -0.68593 + (y * r + x * across) / s, z) + noise()
            })
            .collect()
    };
    (points, body.map(arc).to_vec())
}

#[test]
fn the_mounting_is_recovered_from_measured_points() {
    let (points, arcs) = measured(0.0, 1);
    let exact = circle(&points).expect("a circle");
    assert!((exact.radius - 0.18472).abs() < 1e-12 && (exact.centre - Vector3::new(3.1, -2.2, 0.9)).norm() < 1e-12);
    let hung = exact.axes.transpose() * (anchor(&arcs).expect("an anchor") - exact.centre);
    assert!((hung.x + 0.1233).abs() < 1e-10 && (hung.y + 0.68593).abs() < 1e-10, "{hung}");
    let mut held = [0; 3];
    let mut width = [0.0; 3];
    for seed in 0..400 {
        let (points, arcs) = measured(50e-6, seed);
        let found = mounting(&points, &arcs).expect("found");
        let [ax, ay] = found.anchor.expect("measured");
        for (k, (value, truth)) in [(found.lever, 0.18472), (ax, 0.68593), (ay, 0.1233)].into_iter().enumerate() {
            let ci95 = value.ci95.expect("more points than unknowns");
            held[k] += usize::from((value.value - truth).abs() <= ci95);
            width[k] += ci95 / 400.0;
        }
    }
    println!("L, ax, ay: {held:?} of 400 intervals hold the truth; mean half widths {width:?} m at 50 um");
    let error = 3.0 * (0.95_f64 * 0.05 * 400.0).sqrt();
    assert!(held.iter().all(|&held| (held as f64 - 380.0).abs() < error), "{held:?}");
    assert!(
        mounting(&points[..2], &arcs).is_err() && mounting(&points, &arcs[..0]).expect("a circle").anchor.is_none()
    );
    let line: Vec<Vec<Vector3<f64>>> = vec![(0..4).map(|k| Vector3::x() * f64::from(k)).collect()];
    assert!(anchor(&line).is_err());
    let still: Vec<(f64, Vector3<f64>)> = points.iter().map(|(q, _)| (*q, Vector3::x())).collect();
    assert!(circle(&still).is_err());
}

#[test]
fn the_command_finds_the_compensator_and_refuses_what_it_cannot_use() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    let (points, arcs) = measured(20e-6, 7);
    let mut text = String::from("q,x,y,z\n");
    for (q, p) in &points {
        text += &format!("{},{},{},{}\n", q.to_degrees(), p.x * 1e3, p.y * 1e3, p.z * 1e3);
    }
    write("points.csv", &text);
    let mut text = String::from("point,x,y,z\n");
    for (k, arc) in arcs.iter().enumerate() {
        for p in arc {
            text += &format!("R{k},{},{},{}\n", p.x * 1e3, p.y * 1e3, p.z * 1e3);
        }
    }
    write("anchor.csv", &text);
    let mut text = String::from("q;k2;ci95\n");
    for q in ANGLES {
        text += &format!("{q};{};0.001\n", printed().compliance(&TABLE_V, q.to_radians()) * 1e6);
    }
    write("k2.csv", &text);
    write("negative.csv", "q,k2\n0,0.3\n-50,-0.3\n-100,0.3\n");
    write("short.csv", "q,k2\n0,0.3\n-50,0.28\n");
    write("odd.csv", "q,x,y\n0,1,2\n");
    let all = ["compensator", "--circle", "points.csv", "--anchor", "anchor.csv", "--compliances", "k2.csv"];
    let ran = run(folder.path(), &[&all[..], &["--format", "json"]].concat());
    assert_eq!(ran.status, 0, "{}", ran.err);
    let json: Json = serde_json::from_str(&ran.out).expect("JSON");
    for (name, truth, unit) in [
        ("L", 184.72, "mm"),
        ("ax", 685.93, "mm"),
        ("ay", 123.30, "mm"),
        ("k2_0", 0.302, "1e-6 rad/(N.m)"),
        ("kc", 0.144, "1e-6 m/N"),
        ("s0", 458.0, "mm"),
    ] {
        let (value, ci95) = (json[name]["value"].as_f64().expect("a value"), json[name]["ci95"].as_f64().expect("one"));
        assert!((value / truth - 1.0).abs() < 1e-2 && ci95 > 0.0 && ci95 < 0.05 * truth, "{name}: {value} +- {ci95}");
        assert_eq!(json[name]["unit"], unit);
    }
    let ran = run(folder.path(), &all);
    println!("{}", ran.out);
    assert!(ran.status == 0 && ran.out.contains("k2_0") && ran.out.contains("phi = -79.8"), "{}", ran.out);
    let refused: &[(&[&str], i32, &str)] = &[
        (&[], 2, "give --circle FILE"),
        (&["--circle", "none.csv"], 2, "there is no file `none.csv`"),
        (&["--circle", "odd.csv"], 2, "`z`"),
        (&["--anchor", "anchor.csv"], 2, "--circle"),
        (&["--circle", "points.csv", "--compliances", "k2.csv"], 2, "give --anchor"),
        (&["--mounting", "184,685", "--compliances", "k2.csv"], 2, "give 3 finite numbers"),
        (&["--mounting", "184,685,123", "--compliances", "negative.csv"], 2, "must be above 0"),
        (&["--mounting", "184,685,123", "--compliances", "short.csv"], 1, "three angles or more"),
    ];
    for (arguments, status, message) in refused {
        let ran = run(folder.path(), &[&["compensator"], *arguments].concat());
        assert_eq!(ran.status, *status, "{arguments:?}: {}", ran.err);
        assert!(ran.err.contains(message), "{arguments:?}: {}", ran.err);
    }
}

/// Tables in other units, angles in rad or of another order: refused, unless forced.
#[test]
fn compensators_of_no_machine_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: String| std::fs::write(folder.path().join(name), text).expect("written");
    let (points, arcs) = measured(20e-6, 7);
    let circle = |angle: fn(f64) -> f64, size: f64| {
        let rows = points.iter().map(|(q, p)| format!("{},{},{},{}\n", angle(*q), p.x * size, p.y * size, p.z * size));
        std::iter::once("q,x,y,z\n".into()).chain(rows).collect::<String>()
    };
    let anchor = |size: f64| {
        let rows = arcs.iter().enumerate().flat_map(|(k, arc)| {
            arc.iter().map(move |p| format!("R{k},{},{},{}\n", p.x * size, p.y * size, p.z * size))
        });
        std::iter::once("point,x,y,z\n".into()).chain(rows).collect::<String>()
    };
    let table = |angle: fn(f64) -> f64, compliance: fn(f64) -> f64| {
        let row = |q: f64| {
            let q = q.to_radians();
            format!("{},{}\n", angle(q), compliance(printed().compliance(&TABLE_V, q)))
        };
        std::iter::once("q,k2\n".into()).chain(ANGLES.map(row)).collect::<String>()
    };
    write("p.csv", circle(f64::to_degrees, 1e3));
    write("p-rad.csv", circle(|q| q, 1e3));
    write("p-m.csv", circle(f64::to_degrees, 1.0));
    write("a.csv", anchor(1e3));
    write("a-m.csv", anchor(1.0));
    write("p-order.csv", {
        let mut rows: Vec<String> = circle(f64::to_degrees, 1e3).lines().map(str::to_string).collect();
        // Angles of two rows exchanged.
        let [one, other] = [2, 5].map(|row| rows[row].split_once(',').expect("columns").0.to_string());
        rows[2] = rows[2].replacen(&one, &other, 1);
        rows[5] = rows[5].replacen(&other, &one, 1);
        rows.join("\n")
    });
    write("k.csv", table(f64::to_degrees, |k| k * 1e6));
    write("k-rad.csv", table(|q| q, |k| k * 1e6));
    write("k-si.csv", table(f64::to_degrees, |k| k));
    write("k-stiffness.csv", table(f64::to_degrees, |k| 1.0 / k));
    write("k-sign.csv", table(|q| -q.to_degrees(), |k| k * 1e6));
    let mounting = ["--mounting", "184.72,685.93,123.3"];
    let right: [&[&str]; 2] = [
        &["--circle", "p.csv", "--anchor", "a.csv", "--compliances", "k.csv"],
        &[&mounting[..], &["--compliances", "k.csv"]].concat(),
    ];
    for arguments in right {
        let ran = run(folder.path(), &[&["compensator"], arguments].concat());
        assert!(ran.status == 0 && ran.err.is_empty(), "{arguments:?}: {}", ran.err);
    }
    let wrong: &[(&[&str], &str)] = &[
        (&["--circle", "p-m.csv", "--anchor", "a-m.csv"], "give coordinates in mm"),
        (&["--circle", "p-rad.csv", "--anchor", "a.csv"], "with q read in rad they agree"),
        (&["--circle", "p-order.csv", "--anchor", "a.csv"], "from where their angles q put them"),
        (&["--mounting", "0.18472,0.68593,0.1233", "--compliances", "k.csv"], "the lever L is 0.1847 mm"),
        (&["--mounting", "184.72,685.93,123.3", "--compliances", "k-rad.csv"], "span 2.44 deg"),
        (&["--mounting", "184.72,685.93,123.3", "--compliances", "k-si.csv"], "not stiffnesses"),
        (&["--mounting", "184.72,685.93,123.3", "--compliances", "k-stiffness.csv"], "not stiffnesses"),
    ];
    for (arguments, said) in wrong {
        let ran = run(folder.path(), &[&["compensator"], *arguments].concat());
        assert!(ran.status == 2 && ran.err.contains(said), "{arguments:?}: {} {}", ran.status, ran.err);
    }
    let k6 = table(f64::to_degrees, |k| k * 1e6).lines().map(|line| format!("{line},0.001\n")).collect::<String>();
    let k6 = k6.replacen("k2,0.001", "k2,ci95", 1);
    let value = k6.lines().nth(2).and_then(|line| line.split(',').nth(1)).expect("a value").to_string();
    let off = value.parse::<f64>().expect("a number") + 0.005;
    write("k-wrong.csv", k6.replacen(&value, &off.to_string(), 1));
    write("k-same.csv", table(f64::to_degrees, |_| 0.3));
    let doubted = run(folder.path(), &[&["compensator"], &mounting[..], &["--compliances", "k-wrong.csv"]].concat());
    assert!(doubted.out.contains("times as far from the compliances"), "{}{}", doubted.out, doubted.err);
    let same = run(folder.path(), &[&["compensator"], &mounting[..], &["--compliances", "k-same.csv"]].concat());
    assert!(same.status != 0, "{}", same.out);
    let forced = run(folder.path(), &["compensator", "--force", "--circle", "p-m.csv", "--anchor", "a-m.csv"]);
    assert!(forced.status == 0 && forced.out.starts_with("DOUBTFUL (wrong-units)"), "{}{}", forced.out, forced.err);
    let sign = run(folder.path(), &[&["compensator"], &mounting[..], &["--compliances", "k-sign.csv"]].concat());
    assert!(sign.status != 0, "{}", sign.out);
}
