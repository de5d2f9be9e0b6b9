//! Arguments, files, terminal and exit codes.

mod args;
mod boxes;
mod commands;
mod output;
mod session;
mod terminal;
mod values;

use std::ffi::OsString;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use crate::Error;
use crate::diagnostic::Diagnostic;
use crate::files::Reader;
use crate::render::diagnostics::{inert_lines, render};
use crate::render::table::Screen;
use args::{Arguments, Command, Format};
use output::Output;
use session::Session;
use terminal::Terminal;

/// Runs the command line of this process with the standard effects. Exit status 0 done, 1 the result is not to be used, 2 bad
/// input.
pub fn main() -> ExitCode {
    main_with(Reader::default())
}

/// Runs a command line given as a list, the program's name first, as [`main`] does that of this process; the exit status.
pub fn main_from(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    performed(arguments, Reader::default())
}

/// Names of the commands.
pub fn command_names() -> Vec<String> {
    <Arguments as clap::CommandFactory>::command()
        .get_subcommands()
        .map(|command| command.get_name().to_string())
        .collect()
}

/// What a command found, for a program that called it.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// What `--format json` prints.
    pub json: serde_json::Value,
    /// What people read.
    pub text: String,
    /// Whether the result is not to be used: exit status 1 of the command.
    pub failed: bool,
}

/// Runs one command for a program: as [`main_with`], but nothing is printed, and signals stay with the program. `arguments` are
/// those behind the program's name; `watch` is called with how far long work is. `--jobs`, `--format` and `--quiet` are ignored.
///
/// # Errors
/// As the command, and arguments that it does not have.
///
/// ```
/// use elastogeo::effects::Catalogue;
///
/// let pose = ["pose", "universal-ur5", "--joints", "q1=30,q2=-60,q3=90"].map(String::from);
/// let answer = elastogeo::cli::call(Catalogue::standard(), &pose, &|_| ())?;
/// assert!(answer.json["tool"][0][3].is_f64() && !answer.failed);
/// # Ok::<(), elastogeo::Error>(())
/// ```
pub fn call(reader: impl Into<Reader>, arguments: &[String], watch: &(dyn Fn(&str) + Sync)) -> Result<Answer, Error> {
    crate::files::leave_signals();
    let reader = reader.into();
    let words = std::iter::once("elastogeo").chain(arguments.iter().map(String::as_str)).map(OsString::from);
    let arguments = Arguments::parsed(&reader.kinds, words).map_err(|error| {
        let text = error.to_string();
        let mut lines = text.trim_start_matches("error: ").lines();
        let message = lines.next().unwrap_or_default();
        let rest: Vec<&str> = lines.map(str::trim).filter(|line| !line.is_empty()).collect();
        Error::input(message, rest.join("; "))
    })?;
    let terminal = Terminal { screen: Screen::new(None), quiet: true, watch: Some(watch) };
    let session = Session { arguments: &arguments, terminal, reader };
    let output = run(&session)?;
    spare_inputs(&session, &output)?;
    if !output.files.is_empty() || !output.tables.is_empty() {
        // Who has stopped the work by unwinding it is asked once more.
        watch("writing files");
        write_files(&output, None)?;
    }
    Ok(Answer {
        json: output.with_diagnostics()?,
        text: inert_lines(&output.with_doubts()),
        failed: output.failed || output.alarm,
    })
}

/// Runs the command line of this process with a catalogue of effects, or with a reader that has kinds of readings too: those of a
/// program, for which all commands then work.
pub fn main_with(reader: impl Into<Reader>) -> ExitCode {
    performed(std::env::args_os(), reader.into()).into()
}

fn performed(words: impl IntoIterator<Item = OsString>, reader: Reader) -> u8 {
    let arguments = &Arguments::parsed(&reader.kinds, words).unwrap_or_else(|error| error.exit());
    let color = terminal::color();
    let screen = Screen::new(terminal::width().filter(|_| arguments.output.is_none()));
    if let Some(jobs) = arguments.jobs {
        // Fails only if a pool stands already, which nothing before this makes.
        let _ = rayon::ThreadPoolBuilder::new().num_threads(jobs.into()).build_global();
    }
    let terminal = Terminal { screen, quiet: arguments.quiet, watch: None };
    let session = Session { arguments, terminal, reader };
    let delivered = run(&session).and_then(|output| {
        spare_inputs(&session, &output)?;
        session.terminal.warn(&output.diagnostics);
        deliver(&session, &output)?;
        if output.failed && arguments.quiet {
            write_error(&why_failed(&output, color));
        }
        Ok((output.failed, output.alarm))
    });
    match delivered {
        Ok((true, _)) => 1,
        Ok((_, true)) => 3,
        Ok(_) => 0,
        Err(error) => {
            let (text, status) = match error.diagnostics() {
                Some(diagnostics) => (render(diagnostics, color), 2),
                None => {
                    let help = error.remedy().map_or_else(String::new, |remedy| format!(" = help: {remedy}\n"));
                    (format!("error: {error}\n{help}"), 1)
                }
            };
            write_error(&text);
            if arguments.format == Format::Json {
                refused(&error);
            }
            status
        }
    }
}

/// Why a result is a refusal, where nothing else shows it.
fn why_failed(output: &Output, color: bool) -> String {
    let tells = |found: &&Diagnostic| found.is_error() || found.code.forbids_saving();
    let why: Vec<Diagnostic> = output.diagnostics.iter().filter(tells).cloned().collect();
    match why.is_empty() {
        true => "error: the result is a refusal\n = help: without --quiet it says why\n".into(),
        false => render(&why, color),
    }
}

