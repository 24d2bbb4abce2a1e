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

    /// Channels, temperature and time.
    pub(crate) fn columns(&self) -> Vec<&[f64]> {
        let mut columns = self.channels();
        columns.extend(self.temperature_c.as_deref());
        columns.extend(self.time_s.as_deref());
        columns
    }

    /// As [`columns`](Self::columns).
    pub(crate) fn columns_mut(&mut self) -> Vec<&mut Vec<f64>> {
        let axes = self.accel.iter_mut().chain(self.gyro.iter_mut().flatten());
        axes.chain(&mut self.temperature_c)
            .chain(&mut self.time_s)
            .collect()
    }

    /// The same columns with other values; without rows and breaks.
    pub(crate) fn map(&self, values: impl Fn(&Vec<f64>) -> Vec<f64>) -> Readings {
        Readings {
            accel: self.accel.each_ref().map(&values),
            gyro: self.gyro.as_ref().map(|g| g.each_ref().map(&values)),
            temperature_c: self.temperature_c.as_ref().map(&values),
            time_s: self.time_s.as_ref().map(&values),
            is_measured: Vec::new(),
            breaks: Vec::new(),
        }
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
            is_measured: rows.iter().map(Option::is_some).collect(),
            breaks,
            ..self.map(channel)
        }
    }
}
