//! A fuzzy compliance, drawn against its inputs.

use kuva::plot::{LinePlot, ScatterPlot};
use kuva::render::plots::Plot;
use minijinja::context;

use crate::description::fuzzy::{Component, Input, Rules};
use crate::fuzzy::value;
use crate::math::extremes;
use crate::model::Model;
use crate::parameter::Kind;
use crate::render::html::charts::{BLUE, Frame, ORANGE, chart};
use crate::render::html::page::{Page, Section, safe};
use crate::results::units::shown;

/// Most components drawn, the greatest first.
const COMPONENTS: usize = 4;
/// Points drawn along an input.
const POINTS: usize = 61;
/// Points drawn along each of two inputs.
const SIDE: usize = 31;

/// Rules to be drawn: what they are of, its unit, and what one in SI is in it.
struct Drawn<'a> {
    name: String,
    unit: String,
    factor: f64,
    rules: &'a Rules,
    inputs: &'a [Input],
}

/// Rules of a model: components, the greatest first, then springs.
fn drawn(model: &Model) -> Vec<Drawn<'_>> {
    let greatest = |rules: &Rules| rules.conclusions.iter().fold(0.0_f64, |most, c| most.max(c.abs()));
    let mut found = Vec::new();
    if let Some(fuzzy) = &model.fuzzy {
        let mut components: Vec<&Component> = fuzzy.components.iter().collect();
        components.sort_by(|a, b| greatest(&b.rules).total_cmp(&greatest(&a.rules)));
        found.extend(components.into_iter().map(|component| {
            let [row, column] = component.at;
            // What a millimetre or milliradian is to a kilonewton or kilonewtonmetre.
            let unit = format!("{}/{}", if row < 3 { "mm" } else { "mrad" }, if column < 3 { "kN" } else { "kN.m" });
            let (name, inputs) = (Component::name(component.at), &fuzzy.inputs[..]);
            Drawn { name, unit, factor: 1e6, rules: &component.rules, inputs }
        }));
    }
    if let Some(local) = &model.local_springs {
        found.extend(local.springs.iter().map(|(slot, rules)| {
            let parameter = &model.registry[*slot];
            let unit = if parameter.kind == Kind::RotationalCompliance { "mrad/kN.m" } else { "mm/kN" };
            Drawn { name: parameter.name.clone(), unit: unit.into(), factor: 1e6, rules, inputs: &local.inputs }
        }));
    }
    found.retain(|own| !own.rules.conclusions.is_empty());
    found
}

pub fn section(model: &Model, page: &Page) -> Option<Section> {
    let all = drawn(model);
    let inputs = all.first()?.inputs;
    let names: Vec<String> = inputs.iter().map(|&of| model.input(of).0.to_string()).collect();
    let charts: Vec<_> = all.iter().take(COMPONENTS).filter_map(|own| chart_of(model, own)).collect();
    if charts.is_empty() {
        return None;
    }
    let axes = model.fuzzy.as_ref().and_then(|fuzzy| fuzzy.axes).map(|frame| model.frames[frame].name.clone());
    let html = page.render(
        "fuzzy.html",
        context! {
            charts => charts.into_iter().map(|(name, svg, ends)| context! { name, svg => safe(svg), ends })
                .collect::<Vec<_>>(),
            inputs => names, axes, adds => model.fuzzy.as_ref().is_some_and(|fuzzy| fuzzy.adds),
            springs => model.fuzzy.is_none(), left_out => all.len().saturating_sub(COMPONENTS),
        },
    );
    Some(Section { id: "rules", title: "Fuzzy compliance".into(), html })
}