/// Why there is no result, for programs: nothing but the diagnostics.
fn refused(error: &Error) {
    let found = error.explained();
    if let Ok(text) = serde_json::to_string_pretty(&serde_json::json!({ "diagnostics": found })) {
        // A closed stream is ignored, as that of errors is.
        let _ = writeln!(std::io::stdout().lock(), "{text}");
    }
}

/// Refuses to write over what was read, and two results into one file.
fn spare_inputs(session: &Session, output: &Output) -> Result<(), Error> {
    let printed = session.arguments.output.as_deref().filter(|_| !output.written);
    let tables = output.tables.iter().map(|(path, _)| path.as_path());
    let targets: Vec<&Path> =
        output.files.iter().map(|(path, _)| path.as_path()).chain(tables).chain(printed).collect();
    if let Some(path) = crate::files::named_twice(&targets) {
        let message = format!("two results would go to `{}`", path.display());
        return Err(Error::input(message, "give another name to one of them"));
    }
    if let Some(path) = targets.iter().find(|path| session.reader.has_read(path)) {
        let message = format!("`{}` would be written over, and this command has read it", path.display());
        return Err(Error::input(message, "give another name"));
    }
    match targets
        .iter()
        .find_map(|path| Some((path, campaign_of(path).filter(|own| !targets.contains(&own.as_path()))?)))
    {
        Some((path, campaign)) => Err(Error::input(
            format!("`{}` would be written over, and `{}` names it", path.display(), campaign.display()),
            "give another name",
        )),
        None => Ok(()),
    }
}

/// The campaign in the folder of an existing file that names it.
fn campaign_of(path: &Path) -> Option<PathBuf> {
    let campaign = path.parent()?.join("campaign.yaml");
    let name = path.file_name()?.to_str()?;
    let text = std::fs::read_to_string(&campaign).ok().filter(|_| path.is_file())?;
    let is_name = |word: &str| word.trim_matches(['"', '\'']) == name;
    let separates = |c: char| c.is_whitespace() || ",[]{}".contains(c);
    text.split(separates).any(is_name).then_some(campaign)
}

/// Text on the error stream; a closed one is ignored.
fn write_error(text: &str) {
    let _ = std::io::stderr().write_all(text.as_bytes());
}

fn deliver(session: &Session, output: &Output) -> Result<(), Error> {
    let arguments = session.arguments;
    let text = match arguments.format {
        Format::Text if output.verbatim => output.text.clone(),
        // A file holds what the quiet error stream does not show.
        Format::Text if arguments.quiet && arguments.output.is_some() => {
            inert_lines(&(output.with_doubts() + &output.notes()))
        }
        Format::Text => inert_lines(&output.with_doubts()),
        Format::Json if output.json.is_null() => String::new(),
        Format::Json => serde_json::to_string_pretty(&output.with_diagnostics()?)? + "\n",
    };
    let printed_to = arguments.output.as_deref().filter(|_| !output.written);
    write_files(output, printed_to.map(|path| (path, text.as_bytes())))?;
    if printed_to.is_some() || arguments.quiet {
        return Ok(());
    }
    let text = match session.terminal.screen.columns() {
        Some(columns) if arguments.format == Format::Text && !output.verbatim => terminal::wrapped(&text, columns),
        _ => text,
    };
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        // A reader that has seen enough (`| head`) is no failure.
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(error.into()),
        _ => Ok(()),
    }
}

/// Writes the files of a command, and one more.
fn write_files<'a>(output: &'a Output, more: Option<(&'a Path, &'a [u8])>) -> Result<(), Error> {
    let texts = output.files.iter().map(|(path, content)| (path.as_path(), content.as_bytes()));
    let tables = output.tables.iter().map(|(path, content)| (path.as_path(), content.as_slice()));
    let files: Vec<(&Path, &[u8])> = texts.chain(tables).chain(more).collect();
    crate::files::write_whole(&files)
}

fn run(session: &Session) -> Result<Output, Error> {
    if let Some(path) = &session.arguments.output {
        crate::files::writable(path)?;
    }
    match &session.arguments.command {
        Command::Check(command) => commands::check::run(command, session),
        Command::Convert(command) => commands::convert::run(command, session),
        Command::Pose(command) => commands::pose::run(command, session),
        Command::Stiffness(command) => commands::stiffness::run(command, session),
        Command::Solve(command) => commands::solve::run(command, session),
        Command::Sensitivity(command) => commands::sensitivity::run(command, session),
        Command::Identifiability(command) => commands::identifiability::run(command, session),
        Command::Identify(command) => commands::identify::run(command, session),
        Command::Register(command) => commands::register::run(command, session),
        Command::Diagnose(command) => commands::diagnose::run(command, session),
        Command::Compensator(command) => commands::compensator::run(command, session),
        Command::Residuals(command) => commands::residuals::run(command, session),
        Command::Report(command) if command.certificate => commands::certificate::run(command, session),
        Command::Report(command) => commands::report::run(command, session),
        Command::Track(command) => commands::track::run(command, session),
        Command::View(command) => commands::view::run(command, session),
        Command::Simulate(command) => commands::simulate::run(command, session),
        Command::Compensate(command) => commands::compensate::run(command, session),
        Command::Place(command) => commands::place::run(command, session),
        Command::Plan(command) => commands::plan::run(command, session),
        Command::Blind(command) => commands::blind::run(command, session),
        Command::Init(command) => commands::init::run(command, session),
        Command::Explain(command) => commands::explain::run(command, session),
        Command::Man(command) => commands::man::run(command),
        Command::Schema(command) => commands::schema::run(command),
        Command::Completions(command) => commands::completions::run(command),
    }
}
