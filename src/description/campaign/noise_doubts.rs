//! Noise that a campaign states and none of its readings has.

use super::raw::RawCampaign;
use super::source::Source;
use super::stated::NOISE_COLUMNS;
use super::{Campaign, Reading};
use crate::description::resolve::Locate;
use crate::diagnostic::{Code, Diagnostic};

/// Noise of lengths where none are read: in a column an error, of the instrument a warning; `ppm` without `sigma`.
pub fn of_no_reading(campaign: &Campaign, raw: &RawCampaign, locate: Locate, sources: &[Source]) -> Vec<Diagnostic> {
    let mut found: Vec<Diagnostic> = sources.iter().filter_map(in_a_column).collect();
    found.extend(of_instrument(campaign, raw, locate));
    found.extend(only_ppm(campaign, raw, locate));
    found
}

/// What to state instead of the noise of lengths.
const OTHERS: &str = "state that of angles by `instrument: {orientation: ..}` (in `units: angle`), that of torques by `instrument: {torque: ..}`";

fn in_a_column(source: &Source) -> Option<Diagnostic> {
    let kinds: Vec<&str> = source.kinds.iter().map(|kind| kind.name()).collect();
    if kinds.is_empty() || source.kinds.iter().any(|kind| kind.length_rows() > 0) {
        return None;
    }
    let (column, ..) = NOISE_COLUMNS.into_iter().find(|(column, ..)| source.table.has(column))?;
    let message =
        format!("column `{column}` is the noise of lengths, and readings of `{}` hold none", kinds.join("`, `"));
    Some(
        Diagnostic::error(message)
            .at(source.table.place(0, column))
            .remedy(format!("remove or `ignore` it, and {OTHERS}")),
    )
}

fn of_instrument(campaign: &Campaign, raw: &RawCampaign, locate: Locate) -> Option<Diagnostic> {
    raw.instrument.as_ref()?.sigma.as_ref()?;
    let has_lengths = |reading: &Reading| reading.observes.length_rows() > 0;
    (!campaign.readings.is_empty() && !campaign.readings.iter().any(has_lengths)).then(|| {
        let message = "`sigma` of the instrument is the noise of lengths, and no reading holds any: it is not used";
        Diagnostic::warning(message).code(Code::Doubtful).at(locate(&["instrument", "sigma"])).remedy(OTHERS)
    })
}

/// A part of the distance that is added to a noise which nobody states.
fn only_ppm(campaign: &Campaign, raw: &RawCampaign, locate: Locate) -> Option<Diagnostic> {
    raw.instrument.as_ref()?.ppm?;
    let is_unstated = |reading: &Reading| reading.observes.length_rows() > 0 && !reading.noise.is_stated[0];
    campaign.readings.iter().any(is_unstated).then(|| {
        let message = "`ppm` of the instrument is added to a `sigma`, which is not stated: no noise is known";
        let diagnostic = Diagnostic::warning(message).code(Code::Doubtful).at(locate(&["instrument", "ppm"]));
        diagnostic.remedy("state `sigma` too, the part that does not grow with the distance")
    })
}
