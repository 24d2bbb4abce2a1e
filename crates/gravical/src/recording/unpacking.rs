//! Packed bytes, unpacked with a limit.

use std::cell::Cell;
use std::io::{self, Read};
use std::rc::Rc;

/// Largest accepted compression ratio: text of a recording shrinks to a tenth, that of a dead
/// sensor to a hundredth. Beyond the first [`UNPACKED_FREELY`] bytes a larger ratio is refused as
/// an attempt to fill the memory.
pub(super) const MOST_UNPACKED: u64 = 200;
pub(super) const UNPACKED_FREELY: u64 = 16 << 20;

/// Unpacks, with a limit on the ratio.
pub(super) struct Unpacking<D> {
    decoder: D,
    packed: Rc<Cell<u64>>,
    unpacked: u64,
}

impl<D> Unpacking<D> {
    /// With the `decoder` of the bytes `packed`.
    pub fn new(packed: Box<dyn Read>, decoder: impl FnOnce(Counting) -> D) -> Self {
        let bytes = Rc::new(Cell::new(0));
        let counting = Counting {
            inner: packed,
            bytes: Rc::clone(&bytes),
        };
        Unpacking {
            decoder: decoder(counting),
            packed: bytes,
            unpacked: 0,
        }
    }
}

impl<D: Read> Read for Unpacking<D> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = self.decoder.read(buffer)?;
        self.unpacked += n as u64;
        let packed = self.packed.get();
        if self.unpacked > UNPACKED_FREELY.max(MOST_UNPACKED.saturating_mul(packed)) {
            return Err(io::Error::new(
                io::ErrorKind::InvalidData,
                format!(
                    "it unpacks to more than {MOST_UNPACKED} times its size; no recording does"
                ),
            ));
        }
        Ok(n)
    }
}

/// Counts bytes.
pub(super) struct Counting {
    inner: Box<dyn Read>,
    bytes: Rc<Cell<u64>>,
}

impl Read for Counting {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = self.inner.read(buffer)?;
        self.bytes.set(self.bytes.get() + n as u64);
        Ok(n)
    }
}
