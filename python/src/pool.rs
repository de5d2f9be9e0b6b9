//! Workspaces that calls leave to those after them: making one can take longer than a configuration.

use std::sync::Mutex;

/// Workspaces of one kind, each made for a `K`.
pub struct Pool<K, W>(Mutex<Vec<(K, W)>>);

impl<K, W> Default for Pool<K, W> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<K: Copy + PartialEq, W> Pool<K, W> {
    /// Works with a workspace for `of`: the last one that was left, if it was made for that, or a new one.
    pub fn with<T>(&self, of: K, make: impl FnOnce() -> W, work: impl FnOnce(&mut W) -> T) -> T {
        let left = self.0.lock().ok().and_then(|mut left| left.pop()).filter(|(own, _)| *own == of);
        let mut own = left.map_or_else(make, |(_, own)| own);
        let done = work(&mut own);
        if let Ok(mut left) = self.0.lock() {
            left.push((of, own));
        }
        done
    }
}
