//! Long work on a thread of its own: Python hears how far it is, and can be interrupted.

use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use pushlab::Listener;
use pyo3::exceptions::PyOSError;
use pyo3::types::PyAnyMethods;
use pyo3::{Bound, PyAny, PyResult, Python};

/// How often signals are looked for, which is how long an interrupt takes.
const POLL: Duration = Duration::from_millis(50);
/// That of a main thread; threads have a quarter of it by default.
const STACK: usize = 8 << 20;

/// What the work says on its way.
struct Teller {
    said: Sender<Said>,
    is_stopped: Arc<AtomicBool>,
}

/// As the functions of [`Listener`].
enum Said {
    Told(String),
    Progress(String, usize, usize),
    Phase(String),
}

impl Teller {
    fn say(&self, said: Said) {
        // Nobody listens to work that was interrupted.
        let _ = self.said.send(said);
    }
}

impl Listener for Teller {
    fn tell(&self, text: &str) {
        self.say(Said::Told(text.to_owned()));
    }

    fn progress(&self, what: &str, done: usize, total: usize) {
        self.say(Said::Progress(what.to_owned(), done, total));
    }

    fn phase(&self, phase: &str) {
        self.say(Said::Phase(phase.to_owned()));
    }

    fn is_stopped(&self) -> bool {
        self.is_stopped.load(Ordering::Relaxed)
    }
}

/// Runs work while other threads of Python may go on.
///
/// `tell` is called on this thread as `tell(kind, text, done, total)`. After an interrupt the work is told
/// to stop and left to itself: what it has no place to stop in ends later, and is thrown away.
///
/// # Errors
/// `KeyboardInterrupt`, or what a handler of signals or `tell` raises; `OSError` without a thread.
pub(crate) fn interruptible<T: Send + 'static>(
    py: Python<'_>,
    tell: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(Arc<dyn Listener>) -> T + Send + 'static,
) -> PyResult<T> {
    let is_stopped = Arc::new(AtomicBool::new(false));
    let (sender, said) = channel();
    let teller = Arc::new(Teller { said: sender, is_stopped: is_stopped.clone() });
    let thread = thread::Builder::new().stack_size(STACK).spawn(move || work(teller));
    let thread = thread.map_err(|error| PyOSError::new_err(error.to_string()))?;
    let said = Mutex::new(said);
    let next = || said.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(POLL);
    loop {
        let heard = match py.detach(next) {
            Ok(said) => tell.map_or(Ok(()), |tell| hand_on(tell, said)),
            Err(RecvTimeoutError::Timeout) => Ok(()),
            // The work has ended, and its end of the channel with it.
            Err(RecvTimeoutError::Disconnected) => break,
        };
        if let Err(error) = heard.and_then(|()| py.check_signals()) {
            is_stopped.store(true, Ordering::Relaxed);
            return Err(error);
        }
    }
    match py.detach(|| thread.join()) {
        Ok(done) => Ok(done),
        Err(panic) => resume_unwind(panic),
    }
}

fn hand_on(tell: &Bound<'_, PyAny>, said: Said) -> PyResult<()> {
    let (kind, text, done, total) = match said {
        Said::Told(text) => ("told", text, 0, 0),
        Said::Progress(what, done, total) => ("progress", what, done, total),
        Said::Phase(phase) => ("phase", phase, 0, 0),
    };
    tell.call1((kind, text, done, total))?;
    Ok(())
}
