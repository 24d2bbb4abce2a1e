//! From the rows of a file to a recording.

pub(crate) mod clean;
pub(crate) mod findings;
mod time;

use crate::error::Error;
use crate::finding::Finding;
use crate::full_scale::Clipping;
use crate::judge::{self, AccelClaim, Encoding};
use crate::metadata;
use crate::recording::{CALIBRATED, Labels, Recording};
use crate::role::Role;
use crate::text::{Format, Rows};
use crate::units::{AccelUnit, GyroScale, GyroUnit, Origin};

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
        let resolution = resolution(&accel, gyro.as_ref());
        let is_unsigned = read_as.encoding == Some(Encoding::OffsetBinary);
        let middle = if is_unsigned { 32_768.0 } else { 0.0 };
        let (axes, claim) = (accel.each_ref().map(Vec::as_slice), accel_claim(format));
        let mut of_unit = Vec::new();
        let accel_scale = judge::accel_unit(axes, is_unsigned, claim, options, &mut of_unit);
        if !options.is_gyroscope {
            findings.append(&mut of_unit);
            if options.accel_unit.is_none() {
                judge::refuse_jump(&accel, gyro.as_ref(), &rows.lines, format.head_lines)?;
            }
        }
        let read_gyro = if options.is_gyroscope {
            Some((format.accel, &accel))
        } else {
            format.gyro.zip(gyro.as_ref())
        };
        let gyro_scale = read_gyro.map(|(c, gyro)| gyro_scale(format, c, gyro));
        let is_calibrated_by_board = format.board.is_some_and(|b| b.is_calibrated());
        let reads = |own: &[&str; 3]| {
            let mut pairs = format.accel.iter().zip(own);
            pairs.all(|(column, own)| format.names.get(*column).is_some_and(|n| n == own))
        };
        let is_known = matches!(accel_scale.origin, Origin::Data | Origin::Given);
        let mut recording = Recording {
            name: String::new(),
            sha256: None,
            description: format.describe(),
            serial: metadata::serial(&format.metadata),
            column_names: format.names.clone(),
            is_calibrated: is_calibrated_by_board || CALIBRATED.iter().any(reads),
            is_calibrated_by_board,
            gyro_file: None,
            temperature_c: clean.temperature_c,
            time_s: Some(time.time_s).filter(|time_s| !time_s.is_empty()),
            time_origin_s: time.start_s,
            stated_start_s: metadata::start_s(&format.metadata),
            labels: find_labels(format, &rows)?,
            breaks: clean.breaks,
            zero_offset: options.zero_offset.unwrap_or(middle),
            accel_scale,
            contradicts_header: is_known && claim.unit.is_some_and(|c| c != accel_scale.unit),
            gyro_scale,
            accel,
            gyro,
            resolution,
            timing: time.timing,
            ledger: rows.ledger,
            findings,
            lines: rows.lines,
            restarts: clean.restarts,
            read_as,
        };
        recording.judge_samples(format);
        Ok(recording)
    }

    /// Frozen axes, values at the end of the range, repeats, columns of another sensor.
    fn judge_samples(&mut self, format: &Format) {
        let mut findings = self.frozen_axes(format);
        for (channel, name, mut clipping) in self.ends_of_ranges(format) {
            clipping.observe(channel, &self.lines);
            findings.extend(clipping.finding(name));
        }
        if !self.read_as.is_sparse {
            let channels = self.accel.iter().chain(self.gyro.iter().flatten());
            let channels: Vec<&[f64]> = channels.map(Vec::as_slice).collect();
            let steps = self.resolution.as_flattened();
            findings.extend(judge::repeated_rows(&channels, steps, &self.lines));
        }
        if format.is_guessed {
            findings.extend(findings::not_an_accelerometer(&self.accel));
        }
        self.findings.append(&mut findings);
    }

    pub(crate) fn frozen_axes(&self, format: &Format) -> Vec<Finding> {
        let sensors = std::iter::once(&self.accel).chain(&self.gyro);
        let names = names(format);
        let mut findings = Vec::new();
        for ((sensor, names), steps) in sensors.zip(names.chunks(3)).zip(&self.resolution) {
            findings.extend(judge::frozen_axes(sensor, names, steps, &self.lines));
        }
        findings
    }

    /// Channels, their names and what detects the ends of their ranges.
    pub(crate) fn ends_of_ranges(&self, format: &Format) -> Vec<(&[f64], &'static str, Clipping)> {
        let accel_end = Clipping::of_accel(&self.accel_scale);
        let gyro_end = self.gyro_scale.as_ref().map(Clipping::of_gyro);
        let accel = self.accel.iter().map(|channel| (channel, &accel_end));
        let gyro = self.gyro.iter().flatten().zip(gyro_end.iter().cycle());
        let channels = accel.chain(gyro).zip(names(format));
        channels
            .map(|((channel, end), name)| (channel.as_slice(), name, end.clone()))
            .collect()
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

pub(crate) fn resolution(accel: &[Vec<f64>; 3], gyro: Option<&[Vec<f64>; 3]>) -> [[f64; 3]; 2] {
    let of_gyro = gyro.map_or([0.0; 3], judge::resolution);
    [judge::resolution(accel), of_gyro]
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
