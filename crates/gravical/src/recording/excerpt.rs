//! Properties of a long recording of which only some rows are in memory; read by
//! [`crate::excerpt`].

use super::RowMap;
use crate::stills::TemperatureBlock;

/// Properties of all rows of a recording of which only some are in memory.
#[derive(Debug, Clone)]
pub(crate) struct Excerpt {
    /// Row number in the file of each row in memory.
    pub rows: RowMap,
    /// Lowest and highest temperature of all rows, °C.
    pub temperature_c: Option<[f64; 2]>,
    /// Blocks of all rows for the temperature drift.
    pub thermal: Vec<TemperatureBlock>,
    /// Number of rows at rest for which there was no memory.
    pub still_rows_left_out: usize,
    /// The static intervals, rows in memory; the sensor is worn ([`crate::stills`]).
    pub rests: Vec<std::ops::Range<usize>>,
    pub is_worn: bool,
}
