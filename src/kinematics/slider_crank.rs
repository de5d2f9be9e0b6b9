//! The slider-crank: stroke to joint angle.

/// Joint angle of a slider-crank and its derivatives.
///
/// The five `values` are stroke zero, kappa, lambda, l1, l3 (m, rad). The law, with r = stroke + stroke zero,
/// is r^2 = l1^2 + l3^2 + 2 l1 l3 cos(kappa + lambda - theta), 0 < kappa + lambda - theta < pi (both printed versions
/// lose the square of r). Returns theta and d theta by (stroke, kappa, lambda, l1, l3), or how far (m) the length is
/// from closing the triangle.
pub fn slider_crank(stroke: f64, values: &[f64]) -> Result<(f64, [f64; 5]), f64> {
    let [zero, kappa, lambda, l1, l3] = std::array::from_fn(|k| values[k]);
    let r = stroke + zero;
    let cosine = (r * r - l1 * l1 - l3 * l3) / (2.0 * l1 * l3);
    let sine = ((1.0 - cosine) * (1.0 + cosine)).sqrt();
    if !(sine > 1e-12 && r > 0.0) {
        return Err(if r > l1 + l3 { r - l1 - l3 } else { (l1 - l3).abs() - r });
    }
    let theta = kappa + lambda - cosine.acos();
    // d theta = d cosine / sine.
    let by_r = r / (l1 * l3 * sine);
    let by_l1 = (-1.0 / l3 - cosine / l1) / sine;
    let by_l3 = (-1.0 / l1 - cosine / l3) / sine;
    Ok((theta, [by_r, 1.0, 1.0, by_l1, by_l3]))
}
