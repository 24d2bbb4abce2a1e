//! Recordings from samples in memory.

use crate::{Error, Result};

use super::collect::{About, Collected, Columns, Sink};
use super::head::determine_facts;
use super::layout::Layout;
use super::monitor::RecordingClaims;
use super::names::Quantity;
use super::row::{ACCEL, GYRO, TEMPERATURE, TIME, Values};
use super::rows::{Item, Rows, Source};
use super::{ReadOptions, Recording};

/// Samples of one sensor as columns of equal length; missing values are NaN.
///
/// Units are given in [`ReadOptions`], or determined as for a file.
#[derive(Debug, Clone, Copy, Default)]
pub struct SampleColumns<'a> {
    /// Time stamps.
    pub time: Option<&'a [f64]>,
    /// Specific force along x, y, z.
    pub accel: [&'a [f64]; 3],
    /// Angular rate about x, y, z.
    pub gyro: Option<[&'a [f64]; 3]>,
    /// Temperature of the sensor, °C.
    pub temperature_c: Option<&'a [f64]>,
}

impl SampleColumns<'_> {
    fn len(&self) -> usize {
        self.accel[0].len()
    }

    fn even(&self) -> bool {
        let all = self.accel.iter().chain(self.gyro.iter().flatten());
        let others = self.time.iter().chain(self.temperature_c.iter());
        all.chain(others).all(|column| column.len() == self.len())
    }

    fn layout(&self) -> Layout {
        let accel = (0..3).map(Quantity::Accel);
        let gyro = (0..3).map(Quantity::Gyro).filter(|_| self.gyro.is_some());
        let time = self.time.map(|_| Quantity::Time);
        let temperature = self.temperature_c.map(|_| Quantity::Temperature);
        let all = time.into_iter().chain(accel).chain(gyro);
        Layout {
            fields: all
                .chain(temperature)
                .enumerate()
                .map(|(field, quantity)| (quantity, field))
                .collect(),
            ..Layout::default()
        }
    }
}

impl Recording {
    /// Creates a recording from samples in memory; `name` is used in messages. Clock, units,
    /// empty cells and faults are evaluated as for a file; a "line" is a sample, from 1.
    ///
    /// # Errors
    ///
    /// `samples-length` (usage) for columns of different lengths; `no-rows`, `no-values`,
    /// `all-zero` as [`read`](super::read).
    ///
    /// # Example
    ///
    /// ```
    /// use gravical::recording::{ReadOptions, Recording, SampleColumns};
    ///
    /// let time: Vec<f64> = (0..100).map(|i| 0.01 * f64::from(i)).collect();
    /// let (x, z) = ([0.1; 100], [9.8; 100]);
    /// let samples = SampleColumns {
    ///     time: Some(&time),
    ///     accel: [&x, &x, &z],
    ///     ..SampleColumns::default()
    /// };
    /// let recording = Recording::from_samples("desk", &samples, &ReadOptions::default())?;
    /// assert_eq!(recording.accel_scale.unit.name(), "m/s^2");
    /// # Ok::<(), gravical::Error>(())
    /// ```
    pub fn from_samples(
        name: &str,
        samples: &SampleColumns<'_>,
        options: &ReadOptions,
    ) -> Result<Self> {
        options.validate()?;
        if !samples.even() {
            return Err(Error::usage(
                "samples-length",
                "the columns of samples have different lengths",
            )
            .at(name.as_ref(), None)
            .with_hint("give one value of each for every sample, NaN where there is none"));
        }
        let claims = RecordingClaims {
            layout: samples.layout(),
            options: options.clone(),
            metadata_rate_hz: None,
        };
        // Facts are determined from all samples.
        let rows = |facts| Rows::new(ColumnRows { samples, next: 0 }, name, claims.clone(), facts);
        let facts = determine_facts(rows);
        let mut rows = rows(facts);
        let mut columns = Columns::new(&samples.layout(), &facts);
        columns.collect(&mut rows)?;
        let finished = rows.finish()?;
        let about = About {
            name: name.to_owned(),
            description: "samples in memory".to_owned(),
            ..About::default()
        };
        let read = Collected {
            rows: columns,
            about,
            finished,
            facts,
            zeros_from: None,
        };
        Ok(read.into_recording())
    }
}

