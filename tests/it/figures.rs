//! Every figure of the README and the docs is what a command prints or what a measurement recorded.
//!
//! A figure is a number with a decimal point, or a per cent, outside of code and of quoted output. The line before its
//! paragraph, list or table says where it comes from:
//!
//! ```text
//! <!-- figures: elastogeo diagnose kr270-no-compensator -->   the command is run; the figures must be in what it prints
//! <!-- figures: coverage.txt | 200 43 -->                     they must be in the record docs/figures/coverage.txt;
//!                                                             so must the whole numbers 200 and 43
//! <!-- given: 0.03 0.104 -->                                  not measured: an input, a setting, a published value
//! ```
//!
//! A printed number may have more digits than the docs show. In a table, where a line of the source begins with the row's
//! name, the row's numbers must be those of that line in its order, whole ones too but for the first cell's. A record names the command that makes it in its first line: either a
//! test, which compares its findings with the record whenever it runs ([`recorded`]), or `docs/figures/make.py`.

use std::collections::HashMap;
use std::path::PathBuf;

use crate::cli::run;
use crate::docs::{pages, root, text};

fn record(name: &str) -> PathBuf {
    root().join("docs/figures").join(name)
}

/// Compares findings of a test, a line for each, with the record `docs/figures/NAME.txt`: words alike, numbers to 0.1 % or to
/// the rounding of the digits written. With `ELASTOGEO_FIGURES=write` in the environment the record is written instead.
pub fn recorded(name: &str, command: &str, lines: &[String]) {
    let now = format!("$ {command}\n{}\n", lines.join("\n"));
    let path = record(&format!("{name}.txt"));
    if writes() {
        return std::fs::write(&path, now).expect("written");
    }
    let then = text(&path);
    let alike = |a: &Number, b: &Number| {
        (a.value - b.value).abs() <= (1e-3 * b.value.abs()).max(a.half_digit() + b.half_digit())
    };
    let (a, b) = (numbers(&now), numbers(&then));
    assert!(
        a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| alike(a, b)),
        "{}:\n{then}but found\n{now}If that is meant, run `ELASTOGEO_FIGURES=write {command}`",
        path.display()
    );
}

/// How many seeds a test takes: `full` where it writes its record, `each` in every other run.
pub fn seeds(full: u64, each: u64) -> u64 {
    if writes() { full } else { each }
}

/// Whether records are written.
pub fn writes() -> bool {
    std::env::var("ELASTOGEO_FIGURES").is_ok_and(|value| value == "write")
}

/// A number as it is written.
#[derive(Debug, Clone, PartialEq)]
struct Number {
    written: String,
    value: f64,
    /// Digits after the point, exponent.
    digits: usize,
    exponent: i32,
    percent: bool,
}

impl Number {
    fn half_digit(&self) -> f64 {
        0.5 * 10f64.powi(self.exponent - self.digits as i32)
    }

    /// Whether this number, rounded, is the other one: printed 0.10873 shows as 0.109.
    fn shows_as(&self, shown: &Self) -> bool {
        let fine_enough = self.exponent - self.digits as i32 <= shown.exponent - shown.digits as i32;
        let away = (self.value.abs() - shown.value.abs()).abs();
        fine_enough && away <= shown.half_digit() * (1.0 + 1e-9) && (shown.percent || !self.percent)
    }

    fn is_figure(&self) -> bool {
        self.digits > 0 || self.percent
    }
}

