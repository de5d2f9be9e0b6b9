//! What the terminal can show: colour, progress, width.

use std::io::{IsTerminal, Write};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::diagnostic::Diagnostic;
use crate::render::diagnostics::render;
use crate::render::table::Screen;

/// Narrower than this nothing is laid out.
const NARROWEST: usize = 40;

/// Where text and progress go.
#[derive(Clone, Copy)]
pub struct Terminal<'a> {
    /// What tables are laid out for.
    pub screen: Screen,
    /// Progress and results are not shown.
    pub quiet: bool,
    /// Told of progress, where a program runs the command.
    pub watch: Option<&'a (dyn Fn(&str) + Sync)>,
}

/// Progress of long work: a bar on a terminal, words for a program.
pub struct Bar<'a> {
    shown: ProgressBar,
    watch: Option<&'a (dyn Fn(&str) + Sync)>,
}

impl Bar<'_> {
    pub fn set_position(&self, position: u64) {
        self.shown.set_position(position);
        if self.shown.length().is_some() {
            self.tell(&format!("{position} %"));
        }
    }

    pub fn set_message(&self, message: String) {
        match self.shown.position() {
            0 => self.tell(&message),
            iteration => self.tell(&format!("iteration {iteration}: {message}")),
        }
        self.shown.set_message(message);
        self.shown.tick();
    }

    fn tell(&self, what: &str) {
        if let Some(watch) = self.watch {
            watch(what);
        }
    }
}

impl Drop for Bar<'_> {
    fn drop(&mut self) {
        self.shown.finish_and_clear();
    }
}

impl<'a> Terminal<'a> {
    /// A progress bar of `length` steps, or one that only turns; hidden off a terminal and by `--quiet`.
    pub fn bar(self, length: Option<u64>, template: &str) -> Bar<'a> {
        let bar = match length {
            _ if self.quiet || !std::io::stderr().is_terminal() => {
                ProgressBar::with_draw_target(length, ProgressDrawTarget::hidden())
            }
            Some(length) => ProgressBar::new(length),
            None => ProgressBar::new_spinner(),
        };
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        Bar { shown: bar, watch: self.watch }
    }

    /// Shows warnings on the error stream, unless `--quiet`.
    pub fn warn(self, diagnostics: &[Diagnostic]) {
        if !self.quiet {
            // A closed stream is ignored.
            let _ = std::io::stderr().write_all(render(diagnostics, color()).as_bytes());
        }
    }
}

/// Whether the error stream is coloured: on a terminal, unless `NO_COLOR` says otherwise.
pub fn color() -> bool {
    std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
}

/// Columns of the screen: `COLUMNS` where it is set, else the terminal's; `None` into a pipe or a file.
pub fn width() -> Option<usize> {
    let set = std::env::var("COLUMNS").ok().and_then(|columns| columns.trim().parse().ok());
    let seen = || terminal_size::terminal_size().map(|(width, _)| usize::from(width.0));
    let seen = || if std::io::stdout().is_terminal() { seen() } else { None };
    set.filter(|&columns| columns > 0).or_else(seen).map(|columns| columns.max(NARROWEST))
}

/// Text with lines longer than the screen broken between words, further lines indented.
pub fn wrapped(text: &str, width: usize) -> String {
    let mut out = String::with_capacity(text.len());
    for line in text.split_inclusive('\n') {
        let bare = line.trim_end_matches('\n');
        let indent = bare.len() - bare.trim_start().len();
        // Tables were laid out for the width; what is too wide all the same has columns, and no words.
        if bare.chars().count() <= width || indent >= width / 2 {
            out += line;
            continue;
        }
        let deeper = " ".repeat(indent + 2);
        out += &textwrap::fill(bare, textwrap::Options::new(width).subsequent_indent(&deeper).break_words(false));
        out += if line.ends_with('\n') { "\n" } else { "" };
    }
    out
}
