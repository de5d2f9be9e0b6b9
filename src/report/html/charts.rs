//! Charts as inline SVG, in the page's own colours (CSS variables), so that they follow light, dark and print.

use kuva::backend::svg::SvgBackend;
use kuva::render::layout::Layout;
use kuva::render::plots::Plot;
use kuva::render::render::render_multiple;
use kuva::render::theme::Theme;

/// Colours of the page.
pub const BLUE: &str = "var(--blue)";
/// The suspected pattern.
pub const ORANGE: &str = "var(--orange)";
/// What is of less weight.
pub const GREY: &str = "var(--grey)";

/// Where charts get their size and labels from.
pub struct Frame<'a> {
    /// Width and height in CSS pixels.
    pub size: [f64; 2],
    /// Label of the x axis, with its unit.
    pub x: &'a str,
    /// Label of the y axis, with its unit.
    pub y: &'a str,
    /// What the chart shows, for those who do not see it.
    pub alt: &'a str,
}

fn theme() -> Theme {
    let mut theme = Theme::light();
    let ink = || "var(--ink)".to_string();
    theme.background = "none".into();
    (theme.axis_color, theme.tick_color, theme.text_color) = (ink(), ink(), ink());
    theme.grid_color = "var(--rule)".into();
    (theme.legend_bg, theme.legend_border) = ("var(--paper)".into(), "var(--rule)".into());
    theme.colorbar_border = "var(--rule)".into();
    theme
}

/// Draws plots on one pair of axes. `ranges` are those of x and y; by the data where `None`.
pub fn chart(
    frame: &Frame,
    ranges: Option<[(f64, f64); 2]>,
    plots: Vec<Plot>,
    adjust: impl Fn(Layout) -> Layout,
) -> String {
    let layout = match ranges {
        Some([x, y]) => Layout::new(x, y).with_clamp_axis(),
        None => Layout::auto_from_plots(&plots),
    };
    let [width, height] = frame.size;
    let layout = layout
        .with_theme(theme())
        .with_width(width)
        .with_height(height)
        .with_x_label(frame.x)
        .with_y_label(frame.y)
        .with_label_size(12)
        .with_tick_size(11)
        .with_body_size(11);
    inline(&SvgBackend::new().render_scene(&render_multiple(plots, adjust(layout))), frame)
}

/// An SVG to stand in the page: it scales with its column, names itself, and is short.
fn inline(svg: &str, frame: &Frame) -> String {
    let body = svg.find('>').map_or(svg, |end| &svg[end + 1..]);
    let [width, height] = frame.size;
    let alt = escape(frame.alt);
    let body = shortened(body);
    format!(
        "<svg class=\"chart\" viewBox=\"0 0 {width} {height}\" style=\"max-width:{width}px\" role=\"img\" aria-label=\"{alt}\" fill=\"var(--ink)\">{body}"
    )
}

/// Text as it stands in HTML or an attribute.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The same with at most two decimals in each number, comments left out.
fn shortened(svg: &str) -> String {
    let mut out = String::with_capacity(svg.len() / 2);
    let mut rest = svg;
    while let Some(start) = rest.find("<!--") {
        out += &rest[..start];
        rest = rest[start..].find("-->").map_or("", |end| &rest[start + end + 3..]);
    }
    out += rest;
    let mut short = String::with_capacity(out.len());
    // Decimals after the point of the number at hand; none outside a number.
    let (mut decimals, mut in_number) = (None::<usize>, false);
    // Text is left alone: numbers there are figures.
    let mut in_tag = false;
    for c in out.chars() {
        match c {
            '<' => in_tag = true,
            '>' => in_tag = false,
            _ => {}
        }
        match (c, decimals) {
            ('0'..='9', Some(2)) if in_tag => continue,
            ('0'..='9', Some(count)) => decimals = Some(count + 1),
            ('.', None) if in_number => decimals = Some(0),
            _ => decimals = None,
        }
        in_number = c.is_ascii_digit() && decimals.is_none() || decimals.is_some();
        short.push(c);
    }
    short
}
