//! My robot is calibrated and still off: where, and why?
//!
//! Diagnoses a campaign: which effects explain what calibration leaves on unseen readings, and at which sites the gap lies.
//! `cargo run --example where_is_the_gap`, or with a campaign of yours: `cargo run --example where_is_the_gap -- my-robot`.
//! Among the lines that it prints for the bundled one, whose description has joint 1 rigid:
//!
//! ```text
//! Explained: 0.6665 mm rms on unseen readings, where noise alone makes 0.0520 mm
//! cause: joint-compliance at joint:1, 0.6665 -> 0.0566 mm
//!   to do: identify the stiffness (`identify --what elastic`) and compensate; inspect the gear
//!   these readings cannot separate it from base-compliance at base
//! 87 % of the gap could come from joint:1
//! ```

use std::fmt::Write;

use elastogeo::diagnosis::{Settings, diagnose};
use elastogeo::estimation::split;
use elastogeo::files::load_campaign;

#[allow(dead_code)] // a test includes this file
fn main() -> Result<(), elastogeo::Error> {
    let campaign = std::env::args().nth(1);
    print!("{}", report(campaign.as_deref().unwrap_or("kr270-rigid-joint-1"))?);
    Ok(())
}

/// Diagnoses a campaign, a folder or a bundled name.
pub fn report(campaign: &str) -> Result<String, elastogeo::Error> {
    let loaded = load_campaign(campaign, None)?;
    let (model, campaign) = (&loaded.robot.model, &loaded.campaign);
    let held_out = split(campaign, 0.25, 1);
    let found = diagnose(model, campaign, &held_out, &Settings::new(campaign, 1), &mut |_| {})?;

    let mut text = String::new();
    let [gap, noise] = [found.gap.rms, found.gap.noise].map(|error| 1e3 * error);
    let verdict = found.verdict;
    let _ = writeln!(text, "{verdict:?}: {gap:.4} mm rms on unseen readings, where noise alone makes {noise:.4} mm");
    for cause in &found.causes {
        let [before, after] = [cause.rms_before, cause.rms_after].map(|error| 1e3 * error);
        let _ = writeln!(text, "cause: {} at {}, {before:.4} -> {after:.4} mm", cause.effect, cause.site);
        let _ = writeln!(text, "  to do: {}", cause.remedy);
        for rival in &cause.rivals {
            let _ = writeln!(text, "  these readings cannot separate it from {} at {}", rival.effect, rival.site);
        }
    }
    for site in found.location.sites.iter().filter(|site| site.share > 0.5) {
        let _ = writeln!(text, "{:.0} % of the gap could come from {}", 100.0 * site.share, site.site);
    }
    Ok(text)
}
