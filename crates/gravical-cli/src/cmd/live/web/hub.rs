//! What a session has said so far, and the tabs that listen.

use std::collections::VecDeque;
use std::convert::Infallible;
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll};
use std::time::{Duration, Instant};

use axum::response::sse;
use futures_core::Stream;
use tokio::sync::mpsc;

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

    /// Says an event to all tabs. One that is far behind is disconnected: it connects again, and
    /// gets everything from the beginning.
    pub fn say(&self, text: String, is_status: bool) {
        let text: Arc<str> = text.into();
        let mut state = self.state();
        if is_status {
            state.status = Some(Arc::clone(&text));
        } else {
            state.past.push(Arc::clone(&text));
        }
        state
            .tabs
            .retain(|tab| tab.try_send(Arc::clone(&text)).is_ok());
    }

    /// Says the first event of a session; one before it, which goes on, is over.
    pub fn begin(&self, text: String) {
        let mut state = self.state();
        state.past.clear();
        (state.status, state.report, state.ended) = (None, None, false);
        drop(state);
        self.say(text, false);
    }

    /// Says the last event.
    pub fn end(&self, text: String) {
        self.state().ended = true;
        self.say(text, false);
    }

    /// The last event was said.
    pub fn has_ended(&self) -> bool {
        self.state().ended
    }

    /// Keeps the calibration report.
    pub fn keep_report(&self, html: &str) {
        self.state().report = Some(html.into());
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
    type Item = Result<sse::Event, Infallible>;

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
        let hub = Arc::new(Hub::default());
        hub.say("0".to_owned(), false);
        let (first, mut second) = (hub.join().unwrap(), hub.join().unwrap());
        for i in 0..QUEUE {
            hub.say(i.to_string(), i % 10 != 0);
            assert!(second.receiver.try_recv().is_ok());
        }
        assert!(!hub.is_read());
        hub.say("too many".to_owned(), false);
        assert!(first.receiver.is_closed() && !second.receiver.is_closed());
        drop(first);
        // The events so far, and the latest status.
        let again = hub.join().unwrap();
        assert_eq!(again.before.len(), 1 + QUEUE / 10 + 1 + 1);
        drop(second);
        assert!(!hub.is_left_for(Duration::ZERO));
        drop(again);
        std::thread::sleep(Duration::from_millis(1));
        assert!(hub.is_left_for(Duration::ZERO));
    }
}
