//! A long recording of which what matters is in memory ([`crate::excerpt`] reads it).

use super::RowMap;
use crate::still::{StillOptions, Stills, TemperatureBlock};

/// What is known of a recording of which not all rows are in memory.
#[derive(Debug, Clone)]
pub(crate) struct Excerpt {
    /// Which row of the file each row in memory is.
    pub rows: RowMap,
    /// Lowest and highest temperature of all rows, °C.
    pub temperature_c: Option<[f64; 2]>,
    /// Blocks for the drift with temperature, of all rows.
    pub thermal: Vec<TemperatureBlock>,
    /// Rows of stills that had no room.
    pub still_rows_left_out: usize,
    /// The stills by what they were looked for with.
    pub stills: Vec<(StillOptions, Stills)>,
}

impl Excerpt {
    /// The stills of the recording; none where they were not looked for so.
    pub fn stills_by(&self, options: &StillOptions) -> Option<&Stills> {
        let mut all = self.stills.iter();
        all.find(|(own, _)| own == options)
            .map(|(_, stills)| stills)
    }
}
