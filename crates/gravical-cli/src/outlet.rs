//! Standard output or standard error behind a bounded queue: a reader who stops reading
//! stops neither the recording nor its end.

use std::io::{self, Write};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

/// Messages that wait at most.
const ROOM: usize = 1000;
/// A status, which is repeated every second, is dropped when this many wait.
const ROOM_FOR_STATUS: usize = 50;
/// At the end a reader who reads nothing for this time is not waited for.
const PATIENCE: Duration = Duration::from_secs(2);

/// Where messages of a session go.
pub enum Sink {
    /// As fast as possible: the reader sets the pace.
    Waiting(Box<dyn Write>),
    /// In real time, which does not wait for a reader.
    Queued(Queue),
}

/// A queue of messages to the thread that writes them.
pub struct Queue {
    sender: SyncSender<String>,
    /// Messages that are not written yet.
    waiting: Arc<AtomicUsize>,
    /// Why a message could not be written.
    failed: Arc<OnceLock<io::ErrorKind>>,
    dropped: u64,
    /// Nobody reads: the end is not waited for any more.
    is_given_up: bool,
}

impl Queue {
    fn waiting(&self) -> usize {
        self.waiting.load(Ordering::SeqCst)
    }
}

impl Sink {
    /// Writes to `to` in a thread of its own, which is not waited for.
    pub fn queued(to: impl Write + Send + 'static) -> Self {
        let (sender, messages) = sync_channel(ROOM);
        let waiting = Arc::new(AtomicUsize::new(0));
        let failed = Arc::new(OnceLock::new());
        let (count, failure) = (Arc::clone(&waiting), Arc::clone(&failed));
        std::thread::spawn(move || write(to, &messages, &count, &failure));
        Sink::Queued(Queue {
            sender,
            waiting,
            failed,
            dropped: 0,
            is_given_up: false,
        })
    }

    /// Writes a message; into a queue without room it is dropped, and counted.
    ///
    /// # Errors
    ///
    /// The system's; of a queue those of messages before.
    pub fn send(&mut self, message: String) -> io::Result<()> {
        match self {
            Sink::Waiting(to) => to.write_all(message.as_bytes()).and_then(|()| to.flush()),
            Sink::Queued(queue) => {
                queue.waiting.fetch_add(1, Ordering::SeqCst);
                if queue.sender.try_send(message).is_err() {
                    queue.waiting.fetch_sub(1, Ordering::SeqCst);
                    queue.dropped += 1;
                }
                let failed = queue.failed.get();
                failed.map_or(Ok(()), |kind| Err((*kind).into()))
            }
        }
    }

    /// Writes a status, of which another follows soon, unless many messages wait.
    ///
    /// # Errors
    ///
    /// As [`send`](Self::send).
    pub fn status(&mut self, message: String) -> io::Result<()> {
        let is_full = matches!(self, Sink::Queued(q) if q.waiting() >= ROOM_FOR_STATUS);
        if is_full { Ok(()) } else { self.send(message) }
    }

    /// How many messages were dropped, once there is room to report it.
    pub fn take_dropped(&mut self) -> Option<u64> {
        match self {
            Sink::Queued(queue) if queue.dropped > 0 && queue.waiting() < ROOM / 2 => {
                Some(std::mem::take(&mut queue.dropped))
            }
            _ => None,
        }
    }

    /// Waits until all is written, as long as somebody reads.
    pub fn drain(&mut self) {
        let Sink::Queued(queue) = self else { return };
        let mut last = (Instant::now(), queue.waiting());
        while queue.waiting() > 0 && !queue.is_given_up {
            std::thread::sleep(Duration::from_millis(2));
            if queue.waiting() != last.1 {
                last = (Instant::now(), queue.waiting());
            } else {
                queue.is_given_up = last.0.elapsed() >= PATIENCE;
            }
        }
    }
}

impl Drop for Sink {
    fn drop(&mut self) {
        self.drain();
    }
}

fn write(
    mut to: impl Write,
    messages: &Receiver<String>,
    waiting: &AtomicUsize,
    failed: &OnceLock<io::ErrorKind>,
) {
    for message in messages {
        // A reader who has gone needs no message.
        if let Err(error) = to.write_all(message.as_bytes()).and_then(|()| to.flush()) {
            failed.get_or_init(|| error.kind());
        }
        waiting.fetch_sub(1, Ordering::SeqCst);
    }
}
