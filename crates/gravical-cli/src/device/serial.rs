//! A serial port, read in a thread of its own: whatever the disk or the terminal do,
//! the port is emptied.

use std::io::{self, Read as _, Write as _};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use gravical::Result;
use serialport::SerialPort;

use super::trouble;

/// How long one read waits, and so how late the thread ends at most.
const READ: Duration = Duration::from_millis(50);

/// What is sent may still be in the chip behind the cable, which changes its rate at
/// once: 28 bytes of commands take 2.5 ms at 115200 bits a second. A board that was told
/// to change is silent for 100 ms, while it sets its sensor up.
const LEAVE: Duration = Duration::from_millis(50);

/// What came within the time.
#[derive(Debug)]
pub enum Incoming {
    /// Bytes, in order.
    Bytes(Vec<u8>),
    /// Nothing yet.
    Nothing,
    /// Nothing more will come; what the system says.
    Lost(String),
}

/// An open port.
pub struct Serial {
    port: Box<dyn SerialPort>,
    incoming: Receiver<io::Result<Vec<u8>>>,
    reader: Option<JoinHandle<()>>,
    stop: Arc<AtomicBool>,
    /// It failed behind bytes that had to be given first.
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
                // What came before it is told to stop is still read.
                let stop = stopped.load(Ordering::Relaxed);
                let read = match reading.read(&mut bytes) {
                    // A terminal without its other end has nothing to say at once.
                    Ok(0) => Err(io::Error::new(
                        io::ErrorKind::UnexpectedEof,
                        "the port is gone",
                    )),
                    Ok(n) => Ok(bytes.iter().take(n).copied().collect()),
                    Err(e) if is_patience(&e) => {
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

    /// Waits at most `timeout` for what comes.
    pub fn next(&mut self, timeout: Duration) -> Incoming {
        if let Some(e) = self.failed.take() {
            return Incoming::Lost(e.to_string());
        }
        match self.incoming.recv_timeout(timeout) {
            Ok(Ok(bytes)) => Incoming::Bytes(bytes),
            Ok(Err(e)) => Incoming::Lost(e.to_string()),
            Err(RecvTimeoutError::Timeout) => Incoming::Nothing,
            Err(RecvTimeoutError::Disconnected) => Incoming::Lost("the port is gone".to_owned()),
        }
    }

    /// Sends bytes to the board.
    ///
    /// # Errors
    ///
    /// What the system says.
    pub fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.port.write_all(bytes)?;
        self.port.flush()
    }

    /// Waits until what was sent has left, and sets another rate; gives what came at the
    /// one before.
    ///
    /// # Errors
    ///
    /// What the system says.
    pub fn set_baud(&mut self, baud: u32) -> io::Result<Vec<u8>> {
        self.port.flush()?;
        std::thread::sleep(LEAVE);
        self.port.set_baud_rate(baud)?;
        let (before, failed) = self.taken();
        self.failed = failed;
        Ok(before)
    }

    /// Reads no more; what came until now, and once more what one read gives. It ends
    /// however fast bytes come.
    pub fn rest(&mut self) -> Vec<u8> {
        self.join();
        let (bytes, _) = self.taken();
        bytes
    }

    fn join(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(reader) = self.reader.take() {
            // A panic there has been told already.
            let _ = reader.join();
        }
    }

    /// What waits in the channel, and the error behind it.
    fn taken(&self) -> (Vec<u8>, Option<io::Error>) {
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

fn is_patience(error: &io::Error) -> bool {
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
