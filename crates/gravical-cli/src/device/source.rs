//! Where samples come from.

use std::io;
use std::time::Duration;

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

/// A stream of bytes from a board, and a way to talk to it.
pub trait SampleSource {
    /// Waits at most `timeout` for what comes.
    fn next(&mut self, timeout: Duration) -> Incoming;

    /// Sends bytes to the board.
    ///
    /// # Errors
    ///
    /// What the system says.
    fn send(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// Waits until what was sent has left, and sets another rate; gives what came at the
    /// one before.
    ///
    /// # Errors
    ///
    /// What the system says.
    fn set_baud(&mut self, baud: u32) -> io::Result<Vec<u8>>;
}
