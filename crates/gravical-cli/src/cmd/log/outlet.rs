//! Standard output or standard error behind a bounded queue: who does not read stops
//! neither the recording nor its end.

use std::io::{self, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::{Duration, Instant};

/// Messages that wait at most.
const ROOM: usize = 1000;
/// What will be said anew in a second is left out when so many wait.
const ROOM_FOR_STATUS: usize = 50;
/// At the end nobody is waited for who reads nothing for so long.
const PATIENCE: Duration = Duration::from_secs(2);

/// Where messages go.
pub struct Outlet {
    queue: SyncSender<Vec<u8>>,
    sent: usize,
    written: Arc<AtomicUsize>,
    left_out: u64,
    /// So many were written when waiting for a reader was given up.
    given_up_at: Option<usize>,
}

impl Outlet {
    /// Writes to `to`, in a thread of its own, which nobody waits for.
    pub fn new(to: impl Write + Send + 'static) -> Self {
        let (queue, messages) = sync_channel(ROOM);
        let written = Arc::new(AtomicUsize::new(0));
        let count = Arc::clone(&written);
        std::thread::spawn(move || write(to, &messages, &count));
        Outlet {
            queue,
            sent: 0,
            written,
            left_out: 0,
            given_up_at: None,
        }
    }

    fn written(&self) -> usize {
        self.written.load(Ordering::SeqCst)
    }

    fn waiting(&self) -> usize {
        self.sent.saturating_sub(self.written())
    }

    /// Says it when there is room; else it is left out, and counted.
    pub fn say(&mut self, message: Vec<u8>) {
        match self.queue.try_send(message) {
            Ok(()) => self.sent += 1,
            Err(_) => self.left_out += 1,
        }
    }

    /// Says it unless much waits already.
    pub fn status(&mut self, message: Vec<u8>) {
        if self.waiting() < ROOM_FOR_STATUS {
            self.say(message);
        }
    }

    /// How many messages were left out, once there is room to say so.
    pub fn take_left_out(&mut self) -> Option<u64> {
        let room = self.waiting() < ROOM / 2;
        (self.left_out > 0 && room).then(|| std::mem::take(&mut self.left_out))
    }

    /// Waits until all is written, as long as somebody reads.
    pub fn drain(&mut self) {
        let mut last = (Instant::now(), self.written());
        while self.waiting() > 0 && self.given_up_at != Some(self.written()) {
            std::thread::sleep(Duration::from_millis(2));
            if self.written() != last.1 {
                last = (Instant::now(), self.written());
            } else if last.0.elapsed() >= PATIENCE {
                self.given_up_at = Some(last.1);
            }
        }
    }
}

fn write(mut to: impl Write, messages: &Receiver<Vec<u8>>, written: &AtomicUsize) {
    for message in messages {
        // Whoever does not listen any more has no need of it.
        let _: io::Result<()> = to.write_all(&message).and_then(|()| to.flush());
        written.fetch_add(1, Ordering::SeqCst);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::{Sender, channel};

    /// A reader who waits for leave.
    struct Slow(Receiver<()>, Sender<Vec<u8>>);

    impl Write for Slow {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.recv().map_err(io::Error::other)?;
            self.1.send(bytes.to_vec()).map_err(io::Error::other)?;
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn status_goes_first_and_the_rest_is_counted() {
        let (leave, wait) = channel();
        let (read, seen) = channel();
        let mut outlet = Outlet::new(Slow(wait, read));
        for _ in 0..200 {
            outlet.status(b"status".to_vec());
        }
        assert_eq!(outlet.waiting(), ROOM_FOR_STATUS);
        for _ in 0..ROOM {
            outlet.say(b"event".to_vec());
        }
        assert!((49..=50).contains(&outlet.left_out), "{}", outlet.left_out);
        assert_eq!(outlet.take_left_out(), None);
        // Nobody reads: it ends all the same.
        outlet.drain();
        for _ in 0..ROOM + 1 {
            let _ = leave.send(());
        }
        drop(leave);
        while outlet.waiting() > 0 {
            std::thread::sleep(Duration::from_millis(1));
        }
        assert!(outlet.take_left_out().is_some());
        let seen: Vec<_> = seen.try_iter().collect();
        assert_eq!(seen.iter().filter(|m| *m == b"status").count(), 50);
        outlet.say(b"nobody".to_vec());
        outlet.drain();
    }
}
