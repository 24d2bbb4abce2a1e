//! Progress of reading.

use std::io::{self, Read};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

/// Counts the bytes of recordings as they are read. Give a clone to
/// [`ReadOptions`](crate::ReadOptions), and query it from another thread.
///
/// ```
/// use std::io::Read;
///
/// use gravical_judge::Meter;
///
/// let meter = Meter::default();
/// let text = b"t,ax,ay,az\n0.00,0,0,9.8\n0.01,0,0,9.8\n";
/// let mut reader = meter.over("desk.csv", Some(37), Box::new(&text[..]));
/// reader.read_to_end(&mut Vec::new())?;
/// let progress = meter.progress();
/// assert_eq!((progress.read, progress.total), (37, Some(37)));
/// meter.stop();
/// assert!(reader.read(&mut [0]).is_err());
/// # Ok::<(), std::io::Error>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct Meter(Arc<State>);

#[derive(Debug, Default)]
struct State {
    name: Mutex<String>,
    /// Size of the file in bytes; 0 if unknown.
    total: AtomicU64,
    read: AtomicU64,
    stopped: Arc<AtomicBool>,
}

/// Progress of the file that was opened last.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Progress {
    /// Name of the file.
    pub name: String,
    /// Bytes read (packed bytes of a packed file).
    pub read: u64,
    /// Size of the file; `None` for a pipe.
    pub total: Option<u64>,
}

impl Meter {
    /// The current progress.
    pub fn progress(&self) -> Progress {
        let total = self.0.total.load(Ordering::Relaxed);
        Progress {
            name: self.0.name.lock().map(|n| n.clone()).unwrap_or_default(),
            read: self.0.read.load(Ordering::Relaxed),
            total: (total > 0).then_some(total),
        }
    }

    /// Ends reading: what is being read, and what is opened later, fails with `io`; a
    /// motion ends in the same way. For a user who does not
    /// want to wait.
    pub fn stop(&self) {
        self.0.stopped.store(true, Ordering::Relaxed);
    }

    /// True after [`stop`](Self::stop).
    pub fn is_stopped(&self) -> bool {
        self.0.stopped.load(Ordering::Relaxed)
    }

    /// True after [`stop`](Self::stop), for a computation in another crate.
    #[doc(hidden)]
    pub fn flag(&self) -> Arc<AtomicBool> {
        self.0.stopped.clone()
    }

    /// Wraps `reader` and counts its bytes from the beginning.
    pub fn over(
        &self,
        name: &str,
        total: Option<u64>,
        reader: Box<dyn Read + Send>,
    ) -> Box<dyn Read + Send> {
        if let Ok(mut last) = self.0.name.lock() {
            name.clone_into(&mut last);
        }
        self.0.total.store(total.unwrap_or(0), Ordering::Relaxed);
        self.0.read.store(0, Ordering::Relaxed);
        let meter = self.clone();
        tap(reader, move |bytes| {
            let count = bytes.len() as u64;
            meter.0.read.fetch_add(count, Ordering::Relaxed);
            if meter.is_stopped() {
                return Err(io::Error::other("reading was stopped"));
            }
            Ok(())
        })
    }
}

/// Shows the bytes that are read to a function, which may end the reading.
pub fn tap(
    inner: Box<dyn Read + Send>,
    see: impl FnMut(&[u8]) -> io::Result<()> + Send + 'static,
) -> Box<dyn Read + Send> {
    Box::new(Tap { inner, see })
}

struct Tap<F> {
    inner: Box<dyn Read + Send>,
    see: F,
}

impl<F: FnMut(&[u8]) -> io::Result<()>> Read for Tap<F> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = self.inner.read(buffer)?;
        (self.see)(&buffer[..n])?;
        Ok(n)
    }
}
