//! Standard output, standard error or a file behind a bounded queue: a reader who stops reading stops
//! neither what happens in real time nor its end; and messages on standard error over a status line.

use std::io::{self, IsTerminal as _, Write};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

/// Messages that wait at most.
const ROOM: usize = 1000;
/// A status, which is repeated every second, is dropped when this many wait.
const ROOM_FOR_STATUS: usize = 50;
/// At the end a reader who reads nothing for this time is not waited for.
const PATIENCE: Duration = Duration::from_secs(2);

/// How far the thread that writes is.
#[derive(Default)]
struct Progress {
    /// Messages that are not written yet.
    waiting: AtomicUsize,
    /// Why a message could not be written.
    failed: OnceLock<io::ErrorKind>,
}

/// A queue of messages, and the thread that writes them.
pub struct Outlet {
    queue: SyncSender<String>,
    progress: Arc<Progress>,
    dropped: u64,
    /// The reader sets the pace: nothing is dropped.
    waits: bool,
    /// Nobody reads: the end is not waited for any more.
    is_given_up: bool,
}

impl Outlet {
    /// Writes to `to` in a thread of its own, which is not waited for in `real_time`.
    pub fn new(mut to: impl Write + Send + 'static, real_time: bool) -> Self {
        let (queue, messages) = sync_channel::<String>(ROOM);
        let progress = Arc::<Progress>::default();
        let written = Arc::clone(&progress);
        std::thread::spawn(move || {
            for message in messages {
                // A reader who has gone needs no message.
                if let Err(error) = to.write_all(message.as_bytes()).and_then(|()| to.flush()) {
                    written.failed.get_or_init(|| error.kind());
                }
                written.waiting.fetch_sub(1, Ordering::SeqCst);
            }
        });
        Outlet {
            queue,
            progress,
            dropped: 0,
            waits: !real_time,
            is_given_up: false,
        }
    }

    fn waiting(&self) -> usize {
        self.progress.waiting.load(Ordering::SeqCst)
    }

    /// Sends a message. Where it may not wait for room the message is dropped, and counted.
    ///
    /// # Errors
    ///
    /// The system's for a message before.
    pub fn send(&mut self, message: String) -> io::Result<()> {
        let waiting = &self.progress.waiting;
        waiting.fetch_add(1, Ordering::SeqCst);
        let is_sent = if self.waits {
            self.queue.send(message).is_ok()
        } else {
            self.queue.try_send(message).is_ok()
        };
        if !is_sent {
            waiting.fetch_sub(1, Ordering::SeqCst);
            self.dropped += 1;
        }
        self.failure()
    }

    fn failure(&self) -> io::Result<()> {
        let failed = self.progress.failed.get();
        failed.map_or(Ok(()), |kind| Err((*kind).into()))
    }

    /// Sends a status, of which another follows soon, unless many messages wait.
    ///
    /// # Errors
    ///
    /// As [`send`](Self::send).
    pub fn status(&mut self, message: String) -> io::Result<()> {
        if self.waits || self.waiting() < ROOM_FOR_STATUS {
            self.send(message)
        } else {
            Ok(())
        }
    }

    /// How many messages were dropped, once there is room to report it.
    pub fn take_dropped(&mut self) -> Option<u64> {
        let room = self.waiting() < ROOM / 2;
        (self.dropped > 0 && room).then(|| std::mem::take(&mut self.dropped))
    }

    /// Waits until all is written, as long as somebody reads.
    ///
    /// # Errors
    ///
    /// The system's.
    pub fn drain(&mut self) -> io::Result<()> {
        let mut last = (Instant::now(), self.waiting());
        while self.waiting() > 0 && !self.is_given_up {
            std::thread::sleep(Duration::from_millis(2));
            if self.waiting() != last.1 {
                last = (Instant::now(), self.waiting());
            } else {
                self.is_given_up = !self.waits && last.0.elapsed() >= PATIENCE;
            }
        }
        self.failure()
    }
}

impl Drop for Outlet {
    fn drop(&mut self) {
        let _ = self.drain();
    }
}

/// Standard error. A terminal that has gone stops nothing.
pub struct Screen {
    out: Outlet,
    is_terminal: bool,
    /// The cursor is in a status line.
    in_status: bool,
    /// The terminal is raw: a line ends with carriage return and line feed.
    pub is_raw: bool,
}

impl Screen {
    /// In `real_time` nothing waits for it.
    pub fn new(real_time: bool) -> Self {
        Screen {
            out: Outlet::new(io::stderr(), real_time),
            is_terminal: io::stderr().is_terminal(),
            in_status: false,
            is_raw: false,
        }
    }

    /// The end of a line.
    pub fn end(&self) -> &'static str {
        if self.is_raw { "\r\n" } else { "\n" }
    }

    /// One line or more, in place of the status.
    pub fn line(&mut self, text: &str) {
        let end = self.end();
        let clear = if self.in_status { "\r\x1b[K" } else { "" };
        self.in_status = false;
        let text = text.trim_end().replace('\n', end);
        let _ = self.out.send(format!("{clear}{text}{end}"));
    }

    /// The status; false without a terminal.
    pub fn status(&mut self, line: &str) -> bool {
        if self.is_terminal {
            let _ = self.out.status(format!("\r{line}\x1b[K"));
            self.in_status = true;
        }
        self.is_terminal
    }

    /// Ends the status line.
    pub fn close(&mut self) {
        if std::mem::take(&mut self.in_status) {
            let _ = self.out.send(self.end().to_owned());
        }
        self.is_raw = false;
    }
}
