//! The robot as an SVG for papers: the same parts as in the page, from one side, in black, grey and a few colours.

use std::fmt::Write;

use nalgebra::Vector3;

use super::page::inert;
use crate::description::urdf::escaped;
use crate::scene::{Drive, Part, PartKind, Scene, Shot};

const WIDTH: f64 = 900.0;
const HEIGHT: f64 = 760.0;
const MARGIN: f64 = 70.0;

/// From where the robot is seen, deg: 0, 0 is from -y, with x to the right and z up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// About z.
    pub yaw: f64,
    /// Above the horizon.
    pub pitch: f64,
}

impl Default for Look {
    fn default() -> Self {
        Self { yaw: -50.0, pitch: 20.0 }
    }
}

struct Camera {
    axes: [Vector3<f64>; 3],
    scale: f64,
    offset: [f64; 2],
}

impl Camera {
    /// Right, up and towards the eye; all points within the margins.
    fn new(look: Look, points: &[Vector3<f64>]) -> Self {
        let ((sy, cy), (sp, cp)) = (look.yaw.to_radians().sin_cos(), look.pitch.to_radians().sin_cos());
        let axes =
            [Vector3::new(cy, sy, 0.0), Vector3::new(-sp * sy, sp * cy, cp), Vector3::new(cp * sy, -cp * cy, sp)];
        let mut camera = Self { axes, scale: 1.0, offset: [0.0; 2] };
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for point in points {
            let at = camera.at(point);
            for k in 0..2 {
                low[k] = low[k].min(at[k]);
                high[k] = high[k].max(at[k]);
            }
        }
        let area = [WIDTH - 2.0 * MARGIN, HEIGHT - 2.0 * MARGIN];
        let scale = (0..2).map(|k| area[k] / (high[k] - low[k]).max(1e-6)).fold(f64::INFINITY, f64::min);
        if scale.is_finite() && !points.is_empty() {
            camera.scale = scale;
            let size = [WIDTH, HEIGHT];
            camera.offset = [0, 1].map(|k| 0.5 * (size[k] - scale * (low[k] + high[k])));
        }
        camera
    }

    /// Across, down, and depth (greater is nearer).
    fn at(&self, point: &Vector3<f64>) -> [f64; 3] {
        let [right, up, eye] = &self.axes;
        [self.scale * right.dot(point) + self.offset[0], -self.scale * up.dot(point) + self.offset[1], eye.dot(point)]
    }
}

/// Strokes with their depths.
struct Sheet {
    camera: Camera,
    strokes: Vec<(f64, String)>,
    /// Names and where they stand; those at one place are written side by side.
    names: Vec<([f64; 2], String)>,
}

impl Sheet {
    fn line(&mut self, points: &[Vector3<f64>], style: &str) {
        for pair in points.windows(2) {
            let [a, b] = [self.camera.at(&pair[0]), self.camera.at(&pair[1])];
            let stroke =
                format!("<line x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\" {style}/>", a[0], a[1], b[0], b[1]);
            self.strokes.push((0.5 * (a[2] + b[2]), stroke));
        }
    }

    fn face(&mut self, points: &[Vector3<f64>], style: &str) {
        let at: Vec<[f64; 3]> = points.iter().map(|p| self.camera.at(p)).collect();
        let corners: Vec<String> = at.iter().map(|p| format!("{:.1},{:.1}", p[0], p[1])).collect();
        let depth = at.iter().map(|p| p[2]).sum::<f64>() / at.len().max(1) as f64;
        self.strokes.push((depth, format!("<polygon points=\"{}\" {style}/>", corners.join(" "))));
    }

    fn dot(&mut self, point: &Vector3<f64>, radius: f64, style: &str) {
        let at = self.camera.at(point);
        self.strokes
            .push((at[2] + 1e-3, format!("<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"{radius}\" {style}/>", at[0], at[1])));
    }

    fn text(&mut self, point: &Vector3<f64>, text: &str, below: bool) {
        let [x, y, _] = self.camera.at(point);
        let at = [x + 8.0, y + if below { 18.0 } else { -8.0 }];
        match self.names.iter_mut().find(|(known, _)| (known[0] - at[0]).hypot(known[1] - at[1]) < 12.0) {
            Some((_, names)) => *names += &format!(", {text}"),
            None => self.names.push((at, text.to_string())),
        }
    }

    /// Sides and ends of a beam.
    fn prism(&mut self, p: &[Vector3<f64>], style: &str) {
        let n = p.len() / 2;
        for k in 0..n {
            let next = (k + 1) % n;
            self.face(&[p[k], p[next], p[n + next], p[n + k]], style);
        }
    }
}

