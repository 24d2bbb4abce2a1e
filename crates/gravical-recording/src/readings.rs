//! Channels of rows, as a recording was judged.

/// Channels of the rows of a batch, as the recording was judged.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Readings {
    /// Specific force in the unit of the file, less the zero offset; NaN in a row that is no
    /// measurement
    pub accel: [Vec<f64>; 3],
    /// Angular rate in the unit of the file; NaN in a row that is no measurement
    pub gyro: Option<[Vec<f64>; 3]>,
    /// Temperature, °C; NaN in a row that is no measurement
    pub temperature_c: Option<Vec<f64>>,
    /// Whether each row is a measurement of the sensor that is read
    pub is_measured: Vec<bool>,
    /// Time since the first row of the recording, s, NaN in a row that is no measurement; `None`
    /// without a clock
    pub time_s: Option<Vec<f64>>,
    /// Measurements before which the recording breaks
    pub breaks: Vec<usize>,
}

impl Readings {
    /// Those of the accelerometer, then those of the gyroscope.
    pub(crate) fn channels(&self) -> Vec<&[f64]> {
        let axes = self.accel.iter().chain(self.gyro.iter().flatten());
        axes.map(Vec::as_slice).collect()
    }

    /// Those in these lines of rows; `own_lines`: those of these readings, all measurements.
    pub(crate) fn in_lines(&self, own_lines: &[u32], lines: &[u32]) -> Readings {
        let first = lines.first().copied().unwrap_or_default();
        let mut next = own_lines.partition_point(|line| *line < first);
        let (mut rows, mut breaks) = (Vec::with_capacity(lines.len()), Vec::new());
        for (row, line) in lines.iter().enumerate() {
            let is_row = own_lines.get(next) == Some(line);
            rows.push(is_row.then_some(next));
            if is_row && self.breaks.binary_search(&next).is_ok() {
                breaks.push(row);
            }
            next += usize::from(is_row);
        }
        let channel = |values: &Vec<f64>| -> Vec<f64> {
            let cells = rows.iter();
            cells
                .map(|row| row.map_or(f64::NAN, |row| values[row]))
                .collect()
        };
        Readings {
            accel: self.accel.each_ref().map(channel),
            gyro: self.gyro.as_ref().map(|g| g.each_ref().map(channel)),
            temperature_c: self.temperature_c.as_ref().map(channel),
            is_measured: rows.iter().map(Option::is_some).collect(),
            time_s: self.time_s.as_ref().map(channel),
            breaks,
        }
    }
}
