//! The robot itself as a page.

use minijinja::context;
use nalgebra::Vector3;
use serde_json::{Value, json};

use super::charts::escape;
use super::drawing::{Shot, parts_json, shot_json};
use super::page::{Page, embedded, plain, safe};
use crate::model::Model;
use crate::render::table::mm;
use crate::scene::Scene;

/// What `view` shows.
pub struct View<'a> {
    /// The model.
    pub model: &'a Model,
    /// Values of the variables, rad and m.
    pub q: &'a [f64],
    /// The command line that shows it.
    pub source: String,
    /// The robot as it is drawn.
    pub scene: &'a Scene,
    /// The configuration.
    pub shot: Shot,
    /// The load, in words; none where nothing is deflected.
    pub load: Option<String>,
    /// How many times the deflected shape is magnified.
    pub magnified: f64,
}

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

/// JSON of `view`: parts with their points, m, base frame.
pub fn view_json(view: &View) -> Value {
    let (model, shot) = (view.model, &view.shot);
    let joints: serde_json::Map<String, Value> =
        model.variables.iter().zip(view.q).map(|(variable, q)| (variable.name.clone(), json!(q))).collect();
    let tool = view.scene.parts.iter().find(|part| part.kind == crate::scene::PartKind::Tool);
    let moved = tool.and_then(|part| shot.moved.get(*part.points.get(1)?));
    let deflection =
        moved.map(|d| json!({"x": mm(d.x), "y": mm(d.y), "z": mm(d.z), "norm": mm(d.norm()), "unit": "mm"}));
    json!({"robot": model.name, "source": view.source, "joints": joints, "unit": "m", "parts": parts_json(view.scene),
           "points": shot.points.iter().map(|p| [p.x, p.y, p.z]).collect::<Vec<_>>(),
           "moved": shot.moved.iter().map(|p| [p.x, p.y, p.z]).collect::<Vec<_>>(),
           "load": view.load, "magnified": view.magnified, "deflection": deflection})
}

/// The page of `view`, and what it says in one line.
pub fn view_page(view: &View) -> (String, String) {
    let json = view_json(view);
    let page = Page::new(&json);
    let model = view.model;
    let at: Vec<String> = model
        .variables
        .iter()
        .zip(view.q)
        .map(|(variable, q)| {
            let value =
                if variable.is_angle { format!("{:.2} deg", q.to_degrees()) } else { format!("{:.2} mm", mm(*q)) };
            format!("{} {value}", variable.name)
        })
        .collect();
    let answer = format!("<p>{} at {}.</p>", escape(&model.name), escape(&at.join(", ")));
    let caption = "The robot as its description declares it: grey bodies along their Khalil-Kleinfinger lengths, joints blue where driven, grey where a loop moves them, violet where coupled.";
    let body = page.render("view.html", context! { title => model.name.as_str(), caption });
    let data = embedded(&json!({"unit": "m", "axis": view.scene.axis, "parts": parts_json(view.scene), "suspects": [],
        "shots": [shot_json(&view.shot)], "next": [], "arrows": null, "magnified": view.magnified}));
    let html = page.render(
        "page.html",
        context! {
            title => model.name.as_str(), heading => model.name.as_str(), answer => safe(answer.clone()),
            sections => vec![context! { id => "robot", title => "The robot", html => safe(body) }],
            data, version => env!("CARGO_PKG_VERSION"), report => false,
        },
    );
    (html, plain(&answer))
}
