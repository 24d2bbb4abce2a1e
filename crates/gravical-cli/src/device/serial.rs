//! A serial port, read in a thread of its own, so that a slow disk or terminal does not
//! delay it.

use std::io::{self, Read as _, Write as _};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use gravical::Result;
use serialport::SerialPort;

use super::trouble;

/// Longest wait of one read, and so the longest delay of the thread's end.
const READ: Duration = Duration::from_millis(50);

/// Result of a wait.
#[derive(Debug)]
pub enum Incoming {
    /// Bytes, in order.
    Bytes(Vec<u8>),
    /// Nothing yet.
    Nothing,
    /// The port is lost; the system's message.
    Lost(String),
}

/// An open port.
pub struct Serial {
    port: Box<dyn SerialPort>,
    incoming: Receiver<io::Result<Vec<u8>>>,
    reader: Option<JoinHandle<()>>,
    stop: Arc<AtomicBool>,
    /// An error that occurred after bytes that are returned first.
    failed: Option<io::Error>,
}

impl Serial {
    /// Opens `path`; most boards reset on that.
    ///
    /// # Errors
    ///
    /// `no-such-port`, `port-permission`, `port-busy`, `port-failed` (device).
    pub fn open(path: &str, baud: u32) -> Result<Self> {
        let trouble = |e| trouble::opening(path, &e);
        let port = serialport::new(path, baud)
            .timeout(READ)
            .dtr_on_open(true)
            .open()
            .map_err(trouble)?;
        let mut reading = port.try_clone().map_err(trouble)?;
        let (sender, incoming) = channel();
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let reader = std::thread::spawn(move || {
            let mut bytes = [0; 4096];
            loop {
                // Bytes that arrived before the request to stop are still read.
                let stop = stopped.load(Ordering::Relaxed);
                let read = match reading.read(&mut bytes) {
                    // The other end of a pseudo-terminal is closed.
                    Ok(0) => Err(io::Error::new(
                        io::ErrorKind::UnexpectedEof,
                        "the port is closed",
                    )),
                    Ok(n) => Ok(bytes.iter().take(n).copied().collect()),
                    Err(e) if is_no_data(&e) => {
                        if stop {
                            break;
                        }
                        continue;
                    }
                    Err(e) => Err(e),
                };
                let last = stop || read.is_err();
                if sender.send(read).is_err() || last {
                    break;
                }
            }
        });
        Ok(Serial {
            port,
            incoming,
            reader: Some(reader),
            stop,
            failed: None,
        })
    }

    /// Waits at most `timeout` for bytes.
    pub fn next(&mut self, timeout: Duration) -> Incoming {
        if let Some(e) = self.failed.take() {
            return Incoming::Lost(e.to_string());
        }
        match self.incoming.recv_timeout(timeout) {
            Ok(Ok(bytes)) => Incoming::Bytes(bytes),
            Ok(Err(e)) => Incoming::Lost(e.to_string()),
            Err(RecvTimeoutError::Timeout) => Incoming::Nothing,
            Err(RecvTimeoutError::Disconnected) => Incoming::Lost("the port is closed".to_owned()),
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

    /// Stops reading; returns the bytes that have arrived. It ends even if bytes keep
    /// arriving.
    pub fn rest(&mut self) -> Vec<u8> {
        self.join();
        let (bytes, _) = self.received();
        bytes
    }

    fn join(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(reader) = self.reader.take() {
            // A panic there has been reported already.
            let _ = reader.join();
        }
    }

    /// The bytes in the channel, and the error after them.
    fn received(&self) -> (Vec<u8>, Option<io::Error>) {
        let mut bytes = Vec::new();
        while let Ok(read) = self.incoming.try_recv() {
            match read {
                Ok(read) => bytes.extend(read),
                Err(e) => return (bytes, Some(e)),
            }
        }
        (bytes, None)
    }
}

fn is_no_data(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        io::ErrorKind::TimedOut | io::ErrorKind::Interrupted | io::ErrorKind::WouldBlock
    )
}

impl Drop for Serial {
    fn drop(&mut self) {
        self.join();
    }
}
