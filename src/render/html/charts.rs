//! Charts as inline SVG, in the page's own colours (CSS variables), so that they follow light, dark and print.

use kuva::backend::svg::SvgBackend;
use kuva::render::layout::Layout;
use kuva::render::plots::Plot;
use kuva::render::render::render_multiple;
use kuva::render::theme::Theme;

use crate::description::urdf::escaped;

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
    let alt = escaped(frame.alt);
    let body = dots(&shortened(body));
    // Narrower than this it would not be read on a screen: its figure scrolls.
    let least = width.min((0.62 * width).max(320.0));
    // The last label of an axis stands half beyond it.
    let full = width + 10.0;
    format!(
        "<svg class=\"chart\" viewBox=\"0 0 {full} {height}\" style=\"max-width:{width}px;--least:{least:.0}px\" role=\"img\" aria-label=\"{alt}\" fill=\"var(--ink)\">{body}"
    )
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

/// The same with runs of like circles drawn as one path of dots, which is a sixth as long.
fn dots(svg: &str) -> String {
    let mut out = String::with_capacity(svg.len() / 2);
    let mut rest = svg;
    while let Some(start) = rest.find("<circle ") {
        out += &rest[..start];
        rest = &rest[start..];
        let mut path = String::new();
        let mut run = 0;
        let mut after = rest;
        let look = circle(rest).map(|(_, _, look, _)| look);
        while let Some((x, y, _, next)) = circle(after).filter(|found| Some(found.2) == look) {
            path += &format!("M{x:.1} {y:.1}h0");
            run += 1;
            after = next;
        }
        match look {
            // r="1.6" fill=".." fill-opacity="..": a dot is a stroke of no length with round ends.
            Some(look) if run > 3 && !look.contains("stroke") => {
                let (radius, style) = look.strip_prefix("r=\"").and_then(|l| l.split_once('"')).unwrap_or(("1", ""));
                let width = 2.0 * radius.parse::<f64>().unwrap_or(1.0);
                let style = style.replace("fill=", "stroke=").replace("fill-opacity", "stroke-opacity");
                out += &format!(
                    "<path d=\"{path}\" fill=\"none\" stroke-linecap=\"round\" stroke-width=\"{width}\"{style}/>"
                );
                rest = after;
            }
            _ => {
                let end = rest.find('>').map_or(rest.len(), |end| end + 1);
                out += &rest[..end];
                rest = &rest[end..];
            }
        }
    }
    out + rest
}

/// A circle at the start of the text: centre, all else that is said of it, and what follows.
fn circle(svg: &str) -> Option<(f64, f64, &str, &str)> {
    let (x, after) = svg.strip_prefix("<circle cx=\"")?.split_once('"')?;
    let (y, after) = after.strip_prefix(" cy=\"")?.split_once('"')?;
    let (look, next) = after.split_once("/>")?;
    Some((x.parse().ok()?, y.parse().ok()?, look.trim(), next))
}