/// The numbers of a text, but for those that are part of a name (`q1`, `m2`, `5.alpha`, `6x6`).
fn numbers(text: &str) -> Vec<Number> {
    let bytes = text.as_bytes();
    let is = |at: usize, test: fn(&u8) -> bool| bytes.get(at).is_some_and(test);
    let (mut found, mut at) = (Vec::new(), 0);
    while at < bytes.len() {
        let part_of_a_name = at > 0 && (is(at - 1, |b| b.is_ascii_alphanumeric() || b"_.".contains(b)));
        if !is(at, u8::is_ascii_digit) || part_of_a_name {
            at += 1;
            continue;
        }
        let start = at;
        let run = |mut at: usize| {
            while is(at, u8::is_ascii_digit) {
                at += 1;
            }
            at
        };
        at = run(at);
        let mut digits = 0;
        if is(at, |b| *b == b'.') && is(at + 1, u8::is_ascii_digit) {
            let end = run(at + 1);
            (digits, at) = (end - at - 1, end);
        }
        let mut exponent = 0;
        if is(at, |b| *b == b'e') {
            let sign = usize::from(is(at + 1, |b| b"+-".contains(b)));
            let end = run(at + 1 + sign);
            if end > at + 1 + sign {
                exponent = text[at + 1..end].parse().unwrap_or(0);
                at = end;
            }
        }
        let in_a_name = is(at, |b| b.is_ascii_alphabetic() || *b == b'_')
            || (is(at, |b| *b == b'.') && is(at + 1, u8::is_ascii_alphanumeric));
        let percent = text[at..].trim_start().starts_with('%');
        let written = text[start..at].to_string();
        if let (false, Ok(value)) = (in_a_name, written.parse()) {
            found.push(Number { written, value, digits, exponent, percent });
        }
    }
    found
}

/// Text without code spans and targets of links.
fn prose(block: &str) -> String {
    let words = block.split('`').step_by(2).collect::<Vec<_>>().join("` `");
    let mut parts = words.split("](");
    let mut out = parts.next().unwrap_or_default().to_string();
    for part in parts {
        out += part.split_once(')').map_or("", |(_, after)| after);
    }
    out
}

/// A paragraph, list or table, and the markers before it.
struct Block {
    line: usize,
    markers: Vec<(String, String)>,
    text: String,
}

fn blocks(page: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut block = Block { line: 0, markers: Vec::new(), text: String::new() };
    let mut code = false;
    for (line, words) in page.lines().chain([""]).enumerate() {
        let fence = words.starts_with("```");
        let marker = words.strip_prefix("<!-- ").and_then(|words| words.strip_suffix(" -->"));
        if fence || code || words.trim().is_empty() {
            code ^= fence;
            if !block.text.is_empty() {
                blocks.push(std::mem::replace(&mut block, Block { line: 0, markers: Vec::new(), text: String::new() }));
            }
        } else if let Some((kind, what)) = marker.and_then(|marker| marker.split_once(": ")) {
            block.markers.push((kind.into(), what.trim().into()));
        } else {
            block.line = if block.text.is_empty() { line + 1 } else { block.line };
            block.text += &format!("{words}\n");
        }
    }
    blocks
}

/// What commands print and records hold, each found once.
#[derive(Default)]
struct Sources {
    known: HashMap<String, String>,
}

impl Sources {
    fn get(&mut self, source: &str) -> &str {
        self.known.entry(source.to_string()).or_insert_with(|| {
            let Some(command) = source.strip_prefix("elastogeo ") else {
                let found = text(&record(source));
                assert!(found.starts_with("$ "), "docs/figures/{source} does not begin with its command");
                return found;
            };
            let folder = tempfile::tempdir().expect("a folder");
            let ran = run(folder.path(), &command.split_whitespace().collect::<Vec<_>>());
            assert_eq!(ran.status, 0, "{source}\n{}", ran.err);
            ran.out + &ran.err
        })
    }
}

/// The name of a table's row: its first code span, or its first cell.
fn row_name(line: &str) -> Option<&str> {
    let cell = line.strip_prefix("| ")?.split(" |").next()?.trim();
    Some(cell.split('`').nth(1).unwrap_or(cell)).filter(|name| !name.is_empty())
}

