//! Properties of a recording that are determined from all its rows, in memory that does not grow:
//! clock, units, resolution, faults.
//!
//! Some of them are needed while rows are read (how to read time stamps, where a range ends).
//! These [`Facts`] are determined from the first rows and compared with those of all rows at the
//! end: if they do not [agree](Facts::agrees), the recording must be read again with the better
//! ones.

mod defects;
mod unit;

use gravical_core::matrix3;
use gravical_recording::judge::unit_of_quiet;
use serde::{Deserialize, Serialize};

use super::cells::{CellCounts, CellRules, Channels};
use super::layout::Layout;
use super::names::Quantity;
use super::row::{ACCEL, GYRO, TEMPERATURE, TIME, Values};
use super::text_options::text_options;
use super::timing::{BreakKind, Claims, ClockMonitor, RowTime, StampReading, Timing, untimed};
use super::units::{AccelScale, GyroScale, GyroUnit, Origin};
use super::{POSSIBLE_C, ReadOptions, UnitDoubt};
use crate::finding::{Finding, FindingKind};
use crate::resolution::AxisValues;
use crate::stats::{Thinned, median};

pub(crate) use defects::Defects;
pub(crate) use unit::{GyroCounts, Quiet, QuietBlocks};
use unit::{UnitWatch, Unsigned};

/// Recordings with fewer rows are tables of means or a single pose and need no sampling rate.
const LEAST_ROWS: u64 = 40;

/// Largest number of values for a median.
const SAMPLE: usize = 1 << 13;

/// What the file and the user specify about the channels.
#[derive(Debug, Clone)]
pub(crate) struct RecordingClaims {
    pub layout: Layout,
    pub options: ReadOptions,
    /// The sampling rate given above the header, Hz.
    pub metadata_rate_hz: Option<f64>,
}

impl RecordingClaims {
    /// `facts`: whether the temperatures are in °C.
    pub fn channels(&self, facts: &Facts) -> Channels {
        Channels {
            gyro: self.layout.has_gyro(),
            temperature: facts.celsius && self.has_temperature(),
        }
    }

    fn has_temperature(&self) -> bool {
        self.layout.field(Quantity::Temperature).is_some()
    }

    /// Zero of the counts: by the user's option, or the middle of unsigned 16-bit values.
    fn zero_offset(&self, unsigned: bool) -> f64 {
        let usual = if unsigned { 32768.0 } else { 0.0 };
        self.options.zero_offset.unwrap_or(usual)
    }

    fn clock(&self, temperature_span_c: f64) -> Claims {
        Claims {
            unit: self.options.time_unit.or(self.layout.time_claim),
            nominal_rate_hz: self.options.rate_hz.or(self.metadata_rate_hz),
            temperature_span_c,
        }
    }

    /// The gyroscope's unit before any turn was evaluated.
    pub fn gyro_scale(&self, counted: GyroCounts) -> GyroScale {
        gyro_by_claim(counted, &self.layout, &self.options)
    }
}

/// Properties of a recording that must be known while its rows are read.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(crate) struct Facts {
    /// How to read its time stamps; `None` if they cannot be used.
    pub stamp_reading: Option<StampReading>,
    pub cells: CellRules,
    /// Value subtracted from the accelerometer's counts before their unit is determined.
    pub zero_offset: f64,
    pub accel: AccelScale,
    pub gyro: Option<GyroScale>,
    /// Resolution of ax … gz.
    pub resolution: [f64; 6],
    /// The temperatures are in °C.
    pub celsius: bool,
}

impl Facts {
    /// Without any information.
    pub fn none() -> Self {
        Facts {
            stamp_reading: None,
            cells: CellRules::default(),
            zero_offset: 0.0,
            accel: AccelScale {
                unit: super::units::AccelUnit::Unknown,
                lsb_per_g: None,
                origin: Origin::Assumed,
            },
            gyro: None,
            resolution: [0.0; 6],
            celsius: true,
        }
    }

