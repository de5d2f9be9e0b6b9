//! Snapshots that guard robot descriptions: positions in m, rank and kept parameters of the geometric calibration.

use std::fmt::Write;

use crate::identifiability::{Column, Criterion, DEFAULT_TOLERANCE, Scaling, reduce};
use crate::kinematics::{AssemblyError, By, ErrorColumns, Geometry, Placements, Rates};
use crate::model::Model;
use crate::simulation::{draw_configurations, generator};

/// A text that changes when the description's meaning does: frames at sample configurations, free parameters, rank and
/// kept set for pose readings at 60 seeded configurations.
///
/// # Errors
/// What keeps the robot from being assembled.
pub fn snapshot(model: &Model) -> Result<String, AssemblyError> {
    let geometry = Geometry::nominal(model)?;
    let configurations = draw_configurations(&geometry, 60, 0.8, &mut generator(1))?;
    let mut out = format!("{}\n", model.name);
    let mut placements = Placements::default();
    for q in configurations.iter().take(3) {
        geometry.place(q, &mut placements)?;
        let _ = writeln!(out, "\nat {}", numbers(q));
        for (frame, placed) in model.frames.iter().zip(&placements.frames).skip(1) {
            let r = placed.rotation.matrix();
            let _ = writeln!(
                out,
                "{:>4}: {} | {} | {}",
                frame.name,
                numbers(placed.translation.vector.as_slice()),
                numbers(r.column(0).as_slice()),
                numbers(r.column(2).as_slice())
            );
        }
    }
    let slots = model.free_slots();
    let by: Vec<By> = slots.iter().map(|&slot| By::Slot(slot)).collect();
    let mut rates = Rates::new(model);
    let plan = ErrorColumns::new(&geometry, &rates, model.tool.0, &by);
    let mut columns = vec![[0.0; 6]; slots.len()];
    let mut matrix = Vec::new();
    for q in &configurations {
        geometry.place(q, &mut placements)?;
        rates.evaluate(&geometry, q, &placements);
        plan.evaluate(&geometry, &placements, &rates, &mut columns);
        (0..6).for_each(|row| matrix.extend(columns.iter().map(|column| column[row])));
    }
    let about: Vec<Column> = slots.iter().map(|&slot| Column::about(&model.registry[slot], false)).collect();
    let found = reduce(&matrix, &about, Scaling::Norm, Criterion::Relative(DEFAULT_TOLERANCE));
    let name = |column: &usize| model.registry[slots[*column]].name.as_str();
    let _ =
        writeln!(out, "\nfree ({}): {}", slots.len(), (0..slots.len()).map(|k| name(&k)).collect::<Vec<_>>().join(" "));
    let _ = writeln!(
        out,
        "rank {}, kept ({}): {}",
        found.rank,
        found.kept.len(),
        found.kept.iter().map(name).collect::<Vec<_>>().join(" ")
    );
    Ok(out)
}

/// Six decimals, without a negative zero.
fn numbers(values: &[f64]) -> String {
    let shown: Vec<String> = values.iter().map(|v| format!("{:.6}", if v.abs() < 5e-7 { 0.0 } else { *v })).collect();
    shown.join(" ")
}