/// The drawing. `magnified` times the shot's displacements are drawn as the deflected shape, if it has any; `names` writes
/// names next to joints, actuators, springs and markers.
pub fn figure(scene: &Scene, shot: &Shot, look: Look, magnified: f64, names: bool, caption: &str) -> String {
    let deflected: Vec<Vector3<f64>> = shot.points.iter().zip(&shot.moved).map(|(p, d)| p + d * magnified).collect();
    let near: Vec<usize> =
        scene.parts.iter().filter(|part| part.kind != PartKind::Anchor).flat_map(|part| part.points.clone()).collect();
    let shown: Vec<Vector3<f64>> = near
        .iter()
        .filter_map(|&k| shot.points.get(k))
        .chain(near.iter().filter_map(|&k| deflected.get(k)))
        .copied()
        .collect();
    let mut sheet = Sheet { camera: Camera::new(look, &shown), strokes: Vec::new(), names: Vec::new() };
    for part in &scene.parts {
        let points: Vec<Vector3<f64>> = part.points.iter().filter_map(|&k| shot.points.get(k)).copied().collect();
        if points.len() != part.points.len()
            || points.is_empty()
            || matches!(part.kind, PartKind::Frame | PartKind::Anchor)
        {
            continue;
        }
        draw(&mut sheet, part, &points, scene.axis);
        if names {
            label(&mut sheet, part, &points);
        }
    }
    for part in scene.parts.iter().filter(|_| !deflected.is_empty()) {
        let points: Vec<Vector3<f64>> = part.points.iter().map(|&k| deflected[k]).collect();
        match part.kind {
            PartKind::Link => sheet.line(&points, "class=\"moved\""),
            PartKind::Beam => sheet.prism(&points, "class=\"moved-beam\""),
            _ => {}
        }
    }
    sheet.strokes.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" height=\"{HEIGHT}\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"14\">\n<title>{}</title>\n<style>{STYLE}</style>\n<rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"#fff\"/>\n",
        escaped(caption)
    );
    for (_, stroke) in &sheet.strokes {
        let _ = writeln!(svg, "{stroke}");
    }
    for ([x, y], name) in &sheet.names {
        let _ = writeln!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\">{}</text>", escaped(name));
    }
    svg += &bar(&sheet.camera);
    svg += &triad(&sheet.camera);
    if !deflected.is_empty() {
        let _ = writeln!(
            svg,
            "<text x=\"{}\" y=\"24\" text-anchor=\"end\" class=\"note\">deflected shape x {magnified}</text>",
            WIDTH - 16.0
        );
    }
    inert(&(svg + "</svg>\n"))
}

const STYLE: &str = "line{stroke-linecap:round;fill:none}.link{stroke:#777;stroke-width:5}.beam{fill:#2f6fb5;fill-opacity:.12;stroke:#345;stroke-width:.7}\
.variable,.actuator-joint{stroke:#2f6fb5;stroke-width:10}.passive{stroke:#9aa1ad;stroke-width:10}.coupling{stroke:#7b4fb3;stroke-width:10}\
.actuator{stroke:#2d8a4e;stroke-width:7}.rod{stroke:#2d8a4e;stroke-width:3}.spring{stroke:#c0322b;stroke-width:2}.cut{fill:none;stroke:#7b4fb3;stroke-width:2}\
.pin{fill:#fff;stroke:#2d8a4e;stroke-width:1.5}.mass{fill:#fff;stroke:#111;stroke-width:1.5}.marker{fill:#2d8a4e}.tool{fill:#111}.x{stroke:#c0322b;stroke-width:2}\
.y{stroke:#2d8a4e;stroke-width:2}.z{stroke:#2f6fb5;stroke-width:2}.thin{stroke:#777;stroke-width:2}.moved{stroke:#d9731a;stroke-width:3}\
.moved-beam{fill:#d9731a;fill-opacity:.08;stroke:#d9731a;stroke-width:.7}.note{fill:#d9731a}text{fill:#111;paint-order:stroke;stroke:#fff;stroke-width:3px}";

