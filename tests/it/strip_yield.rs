//! A strip that yields: against the published elastic-plastic cantilever, the elastica, and the arm that bends it.

use elastogeo::description::process::RawProcess;
use elastogeo::process::{Process, ProcessError, Strip, Tip, bend};
use nalgebra::Vector3;

use crate::cli::run;
use crate::figures::recorded;

/// A strip of 500 x 40 x 10 mm along x, pushed along y; Young's modulus 70 GPa.
fn strip(more: &str) -> Process {
    let text = format!(
        "units: {{length: mm, pressure: MPa}}
strip: {{clamp: [0, 0, 0], along: [1, 0, 0], push: [0, 1, 0], length: 500, width: 40, height: 10, young: 70000{more}}}"
    );
    Process::new(&serde_yaml::from_str::<RawProcess>(&text).expect("a process"))
}

fn own(process: &Process) -> &Strip {
    process.strip.as_ref().expect("a strip")
}

/// How far a tip is pushed across the clamp's tangent.
fn deflection(tip: &Tip) -> f64 {
    let (sine, cosine) = tip.slope.sin_cos();
    sine * tip.at[0] + cosine * tip.at[1]
}

/// Deflection of an elastic, perfectly plastic cantilever of rectangular section under a load at its tip, over that at which
/// it yields, by the load over that: Timoshenko, *Strength of Materials* II, sec. 64; Prager and Hodge 1951, sec. 9.
fn published(load: f64) -> f64 {
    (5.0 - (3.0 + load) * (3.0 - 2.0 * load).sqrt()) / (load * load)
}

/// Small bends: a yield stress of 0.07 MPa lets the outer fibres yield at a deflection of 17 um.
#[test]
fn a_strip_that_yields_bends_and_springs_back_as_published() {
    let process = strip(", yield: 0.07");
    let plastic = own(&process).plastic.as_ref().expect("it yields");
    let length = 0.5;
    let yields = plastic.yields * length * length / 3.0;
    let mut lines = Vec::new();
    for load in [1.0_f64, 1.1, 1.2, 1.3, 1.4, 1.45] {
        let n = load * plastic.yields / length;
        let under = deflection(&plastic.tip(n, 0.0, 0.0, length)) / yields;
        let bent = plastic.after(n, 0.0, 0.0, length).bent(n, 0.0, 0.0, length);
        let left = bent.left / yields;
        let [under_is, left_is] = [published(load), published(load) - load];
        lines.push(format!("{load}: bent {under_is:.5} published, {under:.5} here; left {left_is:.5}, {left:.5}"));
        assert!(
            (under / under_is - 1.0).abs() < 2e-4 && (left - left_is).abs() < 3e-4 * under_is,
            "{load}: {under} {left}"
        );
        assert!((bent.under / yields - under).abs() < 3e-4 * under, "{load}: {}", bent.under / yields);
        let elastic = plastic.after(0.99 * plastic.yields / length, 0.0, 0.0, length);
        assert_eq!(&elastic, plastic, "below yield nothing stays");
    }
    recorded("strip-yield", "cargo test a_strip_that_yields", &lines);
}

/// Hardening: far beyond yield the curvature is that of the tangent modulus.
#[test]
fn hardening_takes_over_where_the_section_has_yielded() {
    let process = strip(", yield: 0.07, hardening: 7000");
    let plastic = own(&process).plastic.as_ref().expect("it yields");
    // The deflection of a bilinear cantilever by integration of its moments, Simpson's rule.
    let of = |moment: f64| -> f64 {
        let (mut low, mut high) = (0.0_f64, 1e3);
        let held = |u: f64| if u <= 1.0 { u } else { 0.1 * u + 0.9 * (1.5 - 0.5 / (u * u)) };
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if held(middle) < moment { low = middle } else { high = middle }
        }
        low
    };
    for load in [1.2_f64, 2.0, 4.0] {
        let steps = 20_000;
        let area: f64 = (0..=steps)
            .map(|k| {
                let x = f64::from(k) / f64::from(steps);
                let weight = if k == 0 || k == steps {
                    1.0
                } else if k % 2 == 1 {
                    4.0
                } else {
                    2.0
                };
                weight * x * of(load * x)
            })
            .sum();
        let expected = area / (3.0 * f64::from(steps)) * plastic.yields * 0.25;
        let found = deflection(&plastic.tip(load * plastic.yields / 0.5, 0.0, 0.0, 0.5));
        assert!((found / expected - 1.0).abs() < 2e-4, "{load}: {found} {expected}");
    }
}

