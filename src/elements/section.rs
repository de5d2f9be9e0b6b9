//! Cross-sections: area, second moments, torsion constant and shear areas from their dimensions.

use std::f64::consts::PI;

use num_dual::DualNum;

use crate::description::raw::SectionShape;

/// Properties of a section: m2 and m4. `iz` resists bending in the plane of local x and y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Properties<D> {
    /// Area.
    pub area: D,
    /// Second moment about local y.
    pub iy: D,
    /// Second moment about local z.
    pub iz: D,
    /// Torsion constant.
    pub j: D,
    /// Area that resists shear along y.
    pub shear_y: D,
    /// Area that resists shear along z.
    pub shear_z: D,
}

/// Properties of a section of a shape, from `value` of a symbol (m, m2, m4).
///
/// Torsion: boxes as thin-walled closed (Bredt), rectangles by Roark's formula, I sections as thin strips. Shear areas
/// where none are stated: 5/6 of a rectangle, 9/10 of a rod, half a tube, the walls of a box and the web of an I along
/// the force.
pub fn properties<D: DualNum<Primitive = f64> + Copy>(
    shape: Option<SectionShape>,
    value: impl Fn(&str) -> Option<D>,
) -> Properties<D> {
    let get = |symbol: &str| value(symbol).unwrap_or_else(|| D::from(0.0));
    let mut found = match shape {
        Some(SectionShape::Box) => hollow_box(get("width"), get("height"), get("wall")),
        Some(SectionShape::Tube) => tube(get("diameter"), get("wall")),
        Some(SectionShape::Rectangle) => rectangle(get("width"), get("height")),
        Some(SectionShape::Rod) => rod(get("diameter")),
        Some(SectionShape::I) => i_section(get("width"), get("height"), get("wall"), get("flange")),
        None => {
            let area = get("area");
            Properties { area, iy: get("iy"), iz: get("iz"), j: get("j"), shear_y: area, shear_z: area }
        }
    };
    if let Some(stated) = value("shear_y") {
        found.shear_y = stated;
    }
    if let Some(stated) = value("shear_z") {
        found.shear_z = stated;
    }
    found
}

/// A box, thin-walled and closed in torsion (Bredt).
fn hollow_box<D: DualNum<Primitive = f64> + Copy>(w: D, h: D, t: D) -> Properties<D> {
    let (wi, hi) = (w - t * 2.0, h - t * 2.0);
    let (wm, hm) = (w - t, h - t);
    Properties {
        area: w * h - wi * hi,
        iy: (w * h.powi(3) - wi * hi.powi(3)) / 12.0,
        iz: (h * w.powi(3) - hi * wi.powi(3)) / 12.0,
        j: t * 2.0 * wm.powi(2) * hm.powi(2) / (wm + hm),
        shear_y: t * w * 2.0,
        shear_z: t * h * 2.0,
    }
}

fn tube<D: DualNum<Primitive = f64> + Copy>(d: D, wall: D) -> Properties<D> {
    let inner = d - wall * 2.0;
    let area = (d.powi(2) - inner.powi(2)) * (PI / 4.0);
    let i = (d.powi(4) - inner.powi(4)) * (PI / 64.0);
    Properties { area, iy: i, iz: i, j: i * 2.0, shear_y: area / 2.0, shear_z: area / 2.0 }
}

/// A solid rectangle, in torsion by Roark's formula.
fn rectangle<D: DualNum<Primitive = f64> + Copy>(w: D, h: D) -> Properties<D> {
    let area = w * h;
    let (a, b) = if w.re() >= h.re() { (w, h) } else { (h, w) };
    let ratio = b / a;
    let form = -(ratio * 0.21) * (-(ratio.powi(4) / 12.0) + 1.0) + 1.0 / 3.0;
    let shear = area * (5.0 / 6.0);
    Properties {
        area,
        iy: w * h.powi(3) / 12.0,
        iz: h * w.powi(3) / 12.0,
        j: a * b.powi(3) * form,
        shear_y: shear,
        shear_z: shear,
    }
}

fn rod<D: DualNum<Primitive = f64> + Copy>(d: D) -> Properties<D> {
    let area = d.powi(2) * (PI / 4.0);
    let i = d.powi(4) * (PI / 64.0);
    Properties { area, iy: i, iz: i, j: i * 2.0, shear_y: area * 0.9, shear_z: area * 0.9 }
}

/// An I section, in torsion as three thin strips.
fn i_section<D: DualNum<Primitive = f64> + Copy>(w: D, h: D, web: D, flange: D) -> Properties<D> {
    let hi = h - flange * 2.0;
    Properties {
        area: w * flange * 2.0 + hi * web,
        iy: (w * h.powi(3) - (w - web) * hi.powi(3)) / 12.0,
        iz: (flange * w.powi(3) * 2.0 + hi * web.powi(3)) / 12.0,
        j: (w * flange.powi(3) * 2.0 + hi * web.powi(3)) / 3.0,
        shear_y: w * flange * (5.0 / 3.0),
        shear_z: web * h,
    }
}
