//! Work outside of the interpreter's lock: no panic leaves it, and long work hears of Ctrl-C and tells how far it is.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use pyo3::prelude::*;

use crate::error::{fault, raised};

/// How often signals are looked for.
const INTERVAL: Duration = Duration::from_millis(50);
/// Of the thread that works; numerics of large closures recurse.
const STACK: usize = 16 << 20;

/// What unwinds work that was stopped.
pub struct Stopped;

enum News<T> {
    Progress(String),
    Done(Result<Result<T, elastogeo::Error>, Box<dyn Any + Send>>),
}

/// Work that takes a moment.
pub fn brief<T: Send>(py: Python<'_>, work: impl FnOnce() -> Result<T, elastogeo::Error> + Send) -> PyResult<T> {
    let done = py.detach(|| catch_unwind(AssertUnwindSafe(work)));
    finished(py, done)
}

/// Work that takes long, on a thread of its own: meanwhile signals are heeded, and `progress` is called with what the work says
/// of itself. Work that is stopped ends where it next says something.
pub fn long<T: Send + 'static>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&(dyn Fn(&str) + Sync)) -> Result<T, elastogeo::Error> + Send + 'static,
) -> PyResult<T> {
    let (news, told) = channel();
    let stop = Arc::new(AtomicBool::new(false));
    let asked = Arc::clone(&stop);
    let worker = std::thread::Builder::new().name("elastogeo".into()).stack_size(STACK);
    let started = worker.spawn(move || {
        let tell = |what: &str| {
            if asked.load(Ordering::Relaxed) {
                resume_unwind(Box::new(Stopped));
            }
            let _ = news.send(News::Progress(what.to_string()));
        };
        let done = catch_unwind(AssertUnwindSafe(|| work(&tell)));
        let _ = news.send(News::Done(done));
    });
    started.map_err(|error| fault(py, format!("no thread can be started: {error}"), "end other programs"))?;
    let heeded = |news: &Option<String>| -> PyResult<()> {
        py.check_signals()?;
        match (news, progress) {
            (Some(what), Some(progress)) => progress.call1((what,)).map(drop),
            _ => Ok(()),
        }
    };
    let mut told = told;
    loop {
        // A receiver belongs to one thread at a time: it goes along.
        let (next, same) = py.detach(move || (told.recv_timeout(INTERVAL), told));
        told = same;
        let said = match next {
            Ok(News::Done(done)) => return finished(py, done),
            Ok(News::Progress(what)) => Some(what),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => return finished(py, Err(Box::new("the work ended"))),
        };
        if let Err(error) = heeded(&said) {
            stop.store(true, Ordering::Relaxed);
            return Err(error);
        }
    }
}

fn finished<T>(py: Python<'_>, done: Result<Result<T, elastogeo::Error>, Box<dyn Any + Send>>) -> PyResult<T> {
    match done {
        Ok(Ok(found)) => Ok(found),
        Ok(Err(error)) => Err(raised(py, &error)),
        Err(panic) => {
            let words = panic.downcast_ref::<&str>().map(ToString::to_string);
            let words = words.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
            Err(fault(py, format!("a fault of elastogeo itself: {words}"), "report it, with the input"))
        }
    }
}
