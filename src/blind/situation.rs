//! The state of the machine when a reading is taken.

/// The state of the machine when a reading is taken.
#[derive(Debug, Clone, Copy)]
pub struct Situation<'a> {
    /// Variables as commanded, rad and m.
    pub q: &'a [f64],
    /// Joints moved by the variables, rad.
    pub joints: &'a [f64],
    /// Load on each variable's joint, N.m.
    pub load: &'a [f64],
    /// Greatest such loads in the campaign.
    pub greatest: &'a [f64],
    /// Side of approach of each variable.
    pub side: &'a [f64],
    /// Move of each variable from the configuration before, rad and m; 0 where there is none.
    pub last_move: &'a [f64],
    /// Time as a share of the campaign's length.
    pub time: f64,
}

impl Situation<'_> {
    /// Load on a variable's joint, over `soft` times the greatest.
    pub fn share(&self, variable: usize, soft: f64) -> f64 {
        self.load[variable] / (soft * self.greatest[variable]).max(f64::MIN_POSITIVE)
    }
}
