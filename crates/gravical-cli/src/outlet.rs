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
    Queued(Outlet),
}

impl Sink {
    /// Writes a message.
    ///
    /// # Errors
    ///
    /// The system's; of a queue those of messages before.
    pub fn send(&mut self, message: String) -> io::Result<()> {
        match self {
            Sink::Waiting(to) => to.write_all(message.as_bytes()).and_then(|()| to.flush()),
            Sink::Queued(outlet) => {
                outlet.send(message.into_bytes());
                outlet.failure()
            }
        }
    }

    /// Writes a status, of which another follows soon.
    ///
    /// # Errors
    ///
    /// As [`send`](Self::send).
    pub fn status(&mut self, message: String) -> io::Result<()> {
        match self {
            Sink::Waiting(_) => self.send(message),
            Sink::Queued(outlet) => {
                outlet.status(message.into_bytes());
                outlet.failure()
            }
        }
    }

    /// Waits until all is written, as long as somebody reads.
    pub fn drain(&mut self) {
        if let Sink::Queued(outlet) = self {
            outlet.drain();
        }
    }
}

impl Drop for Sink {
    fn drop(&mut self) {
        self.drain();
    }
}

/// A queue of messages, and the thread that writes them.
pub struct Outlet {
    queue: SyncSender<Vec<u8>>,
    /// Messages that are not written yet.
    waiting: Arc<AtomicUsize>,
    /// Why a message could not be written.
    failed: Arc<OnceLock<io::ErrorKind>>,
    dropped: u64,
    /// Nobody reads: the end is not waited for any more.
    is_given_up: bool,
}

impl Outlet {
    /// Writes to `to` in a thread of its own, which is not waited for.
    pub fn new(to: impl Write + Send + 'static) -> Self {
        let (queue, messages) = sync_channel(ROOM);
        let waiting = Arc::new(AtomicUsize::new(0));
        let failed = Arc::new(OnceLock::new());
        let (count, failure) = (Arc::clone(&waiting), Arc::clone(&failed));
        std::thread::spawn(move || write(to, &messages, &count, &failure));
        Outlet {
            queue,
            waiting,
            failed,
            dropped: 0,
            is_given_up: false,
        }
    }

    fn failure(&self) -> io::Result<()> {
        self.failed.get().map_or(Ok(()), |kind| Err((*kind).into()))
    }

    fn waiting(&self) -> usize {
        self.waiting.load(Ordering::SeqCst)
    }

    /// Sends a message if there is room; otherwise it is dropped, and counted.
    pub fn send(&mut self, message: Vec<u8>) {
        self.waiting.fetch_add(1, Ordering::SeqCst);
        if self.queue.try_send(message).is_err() {
            self.waiting.fetch_sub(1, Ordering::SeqCst);
            self.dropped += 1;
        }
    }

    /// Sends a status unless many messages wait.
    pub fn status(&mut self, message: Vec<u8>) {
        if self.waiting() < ROOM_FOR_STATUS {
            self.send(message);
        }
    }

    /// How many messages were dropped, once there is room to report it.
    pub fn take_dropped(&mut self) -> Option<u64> {
        let room = self.waiting() < ROOM / 2;
        (self.dropped > 0 && room).then(|| std::mem::take(&mut self.dropped))
    }

    /// Waits until all is written, as long as somebody reads.
    pub fn drain(&mut self) {
        let mut last = (Instant::now(), self.waiting());
        while self.waiting() > 0 && !self.is_given_up {
            std::thread::sleep(Duration::from_millis(2));
            if self.waiting() != last.1 {
                last = (Instant::now(), self.waiting());
            } else {
                self.is_given_up = last.0.elapsed() >= PATIENCE;
            }
        }
    }
}

fn write(
    mut to: impl Write,
    messages: &Receiver<Vec<u8>>,
    waiting: &AtomicUsize,
    failed: &OnceLock<io::ErrorKind>,
) {
    for message in messages {
        // A reader who has gone needs no message.
        if let Err(error) = to.write_all(&message).and_then(|()| to.flush()) {
            failed.get_or_init(|| error.kind());
        }
        waiting.fetch_sub(1, Ordering::SeqCst);
    }
}