    /// True if rows read with either give the same values and the same findings.
    pub fn agrees(&self, other: &Facts) -> bool {
        let steps = self.resolution.iter().zip(other.resolution);
        let mut steps_agree = steps.map(|(a, b)| *a <= 2.0 * b && b <= 2.0 * *a);
        self.differences(other).is_empty() && steps_agree.all(|same| same)
    }

    /// Names of the properties that differ.
    fn differences(&self, other: &Facts) -> Vec<&'static str> {
        let clock = match (&self.stamp_reading, &other.stamp_reading) {
            (Some(a), Some(b)) => a.agrees(b),
            (a, b) => a.is_none() && b.is_none(),
        };
        let accel = |f: &Facts| (f.accel.unit, f.accel.lsb_per_g);
        let gyro = |f: &Facts| f.gyro.map(|g| (g.unit, g.lsb_per_deg_s));
        let same = [
            ("clock", clock),
            ("empty cells", self.cells.agrees(&other.cells)),
            ("zero offset", self.zero_offset == other.zero_offset),
            ("unit of the accelerometer", accel(self) == accel(other)),
            ("unit of the gyroscope", gyro(self) == gyro(other)),
            ("unit of the temperature", self.celsius == other.celsius),
        ];
        let differ = same.into_iter().filter(|(_, same)| !same);
        differ.map(|(what, _)| what).collect()
    }

    /// The finding if rows were read with these facts and all rows together give others.
    pub fn contradicted_by(&self, whole: &Facts) -> Option<Finding> {
        let differ = self.differences(whole);
        (!differ.is_empty()).then(|| {
            Finding::new(
                FindingKind::FirstRowsDiffer,
                format!(
                    "the first rows, which determined how the recording is read, differ from the whole recording in: {}",
                    differ.join(", ")
                ),
            )
        })
    }
}

/// Processes the rows of a recording.
#[derive(Debug, Clone)]
pub(crate) struct Monitor {
    claims: RecordingClaims,
    facts: Facts,
    channels: Channels,
    cells: CellCounts,
    clock: Option<ClockMonitor>,
    unsigned: Unsigned,
    counted: GyroCounts,
    quiet: QuietBlocks,
    watch: UnitWatch,
    /// Of ax … gz.
    axes: AxisValues<6>,
    temperature: Option<Temperatures>,
    /// Magnitudes; only if the columns were guessed.
    norms: Option<Thinned<f64, SAMPLE>>,
    defects: Defects,
}

/// Findings, in the order in which they are reported.
#[derive(Debug, Default)]
pub(crate) struct MonitorFindings {
    /// About counts and temperatures.
    pub channels: Vec<Finding>,
    /// About the stamps.
    pub clock: Vec<Finding>,
    /// About empty cells.
    pub cells: Option<Finding>,
    /// About the accelerometer's unit.
    pub unit: Vec<Finding>,
    /// About the samples.
    pub values: Vec<Finding>,
}

/// Results of all rows.
pub(crate) struct MonitorSummary {
    pub facts: Facts,
    pub timing: Timing,
    /// The first time stamp, s.
    pub origin_s: Option<f64>,
    /// Why the accelerometer's unit is unknown.
    pub unit_doubt: Option<UnitDoubt>,
    pub found: MonitorFindings,
}

impl Monitor {
    pub fn new(claims: RecordingClaims, facts: Facts) -> Self {
        let channels = claims.channels(&facts);
        let stamped = claims.layout.field(Quantity::Time).is_some();
        Monitor {
            facts,
            channels,
            cells: CellCounts::new(channels),
            clock: stamped.then(|| ClockMonitor::new(facts.stamp_reading)),
            unsigned: Unsigned::default(),
            counted: GyroCounts::default(),
            quiet: QuietBlocks::default(),
            watch: UnitWatch::default(),
            axes: AxisValues::default(),
            temperature: claims.has_temperature().then(Temperatures::default),
            norms: claims.layout.guessed.then(Thinned::default),
            defects: Defects::new(
                channels,
                facts.accel,
                facts.zero_offset,
                facts.resolution,
                facts.gyro,
            ),
            claims,
        }
    }

