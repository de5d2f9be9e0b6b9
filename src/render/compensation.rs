//! Compensated paths, in text and JSON.

use std::fmt::Write;

use nalgebra::Vector3;
use serde_json::{Map, Value, json};

use super::table::Screen;
use crate::compensation::{Outcome, Point, Refusal, Sides};
use crate::description::table::Sheet;
use crate::description::units::Units;
use crate::math::mean_rms_max;
use crate::model::Model;
use crate::observation::POSE;
use crate::results::units::{deg, mm};

/// What `compensate` found, with what the controller must be told.
#[derive(Debug, Clone)]
pub struct Compensation<'a> {
    /// The calibrated robot.
    pub model: &'a Model,
    /// Names of the points.
    pub names: &'a [String],
    /// Nominal commands, where there are any.
    pub nominal: &'a [Option<Vec<f64>>],
    /// What became of them.
    pub outcome: &'a Outcome,
    /// Pose of the commands by the controller's own geometry (m, rotation vector), base frame: "fake poses".
    pub poses: &'a [Option<[f64; 6]>],
}

/// Greatest number of points shown in text.
const MOST_SHOWN: usize = 200;

impl Compensation<'_> {
    fn done(&self) -> impl Iterator<Item = &Point> {
        self.outcome.points.iter().filter_map(|point| point.as_ref().ok())
    }

    /// Indices of the points refused, from 0, and why.
    pub fn refused(&self) -> impl Iterator<Item = (usize, &Refusal)> {
        self.outcome.points.iter().enumerate().filter_map(|(k, point)| Some((k, point.as_ref().err()?)))
    }

    /// Mean, rms and greatest distance from the target, m: uncorrected, and as predicted at the corrected commands.
    fn before_and_after(&self) -> [[f64; 3]; 2] {
        let before = self.done().filter_map(|point| point.before).map(|deviation| deviation.all.norm());
        [mean_rms_max(before), mean_rms_max(self.done().map(|point| point.corrected.position))]
    }

    /// JSON, SI.
    pub fn json(&self) -> Value {
        let joints = |q: &[f64]| -> Map<String, Value> {
            self.model.variables.iter().zip(q).map(|(v, q)| (v.name.clone(), json!(q))).collect()
        };
        let xyz = |v: &Vector3<f64>| json!([v.x, v.y, v.z]);
        let points = self.outcome.points.iter().enumerate().map(|(index, point)| match point {
            Err(why) => json!({"index": index, "name": self.names[index], "joints": null, "residual": null,
                               "status": format!("refused: {why}")}),
            Ok(point) => {
                let corrected = &point.corrected;
                let correction: Option<Vec<f64>> = self.nominal[index]
                    .as_ref()
                    .map(|nominal| corrected.joints.iter().zip(nominal).map(|(q, n)| q - n).collect());
                let before = point.before.map(|d| {
                    json!({"all": xyz(&d.all), "orientation": d.turned, "geometry": xyz(&d.geometry),
                           "weight": xyz(&d.weight), "wrench": xyz(&d.wrench), "effects": xyz(&d.effects)})
                });
                json!({"index": index, "name": self.names[index], "joints": joints(&corrected.joints),
                       "residual": corrected.position, "orientation_residual": corrected.orientation, "status": "ok",
                       "correction": correction.map(|c| joints(&c)), "pose": self.poses[index], "before": before,
                       "wrench": point.wrench, "settled": point.settled, "iterations": corrected.iterations,
                       "condition": corrected.condition})
            }
        });
        let [before, after] = self.before_and_after();
        let figures = |f: [f64; 3]| json!({"mean": f[0], "rms": f[1], "max": f[2]});
        json!({"unit": "m", "points": points.collect::<Vec<_>>(), "before": figures(before), "after": figures(after),
               "refused": self.refused().map(|(index, _)| index).collect::<Vec<_>>(), "sides": self.sides(),
               "left_out": self.outcome.left_out})
    }

    fn sides(&self) -> &'static str {
        match self.outcome.sides {
            Sides::Given => "given",
            Sides::Derived => "derived",
            Sides::Unsettled => "unsettled",
        }
    }

    /// Text.
    pub fn text(&self, screen: Screen) -> String {
        let model = self.model;
        let largest = |point: &Point, index: usize| -> String {
            let Some(nominal) = &self.nominal[index] else { return String::new() };
            let moved = |k: usize| point.corrected.joints[k] - nominal[k];
            let by = |k: usize| {
                if model.variables[k].is_angle { deg(moved(k)) } else { mm(moved(k)) }
            };
            let k = (0..nominal.len()).max_by(|a, b| by(*a).abs().total_cmp(&by(*b).abs()));
            k.map_or(String::new(), |k| {
                let variable = &model.variables[k];
                format!("{} {:+.4} {}", variable.name, by(k), if variable.is_angle { "deg" } else { "mm" })
            })
        };
        let norm = |v: &Vector3<f64>| format!("{:.4}", mm(v.norm()));
        let rows = self.outcome.points.iter().enumerate().filter_map(|(index, point)| {
            let point = point.as_ref().ok()?;
            let mut row = vec![(index + 1).to_string(), self.names[index].clone()];
            match &point.before {
                Some(d) => row.extend([&d.all, &d.geometry, &d.weight, &d.wrench, &d.effects].map(norm)),
                None => row.extend(std::iter::repeat_n("-".to_string(), 5)),
            }
            row.push(largest(point, index));
            row.push(format!("{:.1e}", mm(point.corrected.position)));
            Some(row)
        });
        let rows: Vec<Vec<String>> = rows.collect();
        let left = rows.len().saturating_sub(MOST_SHOWN);
        let header = [
            "point",
            "name",
            "missed mm",
            "geometry",
            "own weight",
            "wrench",
            "effects",
            "largest correction",
            "residual mm",
        ];
        let mut out = format!("{}: compensated path\n\n", model.name);
        if !rows.is_empty() {
            out += &screen.table(&header, rows.into_iter().take(MOST_SHOWN));
        }
        if left > 0 {
            let _ = writeln!(out, "and {left} more (--format json, --table)");
        }
        let [before, after] = self.before_and_after();
        let done = self.done().count();
        if self.done().any(|point| point.before.is_none()) {
            out += "\n-: without correction arm and process find no balance there\n";
        }
        let all = self.outcome.points.len();
        let _ = if done == 0 {
            writeln!(out, "none of {all} points can be met")
        } else {
            writeln!(
                out,
                "\n{done} of {all} points: {:.4} mm rms, {:.4} mm at most without correction; predicted residual {:.1e} mm at most",
                mm(before[1]),
                mm(before[2]),
                mm(after[2])
            )
        };
        if !self.outcome.left_out.is_empty() {
            let names = self.outcome.left_out.join(", ");
            let _ = writeln!(out, "left out, being of the measurement and not of the robot: {names}");
        }
        if self.outcome.sides == Sides::Unsettled {
            out += "the side of approach of some points flips with the correction itself: those may miss by the backlash\n";
        }
        let refused: Vec<String> = self
            .refused()
            .map(|(index, why)| format!("point {} ({}) refused: {why}", index + 1, self.names[index]))
            .collect();
        for line in refused.iter().take(MOST_SHOWN) {
            let _ = writeln!(out, "{line}");
        }
        if refused.len() > MOST_SHOWN {
            let _ = writeln!(out, "and {} more refused", refused.len() - MOST_SHOWN);
        }
        out
    }

    /// CSV of the points that are not refused, in units: commands, and the poses by the controller's geometry.
    ///
    /// # Errors
    /// As [`Sheet::csv`].
    pub fn csv(&self, units: &Units) -> std::io::Result<String> {
        let points: Vec<(usize, &Point)> = self
            .outcome
            .points
            .iter()
            .enumerate()
            .filter_map(|(index, point)| Some((index, point.as_ref().ok()?)))
            .collect();
        let points = &points;
        let mut sheet = Sheet::new();
        sheet.column("pose", |row| self.names[points[row].0].clone());
        for (k, variable) in self.model.variables.iter().enumerate() {
            let unit = units.of(variable.kind());
            sheet.column(&variable.name, move |row| format!("{:.9}", points[row].1.corrected.joints[k] / unit));
        }
        // Empty where the controller's own geometry has no pose for the commands.
        for (k, column) in POSE.columns().iter().enumerate() {
            let unit = units.of(column.kind);
            sheet.column(column.name, move |row| {
                self.poses[points[row].0].map_or_else(String::new, |pose| format!("{:.9}", pose[k] / unit))
            });
        }
        sheet.csv(0..points.len())
    }
}
