//! How much of the machine's memory a recording may take.

use sysinfo::{MemoryRefreshKind, RefreshKind, System};

use crate::error::{Error, Result, cut_hint};
use crate::options::ReadOptions;
use crate::text::Format;

/// Share of the memory of the machine that a program may take for recordings: others run beside it.
const SHARE: u64 = 2;
/// Memory of a machine that does not tell it, and the most that pointers of 32 bits reach.
const DEFAULT_BYTES: u64 = 1 << 31;
/// Bytes of a row beside its columns: its line, time, and six channels and the time of a sample in SI units.
const ROW_BYTES: u64 = 4 + 8 + 7 * 8;

/// Memory that a recording may take: its columns and samples together.
pub(crate) struct Budget {
    bytes: u64,
}

impl Budget {
    /// Half of the memory of the machine, unless the options say less.
    pub(crate) fn new(options: &ReadOptions) -> Self {
        Budget {
            bytes: options.max_bytes.unwrap_or_else(max_bytes),
        }
    }

    /// Refuses more rows than fit.
    ///
    /// # Errors
    ///
    /// `too-large`.
    pub(crate) fn check_rows(&self, format: &Format, rows: usize) -> Result<()> {
        let max_rows = self.bytes / row_bytes(format);
        if rows as u64 <= max_rows {
            return Ok(());
        }
        Err(self.too_large(format, max_rows as usize))
    }

    fn too_large(&self, format: &Format, line: usize) -> Error {
        let text = format!(
            "the recording takes more than {:.1} GiB of memory, the share of this machine that it may take; {line} lines fit",
            self.bytes as f64 / (1_u64 << 30) as f64
        );
        Error::input("too-large", text).with_hint(cut_hint(format.head_lines, line))
    }
}

/// Bytes that a row takes in memory.
fn row_bytes(format: &Format) -> u64 {
    ROW_BYTES + 8 * format.is_read.iter().filter(|is_read| **is_read).count() as u64
}

/// Bytes of memory that recordings may take together.
#[doc(hidden)]
pub fn max_bytes() -> u64 {
    let memory = RefreshKind::nothing().with_memory(MemoryRefreshKind::nothing().with_ram());
    let system = System::new_with_specifics(memory);
    let of_group = system.cgroup_limits().map(|limits| limits.total_memory);
    let total = [Some(system.total_memory()), of_group];
    let total = total.into_iter().flatten().filter(|bytes| *bytes > 0).min();
    let total = total.unwrap_or(DEFAULT_BYTES);
    let reachable = if cfg!(target_pointer_width = "32") {
        DEFAULT_BYTES
    } else {
        u64::MAX
    };
    total.min(reachable) / SHARE
}
