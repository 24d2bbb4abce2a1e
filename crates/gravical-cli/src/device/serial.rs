//! A serial port, read in a thread of its own, so that a slow disk or terminal does not delay it.

use std::io::{self, Read as _, Write as _};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use gravical::Result;
use serialport::SerialPort;

use super::trouble;

/// Longest wait of one read, and so the longest delay of the thread's end.
const READ: Duration = Duration::from_millis(50);

/// An open port.
pub struct Serial {
    port: Box<dyn SerialPort>,
    incoming: Receiver<io::Result<Vec<u8>>>,
    reader: Option<JoinHandle<()>>,
    stop: Arc<AtomicBool>,
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
        let port = builder.open().map_err(trouble)?;
        let reading = port.try_clone().map_err(trouble)?;
        let (sender, incoming) = channel();
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let reader = std::thread::spawn(move || read(reading, &sender, &stopped));
        Ok(Serial {
            port,
            incoming,
            reader: Some(reader),
            stop,
        })
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

    /// Sends bytes to the board.
    ///
    /// # Errors
    ///
    /// The system's error.
    pub fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.port.write_all(bytes)?;
        self.port.flush()
    }

    /// Stops reading; returns the bytes that have arrived. It ends even if bytes keep arriving.
    pub fn rest(mut self) -> Vec<u8> {
        self.join();
        let rest = self.incoming.try_iter().map_while(|read| read.ok());
        rest.flatten().collect()
    }

    fn join(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(reader) = self.reader.take() {
            // A panic there has been reported already.
            let _ = reader.join();
        }
    }
}

impl Drop for Serial {
    fn drop(&mut self) {
        self.join();
    }
}

fn read(mut port: Box<dyn SerialPort>, to: &Sender<io::Result<Vec<u8>>>, stop: &AtomicBool) {
    use io::ErrorKind::{Interrupted, TimedOut, WouldBlock};
    let mut bytes = [0; 4096];
    loop {
        // Bytes that arrived before the request to stop are still read.
        let is_last = stop.load(Ordering::Relaxed);
        let read = match port.read(&mut bytes) {
            // The other end of a pseudo-terminal is closed.
            Ok(0) => Err(closed()),
            Ok(n) => Ok(bytes.iter().take(n).copied().collect()),
            Err(e) if matches!(e.kind(), TimedOut | Interrupted | WouldBlock) => Ok(Vec::new()),
            Err(e) => Err(e),
        };
        let is_over = is_last || read.is_err();
        let is_empty = matches!(&read, Ok(bytes) if bytes.is_empty());
        if !is_empty && to.send(read).is_err() || is_over {
            return;
        }
    }
}

fn closed() -> io::Error {
    io::Error::new(io::ErrorKind::UnexpectedEof, "the port is closed")
}
