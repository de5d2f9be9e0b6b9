//! Numbers of a declared file multiplied, named by where they stand in it: `sections.column.wall`, `joint_stiffness.*.kar`.

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use super::yaml;

/// A file as any reader of YAML sees it.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(untagged, expecting = "the value fits none of the forms that are accepted here")]
enum Tree {
    Nothing(()),
    Is(bool),
    Whole(i64),
    Number(f64),
    Text(String),
    List(Vec<Tree>),
    Map(IndexMap<String, Tree>),
}

/// Places of the numbers of a file, and the file with some of them multiplied.
#[derive(Debug, Clone, PartialEq)]
pub struct Numbers(Tree);

impl Numbers {
    /// The numbers of what is declared; `None` if it cannot be written as YAML and read back.
    pub fn of<T: Serialize>(declared: &T) -> Option<Self> {
        yaml::read("declared", &yaml::write(declared).ok()?).0.map(Self)
    }

    /// Places of all numbers that a factor changes, keys and places in lists joined by dots.
    pub fn places(&self) -> Vec<String> {
        let mut places = Vec::new();
        self.0.clone().visit(String::new(), &mut |place, number| {
            places.extend((*number != 0.0 && number.is_finite()).then(|| place.to_string()));
        });
        places
    }

    /// The text of the file with each number whose place, or the beginning of it, a pattern names multiplied by a factor, and
    /// where these stand. `*` stands for any part of a name. Zero and infinity stay, and are not counted.
    pub fn multiplied(&self, pattern: &str, factor: f64) -> Option<(String, Vec<String>)> {
        let (mut tree, mut places) = (self.0.clone(), Vec::new());
        tree.visit(String::new(), &mut |place, number| {
            if names(pattern.as_bytes(), place.as_bytes()) && *number != 0.0 && number.is_finite() {
                *number *= factor;
                places.push(place.to_string());
            }
        });
        Some((yaml::write(&tree).ok()?, places))
    }
}

impl Tree {
    fn visit(&mut self, place: String, each: &mut dyn FnMut(&str, &mut f64)) {
        let below = |name: &str| if place.is_empty() { name.to_string() } else { format!("{place}.{name}") };
        match self {
            Self::Number(number) => each(&place, number),
            Self::Whole(whole) => {
                let mut number = *whole as f64;
                each(&place, &mut number);
                if number != *whole as f64 {
                    *self = Self::Number(number);
                }
            }
            Self::List(list) => list.iter_mut().enumerate().for_each(|(k, of)| of.visit(below(&k.to_string()), each)),
            Self::Map(map) => map.iter_mut().for_each(|(name, of)| of.visit(below(name), each)),
            Self::Nothing(()) | Self::Is(_) | Self::Text(_) => {}
        }
    }
}

/// Whether a pattern names a place or something that it lies in.
fn names(pattern: &[u8], place: &[u8]) -> bool {
    match (pattern.split_first(), place.split_first()) {
        (None, None | Some((b'.', _))) => true,
        (Some((b'*', rest)), _) if rest.first() == Some(&b'*') => names(rest, place),
        (Some((b'*', rest)), _) => {
            names(rest, place) || place.split_first().is_some_and(|(next, left)| *next != b'.' && names(pattern, left))
        }
        (Some((wanted, rest)), Some((found, left))) => wanted == found && names(rest, left),
        (None, Some(_)) | (Some(_), None) => false,
    }
}
