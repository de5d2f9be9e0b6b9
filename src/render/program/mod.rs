//! Compensated paths as programs of robot controllers: one template a language, or a user's own.
//!
//! Poses are those of the commands in the controller's own geometry, in the description's base frame. Orientations: `abc` as KUKA
//! writes them (about z, y', x''), `wpr` as FANUC does (the same angles from x on; also A, B, C of DIN 66025), quaternions
//! (w, x, y, z) as ABB, rotation vectors (rad) as Universal Robots.

use minijinja::value::Serde;
use minijinja::{Environment, Error, ErrorKind, UndefinedBehavior};
use nalgebra::{Rotation3, UnitQuaternion, Vector3};
use serde::Serialize;

use crate::results::units::mm;
use crate::results::{Compensation, CorrectedPoint};

/// A language of controllers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Language {
    /// Its name on the command line.
    pub name: &'static str,
    /// Ending of its files.
    pub ending: &'static str,
    /// Longest name of a program.
    longest: usize,
    /// Whether programs of joints can be written.
    pub joints: bool,
    template: &'static str,
}

/// All languages. `json` is the context that templates are given.
pub const LANGUAGES: [Language; 7] = [
    Language { name: "krl", ending: "src", longest: 24, joints: true, template: include_str!("krl.j2") },
    Language { name: "rapid", ending: "mod", longest: 25, joints: true, template: include_str!("rapid.j2") },
    Language { name: "urscript", ending: "script", longest: 64, joints: true, template: include_str!("urscript.j2") },
    Language { name: "fanuc-ls", ending: "ls", longest: 36, joints: true, template: include_str!("fanuc-ls.j2") },
    Language { name: "gcode", ending: "nc", longest: 64, joints: false, template: include_str!("gcode.j2") },
    Language { name: "csv", ending: "csv", longest: 64, joints: true, template: include_str!("csv.j2") },
    Language { name: "json", ending: "json", longest: 64, joints: true, template: "" },
];

/// What the moves of a program name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Moves {
    /// Joints.
    Joints,
    /// Poses of the tool.
    Poses,
}

/// How a program is written.
#[derive(Debug, Clone, Copy)]
pub struct Wanted<'a> {
    /// Name of the program, which is made to fit the language.
    pub name: &'a str,
    pub moves: Moves,
    /// Of the tool along linear moves, mm/s.
    pub speed: f64,
}

/// What a template is given. Joints in deg and mm (`axes`), rad and m (`joints_si`).
#[derive(Serialize)]
struct Context<'a> {
    name: String,
    title: String,
    /// What is to be known of the program, one line each.
    head: Vec<String>,
    moves: Moves,
    speed: f64,
    has_poses: bool,
    variables: Vec<Axis<'a>>,
    points: Vec<ProgramPoint<'a>>,
}

#[derive(Serialize)]
struct Axis<'a> {
    name: &'a str,
    unit: &'static str,
}

#[derive(Serialize)]
struct ProgramPoint<'a> {
    index: usize,
    name: &'a str,
    axes: Vec<f64>,
    units: Vec<&'static str>,
    joints_si: Vec<f64>,
    /// Quarter turns of axes 1, 4 and 6, as ABB's configuration data count them.
    quarters: [i32; 3],
    #[serde(flatten)]
    pose: Option<Shown>,
}

/// A pose: mm, deg, unit quaternion, rad.
#[derive(Serialize)]
struct Shown {
    position: [f64; 3],
    abc: [f64; 3],
    wpr: [f64; 3],
    quaternion: [f64; 4],
    rotation_vector: [f64; 3],
    /// Row-major, m.
    matrix: [[f64; 4]; 4],
}

impl Shown {
    fn new(pose: &[f64; 6]) -> Self {
        let rotation = Rotation3::new(Vector3::new(pose[3], pose[4], pose[5]));
        let (roll, pitch, yaw) = rotation.euler_angles();
        let wpr = [roll, pitch, yaw].map(f64::to_degrees);
        let q = UnitQuaternion::from_rotation_matrix(&rotation);
        let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
        let row = |k: usize| {
            let r = rotation.matrix();
            [r[(k, 0)], r[(k, 1)], r[(k, 2)], pose[k]]
        };
        Self {
            position: [mm(pose[0]), mm(pose[1]), mm(pose[2])],
            abc: [wpr[2], wpr[1], wpr[0]],
            wpr,
            quaternion: [q.w, q.i, q.j, q.k].map(|v| sign * v),
            rotation_vector: [pose[3], pose[4], pose[5]],
            matrix: [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]],
        }
    }
}

/// Why no program can be written: what is wrong, and what to do.
pub type Refused = (String, String);

/// The program of the points that are met.
///
/// # Errors
/// Moves that the language, or the controller's geometry, does not have; a name that is none.
pub fn program(found: &Compensation, language: &Language, wanted: &Wanted) -> Result<String, Refused> {
    if wanted.moves == Moves::Joints && !language.joints {
        let message = format!("a program in {} names poses, not joints", language.name);
        return Err((message, "leave --moves out, or write --moves poses".into()));
    }
    render(found, language.template, language.name, language.longest, wanted)
}

/// The program by a template of the user's: minijinja's language, given the context that `--program json` prints.
///
/// # Errors
/// The same, and what is wrong with the template.
pub fn by_template(found: &Compensation, template: &str, file: &str, wanted: &Wanted) -> Result<String, Refused> {
    render(found, template, file, 64, wanted)
}

