//! Which calibration of a store fits a recording.

use gravical_core::unit::STANDARD_GRAVITY_MPS2;
use serde::Serialize;

use crate::calibrate::common_serial;
use crate::calibration_file::{Grade, TemperatureRange};
use crate::escape::path_word;
use crate::recording::{AccelScale, AccelUnit, GyroScale, GyroUnit, Recording};
use crate::utc::UtcTime;
use crate::{Error, Result};

use super::read::Stored;
use super::{LeftOutFile, StoredCalibration, StoredTimeSource, id_missing};

/// Counts per g, or per °/s, that differ by more than this share are of another range.
const SAME_RANGE: f64 = 0.2;
/// Rejected calibrations that an error lists.
const LISTED: usize = 4;

/// What a calibration has to fit.
#[derive(Debug, Clone, PartialEq)]
pub struct Query {
    /// The sensor; default: the serial number that the recording names.
    pub sensor_id: Option<String>,
    /// When the recording was made.
    pub time: UtcTime,
    /// Source of that time.
    pub time_source: QueryTimeSource,
    /// Unit and range of the accelerometer; none if they do not matter.
    pub accelerometer: Option<AccelScale>,
    /// Unit and range of the gyroscope.
    pub gyroscope: Option<GyroScale>,
    /// Lowest and highest temperature of the recording, °C.
    pub temperature_c: Option<[f64; 2]>,
    /// Take the nearest calibration, before or after. Default: the last one before.
    pub nearest: bool,
    /// Largest time between calibration and recording, days. Default: any.
    pub max_age_days: Option<f64>,
    /// How far the temperatures of the recording may be outside those of the calibration, °C.
    /// Default: 10.
    pub max_temperature_difference_c: f64,
}

/// Source of the time of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum QueryTimeSource {
    /// Given by the user.
    Given,
    /// The first time stamp of the recording.
    TimeStamps,
    /// The present: the recording has no date.
    Now,
}

/// The calibration that was chosen, and why.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Choice {
    /// The folder.
    pub store: String,
    /// The file of the calibration.
    pub path: String,
    /// The sensor.
    pub sensor_id: String,
    /// When the sensor was calibrated.
    pub time: UtcTime,
    /// Source of that time.
    pub time_source: StoredTimeSource,
    /// When the recording was made.
    pub recording_time: UtcTime,
    /// Source of that time.
    pub recording_time_source: QueryTimeSource,
    /// From calibration to recording, days; negative if it is the later one.
    pub age_days: f64,
    /// Why it fits: time, unit and range, temperature, and what could not be tested.
    pub reasons: Vec<String>,
    /// Number of calibrations of the sensor.
    pub candidates: usize,
    /// Those that do not fit.
    pub rejected: Vec<Rejected>,
    /// JSON files of the store that are no calibration of a sensor.
    pub left_out: Vec<LeftOutFile>,
}

/// A calibration that does not fit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Rejected {
    /// Its file.
    pub path: String,
    /// When the sensor was calibrated.
    pub time: UtcTime,
    /// Why, each with its limit.
    pub reasons: Vec<String>,
}

/// How one calibration fits.
#[derive(Debug, Default)]
struct Judged {
    fits: Vec<String>,
    rejects: Vec<String>,
    grounds: Vec<Ground>,
}

/// Why it is rejected, as far as an option would admit it.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Ground {
    Later,
    /// So many days away.
    Age(f64),
    /// So many °C outside.
    Temperature(f64),
    Other,
}

impl Ground {
    /// The option that admits it.
    fn option(self) -> Option<String> {
        match self {
            Ground::Later => Some("--nearest".to_owned()),
            Ground::Age(days) => Some(format!("--max-age {}", days.ceil())),
            Ground::Temperature(outside_c) => {
                Some(format!("--max-temperature-difference {}", outside_c.ceil()))
            }
            Ground::Other => None,
        }
    }
}

impl Query {
    /// The present, for any unit, range and temperature.
    #[must_use]
    pub fn now() -> Self {
        Query {
            sensor_id: None,
            time: UtcTime::now(),
            time_source: QueryTimeSource::Now,
            accelerometer: None,
            gyroscope: None,
            temperature_c: None,
            nearest: false,
            max_age_days: None,
            max_temperature_difference_c: 10.0,
        }
    }

