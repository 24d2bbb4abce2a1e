//! Who shows the events, and what the user wants.

use std::io::BufRead as _;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender};

use gravical::Result;
use gravical::live::event::{Command, Message};

/// Shows events.
pub trait Renderer {
    /// Shows one. A reader who does not read does not stop the session.
    ///
    /// # Errors
    ///
    /// Where every event has to be written, and cannot be.
    fn show(&mut self, message: &Message) -> Result<()>;
    /// Takes the calibration report, which comes before the event that it was saved.
    fn report(&mut self, _html: &str) {}
}

/// What the user wants.
pub enum Entry {
    /// A line that was typed, or why it is no command. Several at once are done one after the
    /// other: what moves a simulated sensor waits until the pose before is taken.
    Typed(std::result::Result<Command, String>),
    /// From the page, where one sees what happens: done at once.
    #[cfg(feature = "live")]
    Clicked(Command),
}

/// Who shows the events, and what the user wants.
pub struct Console {
    pub renderers: Vec<Box<dyn Renderer>>,
    pub entries: Receiver<Entry>,
    /// Set by Ctrl-C.
    pub interrupted: Arc<AtomicBool>,
}

impl Console {
    /// Shows an event.
    ///
    /// # Errors
    ///
    /// As [`Renderer::show`].
    pub fn show(&mut self, message: &Message) -> Result<()> {
        self.renderers.iter_mut().try_for_each(|r| r.show(message))
    }

    /// The user ends the session.
    pub fn interrupt(&self) {
        self.interrupted.store(true, Ordering::SeqCst);
    }

    pub fn is_interrupted(&self) -> bool {
        self.interrupted.load(Ordering::SeqCst)
    }
}

/// Sends what is typed, a line each.
pub fn typed(sender: SyncSender<Entry>) {
    std::thread::spawn(move || {
        let lines = std::io::stdin().lock().lines();
        let lines = lines.map_while(std::io::Result::ok);
        for line in lines.filter(|line| !line.trim().is_empty()) {
            let command = Command::parse(&line).map_err(|e| match e.hint() {
                Some(hint) => format!("{e}; {hint}"),
                None => e.to_string(),
            });
            if sender.send(Entry::Typed(command)).is_err() {
                return;
            }
        }
    });
}
