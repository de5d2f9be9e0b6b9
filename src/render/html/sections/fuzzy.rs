//! A compliance by rules, drawn against its inputs.

use kuva::plot::{LinePlot, ScatterPlot};
use kuva::render::plots::Plot;
use minijinja::context;

use crate::description::fuzzy::{Component, Fuzzy};
use crate::fuzzy::value;
use crate::model::Model;
use crate::render::html::charts::{BLUE, Frame, ORANGE, chart};
use crate::render::html::page::{Page, Section, safe};
use crate::results::units::shown;

/// Most components drawn, the greatest first.
const COMPONENTS: usize = 4;
/// Points drawn along an input.
const POINTS: usize = 61;
/// Points drawn along each of two inputs.
const SIDE: usize = 31;

pub fn section(model: &Model, page: &Page) -> Option<Section> {
    let fuzzy = model.fuzzy.as_ref()?;
    let mut components: Vec<&Component> = fuzzy.components.iter().filter(|c| !c.conclusions.is_empty()).collect();
    let greatest = |component: &Component| component.conclusions.iter().fold(0.0_f64, |most, c| most.max(c.abs()));
    components.sort_by(|a, b| greatest(b).total_cmp(&greatest(a)));
    let names: Vec<String> = fuzzy.inputs.iter().map(|&of| model.input(of).0.to_string()).collect();
    let charts: Vec<_> = components.iter().take(COMPONENTS).filter_map(|c| drawn(model, fuzzy, c)).collect();
    if charts.is_empty() {
        return None;
    }
    let html = page.render(
        "fuzzy.html",
        context! {
            charts => charts.into_iter().map(|(name, svg, ends)| context! { name, svg => safe(svg), ends })
                .collect::<Vec<_>>(),
            inputs => names, adds => fuzzy.adds, left_out => components.len().saturating_sub(COMPONENTS),
        },
    );
    Some(Section { id: "rules", title: "Compliance by rules".into(), html })
}

/// Name, chart, and least and greatest value of a component. Of more than two inputs the first two that have more than
/// one set are drawn, the others at their middle modal value.
fn drawn(model: &Model, fuzzy: &Fuzzy, component: &Component) -> Option<(String, String, [String; 2])> {
    let middle: Vec<f64> =
        component.modes.iter().map(|modes| modes.get(modes.len() / 2).copied()).collect::<Option<_>>()?;
    let mut varied: Vec<usize> = (0..middle.len()).filter(|&k| component.modes[k].len() > 1).take(2).collect();
    if varied.is_empty() {
        varied.extend((0..middle.len()).take(1));
    }
    let drawing = Drawing { model, fuzzy, component, middle };
    let (svg, values) = match *varied {
        [k] => drawing.curve(k),
        [a, b] => drawing.map(a, b),
        _ => return None,
    };
    let ((low, high), unit) = (ends(&values), drawing.unit());
    Some((drawing.name(), svg, [format!("{low:.4} {unit}"), format!("{high:.4} {unit}")]))
}

/// A component as it is drawn: the inputs that do not vary at their middle modal values.
struct Drawing<'a> {
    model: &'a Model,
    fuzzy: &'a Fuzzy,
    component: &'a Component,
    middle: Vec<f64>,
}

impl Drawing<'_> {
    fn name(&self) -> String {
        Component::name(self.component.at)
    }

    /// What a millimetre or milliradian is to a kilonewton or kilonewtonmetre.
    fn unit(&self) -> String {
        let [row, column] = self.component.at;
        format!("{}/{}", if row < 3 { "mm" } else { "mrad" }, if column < 3 { "kN" } else { "kN.m" })
    }

    /// Label of an input, and whether it is an angle.
    fn about(&self, k: usize) -> (String, bool) {
        let (name, angle) = self.model.input(self.fuzzy.inputs[k]);
        (format!("{name}, {}", if angle { "deg" } else { "mm" }), angle)
    }

    /// Values of an input; a tenth beyond the outermost sets shows that they saturate.
    fn along(&self, k: usize, count: usize) -> Vec<f64> {
        let (low, high) = ends(&self.component.modes[k]);
        let margin = 0.1 * (high - low).max(1e-3);
        let step = (high - low + 2.0 * margin) / (count - 1) as f64;
        (0..count).map(|i| low - margin + step * i as f64).collect()
    }

    /// The compliance, in [`Drawing::unit`], with some inputs elsewhere than at their middle.
    fn at(&self, points: &[(usize, f64)]) -> f64 {
        let mut x = self.middle.clone();
        points.iter().for_each(|&(k, value)| x[k] = value);
        1e6 * value(self.component, &x)
    }

    fn curve(&self, k: usize) -> (String, Vec<f64>) {
        let (label, angle) = self.about(k);
        let point = |x: f64| (shown(x, angle), self.at(&[(k, x)]));
        let line: Vec<(f64, f64)> = self.along(k, POINTS).into_iter().map(point).collect();
        let modes: Vec<(f64, f64)> = self.component.modes[k].iter().copied().map(point).collect();
        let values: Vec<f64> = line.iter().map(|p| p.1).collect();
        let (y, alt) =
            (format!("{}, {}", self.name(), self.unit()), format!("Compliance {} against {label}", self.name()));
        let frame = Frame { size: [430.0, 300.0], x: &label, y: &y, alt: &alt };
        let plots = vec![
            Plot::Line(LinePlot::new().with_data(line).with_color(BLUE).with_stroke_width(1.6)),
            Plot::Scatter(ScatterPlot::new().with_data(modes).with_color(ORANGE).with_size(4.0)),
        ];
        (chart(&frame, None, plots, |layout| layout), values)
    }

    fn map(&self, a: usize, b: usize) -> (String, Vec<f64>) {
        let ((x, x_angle), (y, y_angle)) = (self.about(a), self.about(b));
        let rows = self.along(b, SIDE);
        let grid: Vec<(f64, f64)> =
            self.along(a, SIDE).into_iter().flat_map(|x| rows.iter().map(move |&y| (x, y))).collect();
        let values: Vec<f64> = grid.iter().map(|&(x, y)| self.at(&[(a, x), (b, y)])).collect();
        let (low, high) = ends(&values);
        let color = |value: &f64| {
            let share = (value - low) / (high - low).max(f64::MIN_POSITIVE);
            format!("color-mix(in srgb, var(--warm) {:.0}%, var(--blue))", 100.0 * share.clamp(0.0, 1.0))
        };
        let place = |(x, y): (f64, f64)| (shown(x, x_angle), shown(y, y_angle));
        let modes = &self.component.modes;
        let modes = modes[a].iter().flat_map(|&x| modes[b].iter().map(move |&y| (x, y)));
        let grid = ScatterPlot::new()
            .with_data(grid.iter().copied().map(place).collect::<Vec<_>>())
            .with_colors(values.iter().map(color).collect::<Vec<_>>())
            .with_size(5.0);
        let modes =
            ScatterPlot::new().with_data(modes.map(place).collect::<Vec<_>>()).with_color("var(--ink)").with_size(2.5);
        let alt = format!("Compliance {} against {x} and {y}", self.name());
        let frame = Frame { size: [430.0, 380.0], x: &x, y: &y, alt: &alt };
        let plots = vec![Plot::Scatter(grid), Plot::Scatter(modes)];
        (chart(&frame, None, plots, |layout| layout), values)
    }
}

fn ends(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &v| (low.min(v), high.max(v)))
}
