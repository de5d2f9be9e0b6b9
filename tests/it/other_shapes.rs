//! Errors whose shape a law of the catalogue has nearly: waves with corners or steps, moves to and fro, amounts that no machine has. Each
//! next to the law itself, which is named.

use elastogeo::description::raw::{RawAmount, RawEffect};
use elastogeo::diagnosis::Level;
use elastogeo::model::Model;

use super::laws::{arm, causes_of_ur5, read_at};
use super::support::diagnosed;

/// Effects of transmission at joint 3 of so many periods in a turn, with these sines, rad.
fn harmonics(sines: &[(f64, f64)]) -> String {
    let of = |(order, sine): &(f64, f64)| {
        format!("- {{effect: transmission-error, site: joint:3, parameters: {{order: {order}, sin: {sine:e}}}}}\n")
    };
    sines.iter().map(of).collect()
}

/// The first harmonics of a wave, of the k-th odd one by `share`.
fn wave(order: f64, amount: f64, share: impl Fn(f64, f64) -> f64) -> String {
    let odd = (0..5).map(|k| (2.0 * f64::from(k) + 1.0, if k % 2 == 0 { 1.0 } else { -1.0 }));
    harmonics(&odd.map(|(odd, sign)| (order * odd, amount * share(odd, sign))).collect::<Vec<_>>())
}

/// A triangle has 1/9 of its swing in the third harmonic and a square 1/3: the swing takes 99 and 81 % of their squares.
#[test]
fn a_wave_with_corners_is_no_swing() {
    let triangle = wave(3.0, 1e-3, |odd, sign| sign / (odd * odd));
    let square = wave(4.0, 3e-4, |odd, _| 1.0 / odd);
    for (shape, effects) in [("triangle", triangle), ("square", square)] {
        let causes = causes_of_ur5(&effects, "80", "0.02");
        assert!(!causes.is_empty() && causes.iter().all(|cause| cause["level"] != "law"), "{shape}: {causes:?}");
        assert_eq!((&causes[0]["site"], &causes[0]["follows"]), (&"joint:3".into(), &"q3".into()), "{shape}");
    }
}

/// Gears have a second harmonic, which is none of a wave with corners.
#[test]
fn a_swing_with_a_second_harmonic_is_named() {
    for sines in [&[(3.0, 1e-3)][..], &[(3.0, 1e-3), (6.0, 2.4e-4)]] {
        let causes = causes_of_ur5(&harmonics(sines), "80", "0.02");
        let named: Vec<_> = causes.iter().map(|cause| ["effect", "site", "level"].map(|key| &cause[key])).collect();
        assert_eq!(named[0], ["transmission-error", "joint:3", "law"], "{causes:?}");
    }
}

/// An arm with a jump of something by so much along x at each of these times (s).
fn jumping(effect: &str, site: &str, (symbol, key): (&str, &str), jumps: &[(f64, f64)]) -> (Model, Model) {
    let parameters = |(by, at): (f64, f64)| {
        let mut all = vec![(symbol, RawAmount::from(by)), (key, at.into())];
        all.extend((effect == "frame-drift").then(|| ("course", "jump".into())));
        all
    };
    let (plain, mut spoiled) = arm(effect, site, &parameters(jumps[0]));
    for jump in &jumps[1..] {
        let parameters = parameters(*jump).into_iter().map(|(name, value)| (name.to_string(), value)).collect();
        let raw =
            RawEffect { effect: Some(effect.into()), site: Some(site.into()), parameters, ..RawEffect::default() };
        spoiled.switch_on(plain.resolve_effect(&raw).expect("an effect"));
    }
    (plain, spoiled)
}

/// What moves twice, and the second time half way back, has not moved at one time.
#[test]
fn what_moves_twice_has_not_moved_once() {
    let of_base = ("frame-drift", "base", ("x", "jump_at"), 4e-4);
    let of_joint = ("joint-slip", "joint:3", ("offset", "slip_at"), 3e-4);
    for (effect, site, keys, by) in [of_base, of_joint] {
        for (jumps, is_law) in [(&[(by, 2000.0)][..], true), (&[(by, 1200.0), (-0.5 * by, 2700.0)], false)] {
            let (plain, spoiled) = jumping(effect, site, keys, jumps);
            let found = diagnosed(&plain, &read_at(50, &plain, &spoiled, 0.7));
            let said: Vec<String> =
                found.causes.iter().map(|cause| format!("{}@{} {:?}", cause.effect, cause.site, cause.level)).collect();
            let has_law = found.causes.iter().any(|cause| cause.level == Level::Law);
            assert_eq!(has_law, is_law, "{effect} {jumps:?}: {said:?}");
        }
    }
}

/// An angle encoder of the instrument that errs by 100 arc seconds: none does, and the first joint, which stands below it, is not made to
/// err in its place.
#[test]
fn amounts_beyond_reason_are_not_put_on_a_joint() {
    let number = RawAmount::from;
    let (plain, spoiled) = arm(
        "instrument-encoder",
        "instrument",
        &[("cos", number(4e-4)), ("sin", number(3e-4)), ("angle", "azimuth".into()), ("periods", number(2.0))],
    );
    let found = diagnosed(&plain, &read_at(80, &plain, &spoiled, 0.9));
    let said: Vec<String> =
        found.causes.iter().map(|cause| format!("{}@{} {:?}", cause.effect, cause.site, cause.level)).collect();
    assert!(found.causes.iter().all(|cause| cause.level != Level::Law), "{said:?}");
}
