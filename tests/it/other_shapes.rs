//! Errors whose shape a law of the catalogue has nearly: waves with corners or steps, two slips, amounts that no machine has; and laws
//! themselves, which are named.

use elastogeo::description::raw::RawAmount;
use elastogeo::diagnosis::Level;

use super::laws::{arm, causes_of_ur5, causes_of_ur5_with, read_at};
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

/// A joint that slips twice has not slipped once; in half of the time one slip takes most of it.
#[test]
fn what_moves_twice_has_not_moved_once() {
    let slip = |(offset, at): &(f64, f64)| {
        format!("- {{effect: joint-slip, site: joint:3, parameters: {{offset: {offset:e}, slip_at: {at}}}}}\n")
    };
    for (slips, is_law) in [(&[(4e-4, 1679.0)][..], true), (&[(4e-4, 1679.0), (2.4e-4, 3279.0)], false)] {
        let effects: String = slips.iter().map(slip).collect();
        let causes = causes_of_ur5_with(&effects, "60", "0.03", &["--conditions"]);
        let named: Vec<_> = causes.iter().map(|cause| ["effect", "site", "level"].map(|key| &cause[key])).collect();
        assert_eq!(causes.iter().any(|cause| cause["level"] == "law"), is_law, "{slips:?}: {named:?}");
        assert!(named.iter().all(|[_, site, _]| *site == "joint:3"), "{slips:?}: {named:?}");
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
