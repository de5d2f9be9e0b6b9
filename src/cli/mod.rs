//! Arguments, files, terminal and exit codes.

mod args;
mod commands;
mod terminal;
mod values;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;

use crate::diagnostic::Diagnostic;
use crate::render::diagnostics::render;
use args::{Arguments, Command, Format};

/// What a command has to say.
pub struct Output {
    /// For people.
    pub text: String,
    /// For programs.
    pub json: serde_json::Value,
    /// Warnings, shown on the error stream.
    pub diagnostics: Vec<Diagnostic>,
    /// Other files to write, each whole or not at all.
    pub files: Vec<(PathBuf, String)>,
    /// The outcome is a refusal: exit status 1 although there is something to show.
    pub failed: bool,
    /// What is printed stays on the screen: `--output` names one of `files`.
    pub written: bool,
    /// The text is a file's, not for reading: it is never laid out for the screen.
    pub verbatim: bool,
}

impl Output {
    fn new(text: String, json: serde_json::Value) -> Self {
        Self { text, json, diagnostics: Vec::new(), files: Vec::new(), failed: false, written: false, verbatim: false }
    }

    fn verbatim(self) -> Self {
        Self { verbatim: true, ..self }
    }
}

/// Why a command has nothing to show.
pub enum Failure {
    /// Bad input: exit status 2.
    Input(Vec<Diagnostic>),
    /// The computation could not be completed: exit status 1.
    Computation(String),
}

impl From<Vec<Diagnostic>> for Failure {
    fn from(diagnostics: Vec<Diagnostic>) -> Self {
        Self::Input(diagnostics)
    }
}

impl Failure {
    fn input(message: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::Input(vec![Diagnostic::error(message).remedy(remedy)])
    }

    fn computation(error: impl std::fmt::Display) -> Self {
        Self::Computation(error.to_string())
    }
}

/// Runs the command line of this process. Exit status 0 done, 1 not computed, 2 bad input.
pub fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let color = terminal::color();
    terminal::quiet(arguments.quiet);
    if let Some(screen) = terminal::width().filter(|_| arguments.output.is_none()) {
        crate::render::table::fit_to(screen);
    }
    if let Some(jobs) = arguments.jobs {
        // Fails only if a pool stands already, which nothing before this makes.
        let _ = rayon::ThreadPoolBuilder::new().num_threads(jobs.max(1)).build_global();
    }
    match run(&arguments).and_then(|output| sparing_inputs(&arguments, output)) {
        Ok(output) => {
            if !arguments.quiet {
                say(&render(&output.diagnostics, color));
            }
            match deliver(&arguments, &output) {
                Ok(()) if output.failed => ExitCode::from(1),
                Ok(()) => ExitCode::SUCCESS,
                Err(message) => {
                    say(&format!("error: {message}\n"));
                    ExitCode::from(1)
                }
            }
        }
        Err(Failure::Input(diagnostics)) => {
            say(&render(&diagnostics, color));
            ExitCode::from(2)
        }
        Err(Failure::Computation(message)) => {
            say(&format!("error: {message}\n"));
            ExitCode::from(1)
        }
    }
}

/// Refuses to write over what was read.
fn sparing_inputs(arguments: &Arguments, output: Output) -> Result<Output, Failure> {
    let printed = arguments.output.as_deref().filter(|_| !output.written);
    let mut targets = output.files.iter().map(|(path, _)| path.as_path()).chain(printed);
    match targets.find(|path| crate::files::was_read(path)) {
        Some(path) => Err(Failure::input(
            format!("`{}` would be written over, and this command has read it", path.display()),
            "give another name",
        )),
        None => Ok(output),
    }
}

/// Text on the error stream; when that is closed there is nobody to tell.
fn say(text: &str) {
    let _ = std::io::stderr().write_all(text.as_bytes());
}

fn deliver(arguments: &Arguments, output: &Output) -> Result<(), String> {
    let text = match arguments.format {
        Format::Text => output.text.clone(),
        Format::Json => serde_json::to_string_pretty(&output.json).map_err(|error| error.to_string())? + "\n",
    };
    let mut files: Vec<(&Path, &str)> =
        output.files.iter().map(|(path, content)| (path.as_path(), content.as_str())).collect();
    let printed_to = arguments.output.as_deref().filter(|_| !output.written);
    files.extend(printed_to.map(|path| (path, text.as_str())));
    crate::files::write_whole(&files)?;
    if printed_to.is_some() {
        return Ok(());
    }
    if arguments.quiet {
        return Ok(());
    }
    let text = match crate::render::table::screen() {
        Some(screen) if arguments.format == Format::Text && !output.verbatim => terminal::wrapped(&text, screen),
        _ => text,
    };
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        // A reader that has seen enough (`| head`) is no failure.
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(error.to_string()),
        _ => Ok(()),
    }
}

fn run(arguments: &Arguments) -> Result<Output, Failure> {
    if let Some(path) = &arguments.output {
        crate::files::writable(path).map_err(|diagnostic| Failure::Input(vec![diagnostic]))?;
    }
    match &arguments.command {
        Command::Check(command) => commands::check::run(command),
        Command::Convert(command) => commands::convert::run(command),
        Command::Pose(command) => commands::pose::run(command),
        Command::Stiffness(command) => commands::stiffness::run(command),
        Command::Solve(command) => commands::solve::run(command, arguments.seed),
        Command::Sensitivity(command) => commands::sensitivity::run(command),
        Command::Identifiability(command) => commands::identifiability::run(command),
        Command::Identify(command) => commands::identify::run(command, arguments.seed),
        Command::Diagnose(command) => commands::diagnose::run(command, arguments.seed),
        Command::Compensator(command) => commands::compensator::run(command),
        Command::Residuals(command) => commands::residuals::run(command),
        Command::Report(command) => commands::report::run(command, arguments),
        Command::View(command) => commands::view::run(command, arguments),
        Command::Simulate(command) => commands::simulate::run(command, arguments.seed),
        Command::Compensate(command) => commands::compensate::run(command),
        Command::Plan(command) => commands::plan::run(command, arguments.seed),
        Command::Blind(command) => commands::blind::run(command, arguments.seed),
        Command::Init(command) => commands::init::run(command, arguments.seed),
        Command::Explain(command) => commands::explain::run(command),
        Command::Man(command) => commands::man::run(command),
        Command::Schema(command) => commands::schema::run(command),
        Command::Completions(command) => commands::completions::run(command),
    }
}
