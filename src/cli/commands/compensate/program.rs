//! `compensate --program`: the corrected path in the language of a controller.

use std::path::Path;

use serde_json::json;

use crate::Error;
use crate::cli::args::Compensate;
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::compensation::astray;
use crate::diagnostic::Diagnostic;
use crate::kinematics::Geometry;
use crate::render::program::{LANGUAGES, Language, Moves, Wanted, by_template, program};
use crate::results::{Compensation, CorrectedPoint};

/// A program that is asked for.
pub struct Program<'a> {
    source: Source,
    command: &'a Compensate,
}

enum Source {
    Language(&'static Language),
    /// A template of the user's, and its file.
    Template(String, String),
}

impl<'a> Program<'a> {
    /// What the command asks for; `None` where it asks for no program.
    ///
    /// # Errors
    /// A language that is unknown and no file, a speed that is none.
    pub fn new(command: &'a Compensate, session: &Session) -> Result<Option<Self>, Error> {
        let Some(name) = &command.program else { return Ok(None) };
        if !(command.speed > 0.0 && command.speed <= 1e5) {
            return Err(Error::input(format!("--speed {}", command.speed), "give mm/s, above 0 and at most 100000"));
        }
        let source = match LANGUAGES.iter().find(|language| language.name == name) {
            Some(language) => Source::Language(language),
            None if Path::new(name).is_file() => {
                let template = session.reader.text(Path::new(name))?;
                if template.trim().is_empty() {
                    return Err(Error::input(
                        format!("--program: the template `{name}` is empty"),
                        "write what a program holds, as under Programs in docs/compensation.md",
                    ));
                }
                Source::Template(template, name.clone())
            }
            None => {
                let names: Vec<&str> = LANGUAGES.iter().map(|language| language.name).collect();
                return Err(Error::input(
                    format!("--program `{name}` is no language, and no file"),
                    format!("give one of {}, or the file of a template", names.join(", ")),
                ));
            }
        };
        Ok(Some(Self { source, command }))
    }

    fn moves(&self) -> Moves {
        let poses_alone = matches!(self.source, Source::Language(language) if !language.joints);
        self.command.moves.unwrap_or(if poses_alone { Moves::Poses } else { Moves::Joints })
    }

    /// A warning where the tool is to be moved on lines along which the robot does not come to the joints found.
    pub fn doubt(&self, found: &Compensation, geometry: &Geometry) -> Option<Diagnostic> {
        if self.moves() != Moves::Poses {
            return None;
        }
        let points: Vec<&CorrectedPoint> = found.met().collect();
        let joints = |point: &CorrectedPoint| point.joints.values().copied().collect::<Vec<f64>>();
        let strays = |pair: &&[&CorrectedPoint]| astray(geometry, &joints(pair[0]), &joints(pair[1]));
        let wrong: Vec<&[&CorrectedPoint]> = points.windows(2).filter(strays).collect();
        let first = wrong.first()?;
        let message = format!(
            "{} of {} straight moves do not lead to the joints found, the first from `{}` to `{}`: the wrist or the arm would have \
             to turn over on the way, or to pass a singular configuration",
            wrong.len(),
            points.len() - 1,
            first[0].name,
            first[1].name
        );
        Some(
            Diagnostic::warning(message)
                .remedy("move by joints (`--moves joints`), or give points of one configuration"),
        )
    }

    /// The program in the place of the text, and in the JSON.
    ///
    /// # Errors
    /// A program that cannot be written so.
    pub fn output(&self, found: &Compensation, path: &str, mut output: Output) -> Result<Output, Error> {
        let command = self.command;
        let stem = Path::new(path).file_stem().map_or_else(|| "path".into(), |stem| stem.to_string_lossy());
        let wanted = Wanted {
            name: command.program_name.as_deref().unwrap_or(&stem),
            moves: self.moves(),
            speed: command.speed,
        };
        let (text, language) = match &self.source {
            Source::Language(language) => (program(found, language, &wanted), language.name),
            Source::Template(template, file) => (by_template(found, template, file, &wanted), file.as_str()),
        };
        let text = text.map_err(|(message, remedy)| Error::input(message, remedy))?;
        if let Some(object) = output.json.as_object_mut() {
            object.insert("program".into(), json!({"language": language, "moves": wanted.moves, "text": text}));
        }
        output.text = text;
        output.verbatim = true;
        Ok(output)
    }
}
