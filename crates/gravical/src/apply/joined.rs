//! The gyroscope of a second file.

use std::path::Path;

use crate::calibration_file::CalibrationFile;
use crate::poses::gyro_unit::{Claims, Evidence, decide, mismatch};
use crate::poses::rests::find_rests;
use crate::poses::turns::motions;
use crate::recording::{Finding, FindingKind, GyroUnit, Recording};
use crate::{Error, Result};

/// The recording with its gyroscope joined; its rows are found by their lines.
pub(super) struct Joined<'a> {
    recording: &'a Recording,
    gyro: &'a [Vec<f64>; 3],
    next: usize,
    /// Unit of the gyroscope.
    pub unit: GyroUnit,
}

impl<'a> Joined<'a> {
    /// # Errors
    ///
    /// `gyro-not-calibrated` (usage) if the calibration has no gyroscope, `no-gyroscope` if the
    /// recording has none, `unit-mismatch` if the calibration is for another unit or range.
    pub fn new(
        calibration: &CalibrationFile,
        recording: &'a Recording,
        findings: &mut Vec<Finding>,
    ) -> Result<Self> {
        let name = Path::new(&recording.name);
        let Some(section) = &calibration.gyroscope else {
            return Err(Error::usage(
                "gyro-not-calibrated",
                "the calibration has no gyroscope, so it cannot be applied to that of --gyro",
            )
            .with_hint("leave --gyro out, or calibrate with --gyro"));
        };
        let claims = Claims::of(recording, Some(section));
        let (Some(gyro), Some(claims)) = (&recording.gyro, claims) else {
            return Err(
                Error::input("no-gyroscope", "no gyroscope is joined to the recording")
                    .at(name, None),
            );
        };
        let stills = find_rests(recording).spans;
        let evidence = Evidence::of(recording, &stills, &motions(recording, &stills));
        let scale = decide(claims, &evidence, findings);
        if let Some(why) = mismatch(section, &scale) {
            return Err(Error::input("unit-mismatch", why)
                .at(name, None)
                .with_hint(format!(
                    "give --gyro-unit {} if that is its unit",
                    section.input_unit.name()
                )));
        }
        findings.extend(recording.findings.iter().filter(|f| is_of_join(f)).cloned());
        Ok(Joined {
            recording,
            gyro,
            next: 0,
            unit: section.input_unit,
        })
    }

    /// The gyroscope's values of the rows in these lines, which come in rising order; NaN where
    /// there are none.
    pub fn rates(&mut self, lines: &[u32]) -> [Vec<f64>; 3] {
        let mut rates = [(); 3].map(|()| Vec::with_capacity(lines.len()));
        for line in lines {
            let line = u64::from(*line);
            let rows = self.recording.rows();
            while self.next < rows && self.recording.line(self.next) < line {
                self.next += 1;
            }
            let is_there = self.next < rows && self.recording.line(self.next) == line;
            for (rate, channel) in rates.iter_mut().zip(self.gyro) {
                rate.push(if is_there {
                    channel[self.next]
                } else {
                    f64::NAN
                });
            }
        }
        rates
    }
}

/// What joining found; the rest is found again while rows are written.
fn is_of_join(finding: &Finding) -> bool {
    matches!(
        finding.kind,
        FindingKind::GyroRowByRow | FindingKind::GyroInterpolated | FindingKind::GyroUncovered
    )
}