/// Figures of a block that its markers do not account for.
fn unfounded(block: &Block, sources: &mut Sources) -> Vec<String> {
    let (mut texts, mut given, mut missing) = (Vec::new(), Vec::new(), Vec::new());
    for (kind, what) in &block.markers {
        match kind.as_str() {
            "figures" => {
                let (source, whole) = what.split_once(" | ").unwrap_or((what, ""));
                let found = sources.get(source).to_string();
                for number in whole.split_whitespace() {
                    let holds = |text: &str| numbers(text).iter().any(|found| found.written == number);
                    if !holds(&found) || !holds(&prose(&block.text)) {
                        missing.push(format!("{number} ({source})"));
                    }
                }
                texts.push(found);
            }
            "given" => given.extend(what.split_whitespace().map(str::to_string)),
            _ => missing.push(format!("marker `{kind}`: write `figures` or `given`")),
        }
    }
    for line in block.text.lines() {
        let of_row: Vec<&str> = row_name(line).map_or_else(Vec::new, |name| {
            let begins = |line: &&str| {
                let after = line.strip_prefix(name);
                after.is_some_and(|after| after.starts_with(|c: char| c == ':' || c.is_whitespace()))
            };
            texts.iter().flat_map(|text| text.lines()).filter(begins).collect()
        });
        let shown = numbers(&prose(line));
        let is_to_show = |number: &&Number| number.is_figure() && !given.contains(&number.written);
        if of_row.is_empty() {
            let known: Vec<Number> = texts.iter().flat_map(|text| numbers(text)).collect();
            let is_missing = |number: &&Number| !known.iter().any(|known| known.shows_as(number));
            missing.extend(shown.iter().filter(is_to_show).filter(is_missing).map(|number| number.written.clone()));
            continue;
        }
        // Each cell's numbers, whole ones too, are those of the row's line, in its order: one does not stand for another.
        let of_label = numbers(&prose(line.split(" |").next().unwrap_or_default())).len();
        let mut known: Vec<Number> = of_row.into_iter().flat_map(numbers).collect();
        for (at, number) in shown.iter().enumerate() {
            if given.contains(&number.written) || at < of_label && !number.is_figure() {
                continue;
            }
            match known.iter().position(|known| known.shows_as(number)) {
                Some(at) => drop(known.drain(..=at)),
                None => missing.push(number.written.clone()),
            }
        }
    }
    missing
}

#[test]
fn every_figure_of_the_docs_is_printed_or_recorded() {
    let mut sources = Sources::default();
    let (mut wrong, mut checked) = (Vec::new(), 0);
    for page in pages() {
        let name = page.strip_prefix(root()).expect("a page").display().to_string();
        for block in blocks(&text(&page)) {
            checked += numbers(&prose(&block.text)).iter().filter(|number| number.is_figure()).count();
            let missing = unfounded(&block, &mut sources);
            if !missing.is_empty() {
                wrong.push(format!("{name}:{}: {}", block.line, missing.join(", ")));
            }
        }
    }
    assert!(wrong.is_empty(), "figures that no marker accounts for:\n{}", wrong.join("\n"));
    assert!(checked > 150, "{checked} figures");
}

/// The check itself: a figure that is not printed, in another row, without a marker, is found.
#[test]
fn wrong_figures_are_found() {
    let mut sources = Sources::default();
    sources.known.insert("made.txt".into(), "$ make\nUR5: 0.10873 24 %\nUR10: 0.4247 1.2e-5\nSCARA: 6 of 40\n".into());
    let mut missing =
        |page: &str| -> Vec<String> { blocks(page).iter().flat_map(|block| unfounded(block, &mut sources)).collect() };
    let marker = "<!-- figures: made.txt -->\n";
    for right in [
        format!("{marker}0.109 mm, 0.11 mm, 24 % and 1.2e-5"),
        format!("{marker}| UR5 | 0.1087 |\n| UR10 | 0.42 |"),
        format!("{marker}<!-- given: 0.03 -->\n0.109 mm at 0.03 mm"),
        "the numbers of `0.5` and m2.5 in [a link](0.7)\n\n```sh\n0.3\n```".into(),
    ] {
        assert_eq!(missing(&right), Vec::<String>::new(), "{right}");
    }
    for (wrong, found) in [
        (format!("{marker}0.108 mm"), "0.108"),
        (format!("{marker}0.10873 mm but 0.108731 mm"), "0.108731"),
        (format!("{marker}25 %"), "25"),
        (format!("{marker}| UR5 | 0.4247 |"), "0.4247"),
        (format!("{marker}| UR5 | 0.109 | 0.109 |"), "0.109"),
        (format!("{marker}| `SCARA`, 9 readings | 8 of 40 |"), "8"),
        (format!("{marker}1.3e-5"), "1.3e-5"),
        ("0.109 mm".into(), "0.109"),
        (format!("{marker}0.109 mm\n\n0.11 mm"), "0.11"),
        ("<!-- figures: made.txt | 7 -->\n7 arms".into(), "7 (made.txt)"),
    ] {
        assert_eq!(missing(&wrong), [found], "{wrong}");
    }
}