    /// For recordings of one sensor: serial number, first time stamp, unit and range, temperature.
    /// The first rows of them are enough.
    ///
    /// # Errors
    ///
    /// `sensors-differ` (input) if they name several serial numbers.
    pub fn of(recordings: &[Recording]) -> Result<Self> {
        let mut query = Query {
            sensor_id: common_serial(recordings)?,
            accelerometer: recordings.first().map(|r| r.accel_scale),
            gyroscope: recordings.iter().find_map(|r| r.gyro_scale),
            ..Query::now()
        };
        if let Some(time) = recordings.iter().filter_map(Recording::recorded_at).min() {
            (query.time, query.time_source) = (time, QueryTimeSource::TimeStamps);
        }
        let temperatures = recordings.iter().filter_map(|r| r.temperature_c.as_ref());
        let temperatures = temperatures.flatten().filter(|t| t.is_finite());
        query.temperature_c = temperatures.fold(None, |range, t| {
            let [low, high] = range.unwrap_or([*t, *t]);
            Some([f64::min(low, *t), f64::max(high, *t)])
        });
        Ok(query)
    }

    /// Checks ranges.
    ///
    /// # Errors
    ///
    /// `option-range` (usage).
    pub fn validate(&self) -> Result<()> {
        let positive = |v: f64| v.is_finite() && v >= 0.0;
        if let Some(age) = self.max_age_days
            && !positive(age)
        {
            let what = format!("{age} is no number of days");
            return Err(Error::range("max_age_days", what));
        }
        let difference = self.max_temperature_difference_c;
        if !positive(difference) {
            let what = format!("{difference} °C is no difference; 0 or more is");
            return Err(Error::range("max_temperature_difference_c", what));
        }
        Ok(())
    }

    fn judge(&self, stored: &StoredCalibration) -> Judged {
        let mut judged = Judged::default();
        self.judge_time(stored, &mut judged);
        if stored.file.verdict.grade == Grade::Poor {
            judged.reject(Ground::Other, "its verdict is poor".to_owned());
        }
        self.judge_accelerometer(stored, &mut judged);
        self.judge_gyroscope(stored, &mut judged);
        self.judge_temperature(stored, &mut judged);
        judged
    }

    fn judge_time(&self, stored: &StoredCalibration, judged: &mut Judged) {
        let days = stored.time.days_until(self.time);
        let words = apart(days);
        let mut text = format!("made {words} the recording");
        if days < 0.0 && !self.nearest {
            judged.grounds.push(Ground::Later);
        }
        match self.max_age_days {
            Some(most) if days.abs() > most => {
                judged.grounds.push(Ground::Age(days.abs()));
                text.push_str(&format!(", the limit is {most} days"));
            }
            Some(most) => text.push_str(&format!(", within {most} days")),
            None => {}
        }
        match judged.grounds.is_empty() {
            true => judged.fits.push(text),
            false => judged.rejects.push(text),
        }
    }

    fn judge_accelerometer(&self, stored: &StoredCalibration, judged: &mut Judged) {
        let Some(scale) = self.accelerometer else {
            return;
        };
        let section = &stored.file.accelerometer;
        let (own, wanted) = (section.input_unit, scale.unit);
        if own == AccelUnit::Unknown || wanted == AccelUnit::Unknown {
            let whose = match own {
                AccelUnit::Unknown => "the calibration does not give its unit",
                _ => "the unit of the recording is unknown",
            };
            judged.fits.push(format!("{whose}: not compared"));
        } else if own != wanted {
            let (own, wanted) = (own.name(), wanted.name());
            judged.reject(
                Ground::Other,
                format!("for {own}, the recording is in {wanted}"),
            );
        } else if own == AccelUnit::Counts {
            let mean = section.scale.iter().sum::<f64>() / 3.0 * STANDARD_GRAVITY_MPS2;
            judged.range("per g", mean, scale.lsb_per_g);
        } else {
            judged
                .fits
                .push(format!("for {} as the recording", own.name()));
        }
    }

