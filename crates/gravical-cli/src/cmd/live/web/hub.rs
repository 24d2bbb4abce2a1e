//! What a session has said so far, and the tabs that listen.

use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;

use axum::response::sse;
use futures_util::stream::{Stream, unfold};
use gravical::live::{Event, Message};
use tokio::sync::watch;

/// A tab that was disconnected connects again after this time.
const RETRY: Duration = Duration::from_millis(500);

/// Everything that was said, for each tab to read at its own pace.
#[derive(Default)]
pub struct Said {
    /// All events but the status.
    past: Vec<Arc<str>>,
    /// The latest status.
    status: Option<Arc<str>>,
    /// The file of the calibration report.
    pub report: Option<String>,
    /// The last event was said.
    pub has_ended: bool,
    /// A tab has listened.
    pub had_tab: bool,
    /// Nothing more will be said.
    is_closed: bool,
}

/// What was said, and who listens.
#[derive(Default)]
pub struct Hub(pub watch::Sender<Said>);

impl Hub {
    /// Says an event to all tabs.
    pub fn say(&self, message: &Message) {
        let text = message.to_json();
        self.0.send_modify(|said| {
            match &message.event {
                Event::Saved { report, .. } => said.report.clone_from(report),
                Event::End { .. } => said.has_ended = true,
                _ => {}
            }
            if message.event.is_status() {
                said.status = Some(text.into());
            } else {
                said.past.push(text.into());
            }
        });
    }

    /// Ends the streams of all tabs, once they have everything.
    pub fn close(&self) {
        self.0.send_modify(|said| said.is_closed = true);
    }

    /// Tabs that listen.
    pub fn tabs(&self) -> usize {
        self.0.receiver_count()
    }

    /// The events for a new tab, from the beginning.
    pub fn join(&self) -> impl Stream<Item = Result<sse::Event, Infallible>> + use<> {
        self.0.send_modify(|said| said.had_tab = true);
        let tab = Tab {
            said: self.0.subscribe(),
            next: 0,
            status: None,
        };
        unfold(tab, |mut tab| async {
            loop {
                if let Some(text) = tab.unread() {
                    let event = sse::Event::default().retry(RETRY).data(text);
                    return Some((Ok(event), tab));
                }
                if tab.said.borrow().is_closed {
                    return None;
                }
                tab.said.changed().await.ok()?;
            }
        })
    }
}

/// How far a tab has read.
struct Tab {
    said: watch::Receiver<Said>,
    /// Its next event.
    next: usize,
    status: Option<Arc<str>>,
}

impl Tab {
    /// The next event that was said already. Of statuses the latest is enough.
    fn unread(&mut self) -> Option<Arc<str>> {
        let said = self.said.borrow_and_update();
        if let Some(text) = said.past.get(self.next) {
            self.next += 1;
            return Some(Arc::clone(text));
        }
        let status = said.status.clone()?;
        let last = self.status.replace(Arc::clone(&status));
        let is_read = last.is_some_and(|last| Arc::ptr_eq(&last, &status));
        (!is_read).then_some(status)
    }
}