/// What never yields is the elastica, however it is bent.
#[test]
fn a_high_yield_stress_leaves_the_elastica() {
    let (yielding, elastic) = (strip(", yield: 6900, friction: 0.2"), strip(", friction: 0.2"));
    let plastic = own(&yielding).plastic.as_ref().expect("it yields");
    // The steps of the integration differ, and so does its error (1e-9 at the greatest bends).
    for n in [0.1, 1.0, 4.0] {
        let (a, b) = (plastic.tip(n, 0.2, 0.005, 0.5), bend(n, 0.2, 0.005, 0.5));
        assert!((a.slope - b.slope).abs() < 1e-9 && (a.at[1] - b.at[1]).abs() < 1e-9, "{a:?} {b:?}");
        let pairs = a.by_n.iter().zip(&b.by_n).chain(a.by_length.iter().zip(&b.by_length));
        pairs.for_each(|(a, b)| assert!((a - b).abs() < 1e-8, "{a} {b}"));
    }
    let travel = Vector3::new(-1.0, 0.0, 0.0);
    for at in [Vector3::new(0.45, 0.01, 0.0), Vector3::new(0.3, 0.05, 0.0), Vector3::new(0.4, -0.01, 0.0)] {
        let [a, b] = [&yielding, &elastic].map(|process| process.push(&at, &travel).expect("a push"));
        assert!((a.force - b.force).norm() <= 1e-8 * b.force.norm(), "{} {}", a.force, b.force);
        assert!((a.gradient - b.gradient).norm() <= 1e-7 * b.gradient.norm());
        let after = yielding.after(&at, &travel).expect("a place");
        assert!(after.is_none_or(|(after, bent)| after == yielding && bent.left == 0.0 && bent.worst == 1.0));
    }
}

/// A second pass over a strip that has kept part of its bend: it is touched later, and holds as it did where it is bent as far.
#[test]
fn a_second_pass_finds_the_strip_bent() {
    let process = strip(", yield: 150");
    let travel = Vector3::new(-1.0, 0.0, 0.0);
    let (deep, shallow) = (Vector3::new(0.4, 0.045, 0.0), Vector3::new(0.4, 0.01, 0.0));
    let first = process.push(&deep, &travel).expect("a push").force;
    let (after, bent) = process.after(&deep, &travel).expect("a place").expect("touched");
    assert!(bent.worst > 1.5 && bent.left > 0.01 && bent.under > bent.left, "{bent:?}");
    // The elastic strip would push harder.
    assert!(strip("").push(&deep, &travel).expect("a push").force.norm() > 1.1 * first.norm());
    let again = after.push(&deep, &travel).expect("a push").force;
    assert!((again - first).norm() < 2e-3 * first.norm(), "reloaded to where it was: {first} {again}");
    assert_eq!(after.push(&shallow, &travel).expect("a place").force, Vector3::zeros(), "it hangs lower");
    assert!(process.push(&shallow, &travel).expect("a push").force.norm() > 1.0);
    // What does not harden folds at the clamp before the tool is as deep as 20/9 of where it yields.
    let folded = process.push(&Vector3::new(0.4, 0.06, 0.0), &travel);
    assert!(matches!(folded, Err(ProcessError::Hinge { .. })), "{folded:?}");
    assert!(strip(", yield: 150, hardening: 1000").push(&Vector3::new(0.4, 0.06, 0.0), &travel).is_ok());
    // Its derivative, after yielding, is that of differences; between what yields anew and what unloads it has a kink.
    for (of, at) in
        [(&process, deep), (&after, Vector3::new(0.42, 0.04, 0.0)), (&after, Vector3::new(0.39, 0.045, 0.0))]
    {
        let gradient = of.push(&at, &travel).expect("a push").gradient;
        for axis in 0..2 {
            let step = Vector3::ith(axis, 1e-6);
            let [up, down] = [at + step, at - step].map(|at| of.push(&at, &travel).expect("a push").force);
            let away = (gradient.column(axis) - (up - down) / 2e-6).norm() / gradient.norm();
            // A step of the integration over the edge of what has yielded makes no difference to more than that.
            assert!(away < 1e-2, "{at}: {away:e}");
        }
    }
}