    fn judge_gyroscope(&self, stored: &StoredCalibration, judged: &mut Judged) {
        let (Some(scale), Some(section)) = (self.gyroscope, &stored.file.gyroscope) else {
            return;
        };
        let (own, wanted) = (section.input_unit, scale.unit);
        // What a recording says of its gyroscope is often wrong; the commands find out by turns.
        let believed = scale.origin != crate::recording::Origin::Assumed;
        if own == GyroUnit::Counts && wanted == GyroUnit::Counts && scale.lsb_per_deg_s.is_some() {
            let mean = section.scale.iter().map(|s| s.abs()).sum::<f64>() / 3.0;
            judged.range("per °/s", mean.to_radians(), scale.lsb_per_deg_s);
        } else if believed
            && (own == GyroUnit::Counts) != (wanted == GyroUnit::Counts)
            && own != GyroUnit::Unknown
            && wanted != GyroUnit::Unknown
        {
            let (own, wanted) = (own.name(), wanted.name());
            let what = format!("its gyroscope is for {own}, that of the recording is in {wanted}");
            judged.reject(Ground::Other, what);
        }
    }

    fn judge_temperature(&self, stored: &StoredCalibration, judged: &mut Judged) {
        let model = stored.file.temperature_model.as_ref();
        let model = model.filter(|m| m.any_corrected()).map(|m| m.range_c);
        let poses = stored
            .file
            .temperature_c
            .map(|t: TemperatureRange| [t.min, t.max]);
        let own = match (model, poses) {
            (Some(a), Some(b)) => Some([a[0].min(b[0]), a[1].max(b[1])]),
            (a, b) => a.or(b),
        };
        let ([low, high], [from, to]) = match (own, self.temperature_c) {
            (Some(own), Some(wanted)) => (own, wanted),
            (None, Some(_)) => {
                judged
                    .fits
                    .push("its temperature is unknown: not compared".to_owned());
                return;
            }
            (_, None) => return,
        };
        let outside = (low - from).max(to - high).max(0.0);
        let most = self.max_temperature_difference_c;
        let text = format!(
            "calibrated at {}, the recording is at {}",
            degrees([low, high]),
            degrees([from, to])
        );
        match outside > most {
            true => judged.reject(
                Ground::Temperature(outside),
                format!("{text}: {outside:.1} °C outside, the limit is {most} °C"),
            ),
            false => judged.fits.push(text),
        }
    }
}

impl Judged {
    fn reject(&mut self, ground: Ground, why: String) {
        self.grounds.push(ground);
        self.rejects.push(why);
    }

    /// Counts of one size, if both are known.
    fn range(&mut self, per: &str, own: f64, wanted: Option<f64>) {
        match wanted {
            Some(wanted) if (wanted / own - 1.0).abs() > SAME_RANGE => self.reject(
                Ground::Other,
                format!("another range: for {own:.0} counts {per}, the recording has {wanted:.0}"),
            ),
            Some(_) => self
                .fits
                .push(format!("for {own:.0} counts {per} as the recording")),
            None => self.fits.push(format!(
                "for {own:.0} counts {per}; the range of the recording is unknown"
            )),
        }
    }
}

/// "12.3 days before", "2.0 hours after".
fn apart(days: f64) -> String {
    let size = days.abs();
    let (value, unit) = match size {
        s if s >= 2.0 => (s, "days"),
        s if s * 24.0 >= 1.0 => (s * 24.0, "hours"),
        s => (s * 1440.0, "minutes"),
    };
    let side = if days < 0.0 { "after" } else { "before" };
    format!("{value:.1} {unit} {side}")
}

fn degrees([low, high]: [f64; 2]) -> String {
    match high - low < 0.05 {
        true => format!("{low:.1} °C"),
        false => format!("{low:.1} to {high:.1} °C"),
    }
}