/// Name, chart, and least and greatest value of rules. Of more than two inputs the two with most sets are
/// drawn, the others at the middle of their sets.
fn chart_of(model: &Model, own: &Drawn) -> Option<(String, String, [String; 2])> {
    let marks: Vec<Vec<f64>> = (0..own.inputs.len()).map(|input| own.rules.premise.marks(input)).collect();
    let middle: Vec<f64> = marks.iter().map(|marks| marks.get(marks.len() / 2).copied().unwrap_or(0.0)).collect();
    let mut varied: Vec<usize> = (0..middle.len()).filter(|&k| marks[k].len() > 1).collect();
    varied.sort_by_key(|&k| std::cmp::Reverse(marks[k].len()));
    varied.truncate(2);
    if varied.is_empty() {
        varied.extend((0..middle.len()).take(1));
    }
    let drawing = Drawing { model, own, marks, middle };
    let (svg, values) = match *varied {
        [k] => drawing.curve(k),
        [a, b] => drawing.map(a, b),
        _ => return None,
    };
    let ([low, high], unit) = (extremes(values.iter().copied()), &own.unit);
    Some((own.name.clone(), svg, [format!("{low:.4} {unit}"), format!("{high:.4} {unit}")]))
}

/// Rules as they are drawn: the inputs that do not vary at the middle of their sets.
struct Drawing<'a> {
    model: &'a Model,
    own: &'a Drawn<'a>,
    marks: Vec<Vec<f64>>,
    middle: Vec<f64>,
}

impl Drawing<'_> {
    /// Label of an input, and whether it is an angle.
    fn about(&self, k: usize) -> (String, bool) {
        let (name, angle) = self.model.input(self.own.inputs[k]);
        (format!("{name}, {}", if angle { "deg" } else { "mm" }), angle)
    }

    /// Values of an input; a tenth beyond the outermost sets shows that they saturate.
    fn along(&self, k: usize, count: usize) -> Vec<f64> {
        let [low, high] = if self.marks[k].is_empty() { [0.0; 2] } else { extremes(self.marks[k].iter().copied()) };
        let margin = 0.1 * (high - low).max(1e-3);
        let step = (high - low + 2.0 * margin) / (count - 1) as f64;
        (0..count).map(|i| low - margin + step * i as f64).collect()
    }

    /// The compliance, in [`Drawn::unit`], with some inputs elsewhere than at their middle.
    fn at(&self, points: &[(usize, f64)]) -> f64 {
        let mut x = self.middle.clone();
        points.iter().for_each(|&(k, value)| x[k] = value);
        self.own.factor * value(self.own.rules, &x)
    }

    fn curve(&self, k: usize) -> (String, Vec<f64>) {
        let (label, angle) = self.about(k);
        let point = |x: f64| (shown(x, angle), self.at(&[(k, x)]));
        let line: Vec<(f64, f64)> = self.along(k, POINTS).into_iter().map(point).collect();
        let modes: Vec<(f64, f64)> = self.marks[k].iter().copied().map(point).collect();
        let values: Vec<f64> = line.iter().map(|p| p.1).collect();
        let (y, alt) =
            (format!("{}, {}", self.own.name, self.own.unit), format!("Compliance {} against {label}", self.own.name));
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
        let [low, high] = extremes(values.iter().copied());
        let color = |value: &f64| {
            let share = (value - low) / (high - low).max(f64::MIN_POSITIVE);
            format!("color-mix(in srgb, var(--warm) {:.0}%, var(--blue))", 100.0 * share.clamp(0.0, 1.0))
        };
        let place = |(x, y): (f64, f64)| (shown(x, x_angle), shown(y, y_angle));
        let modes = &self.marks;
        let modes = modes[a].iter().flat_map(|&x| modes[b].iter().map(move |&y| (x, y)));
        let grid = ScatterPlot::new()
            .with_data(grid.iter().copied().map(place).collect::<Vec<_>>())
            .with_colors(values.iter().map(color).collect::<Vec<_>>())
            .with_size(5.0);
        let modes =
            ScatterPlot::new().with_data(modes.map(place).collect::<Vec<_>>()).with_color("var(--ink)").with_size(2.5);
        let alt = format!("Compliance {} against {x} and {y}", self.own.name);
        let frame = Frame { size: [430.0, 380.0], x: &x, y: &y, alt: &alt };
        let plots = vec![Plot::Scatter(grid), Plot::Scatter(modes)];
        (chart(&frame, None, plots, |layout| layout), values)
    }
}
