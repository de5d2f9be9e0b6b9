//! A simulated campaign as files: description, measurements in mm and deg, and the truth in SI.

use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use serde_json::Value;

use crate::Error;
use crate::blind::seal as digest;
use crate::cli::args::{SchemaOf, Simulate};
use crate::cli::commands::schema::file_name;
use crate::cli::output::Output;
use crate::description::campaign::raw::{
    Measurements, RawCampaign, RawEstimate, RawInstrument, RawKinds, RawSharing, RawSigma,
};
use crate::description::campaign::{self, Campaign};
use crate::description::units::{Angle, Force, Length, Torque, Units};
use crate::description::yaml;
use crate::files::{LoadedRobot, schema_line};
use crate::results::{OwnWeight, PathPoint, Simulation, Truth};
use crate::simulation::Plan;

/// What a campaign was made with.
pub struct Made<'a> {
    pub command: &'a Simulate,
    pub loaded: &'a LoadedRobot,
    pub values: &'a [f64],
    pub plan: &'a Plan,
    pub seed: u64,
}

/// Key of truth.json: SHA-256 of the files written next to it, by name.
pub const DIGESTS: &str = "files";

/// A campaign and its truth as files.
///
/// # Errors
/// A folder that cannot be made, or a campaign that cannot be written.
pub fn delivered(
    made: &Made,
    mut campaign: Campaign,
    points: Option<Vec<PathPoint>>,
    random: &mut ChaCha8Rng,
) -> Result<Output, Error> {
    let Made { command, loaded, values, plan, seed } = *made;
    campaign = with_sets(command, campaign, random);
    let header = raw_campaign(command, loaded, &campaign, plan, seed);
    let files = vec![("measurements.csv".to_string(), csv(loaded, &campaign)?)];
    written(command, loaded, values, seed, Simulated { campaign: &campaign, header: &header, files, points })
}

/// The campaign with a share of its configurations drawn to check.
pub fn with_sets(command: &Simulate, mut campaign: Campaign, random: &mut ChaCha8Rng) -> Campaign {
    let mut order: Vec<usize> = (0..campaign.poses.len()).collect();
    order.shuffle(random);
    order.truncate((command.check * order.len() as f64).round() as usize);
    campaign.readings.iter_mut().for_each(|reading| reading.check = Some(order.contains(&reading.pose)));
    campaign
}

/// A simulated campaign.
pub struct Simulated<'a> {
    pub campaign: &'a Campaign,
    /// Its file.
    pub header: &'a RawCampaign,
    /// Files of its readings: names and texts.
    pub files: Vec<(String, String)>,
    /// Points of a path.
    pub points: Option<Vec<PathPoint>>,
}

/// A campaign with its file and those of its readings, and its truth.
///
/// # Errors
/// As [`delivered`].
pub fn written(
    command: &Simulate,
    loaded: &LoadedRobot,
    values: &[f64],
    seed: u64,
    simulated: Simulated,
) -> Result<Output, Error> {
    let Simulated { campaign, header, files, points } = simulated;
    let model = &loaded.model;
    let truth = Truth::new(model, values, seed);
    let header_file = command.into.join("campaign.yaml");
    let (readings, poses) = (campaign.readings.len(), campaign.poses.len());
    let own_weight = OwnWeight::of_campaign(model, values, campaign);
    let text = format!(
        "{readings} readings at {poses} configurations: {}\n{}\n",
        header_file.display(),
        own_weight.of_readings()
    );
    let made = Simulation { campaign: header_file.display().to_string(), readings, own_weight, truth, points };
    let mut output = Output::new(text, &made)?;
    output.diagnostics = loaded.diagnostics.clone();
    std::fs::create_dir_all(&command.into).map_err(|error| {
        Error::input(format!("`{}` cannot be made: {error}", command.into.display()), "give another folder")
    })?;
    let line = schema_line(&header_file, file_name(SchemaOf::Campaign));
    let mut made = files;
    made.push(("campaign.yaml".into(), line + &yaml::write(header)?));
    // Their digests show the next run whether someone has edited them since.
    let mut truth = output.json["truth"].clone();
    let digests = made.iter().map(|(name, text)| (name.clone(), digest(text).into())).collect();
    truth.as_object_mut().map(|truth| truth.insert(DIGESTS.into(), Value::Object(digests)));
    output.files = made.into_iter().map(|(name, text)| (command.into.join(name), text)).collect();
    output.files.push((command.into.join("truth.json"), serde_json::to_string_pretty(&truth)? + "\n"));
    Ok(output)
}

/// What a campaign file says of where its readings come from.
pub fn source(seed: u64) -> String {
    format!("simulated by elastogeo {} with seed {seed}; truth.json holds the truth", env!("CARGO_PKG_VERSION"))
}

fn raw_campaign(command: &Simulate, loaded: &LoadedRobot, campaign: &Campaign, plan: &Plan, seed: u64) -> RawCampaign {
    let robot = as_seen_from(&command.into, &command.robot);
    RawCampaign {
        campaign: Some(campaign.name.clone()),
        source: Some(source(seed)),
        robot: Some(robot),
        units: Units {
            length: Length::Millimetre,
            angle: Angle::Degree,
            force: Force::Newton,
            torque: Torque::NewtonMetre,
            ..loaded.raw.units
        },
        observes: Some(RawKinds::one(plan.observes)),
        instrument: (plan.sigma > 0.0).then(|| RawInstrument {
            sigma: Some(RawSigma::All(command.noise)),
            ppm: None,
            torque: None,
            orientation: (plan.observes.rows() > plan.observes.length_rows() && command.orientation_noise > 0.0)
                .then_some(command.orientation_noise),
        }),
        estimate: RawEstimate {
            base: RawSharing(command.unknown_base.then_some(campaign.sessions.base)),
            tool: RawSharing(command.unknown_tool.then_some(campaign.sessions.tool)),
            ..RawEstimate::default()
        },
        calibrate: Some(campaign.calibrate.clone()),
        measurements: Some(Measurements::file("measurements.csv")),
        ..RawCampaign::default()
    }
}

/// The robot as a campaign in `folder` names it: a file relative to the folder where that is plain, else absolute.
pub fn as_seen_from(folder: &std::path::Path, robot: &str) -> String {
    use std::path::{Component, Path};
    if !Path::new(robot).is_file() {
        return robot.into();
    }
    let plain = |path: &Path| path.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
    if plain(folder) && plain(Path::new(robot)) {
        let depth = folder.components().filter(|part| matches!(part, Component::Normal(_))).count();
        return "../".repeat(depth) + robot.trim_start_matches("./");
    }
    std::fs::canonicalize(robot).map_or_else(|_| robot.into(), |path| path.display().to_string())
}

/// Readings in mm and deg.
pub fn csv(loaded: &LoadedRobot, campaign: &Campaign) -> Result<String, Error> {
    let markers: Vec<String> = loaded.model.markers.iter().map(|marker| marker.name.clone()).collect();
    Ok(campaign::csv(campaign, &loaded.model.variables, &markers)?)
}