impl Stored {
    /// The calibration that fits, and why: of the same sensor, the last one before the recording
    /// (or the nearest), within the age limit, for the same unit and range, at its temperature, and
    /// not poor. Without a temperature or unit on either side that is not tested, which the
    /// reasons say.
    ///
    /// # Errors
    ///
    /// `sensor-id-missing` (usage) without a sensor; `no-such-sensor` and `no-calibration`
    /// (input), with the reason for each that was rejected; `option-range` (usage).
    pub fn choose(&self, query: &Query) -> Result<(&StoredCalibration, Choice)> {
        query.validate()?;
        let id = query.sensor_id.as_deref().map(str::trim).unwrap_or("");
        if id.is_empty() {
            let what = "the recording names no sensor, and the store is kept by sensor";
            let what = format!("{what}: {}", self.ids(""));
            return Err(id_missing(what).at(&self.folder, None));
        }
        let own = self.of(id)?;
        let mut fitting: Vec<(&StoredCalibration, Vec<String>)> = Vec::new();
        let mut rejected = Vec::new();
        let mut grounds = Vec::new();
        for stored in own {
            let judged = query.judge(stored);
            if judged.rejects.is_empty() {
                fitting.push((stored, judged.fits));
                continue;
            }
            if !judged.grounds.contains(&Ground::Other) {
                grounds.push((stored.time, judged.grounds));
            }
            rejected.push(Rejected {
                path: stored.path.display().to_string(),
                time: stored.time,
                reasons: judged.rejects,
            });
        }
        // The last of equally near ones: they are in order of time, and of their computation.
        let distance = |c: &StoredCalibration| c.time.days_until(query.time);
        let best = fitting.iter().min_by(|(a, _), (b, _)| {
            let (da, db) = (distance(a), distance(b));
            // Before goes before after.
            let by_side = (da < 0.0).cmp(&(db < 0.0));
            da.abs()
                .total_cmp(&db.abs())
                .then(by_side)
                .then(b.file.created.cmp(&a.file.created))
        });
        let Some((chosen, fits)) = best else {
            return Err(self.none_fits(id, own, &rejected, &grounds));
        };
        let mut reasons = fits.clone();
        let as_near = |(c, _): &&(&StoredCalibration, _)| distance(c) == distance(chosen);
        let as_near = fitting.iter().filter(as_near).count() - 1;
        let mut tell = |others: usize, one: &str, several: &str| match others {
            0 => {}
            1 => reasons.push(format!("1 more fits, too, and {one}")),
            n => reasons.push(format!("{n} more fit, too, and {several}")),
        };
        tell(as_near, "was computed earlier", "were computed earlier");
        tell(
            fitting.len() - 1 - as_near,
            "is further away in time",
            "are further away in time",
        );
        let choice = Choice {
            store: self.folder.display().to_string(),
            path: chosen.path.display().to_string(),
            sensor_id: id.to_owned(),
            time: chosen.time,
            time_source: chosen.time_source,
            recording_time: query.time,
            recording_time_source: query.time_source,
            age_days: distance(chosen),
            reasons,
            candidates: own.len(),
            rejected,
            left_out: self.left_out.clone(),
        };
        Ok((chosen, choice))
    }

    fn none_fits(
        &self,
        id: &str,
        own: &[StoredCalibration],
        rejected: &[Rejected],
        grounds: &[(UtcTime, Vec<Ground>)],
    ) -> Error {
        let count = own.len();
        let each = rejected.iter().rev().take(LISTED);
        let mut each: Vec<String> = each
            .map(|r| format!("{}: {}", r.time, r.reasons.join(", ")))
            .collect();
        if count > LISTED {
            each.push(format!("and {} earlier ones", count - LISTED));
        }
        let what = match count {
            1 => format!("the one calibration of sensor \"{id}\" does not fit"),
            n => format!("none of the {n} calibrations of sensor \"{id}\" fits"),
        };
        let mut hints: Vec<String> = Vec::new();
        // Of each set of options the one that admits the last calibration.
        let mut known: Vec<Vec<std::mem::Discriminant<Ground>>> = Vec::new();
        for (time, own) in grounds.iter().rev() {
            let kinds: Vec<_> = own.iter().map(std::mem::discriminant).collect();
            let options: Vec<String> = own.iter().filter_map(|g| g.option()).collect();
            if !known.contains(&kinds) {
                hints.push(format!(
                    "{} takes the one of {time}",
                    options.join(" with ")
                ));
                known.push(kinds);
            }
        }
        hints.push(match own.last() {
            // One of another unit or verdict would not help.
            Some(last) if !grounds.is_empty() => format!(
                "calibrate again, or name a file in place of --store: {}",
                path_word(&last.path)
            ),
            _ => "calibrate this sensor as it was in the recording".to_owned(),
        });
        Error::input("no-calibration", format!("{what}: {}", each.join("; ")))
            .at(&self.folder, None)
            .with_hint(hints.join("; "))
    }
}
