//! `check`: is the description, or the campaign, sound, and what does it say?

use std::path::Path;

use crate::Error;
use crate::cli::args::Check;
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::description::units::Units;
use crate::files::cannot_stand;
use crate::plausibility::{Evidence, Limits, as_stiff_as_arms, judge};
use crate::render::campaign::campaign as render_campaign;
use crate::render::robot as render;
use crate::results::{CampaignCheck, RobotSummary, SnapshotAgreement};
use crate::snapshot::{apart_from_model, range_of, snapshot};

pub fn run(command: &Check, session: &Session) -> Result<Output, Error> {
    if session.reader.is_campaign(&command.file) {
        return campaign(command, session);
    }
    if command.robot.is_some() {
        return Err(Error::input(format!("--robot, and `{}` is no campaign", command.file), "leave --robot out"));
    }
    let loaded = session.reader.robot(&command.file)?;
    let mut found = RobotSummary::new(&loaded.model, &loaded.raw);
    let mut text = render::robot(&found, &loaded.model, &loaded.raw, session.terminal.screen);
    let mut files = Vec::new();
    if let Some(path) = &command.snapshot {
        // Snapshots of earlier versions hold no units, nothing apart from the model, or no range of validity.
        let without_units = snapshot(&loaded.model)?;
        let of_model = format!("{without_units}\n{}", units(&loaded.raw.units)?);
        let without_range = format!("{of_model}{}", apart_from_model(&loaded.robot));
        let range = loaded.raw.validity.as_ref().map(range_of).unwrap_or_default();
        let new = format!("{without_range}{range}");
        let old = old(path)?;
        let shown = path.display();
        let agrees = old.as_ref().is_none_or(|old| [&new, &without_range, &of_model, &without_units].contains(&old));
        text = match &old {
            Some(_) if agrees => format!("{} agrees with {shown}\n", command.file),
            Some(old) => format!(
                "{} differs from {shown} (- snapshot, + now):\n{}delete the file and run again to accept what is now\n",
                command.file,
                difference(old, &new)
            ),
            None => format!("wrote {shown}\n"),
        };
        found.snapshot = Some(SnapshotAgreement { file: shown.to_string(), agrees });
        if old.is_none() {
            files.push((path.clone(), new));
        }
    }
    let mut output = Output::new(text, &found)?;
    output.failed = found.snapshot.is_some_and(|snapshot| !snapshot.agrees);
    output.diagnostics = loaded.diagnostics;
    output.diagnostics.extend(as_stiff_as_arms(&loaded.model, &Limits::default()));
    output.files = files;
    Ok(output)
}

fn campaign(command: &Check, session: &Session) -> Result<Output, Error> {
    if command.snapshot.is_some() {
        return Err(Error::input("--snapshot, and a campaign", "give its robot to `check --snapshot`"));
    }
    let loaded = session.reader.campaign(&command.file, command.robot.as_deref())?;
    let found = CampaignCheck::new(&loaded.robot.model, &loaded.campaign, loaded.raw.joints, &loaded.diagnostics);
    let mut output = Output::new(render_campaign(&found, session.terminal.screen), &found)?;
    output.diagnostics = loaded.diagnostics;
    output.diagnostics.extend(cannot_stand(&loaded.robot.model, &loaded.campaign));
    let judged = judge(&Evidence::of(&loaded.robot.model, &loaded.campaign), &Limits::default());
    output.judged(judged, session.arguments.force)
}

/// The units in which commands take and give values of a description.
fn units(units: &Units) -> Result<String, Error> {
    Ok(format!("units: {}\n", serde_json::to_string(units)?))
}

/// The text of a snapshot; `None` where there is no such file.
fn old(path: &Path) -> Result<Option<String>, Error> {
    match std::fs::read_to_string(path) {
        Ok(old) => Ok(Some(old)),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(Error::input(format!("`{}` cannot be read: {error}", path.display()), "give another file")),
    }
}

/// Lines that differ, line by line.
fn difference(old: &str, new: &str) -> String {
    let (old, new): (Vec<&str>, Vec<&str>) = (old.lines().collect(), new.lines().collect());
    let mut text = String::new();
    for k in 0..old.len().max(new.len()) {
        let (before, now) = (old.get(k), new.get(k));
        if before != now {
            before.iter().for_each(|line| text += &format!("- {line}\n"));
            now.iter().for_each(|line| text += &format!("+ {line}\n"));
        }
    }
    text
}
