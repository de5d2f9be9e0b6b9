//! Faces that contacts touch, as estimates show them: by their unit normal, to which the offset belongs.

use nalgebra::{Matrix3, Vector3};

use crate::description::campaign::Campaign;
use crate::estimation::Calibration;
use crate::math::quantiles::t95;
use crate::model::Model;
use crate::parameter::Slot;

/// An estimated value of a face, by its position among the candidates.
pub(super) struct OfFace {
    pub column: usize,
    /// Whether the campaign says where the face is about; else no nominal value is.
    pub has_nominal: bool,
    /// Of a component of the normal: that of the unit normal, and half the width of its 95 % interval where it is known.
    pub component: Option<(f64, Option<f64>)>,
}

/// Estimated values of faces. The components of a normal, whose length means nothing, are those of the unit normal.
pub(super) fn of_faces(model: &Model, campaign: &Campaign, found: &Calibration) -> Vec<OfFace> {
    let column = |slot: Slot| found.slots.iter().position(|known| *known == slot);
    let mut all = Vec::new();
    for (index, target) in campaign.targets.iter().enumerate().filter(|(_, target)| target.is_face()) {
        let slots = model.target_values(index);
        let normal = match *slots {
            [Some(x), Some(y), Some(z), ..] => column(x).zip(column(y)).zip(column(z)).map(|((x, y), z)| [x, y, z]),
            _ => None,
        };
        let components = normal.map(|columns| unit_normal(found, columns));
        for column in slots.iter().flatten().filter_map(|&slot| column(slot)) {
            let at = normal.and_then(|columns| columns.iter().position(|known| *known == column));
            let component = at.zip(components).map(|(k, components)| components[k]);
            all.push(OfFace { column, has_nominal: target.is_near, component });
        }
    }
    all
}

/// Components of the unit normal with half the widths of their intervals.
fn unit_normal(found: &Calibration, columns: [usize; 3]) -> [(f64, Option<f64>); 3] {
    let normal = Vector3::from(columns.map(|column| found.values[found.slots[column]]));
    let length = normal.norm().max(f64::MIN_POSITIVE);
    let unit = normal / length;
    let across = (Matrix3::identity() - unit * unit.transpose()) / length;
    let covariance = across * covariance(found, columns) * across.transpose();
    // Its length is what no reading tells: a fit that holds one component knows all three of the direction.
    let is_known = columns.iter().any(|column| found.estimates[*column].identifiable());
    let known = columns.iter().filter_map(|&column| found.estimates[column].degrees_of_freedom);
    let degrees = known.fold(1.0, f64::max);
    [0, 1, 2].map(|k| (unit[k], is_known.then(|| t95(degrees) * covariance[(k, k)].max(0.0).sqrt())))
}

/// Covariance of three parameters; none of one that was dropped.
fn covariance(found: &Calibration, columns: [usize; 3]) -> Matrix3<f64> {
    let kept = columns.map(|column| found.identifiability.kept.binary_search(&column).ok());
    let sigma = columns.map(|column| found.estimates[column].sigma().unwrap_or(0.0));
    Matrix3::from_fn(|i, j| {
        let both = kept[i].zip(kept[j]);
        both.and_then(|at| found.correlation.get(at)).map_or(0.0, |correlation| correlation * sigma[i] * sigma[j])
    })
}
