//! From the rows of a file to a recording.

pub(crate) mod cells;
pub(crate) mod clean;
pub(crate) mod findings;
mod time;

use crate::metadata;
use crate::problem::Problem;
use crate::recording::Recording;
use crate::text::{Format, Rows};

use clean::{clean, names};
use gravical_judge::full_scale::Clipping;
use gravical_judge::units::{AccelUnit, GyroScale, GyroUnit, Origin};
use gravical_judge::{self as judge, AccelClaim, Encoding, Error, Finding, Jump};

impl Recording {
    /// Judges the rows of a whole file.
    ///
    /// # Errors
    ///
    /// `no-rows`, `no-values`, `all-zero`, `sensor-unknown`, `too-many-labels`, `unit-changed`, `shifted-columns`.
    pub fn judge(format: &Format, rows: Rows) -> Result<Self, Error> {
        clean(format, rows)?.judged()
    }

    /// The same of rows that others follow; none where no row is a measurement so far.
    pub(crate) fn judge_so_far(format: &Format, rows: Rows) -> Result<Option<Self>, Error> {
        use Problem::{AllZero, NoRowRead, NoValues};
        match clean(format, rows) {
            Err(NoRowRead { .. } | NoValues { .. } | AllZero { .. }) => Ok(None),
            cleaned => cleaned?.judged().map(Some),
        }
    }

    fn judged(mut self) -> Result<Self, Error> {
        self.judge_units()?;
        self.judge_samples();
        Ok(self)
    }

    fn judge_units(&mut self) -> Result<(), Error> {
        let (format, options) = (&self.format, &self.format.options);
        let is_unsigned = self.read_as.encoding == Some(Encoding::OffsetBinary);
        let middle = if is_unsigned { 32_768.0 } else { 0.0 };
        let gyro = if options.is_gyroscope {
            Some((format.accel, &self.accel))
        } else {
            format.gyro.zip(self.gyro.as_ref())
        };
        let units = &mut self.units;
        units.gyro = gyro.map(|(columns, gyro)| gyro_scale(format, columns, gyro));
        units.zero_offset = options.zero_offset.unwrap_or(middle);
        units.resolution = [Some(&self.accel), self.gyro.as_ref()]
            .map(|sensor| sensor.map_or([0.0; 3], judge::resolution));
        let axes = self.accel.each_ref().map(Vec::as_slice);
        let (claim, mut of_unit) = (accel_claim(format), Vec::new());
        let scale = judge::accel_unit(axes, is_unsigned, claim, options, units, &mut of_unit);
        let is_known = matches!(scale.origin, Origin::Data | Origin::Given);
        units.contradicts_header = is_known && claim.unit.is_some_and(|c| c != scale.unit);
        units.accel = scale;
        if scale.unit == AccelUnit::Unknown {
            self.why_unit_unknown = of_unit.last().cloned();
        }
        if !options.is_gyroscope {
            self.findings.extend(of_unit);
            if options.accel_unit.is_none()
                && let Some(Jump {
                    norms,
                    row,
                    is_of_unit,
                }) = judge::find_jump(&self.accel, self.gyro.as_ref())
            {
                let (line, head) = (self.lines[row] as usize, format.head_lines);
                let problem = if is_of_unit {
                    Problem::UnitChanged { norms, line, head }
                } else {
                    Problem::ShiftedColumns { norms, line, head }
                };
                return Err(problem.error().at_line(line));
            }
        }
        Ok(())
    }

    /// What is found of axes that keep one value while the others change.
    pub fn frozen_axes(&self) -> Vec<Finding> {
        let sensors = std::iter::once(&self.accel).chain(&self.gyro);
        let sensors = sensors.zip(names(&self.format).chunks(3));
        let mut findings = Vec::new();
        for ((sensor, names), steps) in sensors.zip(&self.units.resolution) {
            findings.extend(judge::frozen_axes(sensor, names, steps, &self.lines));
        }
        findings
    }

    /// Frozen axes, values at the end of the range, repeats, columns of another sensor.
    fn judge_samples(&mut self) {
        let names = names(&self.format);
        let mut findings = self.frozen_axes();
        let gyro_end = self.units.gyro.as_ref().map(Clipping::of_gyro);
        // In a file of its own the gyroscope is the first sensor.
        let alone = gyro_end
            .clone()
            .filter(|_| self.format.options.is_gyroscope);
        let accel_end = alone.unwrap_or_else(|| Clipping::of_accel(&self.units.accel));
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
    if let (Some(board), None) = (format.board, claim.unit)
        && board.is_counts()
        && board.accel_range_g > 0
    {
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
    let lsb = options.gyro_range_deg_s.map(|range| 32_768.0 / range);
    let lsb = lsb.or_else(|| GyroUnit::per_deg_s(text));
    GyroScale {
        unit,
        lsb_per_deg_s: lsb.or_else(|| board?.lsb_per_deg_s()),
        origin,
    }
}
