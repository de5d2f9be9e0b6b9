//! Signals that would end the program wait until the files stand.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::{flag, low_level};

/// Signals that end a program: by hand, by the system, and by a terminal that closes.
#[cfg(unix)]
const ENDING: [i32; 3] = [SIGINT, SIGTERM, signal_hook::consts::SIGHUP];
#[cfg(not(unix))]
const ENDING: [i32; 2] = [SIGINT, SIGTERM];

/// While it lives, signals to end are noted; they take effect when it is dropped.
pub(super) struct Deferred(Option<&'static State>);

static LEFT: AtomicBool = AtomicBool::new(false);

/// Leaves signals to the program that uses the library: one that handles them itself must not be ended by them.
pub fn leave_signals() {
    LEFT.store(true, Ordering::SeqCst);
}

struct State {
    /// Whether a signal ends the program at once.
    effective: Arc<AtomicBool>,
    noted: Arc<AtomicUsize>,
}

impl Deferred {
    pub(super) fn new() -> Self {
        if LEFT.load(Ordering::SeqCst) {
            return Self(None);
        }
        static STATE: OnceLock<State> = OnceLock::new();
        let state = STATE.get_or_init(|| {
            let state = State { effective: Arc::new(AtomicBool::new(true)), noted: Arc::default() };
            for signal in ENDING {
                // Where it cannot be registered the program ends at once, as it would without.
                let _ = flag::register_conditional_default(signal, Arc::clone(&state.effective));
                let _ = flag::register_usize(signal, Arc::clone(&state.noted), signal.unsigned_abs() as usize);
            }
            state
        });
        state.effective.store(false, Ordering::SeqCst);
        Self(Some(state))
    }
}

impl Drop for Deferred {
    fn drop(&mut self) {
        let Some(state) = self.0 else { return };
        state.effective.store(true, Ordering::SeqCst);
        if let Ok(signal @ 1..) = i32::try_from(state.noted.load(Ordering::SeqCst)) {
            let _ = low_level::emulate_default_handler(signal);
        }
    }
}