fn draw(sheet: &mut Sheet, part: &Part, p: &[Vector3<f64>], axis: f64) {
    match (part.kind, p) {
        (PartKind::Link, _) => sheet.line(p, "class=\"link\""),
        (PartKind::Beam, _) => sheet.prism(p, "class=\"beam\""),
        (PartKind::Joint, [origin, tip]) => {
            let along = (tip - origin) * 0.42;
            let class = match part.drive {
                Some(Drive::Variable) => "variable",
                Some(Drive::Actuator) => "actuator-joint",
                Some(Drive::Coupling) => "coupling",
                Some(Drive::Passive) => "passive",
                None => "",
            };
            sheet.line(&[origin - along, origin + along], &format!("class=\"{class}\""));
        }
        (PartKind::Cut, [at, _]) => sheet.dot(at, 8.0, "class=\"cut\""),
        (PartKind::Actuator, [a, b]) => {
            let half = a.lerp(b, 0.55);
            sheet.line(&[*a, half], "class=\"actuator\"");
            sheet.line(&[half, *b], "class=\"rod\"");
            [a, b].into_iter().for_each(|pin| sheet.dot(pin, 4.0, "class=\"pin\""));
        }
        (PartKind::Spring, [a, b]) => sheet.line(&coil(a, b, 0.28 * axis), "class=\"spring\""),
        (PartKind::Mass, [at]) => sheet.dot(at, 4.0, "class=\"mass\""),
        (PartKind::Marker, [from, at]) => {
            sheet.line(&[*from, *at], "stroke=\"#999\" stroke-width=\"1\" stroke-dasharray=\"2 3\"");
            sheet.dot(at, 4.5, "class=\"marker\"");
        }
        (PartKind::Tool, [from, at, x, y, z]) => {
            sheet.line(&[*from, *at], "class=\"thin\"");
            for (tip, class) in [(x, "x"), (y, "y"), (z, "z")] {
                sheet.line(&[*at, *tip], &format!("class=\"{class}\""));
            }
            sheet.dot(at, 4.0, "class=\"tool\"");
        }
        _ => {}
    }
}

fn label(sheet: &mut Sheet, part: &Part, p: &[Vector3<f64>]) {
    match (part.kind, p) {
        (PartKind::Joint, [at, ..]) | (PartKind::Marker | PartKind::Tool, [_, at, ..]) => {
            sheet.text(at, &part.name, false)
        }
        (PartKind::Actuator | PartKind::Spring, [a, b]) => sheet.text(&a.lerp(b, 0.5), &part.name, false),
        (PartKind::Cut, [at, ..]) => sheet.text(at, &part.name, true),
        _ => {}
    }
}

/// A zigzag from a to b.
fn coil(a: &Vector3<f64>, b: &Vector3<f64>, width: f64) -> Vec<Vector3<f64>> {
    let along = b - a;
    let other = if along.z.abs() < 0.9 * along.norm() { Vector3::z() } else { Vector3::x() };
    let side = along.cross(&other).try_normalize(1e-12).unwrap_or_else(Vector3::x) * width;
    let turn = |k: i32| a + along * (0.14 + 0.72 * f64::from(k) / 18.0) + side * if k % 2 == 0 { 1.0 } else { -1.0 };
    let mut points = vec![*a, a.lerp(b, 0.12)];
    points.extend((0..=18).map(turn));
    points.extend([a.lerp(b, 0.88), *b]);
    points
}

/// A bar of a round length, mm.
fn bar(camera: &Camera) -> String {
    let wanted = 0.2 * WIDTH / camera.scale;
    let decade = 10f64.powf(wanted.max(1e-9).log10().floor());
    let length = decade * [5.0, 2.0, 1.0].into_iter().find(|m| m * decade <= wanted).unwrap_or(1.0);
    let (x, y) = (WIDTH - 16.0, HEIGHT - 18.0);
    let from = x - length * camera.scale;
    format!(
        "<path d=\"M{from:.1} {y}H{x}M{from:.1} {}V{}M{x} {}V{}\" stroke=\"#111\" stroke-width=\"2\" fill=\"none\"/><text x=\"{x}\" y=\"{}\" text-anchor=\"end\">{} mm</text>\n",
        y - 4.0,
        y + 4.0,
        y - 4.0,
        y + 4.0,
        y - 10.0,
        length * 1e3
    )
}

/// Axes of the base.
fn triad(camera: &Camera) -> String {
    let (x, y) = (44.0, HEIGHT - 40.0);
    let mut out = String::new();
    for (k, name) in ["x", "y", "z"].into_iter().enumerate() {
        let (dx, dy) = (28.0 * camera.axes[0][k], -28.0 * camera.axes[1][k]);
        let _ = writeln!(
            out,
            "<line x1=\"{x}\" y1=\"{y}\" x2=\"{:.1}\" y2=\"{:.1}\" class=\"{name}\"/><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{name}</text>",
            x + dx,
            y + dy,
            x + 1.35 * dx,
            y + 1.35 * dy + 5.0
        );
    }
    out
}
