//! `residuals`: a description against measurements, nothing fitted.

use serde_json::{Value, json};

use crate::Error;
use crate::cli::args::OnCampaign;
use crate::cli::{Output, Session};
use crate::estimation::errors_of;
use crate::prediction::{Linearised, Predictor};
use crate::render::identification::{errors_json, errors_table};

pub fn run(command: &OnCampaign, session: &Session) -> Result<Output, Error> {
    let loaded = session.reader.campaign(&command.campaign, Some(&command.robot))?;
    let (model, campaign) = (&loaded.robot.model, &loaded.campaign);
    let mut found = Linearised::default();
    let predictor = Predictor::new(model, campaign, Vec::new())?;
    predictor.linearise(&model.registry.nominal(), false, &mut found)?;
    let errors = |among: &dyn Fn(usize) -> bool| errors_of(campaign, &found.residual, among);
    let marker = |index: usize| campaign.readings[index].marker.map_or("TCP", |m| model.markers[m].name.as_str());
    let all = errors(&|_| true);
    let fit = errors(&|i| campaign.readings[i].check == Some(false));
    let check = errors(&|i| campaign.readings[i].check == Some(true));
    let mut names: Vec<&str> = (0..campaign.readings.len()).map(marker).collect();
    names.sort_unstable();
    names.dedup();
    let by_marker: Vec<(&str, crate::estimation::Errors)> =
        names.iter().map(|name| (*name, errors(&|i| marker(i) == *name))).collect();
    let components = campaign.components();
    let by_direction: Vec<f64> = (0..components.min(3))
        .map(|k| crate::math::mean_rms_max(found.residual.iter().skip(k).step_by(components).copied())[1] * 1e3)
        .collect();
    let mut rows = vec![("all", &all), ("set fit", &fit), ("set check", &check)];
    rows.extend(by_marker.iter().map(|(name, errors)| (*name, errors)));
    let mut text = errors_table(&rows, session.terminal.screen);
    let directions: Vec<String> =
        ["x", "y", "z"].iter().zip(&by_direction).map(|(axis, rms)| format!("{axis} {rms:.4} mm")).collect();
    if components > 1 {
        text += &format!("rms by direction: {}\n", directions.join(", "));
    }
    let readings: Vec<Value> = campaign
        .readings
        .iter()
        .zip(found.residual.chunks(components))
        .enumerate()
        .map(|(index, (reading, residual))| {
            let mut value = json!({"row": reading.row, "pose": campaign.poses[reading.pose], "marker": marker(index),
                                   "error": residual.iter().take(3).map(|v| v * 1e3).collect::<Vec<f64>>()});
            if components == 6 {
                value["orientation_error_deg"] =
                    json!(residual[3..6].iter().map(|v| v.to_degrees()).collect::<Vec<f64>>());
            }
            value
        })
        .collect();
    let markers: serde_json::Map<String, Value> =
        by_marker.iter().map(|(name, errors)| ((*name).to_string(), errors_json(errors))).collect();
    let json = json!({"unit": "mm", "all": errors_json(&all), "fit": errors_json(&fit), "check": errors_json(&check), "markers": markers,
                      "directions": by_direction, "readings": readings});
    let mut output = Output::new(text, json);
    output.diagnostics = loaded.diagnostics;
    Ok(output)
}
