//! From the rows of a file to a recording.

pub(crate) mod clean;
pub(crate) mod findings;
mod time;

use crate::error::Error;
use crate::full_scale::Clipping;
use crate::judge::{self, AccelClaim, Encoding};
use crate::metadata;
use crate::recording::{Labels, Recording};
use crate::role::Role;
use crate::text::{Format, Rows};
use crate::units::{AccelScale, AccelUnit, GyroScale, GyroUnit, Origin, Units};

use clean::{CleanRows, column_labels, names};

impl Recording {
    /// Judges the rows of a whole file.
    ///
    /// # Errors
    ///
    /// There are no rows, or the sensor did not answer.
    pub fn judge(format: &Format, rows: Rows) -> Result<Self, Error> {
        let options = &format.options;
        let clean = CleanRows::new(format, rows)?;
        let (rows, time, accel, gyro) = (clean.rows, clean.time, clean.accel, clean.gyro);
        let read_as = clean.read_as;
        let mut findings = clean.findings;
        let is_unsigned = read_as.encoding == Some(Encoding::OffsetBinary);
        let middle = if is_unsigned { 32_768.0 } else { 0.0 };
        let read_gyro = if options.is_gyroscope {
            Some((format.accel, &accel))
        } else {
            format.gyro.zip(gyro.as_ref())
        };
        let mut units = Units {
            accel: AccelScale::UNKNOWN,
            gyro: read_gyro.map(|(c, gyro)| gyro_scale(format, c, gyro)),
            zero_offset: options.zero_offset.unwrap_or(middle),
            resolution: [
                judge::resolution(&accel),
                gyro.as_ref().map_or([0.0; 3], judge::resolution),
            ],
            contradicts_header: false,
            contradicts_given: false,
            is_without_gravity: false,
            has_unknown_temperature: clean.has_unknown_temperature,
        };
        let (axes, claim) = (accel.each_ref().map(Vec::as_slice), accel_claim(format));
        let of_unit = judge::accel_unit(axes, is_unsigned, claim, options, &mut units);
        if !options.is_gyroscope {
            findings.extend(of_unit);
            if options.accel_unit.is_none() {
                judge::refuse_jump(&accel, gyro.as_ref(), &rows.lines, format.head_lines)?;
            }
        }
        let mut recording = Recording {
            name: String::new(),
            sha256: None,
            gyro_file: None,
            labels: find_labels(format, &rows)?,
            format: format.clone(),
            accel,
            gyro,
            temperature_c: clean.temperature_c,
            time_s: Some(time.time_s).filter(|time_s| !time_s.is_empty()),
            lines: rows.lines,
            breaks: clean.breaks,
            ledger: rows.ledger,
            read_as,
            clock: time.clock,
            units,
            findings,
        };
        recording.judge_samples();
        Ok(recording)
    }

    /// Frozen axes, values at the end of the range, repeats, columns of another sensor.
    fn judge_samples(&mut self) {
        let names = names(&self.format);
        let sensors = std::iter::once(&self.accel).chain(&self.gyro);
        let mut findings = Vec::new();
        for ((sensor, names), steps) in sensors.zip(names.chunks(3)).zip(&self.units.resolution) {
            findings.extend(judge::frozen_axes(sensor, names, steps, &self.lines));
        }
        let accel_end = Clipping::of_accel(&self.units.accel);
        let gyro_end = self.units.gyro.as_ref().map(Clipping::of_gyro);
        let ends = std::iter::repeat_n(accel_end, 3).chain(gyro_end.into_iter().cycle());
        let channels = self.accel.iter().chain(self.gyro.iter().flatten());
        for ((channel, name), mut clipping) in channels.clone().zip(names).zip(ends) {
            clipping.observe(channel, &self.lines);
            findings.extend(clipping.finding(name));
        }
        if !self.read_as.is_sparse {
            let channels: Vec<&[f64]> = channels.map(Vec::as_slice).collect();
            let steps = self.units.resolution.as_flattened();
            if let Some(repeated) = judge::repeated_rows(&channels, steps, &self.lines) {
                let readings = judge::count_changes(&channels[..3]);
                self.clock.rows_per_reading = self.rows() as f64 / readings as f64;
                findings.push(repeated);
            }
        }
        if self.format.is_guessed {
            findings.extend(findings::not_an_accelerometer(&self.accel));
        }
        self.findings.append(&mut findings);
    }
}

/// What header and board claim about the accelerometer.
fn accel_claim(format: &Format) -> AccelClaim {
    let column = &format.columns[format.accel[0]];
    let mut claim = AccelClaim {
        unit: AccelUnit::parse(&column.unit),
        lsb_per_g: AccelUnit::per_g(&column.unit),
        without_gravity: column.is_linear,
    };
    let board = format
        .board
        .filter(|b| b.is_counts() && b.accel_range_g > 0);
    if let (Some(board), None) = (board, claim.unit) {
        claim.unit = Some(AccelUnit::Counts);
        claim.lsb_per_g = Some(board.lsb_per_g());
    }
    // For other counts a converter of 16 bits is assumed unless gravity contradicts.
    if claim.unit == Some(AccelUnit::Counts) && claim.lsb_per_g.is_none() {
        claim.lsb_per_g = metadata::range_g(&format.metadata).map(|range| 32_768.0 / range);
    }
    claim
}

/// The unit of the gyroscope before any turn was evaluated.
fn gyro_scale(format: &Format, columns: [usize; 3], gyro: &[Vec<f64>; 3]) -> GyroScale {
    let options = &format.options;
    let text = &format.columns[columns[0]].unit;
    let board = format
        .board
        .filter(|b| b.is_counts() && GyroUnit::parse(text).is_none());
    let claimed = GyroUnit::parse(text).or(board.map(|_| GyroUnit::Counts));
    let values = || gyro.iter().flatten();
    let are_counts =
        values().all(|v| v.is_nan() || v.fract() == 0.0) && values().any(|v| v.abs() >= 1.0);
    let (unit, origin) = match (options.gyro_unit, claimed) {
        (Some(unit), _) => (unit, Origin::Given),
        (None, Some(unit)) => (unit, Origin::Header),
        (None, None) if are_counts => (GyroUnit::Counts, Origin::Data),
        (None, None) => (GyroUnit::Unknown, Origin::Assumed),
    };
    let range = options.gyro_range_deg_s.map(|range| 32_768.0 / range);
    let by_board = || board.and_then(|b| b.lsb_per_deg_s());
    GyroScale {
        unit,
        lsb_per_deg_s: range
            .or_else(|| GyroUnit::per_deg_s(text))
            .or_else(by_board),
        origin,
    }
}

fn find_labels(format: &Format, rows: &Rows) -> Result<Option<Labels>, Error> {
    let Some(column) = format.columns.iter().position(|c| c.role == Role::Label) else {
        return Ok(None);
    };
    if rows.texts[column].contains(&u8::MAX) {
        let text = "the label column holds more than 254 words";
        let error = Error::input("too-many-labels", text);
        let error = error.with_hint("leave the column out, or cut the file");
        return Err(error.advise("columns", "label=-"));
    }
    Ok(Some(column_labels(rows, column)))
}