fn render(
    found: &Compensation,
    template: &str,
    source: &str,
    longest: usize,
    wanted: &Wanted,
) -> Result<String, Refused> {
    let points: Vec<&CorrectedPoint> = found.met().collect();
    if points.is_empty() {
        return Err((
            "no point can be met: there is nothing to write a program of".into(),
            "see the points refused".into(),
        ));
    }
    let lacking = points.iter().find(|point| point.pose.is_none());
    if let (Moves::Poses, Some(point)) = (wanted.moves, lacking) {
        let message = format!("the controller's geometry has no pose at the commands of point `{}`", point.name);
        return Err((message, "write --moves joints".into()));
    }
    let context = Context {
        name: identifier(wanted.name, longest),
        title: format!("{}: compensated path", found.robot),
        head: head(found, points.len(), wanted.moves),
        moves: wanted.moves,
        speed: wanted.speed,
        has_poses: lacking.is_none(),
        variables: found.variables.iter().map(|v| Axis { name: &v.name, unit: unit(v.is_angle) }).collect(),
        points: points.into_iter().map(|point| program_point(found, point)).collect(),
    };
    if template.is_empty() {
        return serde_json::to_string_pretty(&context)
            .map(|text| text + "\n")
            .map_err(|error| (format!("the path cannot be written: {error}"), "write it with --table".to_string()));
    }
    let faulty = |error: Error| {
        let line = error.line().map_or_else(String::new, |line| format!(":{line}"));
        let what = error.detail().map_or_else(|| error.kind().to_string(), ToString::to_string);
        let remedy = "templates are minijinja's, and are given what `--program json` prints";
        (format!("{source}{line}: the template cannot be filled in: {what}"), remedy.to_string())
    };
    let mut environment = environment();
    environment.add_template(source, template).map_err(faulty)?;
    let text = environment.get_template(source).and_then(|filled| filled.render(Serde(&context))).map_err(faulty)?;
    Ok(text.trim_end().to_string() + "\n")
}

fn program_point<'a>(found: &'a Compensation, point: &'a CorrectedPoint) -> ProgramPoint<'a> {
    let joints_si: Vec<f64> = point.joints.values().copied().collect();
    let in_units = found.variables.iter().zip(&joints_si);
    let axes: Vec<f64> = in_units.map(|(v, q)| if v.is_angle { q.to_degrees() } else { mm(*q) }).collect();
    let quarter = |k: usize| axes.get(k).map_or(0, |axis| (axis / 90.0).floor() as i32);
    ProgramPoint {
        index: point.index,
        name: &point.name,
        quarters: [quarter(0), quarter(3), quarter(5)],
        units: found.variables.iter().map(|v| unit(v.is_angle)).collect(),
        axes,
        joints_si,
        pose: point.pose.as_ref().map(Shown::new),
    }
}

fn unit(is_angle: bool) -> &'static str {
    if is_angle { "deg" } else { "mm" }
}

/// What whoever opens the program has to know.
fn head(found: &Compensation, met: usize, moves: Moves) -> Vec<String> {
    let mut lines = vec![
        format!("{met} of {} points", found.points.len()),
        format!("without correction {:.4} mm rms, {:.4} mm max", mm(found.before.rms), mm(found.before.max)),
        format!("predicted residual {:.1e} mm max", mm(found.after.max)),
    ];
    if let Some(uncertainty) = &found.uncertainty {
        lines.push(format!("standard uncertainty {:.4} mm rms", mm(uncertainty.rms)));
    }
    lines.push(match moves {
        Moves::Joints => "axes are the variables of the description".into(),
        Moves::Poses => "poses of the tool in the robot's base".to_string(),
    });
    lines
}

fn environment() -> Environment<'static> {
    let mut environment = Environment::new();
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    environment.set_auto_escape_callback(|_| minijinja::AutoEscape::None);
    environment.add_filter("fixed", |value: f64, digits: usize| {
        if digits > 17 {
            return Err(Error::new(ErrorKind::InvalidOperation, "`fixed` writes at most 17 digits"));
        }
        let text = format!("{value:.digits$}");
        // No minus before a zero.
        Ok(if text.trim_start_matches('-').chars().all(|c| c == '0' || c == '.') {
            text.trim_start_matches('-').to_string()
        } else {
            text
        })
    });
    environment.add_filter("padded", |value: usize, width: usize| format!("{value:>width$}", width = width.min(80)));
    environment.add_filter("truncated", |text: String, most: usize| text.chars().take(most).collect::<String>());
    environment.add_filter("quoted", |text: String| match text.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text,
    });
    environment.add_function("comment", |text: String| {
        // Names come from files: what could end a comment, or begin a command, is left out.
        let is_plain = |c: &char| c.is_ascii_graphic() && !"();!%\"{}#\\".contains(*c) || *c == ' ';
        text.chars().filter(is_plain).collect::<String>()
    });
    environment
}

/// A name that all controllers take: letters, digits and underscores, a letter first.
fn identifier(name: &str, longest: usize) -> String {
    let plain: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    let plain = if plain.starts_with(|c: char| c.is_ascii_alphabetic()) { plain } else { format!("p_{plain}") };
    plain.chars().take(longest).collect()
}
