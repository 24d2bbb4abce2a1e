//! A serial port, read in a thread of its own, so that a slow disk or terminal does not delay it.

use std::io::{self, Read as _, Write as _};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

use gravical::Result;
use serialport::SerialPort;

use super::trouble;

/// Longest wait of one read. After a silence of this time the thread sends no bytes, by which it notices
/// that nobody wants more, and ends.
const READ: Duration = Duration::from_millis(10);
/// What waits at the end is taken in this time, in which few bytes arrive.
const REST: Duration = Duration::from_millis(20);

/// An open port.
pub struct Serial {
    port: Box<dyn SerialPort>,
    incoming: Receiver<io::Result<Vec<u8>>>,
}

impl Serial {
    /// Opens `path`; most boards reset on that.
    ///
    /// # Errors
    ///
    /// `no-such-port`, `port-permission`, `port-busy`, `port-failed` (device).
    pub fn open(path: &str, baud: u32) -> Result<Self> {
        let trouble = |e| trouble::opening(path, &e);
        let builder = serialport::new(path, baud).timeout(READ).dtr_on_open(true);
        let port = builder.clone().open().or_else(|_| {
            // Its reader before may have it for one more read.
            std::thread::sleep(2 * READ);
            builder.open()
        });
        let port = port.map_err(trouble)?;
        let reading = port.try_clone().map_err(trouble)?;
        let (sender, incoming) = channel();
        std::thread::spawn(move || read(reading, &sender));
        Ok(Serial { port, incoming })
    }

    /// The next bytes, in order; none within `timeout`.
    ///
    /// # Errors
    ///
    /// The system's error: the port is lost.
    pub fn next(&mut self, timeout: Duration) -> io::Result<Vec<u8>> {
        match self.incoming.recv_timeout(timeout) {
            Ok(read) => read,
            Err(RecvTimeoutError::Timeout) => Ok(Vec::new()),
            Err(RecvTimeoutError::Disconnected) => Err(closed()),
        }
    }

    /// Sends bytes to the board. It does not wait until they are there: a port that is stuck takes forever.
    ///
    /// # Errors
    ///
    /// The system's error.
    pub fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.port.write_all(bytes)
    }

    /// Closes the port; returns the bytes that have arrived. It ends even if bytes keep arriving.
    pub fn rest(self) -> Vec<u8> {
        let start = Instant::now();
        let reads = self.incoming.try_iter().map_while(|read| read.ok());
        let reads = reads.take_while(|_| start.elapsed() < REST);
        reads.flatten().collect()
    }
}

fn read(mut port: Box<dyn SerialPort>, to: &Sender<io::Result<Vec<u8>>>) {
    use io::ErrorKind::{Interrupted, TimedOut, WouldBlock};
    let mut bytes = [0; 4096];
    loop {
        let read = match port.read(&mut bytes) {
            // The other end of a pseudo-terminal is closed.
            Ok(0) => Err(closed()),
            Ok(n) => Ok(bytes.iter().take(n).copied().collect()),
            Err(e) if matches!(e.kind(), TimedOut | Interrupted | WouldBlock) => Ok(Vec::new()),
            Err(e) => Err(e),
        };
        let is_lost = read.is_err();
        if to.send(read).is_err() || is_lost {
            return;
        }
    }
}

fn closed() -> io::Error {
    io::Error::new(io::ErrorKind::UnexpectedEof, "the port is closed")
}
