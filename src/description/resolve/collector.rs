//! Collects the diagnostics of a description while it is resolved, each with its place, and what they make unknown.

use nalgebra::Vector3;

use super::super::parameters::Owner;
use crate::diagnostic::{Code, Diagnostic, Explained, Locate, Place};

/// What to do about a number that is none, or to which too great ones add up.
const FINITE: &str = "check the value and those that it is made of: lengths and angles are small numbers";

/// Greatest length (m) or angle (rad) that is taken for one.
pub const GREATEST: f64 = 1e9;

/// Collects diagnostics, each with its place.
pub struct Collector<'a> {
    locate: Locate<'a>,
    explained: Explained<'a>,
    pub diagnostics: Vec<Diagnostic>,
    /// Some antecedent is missing or part of a circle: what hangs on the tree is not known.
    pub antecedents_failed: bool,
    /// Some coupling cannot be read: which joints it drives is not known.
    pub couplings_failed: bool,
}

impl<'a> Collector<'a> {
    pub fn new(locate: Locate<'a>, explained: Explained<'a>) -> Self {
        Self { locate, explained, diagnostics: Vec::new(), antecedents_failed: false, couplings_failed: false }
    }

    /// Whether what is missing at `path` has been reported as faulty.
    pub fn explained(&self, path: &[&str]) -> bool {
        (self.explained)(path)
    }

    /// Files an error about an owner at `path` that has no `key`, unless the key is there and faulty.
    pub fn lacking(&mut self, path: &[&str], key: &str, message: impl Into<String>) -> Option<&mut Diagnostic> {
        let mut wanted = path.to_vec();
        wanted.push(key);
        if self.explained(&wanted) {
            return None;
        }
        let diagnostic = self.error(path, message);
        diagnostic.code = Code::Missing;
        Some(diagnostic)
    }

    pub fn place(&self, path: &[&str]) -> Option<Place> {
        (self.locate)(path)
    }

    /// Files an error about the value at `path`; the caller may add to it.
    pub fn error(&mut self, path: &[&str], message: impl Into<String>) -> &mut Diagnostic {
        self.file(Diagnostic::error(message).at(self.place(path)))
    }

    /// Files an error about the value at `path`, with what to do about it.
    pub fn reject(&mut self, path: &[&str], message: impl Into<String>, remedy: impl Into<String>) {
        self.error(path, message).remedy = Some(remedy.into());
    }

    /// Files an error about the value at `path`, which contradicts or repeats that at another path, with a word on why.
    pub fn conflict(
        &mut self,
        path: &[&str],
        message: impl Into<String>,
        first: &[&str],
        why: &str,
        remedy: impl Into<String>,
    ) {
        let first = self.place(first);
        let diagnostic = Diagnostic::error(message).code(Code::Duplicate).at(self.place(path));
        self.diagnostics.push(diagnostic.related(first, why).remedy(remedy));
    }

    fn file(&mut self, diagnostic: Diagnostic) -> &mut Diagnostic {
        let last = self.diagnostics.len();
        self.diagnostics.push(diagnostic);
        &mut self.diagnostics[last]
    }

    /// Files an error unless a name is one of the valid ones.
    pub fn known<'n>(&mut self, path: &[&str], kind: &str, name: &str, valid: impl Iterator<Item = &'n str> + Clone) {
        if !valid.clone().any(|known| known == name) {
            self.unknown(path, kind, name, valid);
        }
    }

    /// An unknown name, with the nearest valid one.
    ///
    /// Files nothing about a name whose declaration is there and faulty.
    pub fn unknown<'n>(&mut self, path: &[&str], kind: &str, name: &str, valid: impl IntoIterator<Item = &'n str>) {
        let sections: &[&str] = match kind {
            "frame" | "joint" => &["frames"],
            "node" => &["nodes", "frames"],
            "section" => &["sections"],
            "material" => &["materials"],
            "actuator" => &["actuators"],
            _ => &[],
        };
        let owners = if kind == "parameter" { Owner::possible(name) } else { Vec::new() };
        if sections.iter().any(|section| self.is_faulty(section, name))
            || owners.iter().any(|owner| matches!(*owner.path(), [section, entry] if self.is_faulty(section, entry)))
        {
            return;
        }
        let diagnostic =
            Diagnostic::error(format!("unknown {kind} `{name}`")).at(self.place(path)).suggest(name, valid);
        self.diagnostics.push(diagnostic);
    }

    /// Whether a section, or the entry under exactly this name in it, was left out as faulty.
    fn is_faulty(&self, section: &str, name: &str) -> bool {
        self.explained(&[section]) || self.explained(&[section, name])
    }

    /// `value * factor`, with an error unless it is a finite number that a length or an angle can be.
    pub fn finite(&mut self, path: &[&str], value: Option<f64>, factor: f64) -> f64 {
        let value = value.unwrap_or(0.0);
        if !value.is_finite() {
            self.reject(path, format!("`{value}` where a finite number is needed"), FINITE);
            return 0.0;
        }
        if (value * factor).abs() > GREATEST {
            self.reject(path, format!("`{value:e}` is too great"), "check the value and `units:`");
            return 0.0;
        }
        value * factor
    }

    pub fn vector(&mut self, path: &[&str], value: Option<[f64; 3]>, factor: f64) -> Vector3<f64> {
        let value = value.unwrap_or_default();
        if let Some(bad) = value.iter().find(|v| !v.is_finite()) {
            self.reject(path, format!("`{bad}` where a finite number is needed"), FINITE);
            return Vector3::zeros();
        }
        if let Some(bad) = value.iter().find(|v| (**v * factor).abs() > GREATEST) {
            self.reject(path, format!("`{bad:e}` is too great"), "check the value and `units:`");
            return Vector3::zeros();
        }
        Vector3::from(value) * factor
    }

    /// Limits of a joint or a stroke: an interval of lengths or angles, infinite where there is none.
    pub fn limits(&mut self, path: &[&str], value: Option<[f64; 2]>, factor: f64) -> Option<[f64; 2]> {
        let limits = self.interval(path, value, factor, true)?;
        if let Some(bad) = limits.iter().find(|v| v.is_finite() && v.abs() > GREATEST) {
            let shown = bad / factor;
            self.reject(path, format!("`{shown:e}` is too great"), "write `.inf` where there is no limit");
            return None;
        }
        Some(limits)
    }

    /// Limits or bounds: numbers, in order; infinite ones only where `open`.
    pub fn interval(&mut self, path: &[&str], value: Option<[f64; 2]>, factor: f64, open: bool) -> Option<[f64; 2]> {
        let [low, high] = value?;
        if low.is_nan() || high.is_nan() || !(open || low.is_finite() && high.is_finite()) {
            let message = format!("[{low}, {high}]: both ends must be {}numbers", if open { "" } else { "finite " });
            let remedy = if open { "write `-.inf` or `.inf` where there is no limit" } else { "give both ends" };
            self.reject(path, message, remedy);
            return None;
        }
        if low >= high {
            self.reject(
                path,
                format!("[{low}, {high}]: the lower end is not below the upper one"),
                if low > high { format!("write [{high}, {low}]") } else { "give an interval that is not empty".into() },
            );
            return None;
        }
        Some([low * factor, high * factor])
    }
}
