//! What a command says where a program listens in place of a terminal.

use std::panic::resume_unwind;
use std::sync::{Arc, Mutex, PoisonError};

use crate::tool::listener::{Listener, Printed};

/// A listener, and what the command has printed so far.
#[derive(Clone)]
pub(crate) struct Heard {
    listener: Arc<dyn Listener>,
    printed: Arc<Mutex<Printed>>,
}

/// What unwinds the stack when the listener wants no more of it.
pub(crate) struct Stopped;

impl Heard {
    pub(crate) fn new(listener: Arc<dyn Listener>) -> Self {
        Self { listener, printed: Arc::default() }
    }

    /// Hands a warning or a note on.
    pub(crate) fn tell(&self, text: &str) {
        self.listener.tell(&plain(text));
    }

    /// Hands on how much is done, and ends the work if nobody wants it any more.
    pub(crate) fn progress(&self, what: &str, done: usize, total: usize) {
        self.listener.progress(what, done, total);
        self.stop_if_asked();
    }

    /// Hands on what the work is at, and ends it if nobody wants it any more.
    pub(crate) fn phase(&self, phase: &str) {
        self.listener.phase(phase);
        self.stop_if_asked();
    }

    /// Unwinds to the caller, as a panic does but without its message: from between any two pieces of
    /// work, with every half-written file removed.
    pub(crate) fn stop_if_asked(&self) {
        if self.listener.is_stopped() {
            resume_unwind(Box::new(Stopped));
        }
    }

    /// Keeps the result, for programs and for people.
    pub(crate) fn keep(&self, document: String, text: &str) {
        let mut printed = self.printed.lock().unwrap_or_else(PoisonError::into_inner);
        printed.document = document;
        printed.text += &plain(text);
    }

    /// Keeps what was printed beside a result.
    pub(crate) fn keep_text(&self, text: &str) {
        self.printed.lock().unwrap_or_else(PoisonError::into_inner).text += &plain(text);
    }

    pub(crate) fn printed(&self) -> Printed {
        self.printed.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// Without colors.
fn plain(text: &str) -> String {
    anstream::adapter::strip_str(text).to_string()
}