    /// Processes a row, as in the file and with its cells filled; `line` is its line number and
    /// `break_kind` the kind of break before it.
    #[inline]
    pub fn observe(
        &mut self,
        raw: &Values,
        values: &Values,
        line: u64,
        break_kind: Option<BreakKind>,
    ) -> RowTime {
        self.cells.observe(raw, line);
        self.unsigned
            .observe([raw[ACCEL], raw[ACCEL + 1], raw[ACCEL + 2]]);
        let offset = self.facts.zero_offset;
        let accel = [values[ACCEL], values[ACCEL + 1], values[ACCEL + 2]].map(|v| v - offset);
        self.quiet.push(accel);
        self.watch.observe(accel, line);
        if let Some(norms) = &mut self.norms {
            norms.push_with(|| matrix3::norm(&accel));
        }
        let rate = [values[GYRO], values[GYRO + 1], values[GYRO + 2]];
        if self.channels.gyro {
            self.counted.observe(rate);
        }
        let ([ax, ay, az], [gx, gy, gz]) = (accel, rate);
        self.axes.observe([ax, ay, az, gx, gy, gz]);
        if let Some(temperature) = &mut self.temperature {
            temperature.observe(raw[TEMPERATURE]);
        }
        self.defects.observe(values, line);
        match &mut self.clock {
            Some(clock) => clock.observe(raw[TIME], line, break_kind),
            None => RowTime::UNKNOWN,
        }
    }

    /// Resolution of ax … gz.
    pub fn resolution(&self) -> [f64; 6] {
        let [a, b, c] = self.axes.resolution(0);
        let [d, e, f] = match self.channels.gyro {
            true => self.axes.resolution(3),
            false => [0.0; 3],
        };
        [a, b, c, d, e, f]
    }

    /// Results, after the last row, except the [resolution](Self::resolution).
    pub fn finish(&self) -> MonitorSummary {
        let mut found = MonitorFindings::default();
        let options = &self.claims.options;
        let unsigned = options.zero_offset.is_none() && self.unsigned.is_unsigned();
        if unsigned {
            found.channels.push(Finding::new(
                FindingKind::UnsignedCounts,
                "unsigned 16-bit values around 32768, which is subtracted; the range is unknown",
            ));
        }
        let temperature = self.temperature.as_ref();
        let celsius = temperature.is_none_or(|t| t.is_celsius(&mut found.channels));
        let span_c = temperature.map_or(0.0, Temperatures::span_c);
        let clock_claims = self.claims.clock(span_c);
        let (timing, stamp_reading, origin_s) = match &self.clock {
            Some(clock) => {
                let summary = clock.finish(&clock_claims, &mut found.clock);
                (summary.timing, summary.stamp_reading, summary.origin_s)
            }
            None => (untimed(self.cells.rows(), &clock_claims), None, None),
        };
        if timing.rate_hz().is_none() && self.cells.rows() >= LEAST_ROWS {
            found.clock.push(Finding::new(
                FindingKind::RateUnknown,
                "no time stamps and no --rate: static intervals are counted in rows",
            ));
        }
        found.cells = self.cells.finding(&self.facts.cells);
        let quiet = self.quiet.finish();
        let judged = unit_of_quiet(
            quiet.map(|q| (q.norm, q.integers)),
            unsigned,
            self.claims.layout.accel_claim,
            &text_options(options, false),
        );
        found
            .unit
            .extend(judged.notes.into_iter().map(Finding::from));
        found.unit.extend(self.watch.finding());
        let held = self.facts.cells.holds();
        found.values = self.defects.clone().finish(held);
        found.values.extend(self.not_an_accelerometer(quiet));
        let without_gravity = self.claims.layout.accel_claim.without_gravity;
        MonitorSummary {
            facts: Facts {
                stamp_reading,
                cells: self.cells.rules(without_gravity),
                zero_offset: self.claims.zero_offset(unsigned),
                accel: judged.scale,
                gyro: self
                    .channels
                    .gyro
                    .then(|| self.claims.gyro_scale(self.counted)),
                resolution: self.facts.resolution,
                celsius,
            },
            timing,
            origin_s,
            unit_doubt: judged.doubt,
            found,
        }
    }

