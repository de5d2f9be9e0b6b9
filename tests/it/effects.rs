//! The catalogue against what is said of it elsewhere.

use elastogeo::description::resolve::EFFECTS;
use elastogeo::effects::{SiteKind, catalogue};

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
fn descriptions_know_the_effects_of_the_catalogue() {
    let known: Vec<(&str, &str)> = catalogue().iter().map(|e| (e.name(), site(e.sits_at()).0)).collect();
    assert_eq!(known, EFFECTS);
}

#[test]
fn every_effect_has_its_section() {
    let path = format!("{}/docs/effects.md", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).expect("a file");
    let sections: Vec<&str> = text.split("\n## ").skip(1).collect();
    let named: Vec<&str> = sections.iter().map(|s| s.lines().next().unwrap_or_default().trim_matches('`')).collect();
    let names: Vec<&str> = catalogue().iter().map(|effect| effect.name()).collect();
    assert_eq!(named, names, "one section each, in the order of the catalogue");
    for (effect, section) in catalogue().into_iter().zip(sections) {
        let (kind, is_named) = site(effect.sits_at());
        let name = if kind == "actuator" { "name" } else { "n" };
        let said = if is_named { format!("Site: `{kind}:<{name}>`") } else { format!("Site: `{kind}`") };
        assert!(section.contains(&said), "{}: {said}", effect.name());
        for part in ["* Looks like:", "* Told from", "* On the machine:"] {
            assert!(section.contains(part), "{}: {part}", effect.name());
        }
        for symbol in effect.form_symbols() {
            assert!(section.contains(&format!("`{symbol}`")), "{}: {symbol}", effect.name());
        }
    }
}
