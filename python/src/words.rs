//! Words of a Python program where the library wants constants.

use std::collections::HashMap;
use std::sync::{Mutex, OnceLock};

/// A word that lives as long as the program; each is kept once.
pub fn kept(word: &str) -> &'static str {
    static WORDS: OnceLock<Mutex<HashMap<String, &'static str>>> = OnceLock::new();
    let Ok(mut words) = WORDS.get_or_init(Mutex::default).lock() else { return "" };
    words.entry(word.to_string()).or_insert_with(|| Box::leak(word.to_string().into_boxed_str()))
}