const PROCESS: &str = "process: Strip that yields
units: {length: mm, force: N, pressure: GPa}
carried: [0, 0, -920]
strip: {clamp: [2230, 0, 1425], along: [-1, 0, 0], push: [0, 0, -1], length: 585, width: 50, height: 14, young: 69.5";

/// The arm of the bundled path bends such a strip: the compensated commands pass where they should, also on a second pass.
#[test]
fn an_arm_bends_a_strip_that_yields() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    write("yields.yaml", &format!("{PROCESS}, yield: 0.15}}\n"));
    let mut path = String::from("pose,x,y,z,rx,ry,rz\n");
    for pass in 1..=2 {
        for (k, (x, z)) in [(1650, 1430), (1650, 1400), (1750, 1400), (1850, 1400), (1850, 1430)].iter().enumerate() {
            path += &format!("pass {pass} {k},{x},0,{z},180,0,0\n");
        }
    }
    write("path.csv", &path);
    let ran = |arguments: &[&str]| {
        let ran = run(folder.path(), arguments);
        assert_eq!(ran.status, 0, "{}{}", ran.out, ran.err);
        ran.out
    };
    let json = |arguments: &[&str]| -> serde_json::Value {
        serde_json::from_str(&ran(&[arguments, &["--format", "json"]].concat())).expect("JSON")
    };
    let compensate = ["compensate", "kuka-ir663", "path.csv", "--process", "yields.yaml"];
    let found = json(&compensate);
    let number = |value: &serde_json::Value| value.as_f64().expect("a number");
    let point = |k: usize| &found["points"][k];
    assert!(point(0)["strip"].is_null() && point(4)["strip"].is_null(), "above the strip");
    let force = |k: usize| number(&point(k)["wrench"][2]) + 920.0;
    // Near the clamp the strip yields; on the second pass the free end is met lower and with less force.
    assert!(force(3) > 300.0 && force(6) < 0.9 * force(1), "{} {} {}", force(3), force(1), force(6));
    assert!(found["points"].as_array().expect("points").iter().all(|point| number(&point["settled"]) < 1e-6));
    let left = &found["strip"];
    assert!(number(&left["left"]) > 1e-3 && number(&left["sprung_back"]) > number(&left["left"]), "{left}");
    assert!((number(&left["bent"]) - number(&left["left"]) - number(&left["sprung_back"])).abs() < 1e-12);
    let text = ran(&compensate);
    assert!(
        text.contains("the strip yields from point pass 1 ") && text.contains("remain when the tool leaves"),
        "{text}"
    );
    // Played back, the commands meet the path with the history that compensation foresaw.
    ran(&[&compensate[..], &["--table", "commands.csv"]].concat());
    let simulate = ["simulate", "kuka-ir663", "--process", "yields.yaml", "--poses"];
    let played = json(&[&simulate[..], &["commands.csv", "--into", "played"]].concat());
    let points = played["points"].as_array().expect("points");
    for (k, played) in points.iter().enumerate() {
        let wrench = (number(&played["wrench"][2]) - number(&point(k)["wrench"][2])).abs();
        assert!(wrench < 0.05, "{k}: {wrench} N");
    }
    let said = ran(&[&simulate[..], &["path.csv", "--into", "uncorrected"]].concat());
    assert!(said.contains("the strip yields from point"), "{said}");
}

#[test]
fn what_cannot_yield_is_refused_at_its_place() {
    let folder = tempfile::tempdir().expect("a folder");
    for (more, said) in [
        ("yield: 0", "`yield` is 0"),
        ("yield: 30", "below a tenth of `young`"),
        ("yield: 0.1, theory: euler-bernoulli", "does not yield"),
        ("hardening: 1", "the strip does not yield"),
        ("yield: 0.1, hardening: 70", "from 0 to below `young`"),
    ] {
        std::fs::write(folder.path().join("p.yaml"), format!("{PROCESS}, {more}}}\n")).expect("written");
        let ran = run(folder.path(), &["compensate", "kuka-ir663", "ir663-strip", "--process", "p.yaml"]);
        assert_eq!(ran.status, 2, "{more}: {}", ran.out);
        assert!(ran.err.contains(said) && ran.err.contains("p.yaml:4:"), "{more}: {}", ran.err);
    }
}
