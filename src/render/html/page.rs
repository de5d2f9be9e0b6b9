//! The page: templates, and figures that know where they come from.

use std::sync::Arc;

use minijinja::value::Serde;
use minijinja::{Environment, Value as Shown};
use serde_json::Value;

use crate::description::urdf::escaped;
use crate::render::diagnostics::is_active;

macro_rules! templates {
    ($($name:literal)*) => { &[$((concat!($name, ".html"), include_str!(concat!("templates/", $name, ".html")))),*] };
}

/// Templates by name; the ending says that what is put in is escaped.
const TEMPLATES: &[(&str, &str)] = templates! {
    "page" "certificate" "certificate-answer" "scene" "view" "fitted" "fitted-answer" "answer" "waterfall" "arrows"
    "against" "parts" "sensitivity" "patterns" "distribution" "parameters" "conditioning" "effects" "stiffness"
    "fuzzy" "track" "next"
};

/// Style and scripts of every page.
const ASSETS: [(&str, &str); 4] = [
    ("style", include_str!("assets/style.css")),
    ("paint", include_str!("assets/paint.js")),
    ("scene", include_str!("assets/scene.js")),
    ("start", include_str!("assets/start.js")),
];

/// A part of a page under its own heading.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Section {
    /// Its anchor.
    pub id: &'static str,
    /// Heading.
    pub title: String,
    /// Content.
    pub html: String,
}

/// Renders templates over the JSON of one result; figures carry the JSON pointer of their value.
pub struct Page {
    environment: Environment<'static>,
}

impl Page {
    /// A page over `json`, which templates call `r`, without its readings: no template goes through them, and they are long.
    pub fn new(json: &Value) -> Self {
        Self::of(json, &["readings"])
    }

    /// The same, without the keys `hidden`.
    pub fn of(json: &Value, hidden: &[&str]) -> Self {
        let mut environment = Environment::new();
        for (name, text) in TEMPLATES {
            // A template that does not parse is found by the first test that renders it.
            let added = environment.add_template(name, text);
            debug_assert!(added.is_ok(), "{name}: {added:?}");
        }
        let shared = Arc::new(json.clone());
        // `pct_more` is of a share by which something is more than before.
        let degrees = 180.0 / std::f64::consts::PI;
        for (name, scale) in [("fig", 1.0), ("deg", degrees), ("mm", 1e3), ("pct", 100.0), ("pct_more", -100.0)] {
            let own = Arc::clone(&shared);
            environment.add_function(name, move |pointer: String, digits: usize| figure(&own, &pointer, digits, scale));
        }
        environment.add_function("sci", move |pointer: String| scientific(&shared, &pointer));
        environment.add_filter("step", |name: String| name.replace('~', "~0").replace('/', "~1"));
        environment.add_filter("ticks", |text: String| {
            let parts = text.split('`').enumerate();
            let marked = parts
                .map(|(k, part)| if k % 2 == 1 { format!("<code>{}</code>", escaped(part)) } else { escaped(part) });
            safe(marked.collect::<String>())
        });
        let mut shown = json.clone();
        if let Some(all) = shown.as_object_mut() {
            hidden.iter().for_each(|key| drop(all.remove(*key)));
        }
        environment.add_global("r", Shown::from(Serde(&shown)));
        for (name, text) in ASSETS {
            environment.add_global(name, Shown::from_safe_string(text.into()));
        }
        Self { environment }
    }

    /// Renders a template. What goes wrong in it stands in its place: a report is never lost over one sentence.
    pub fn render(&self, template: &str, context: Shown) -> String {
        let rendered = self.environment.get_template(template).and_then(|template| template.render(context));
        rendered.unwrap_or_else(|error| format!("<p class=\"fault\">{}</p>", escaped(&format!("{error:#}"))))
    }
}

/// A page in which what is no letter does nothing: of titles and names, also within its JSON.
pub fn inert(html: &str) -> String {
    html.chars().map(|char| if is_active(char) && char != '\n' { '\u{fffd}' } else { char }).collect()
}

/// Text that is HTML already.
pub fn safe(html: impl Into<String>) -> Shown {
    Shown::from_safe_string(html.into())
}

/// JSON to stand in a script element.
///
/// # Errors
/// A value that JSON cannot hold.
pub fn embedded(value: &impl serde::Serialize) -> Result<Shown, serde_json::Error> {
    Ok(safe(serde_json::to_string(value)?.replace('<', "\\u003c")))
}

/// The number at a JSON pointer, `None` where it is null.
fn number(json: &Value, pointer: &str) -> Result<Option<f64>, minijinja::Error> {
    let fault = |what| minijinja::Error::new(minijinja::ErrorKind::UndefinedError, format!("`{pointer}` {what}"));
    match json.pointer(pointer) {
        None => Err(fault("is not in the JSON")),
        Some(Value::Null) => Ok(None),
        Some(value) => value.as_f64().map(Some).ok_or_else(|| fault("is no number")),
    }
}

fn figure(json: &Value, pointer: &str, digits: usize, scale: f64) -> Result<Shown, minijinja::Error> {
    let Some(value) = number(json, pointer)? else { return Ok(safe("&ndash;")) };
    let text = format!("{:.digits$}", value * scale).replace('-', "\u{2212}");
    let path = escaped(pointer);
    Ok(safe(format!(
        "<data class=\"figure\" value=\"{value}\" data-path=\"{path}\" data-digits=\"{digits}\" data-scale=\"{scale}\">{text}</data>"
    )))
}

fn scientific(json: &Value, pointer: &str) -> Result<Shown, minijinja::Error> {
    let Some(value) = number(json, pointer)? else { return Ok(safe("&ndash;")) };
    let path = escaped(pointer);
    let text = match value.abs() {
        size if size == 0.0 || (1e-3..1e5).contains(&size) => {
            let digits = if size == 0.0 { 0 } else { (4 - size.log10().floor() as i32).clamp(0, 6) as usize };
            format!("{value:.digits$}")
        }
        _ => format!("{value:.3e}"),
    };
    Ok(safe(format!(
        "<data class=\"figure\" value=\"{value}\" data-path=\"{path}\" data-digits=\"sci\">{}</data>",
        text.replace('-', "\u{2212}")
    )))
}

/// What is read of HTML: its text, on one line.
pub fn plain(html: &str) -> String {
    let mut text = String::new();
    let mut inside = false;
    for c in html.chars() {
        match c {
            '<' => inside = true,
            '>' => inside = false,
            c if !inside => text.push(c),
            _ => {}
        }
    }
    let text = text.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&#x27;", "'");
    let text = text.replace("&#x2f;", "/").replace("&ndash;", "-").replace('\u{2212}', "-").replace("&amp;", "&");
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
