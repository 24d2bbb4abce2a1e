//! How much of the machine's memory a recording may take.

use gravical_judge::{ReadOptions, Result};
use sysinfo::{MemoryRefreshKind, RefreshKind, System};

use crate::problem::Problem;
use crate::text::Format;

/// Share of the memory of the machine that a program may take for recordings: others run beside it.
const SHARE: u64 = 2;
/// Memory of a machine that does not tell it.
const DEFAULT_BYTES: u64 = 1 << 31;
/// Bytes of a row beside its columns: its line, time, and six channels and the time of a sample in SI units.
const ROW_BYTES: u64 = 4 + 8 + 7 * 8;

/// Memory that a recording may take: its columns and samples together.
pub(crate) struct Budget(u64);

impl Budget {
    /// Half of the memory of the machine, unless the options say less.
    pub(crate) fn new(options: &ReadOptions) -> Self {
        Budget(options.max_bytes.unwrap_or_else(max_bytes))
    }

    /// Refuses more rows than fit.
    ///
    /// # Errors
    ///
    /// `too-large`.
    pub(crate) fn check_rows(&self, format: &Format, rows: usize) -> Result<()> {
        let columns = format.is_read.iter().filter(|is_read| **is_read);
        let max_rows = self.0 / (ROW_BYTES + 8 * columns.count() as u64);
        if rows as u64 <= max_rows {
            return Ok(());
        }
        let (bytes, lines, head) = (self.0, max_rows, format.head_lines);
        Err(Problem::TooLarge { bytes, lines, head }.error())
    }
}

/// Bytes of memory that recordings may take together.
#[doc(hidden)]
pub fn max_bytes() -> u64 {
    let memory = RefreshKind::nothing().with_memory(MemoryRefreshKind::nothing().with_ram());
    let system = System::new_with_specifics(memory);
    let of_group = system.cgroup_limits().map(|limits| limits.total_memory);
    let total = [Some(system.total_memory()), of_group];
    let total = total.into_iter().flatten().filter(|bytes| *bytes > 0).min();
    // No more can be allocated.
    total.unwrap_or(DEFAULT_BYTES).min(isize::MAX as u64) / SHARE
}
