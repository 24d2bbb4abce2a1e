//! What a session has said so far, and the tabs that listen.

use std::collections::VecDeque;
use std::convert::Infallible;
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll};
use std::time::{Duration, Instant};

use axum::response::sse;
use futures_core::Stream;
use gravical::live::{Event, Message};
use gravical::{Error, Result};
use tokio::sync::mpsc;

use crate::cmd::live::console::Renderer;

/// Events that may wait for a tab: half a minute of a session.
const QUEUE: usize = 300;
/// Tabs at a time. A browser opens six connections to a host, and each tab holds one.
const TABS: usize = 4;
/// A tab that does not read connects again after this time.
const RETRY: Duration = Duration::from_millis(500);

/// Everything that was said, for tabs that come later, and the tabs that listen.
#[derive(Default)]
pub struct Hub {
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    /// All events but the status.
    past: Vec<Arc<str>>,
    /// The latest status.
    status: Option<Arc<str>>,
    report: Option<Arc<str>>,
    tabs: Vec<mpsc::Sender<Arc<str>>>,
    /// When the last tab went.
    left: Option<Instant>,
    ended: bool,
}

impl Hub {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The last event was said.
    pub fn has_ended(&self) -> bool {
        self.state().ended
    }

    /// The calibration report.
    pub fn report(&self) -> Option<Arc<str>> {
        self.state().report.clone()
    }

    /// All tabs have what was said.
    pub fn is_read(&self) -> bool {
        let mut tabs = self.state().tabs.clone().into_iter();
        tabs.all(|tab| tab.capacity() == tab.max_capacity())
    }

    /// Disconnects all tabs.
    pub fn close(&self) {
        self.state().tabs.clear();
    }

    /// No tab has listened for so long.
    pub fn is_left_for(&self, time: Duration) -> bool {
        let state = self.state();
        state.tabs.is_empty() && state.left.is_none_or(|left| left.elapsed() > time)
    }

    /// A new tab, which gets everything from the beginning; none when there are too many.
    pub fn join(self: &Arc<Self>) -> Option<Listener> {
        let (sender, receiver) = mpsc::channel(QUEUE);
        let mut state = self.state();
        if state.tabs.len() >= TABS {
            return None;
        }
        state.tabs.push(sender);
        Some(Listener {
            before: state.past.iter().chain(&state.status).cloned().collect(),
            retry: Some(RETRY),
            receiver,
            hub: Arc::clone(self),
        })
    }
}

impl Renderer for Arc<Hub> {
    /// Says an event to all tabs. One that is far behind is disconnected: it connects again, and
    /// gets everything from the beginning.
    fn show(&mut self, message: &Message) -> Result<()> {
        let text = serde_json::to_string(message);
        let text: Arc<str> = text
            .map_err(|e| Error::device("page", e.to_string()))?
            .into();
        let mut state = self.state();
        if matches!(message.event, Event::Session { .. }) {
            // One before it, which goes on, is over.
            state.past.clear();
            (state.status, state.report, state.ended) = (None, None, false);
        }
        state.ended |= matches!(message.event, Event::End { .. });
        if message.event.is_status() {
            state.status = Some(Arc::clone(&text));
        } else {
            state.past.push(Arc::clone(&text));
        }
        state
            .tabs
            .retain(|tab| tab.try_send(Arc::clone(&text)).is_ok());
        Ok(())
    }

    fn report(&mut self, html: &str) {
        self.state().report = Some(html.into());
    }
}

/// The events for a tab.
pub struct Listener {
    before: VecDeque<Arc<str>>,
    /// Sent first.
    retry: Option<Duration>,
    receiver: mpsc::Receiver<Arc<str>>,
    hub: Arc<Hub>,
}

impl Drop for Listener {
    fn drop(&mut self) {
        self.receiver.close();
        let mut state = self.hub.state();
        state.tabs.retain(|tab| !tab.is_closed());
        state.left = Some(Instant::now());
    }
}

impl Stream for Listener {
    type Item = std::result::Result<sse::Event, Infallible>;

    fn poll_next(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        if let Some(retry) = self.retry.take() {
            return Poll::Ready(Some(Ok(sse::Event::default().retry(retry))));
        }
        let event = |text: Arc<str>| Ok(sse::Event::default().data(text));
        if let Some(text) = self.before.pop_front() {
            return Poll::Ready(Some(event(text)));
        }
        self.receiver.poll_recv(cx).map(|text| text.map(event))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tab_that_does_not_read_is_disconnected_and_the_others_go_on() {
        let mut hub = Arc::new(Hub::default());
        let event = Message::new(0.0, Event::PoseCandidate, "");
        hub.show(&event).unwrap();
        let (first, mut second) = (hub.join().unwrap(), hub.join().unwrap());
        for _ in 0..QUEUE {
            hub.show(&event).unwrap();
            assert!(second.receiver.try_recv().is_ok());
        }
        assert!(!hub.is_read());
        hub.show(&event).unwrap();
        assert!(first.receiver.is_closed() && !second.receiver.is_closed());
        drop(first);
        // Everything so far.
        let again = hub.join().unwrap();
        assert_eq!(again.before.len(), 1 + QUEUE + 1);
        drop(second);
        assert!(!hub.is_left_for(Duration::ZERO));
        drop(again);
        std::thread::sleep(Duration::from_millis(1));
        assert!(hub.is_left_for(Duration::ZERO));
    }
}
