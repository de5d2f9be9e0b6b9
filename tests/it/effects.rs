//! The catalogue against its documentation.

use elastogeo::effects::{Catalogue, NonlinearKind, NonlinearParameter, SiteKind};
use elastogeo::estimation::{Settings, calibrate};
use elastogeo::files::load_robot;
use elastogeo::kinematics::Geometry;
use elastogeo::observation::POSITION;
use elastogeo::prediction::{Linearised, Predictor};
use elastogeo::simulation::{Plan, draw_configurations, draw_errors, generator, simulate};

use super::support::switch_on;

fn site(kind: SiteKind) -> (&'static str, bool) {
    match kind {
        SiteKind::Frame => ("frame", true),
        SiteKind::Joint => ("joint", true),
        SiteKind::Link => ("link", true),
        SiteKind::Actuator => ("actuator", true),
        SiteKind::Base => ("base", false),
        SiteKind::Tool => ("tool", false),
        SiteKind::Instrument => ("instrument", false),
    }
}

#[test]
fn every_effect_has_its_section() {
    let path = format!("{}/docs/effects.md", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).expect("a file");
    let sections: Vec<&str> = text.split("\n## ").skip(1).collect();
    let named: Vec<&str> = sections.iter().map(|s| s.lines().next().unwrap_or_default().trim_matches('`')).collect();
    let names: Vec<&str> = Catalogue::standard().names().collect();
    assert_eq!(named, names, "one section each, in the order of the catalogue");
    for (effect, section) in Catalogue::standard().iter().zip(sections) {
        let (kind, is_named) = site(effect.sits_at());
        let name = if kind == "actuator" { "name" } else { "n" };
        let said = if is_named { format!("Site: `{kind}:<{name}>`") } else { format!("Site: `{kind}`") };
        assert!(section.contains(&said), "{}: {said}", effect.name());
        for part in ["* Looks like:", "* Told from", "* On the machine:"] {
            assert!(section.contains(part), "{}: {part}", effect.name());
        }
        for parameter in effect.nonlinear_parameters() {
            let NonlinearParameter { name, kind, .. } = parameter;
            assert!(section.contains(&format!("`{name}`")), "{}: {name}", effect.name());
            if let NonlinearKind::Choice(words) = kind {
                for word in *words {
                    assert!(section.contains(&format!("`{name}: {word}`")), "{}: {name}: {word}", effect.name());
                }
            }
        }
    }
}

/// Amounts of effects that are switched on are fitted with all else, and by derivatives that differences confirm.
#[test]
fn effects_switched_on_are_identified() {
    let mut model = load_robot("kuka-kr270").expect("a robot").model;
    type Amount<'a> = (&'a str, &'a str, &'a [(&'a str, f64)]);
    let amounts: [Amount; 3] = [
        ("gear-ratio", "joint:3", &[("ratio", 4e-4)]),
        ("backlash", "joint:1", &[("half_width", 3e-4), ("changes_at", 0.0)]),
        ("transmission-error", "joint:2", &[("cos", 3e-4), ("sin", -2e-4), ("order", 3.0)]),
    ];
    for (effect, site, parameters) in amounts {
        switch_on(&mut model, effect, site, parameters);
    }
    let mut random = generator(3);
    let truth = draw_errors(&model, 0.5, 0.0, &mut random);
    let plan = Plan {
        conditions: true,
        wrenches: vec![[0.0; 6]],
        configurations: draw_configurations(&Geometry::new(&model, &truth).expect("assembled"), 60, 0.8, &mut random)
            .expect("drawn"),
        markers: (0..model.markers.len()).map(Some).collect(),
        repeats: 1,
        observes: POSITION,
        sigma: 3e-5,
        sigma_orientation: 0.0,
        estimate: [true, true],
    };
    let campaign = simulate(&model, &truth, &plan, &mut random).expect("simulated");
    let names = [
        "gear-ratio@joint:3.ratio",
        "backlash@joint:1.half_width",
        "transmission-error@joint:2.cos",
        "transmission-error@joint:2.sin",
    ];
    let slots: Vec<usize> = names.iter().map(|name| model.registry.slot(name).expect("a parameter")).collect();

    let predictor = Predictor::new(&model, &campaign, slots.clone()).expect("a predictor");
    let (mut exact, mut up, mut down) = (Linearised::default(), Linearised::default(), Linearised::default());
    predictor.linearise(&truth, true, &mut exact).expect("linearised");
    for (column, &slot) in slots.iter().enumerate() {
        let mut moved = truth.clone();
        moved[slot] = truth[slot] + 1e-5;
        predictor.linearise(&moved, false, &mut up).expect("predicted");
        moved[slot] = truth[slot] - 1e-5;
        predictor.linearise(&moved, false, &mut down).expect("predicted");
        for row in 0..predictor.rows() {
            let difference = (down.residual[row] - up.residual[row]) / 2e-5;
            let ours = exact.jacobian[row * slots.len() + column];
            assert!((ours - difference).abs() < 1e-6 * (1.0 + ours.abs()), "{}: {ours} {difference}", names[column]);
        }
    }

    // What the description says of the amounts is wrong; the readings determine them.
    for &slot in &slots {
        model.registry.all_mut()[slot].nominal = 0.0;
    }
    let held_out = vec![false; campaign.readings.len()];
    let found = calibrate(&model, &campaign, &held_out, &Settings::default(), &mut |_| {}).expect("calibrated");
    for (name, &slot) in names.iter().zip(&slots) {
        let estimate = found.estimates.iter().find(|estimate| estimate.slot == slot).expect("an estimate");
        let ci95 = estimate.ci95.expect("identifiable");
        let off = (estimate.value - truth[slot]).abs();
        assert!(off < 2.0 * ci95 && ci95 < 0.2 * truth[slot].abs(), "{name}: {estimate:?}");
    }
}