    /// Results with the resolution.
    pub fn finish_with_resolution(&self) -> MonitorSummary {
        let mut summary = self.finish();
        summary.facts.resolution = self.resolution();
        summary
    }

    /// Reports columns that were taken for an accelerometer by their numbers alone and do not
    /// behave like one: an accelerometer always measures gravity, so that its magnitudes at rest
    /// and in motion are similar.
    fn not_an_accelerometer(&self, quiet: Option<Quiet>) -> Option<Finding> {
        let quiet = quiet?.norm;
        let norms = self.norms.as_ref()?.items().iter();
        let mut norms: Vec<f64> = norms.copied().filter(|n| n.is_finite()).collect();
        let at = ((norms.len() * 49) / 50).min(norms.len().checked_sub(1)?);
        let (_, high, _) = norms.select_nth_unstable_by(at, f64::total_cmp);
        (*high > 4.0 * quiet).then(|| {
            Finding::new(
                FindingKind::NotAnAccelerometer,
                format!("the magnitude is {quiet:.0} at rest and up to {high:.0} in motion: these columns look like a gyroscope"),
            )
        })
    }
}

/// Temperatures, for their unit and range.
#[derive(Debug, Clone)]
struct Temperatures {
    low: f64,
    high: f64,
    some: Thinned<f64, SAMPLE>,
}

impl Default for Temperatures {
    fn default() -> Self {
        Temperatures {
            low: f64::INFINITY,
            high: f64::NEG_INFINITY,
            some: Thinned::default(),
        }
    }
}

impl Temperatures {
    #[inline]
    fn observe(&mut self, value: f64) {
        if POSSIBLE_C.contains(&value) {
            self.low = self.low.min(value);
            self.high = self.high.max(value);
        }
        self.some.push_with(|| value);
    }

    /// Range of the possible ones, °C; 0 without any.
    fn span_c(&self) -> f64 {
        (self.high - self.low).max(0.0)
    }

    /// True if the values can be °C; raw counts are reported.
    fn is_celsius(&self, findings: &mut Vec<Finding>) -> bool {
        let some = self.some.items().iter().copied().filter(|t| t.is_finite());
        let Some(middle) = median(&mut some.collect::<Vec<f64>>()) else {
            return true;
        };
        let fits = POSSIBLE_C.contains(&middle);
        if !fits {
            findings.push(Finding::new(
                FindingKind::TemperatureUnit,
                format!(
                    "the temperature column is around {middle:.0}, not °C (raw counts?); it is not used"
                ),
            ));
        }
        fits
    }
}

/// The gyroscope's unit before any turn was evaluated.
pub(crate) fn gyro_by_claim(
    counted: GyroCounts,
    layout: &Layout,
    options: &ReadOptions,
) -> GyroScale {
    let given = options.gyro_unit.map(|unit| (unit, Origin::Given));
    let claimed = layout.gyro_claim.map(|unit| (unit, Origin::Header));
    let by_values = match counted.look_like_counts() {
        true => (GyroUnit::Counts, Origin::Data),
        false => (GyroUnit::Unknown, Origin::Assumed),
    };
    let (unit, origin) = given.or(claimed).unwrap_or(by_values);
    GyroScale {
        unit,
        lsb_per_deg_s: options
            .gyro_range_deg_s
            .map(|range| 32768.0 / range)
            .or(layout.gyro_lsb_per_deg_s),
        origin,
    }
}
