//! The robot itself as a page.

use minijinja::context;
use nalgebra::Vector3;

use super::drawing::{Drawing, DrawnShot};
use super::page::{Page, embedded, inert, plain, safe};
use crate::Error;
use crate::description::urdf::escaped;
use crate::results::View;
use crate::scene::{Scene, Shot};

/// A magnification under which the deflected shape shows: a share of the robot's size, to one digit.
pub fn magnification(shot: &Shot) -> f64 {
    let most = shot.moved.iter().map(Vector3::norm).fold(0.0, f64::max);
    let size = shot.points.iter().map(Vector3::norm).fold(0.0, f64::max);
    let wanted = 0.12 * size / most;
    if !(wanted.is_finite() && wanted > 0.0) {
        return 1.0;
    }
    let decade = 10f64.powf(wanted.log10().floor());
    let digit = wanted / decade;
    decade
        * if digit >= 5.0 {
            5.0
        } else if digit >= 2.0 {
            2.0
        } else {
            1.0
        }
}

/// The page of `view`, and its first line in words.
///
/// # Errors
/// A result that cannot be written as JSON.
pub fn view_page(view: &View, scene: &Scene, shot: &Shot) -> Result<(String, String), Error> {
    let page = Page::new(&serde_json::to_value(view)?);
    let title = view.robot.as_str();
    let answer = format!("<p>{} at {}.</p>", escaped(title), escaped(&view.at.join(", ")));
    let caption = "The robot as its description declares it: grey bodies along their Khalil-Kleinfinger lengths, joints blue where driven, grey where a loop moves them, violet where coupled.";
    let body = page.render("view.html", context! { title, caption });
    let data = embedded(&Drawing {
        unit: "m",
        axis: scene.axis,
        parts: view.parts.clone(),
        suspects: Vec::new(),
        shots: vec![DrawnShot::new(shot)],
        next: Vec::new(),
        arrows: None,
        magnified: Some(view.magnified),
    })?;
    let html = page.render(
        "page.html",
        context! {
            title, heading => title, answer => safe(answer.clone()),
            sections => vec![context! { id => "robot", title => "The robot", html => safe(body) }],
            data, version => env!("CARGO_PKG_VERSION"), report => false,
        },
    );
    Ok((inert(&html), plain(&answer)))
}