/// Source of rows.
struct ColumnRows<'a> {
    samples: &'a SampleColumns<'a>,
    next: usize,
}

impl Source for ColumnRows<'_> {
    fn next(&mut self, values: &mut Values) -> Result<Option<Item>> {
        let row = self.next;
        if row >= self.samples.len() {
            return Ok(None);
        }
        let samples = self.samples;
        let one = |column: Option<&[f64]>| column.map_or(f64::NAN, |c| c[row]);
        values[TIME] = one(samples.time);
        for i in 0..3 {
            values[ACCEL + i] = samples.accel[i][row];
            values[GYRO + i] = one(samples.gyro.map(|g| g[i]));
        }
        values[TEMPERATURE] = one(samples.temperature_c);
        self.next += 1;
        Ok(Some(Item::Row))
    }

    fn number(&self) -> u64 {
        self.next as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{FindingKind, read_bytes};

    #[test]
    fn samples_and_their_text_give_equal_recordings() {
        let wave = |i: u32, k: f64| (f64::from(i) * k).sin();
        let rows: Vec<[f64; 8]> = (0..4000)
            .map(|i| {
                let value = |k| (1e4 * (0.02 * wave(i, k))).round() / 1e4;
                let t = 10.0 * f64::from(i) + if i > 2000 { 700.0 } else { 0.0 };
                let mut row = [
                    t,
                    value(0.7),
                    value(1.3),
                    9.8 + value(2.1),
                    0.0,
                    0.0,
                    0.0,
                    25.0,
                ];
                (4..7).for_each(|k| row[k] = value(0.9 * k as f64));
                if i % 1000 == 17 {
                    row[1..7].fill(0.0);
                }
                row
            })
            .collect();
        let mut text = "t_ms,ax,ay,az,gx (rad/s),gy (rad/s),gz (rad/s),temp (C)\n".to_owned();
        for row in &rows {
            let cells: Vec<String> = row.iter().map(ToString::to_string).collect();
            text += &(cells.join(",") + "\n");
        }
        let column = |k: usize| rows.iter().map(|row| row[k]).collect::<Vec<f64>>();
        let columns: Vec<Vec<f64>> = (0..8).map(column).collect();
        let samples = SampleColumns {
            time: Some(&columns[0]),
            accel: [&columns[1], &columns[2], &columns[3]],
            gyro: Some([&columns[4], &columns[5], &columns[6]]),
            temperature_c: Some(&columns[7]),
        };
        let options = ReadOptions {
            time_unit: Some(super::super::TimeUnit::Millisecond),
            ..ReadOptions::default()
        };
        let own = Recording::from_samples("memory", &samples, &options).unwrap();
        let read = read_bytes(text.as_bytes(), "memory", &options).unwrap();
        assert_eq!((own.rows(), &own.timing), (read.rows(), &read.timing));
        assert_eq!(own.time_s, read.time_s);
        assert_eq!(own.resolution, read.resolution);
        assert_eq!(own.accel_scale.unit, read.accel_scale.unit);
        assert!(own.accel[0][17].is_nan() && read.accel[0][17].is_nan());
        let kinds = |r: &Recording| r.findings.iter().map(|f| f.kind).collect::<Vec<_>>();
        assert_eq!(kinds(&own), kinds(&read));
        assert!(kinds(&own).contains(&FindingKind::ZeroRows));
        // A sample counts as a line: there is no header.
        assert_eq!(own.line(10) + 1, read.line(10));

        let short = SampleColumns {
            time: Some(&columns[0][1..]),
            ..samples
        };
        let error = Recording::from_samples("memory", &short, &options).unwrap_err();
        assert_eq!(error.code(), "samples-length");
        let none = SampleColumns::default();
        let error = Recording::from_samples("memory", &none, &options).unwrap_err();
        assert_eq!(error.code(), "no-rows");
    }
}
