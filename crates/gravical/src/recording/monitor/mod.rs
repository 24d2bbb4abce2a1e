//! What the rows of a recording say of it, row by row and in flat memory: its clock, its
//! units, its steps, and what is odd.
//!
//! Some of it has to be known while rows are read (how stamps are to be read, where a
//! range ends). That is judged by the first rows, [`Facts`], and held against what all of
//! them say at the end: where the two do not [agree](Facts::agrees), the recording has to
//! be read again by the better ones.

mod defects;
mod unit;

use std::path::Path;

use super::cells::{CellCounts, CellRules, Channels};
use super::layout::Layout;
use super::names::Quantity;
use super::resolution::AxisValues;
use super::row::{ACCEL, GYRO, TEMPERATURE, TIME, Values};
use super::timing::{
    Claims, ClockMonitor, Follower, Parting, RowTime, StampReading, Timing, Treatment, untimed,
};
use super::unit_choice::{UnitDoubt, decide_accel};
use super::units::{AccelScale, GyroScale, GyroUnit, Origin};
use super::{POSSIBLE_C, ReadOptions, Recording};
use crate::finding::{Finding, FindingKind};
use crate::stats::{Thinned, median};
use crate::{Error, Result};

pub(crate) use defects::Defects;
pub use unit::quiet_norm;
pub(crate) use unit::{LooksCounted, Quiet, quiet};
use unit::{QuietBlocks, UnitWatch, Unsigned};

/// Fewer rows than these are a table of means, or one placement: no rate is needed.
const LEAST_ROWS: u64 = 40;

/// Values of which the median is taken, at most.
const SAMPLE: usize = 1 << 13;

/// What the file and the user say of the channels.
#[derive(Debug, Clone)]
pub(crate) struct RecordingClaims {
    pub layout: Layout,
    pub options: ReadOptions,
    /// The rate that the lines above the header claim, Hz.
    pub metadata_rate_hz: Option<f64>,
}

impl RecordingClaims {
    pub fn channels(&self) -> Channels {
        Channels {
            gyro: self.layout.has_gyro(),
            temperature: self.layout.field(Quantity::Temperature).is_some(),
        }
    }

    /// Counts of unsigned 16-bit values begin here, unless the user says where.
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

    /// The gyroscope's unit before any turn has been looked at.
    pub fn gyro_scale(&self, counted: LooksCounted) -> GyroScale {
        gyro_by_claim(counted, &self.layout, &self.options)
    }
}

/// What has to be known of a recording while its rows are read.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Facts {
    /// How its stamps are to be read; none where they are of no use.
    pub stamp_reading: Option<StampReading>,
    pub cells: CellRules,
    /// What is subtracted from the accelerometer's values before their unit is judged.
    pub zero_offset: f64,
    pub accel: AccelScale,
    pub gyro: Option<GyroScale>,
    /// Steps of ax … gz.
    pub resolution: [f64; 6],
    /// The temperatures are °C.
    pub celsius: bool,
}

impl Facts {
    /// Before anything is known.
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

    /// Rows that are read by either come out alike, and so does what is odd about them.
    pub fn agrees(&self, other: &Facts) -> bool {
        let steps = self.resolution.iter().zip(other.resolution);
        let mut steps_agree = steps.map(|(a, b)| *a <= 2.0 * b && b <= 2.0 * *a);
        self.differences(other).is_empty() && steps_agree.all(|same| same)
    }

    /// What rows that are read by either differ in.
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

    /// What is said where rows were read by these, and all of them together say otherwise.
    pub fn contradicted_by(&self, whole: &Facts) -> Option<Finding> {
        let differ = self.differences(whole);
        (!differ.is_empty()).then(|| {
            Finding::new(
                FindingKind::FirstRowsDiffer,
                format!(
                    "the first rows, by which the recording was read, say otherwise than all of them: {}",
                    differ.join(", ")
                ),
            )
        })
    }
}

/// Follows the rows of a recording.
#[derive(Debug, Clone)]
pub(crate) struct Monitor {
    claims: RecordingClaims,
    facts: Facts,
    channels: Channels,
    cells: CellCounts,
    clock: Option<ClockMonitor>,
    unsigned: Unsigned,
    counted: LooksCounted,
    quiet: QuietBlocks,
    watch: UnitWatch,
    /// Of ax … gz.
    axes: AxisValues<6>,
    temperature: Temperatures,
    /// Magnitudes, where nobody said that it is an accelerometer.
    norms: Option<Thinned<f64, SAMPLE>>,
    defects: Defects,
}

/// What is found, in the order in which it is said.
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

/// What all rows came to.
pub(crate) struct MonitorSummary {
    pub facts: Facts,
    pub timing: Timing,
    /// The first stamp itself, s.
    pub origin_s: Option<f64>,
    /// Why the accelerometer's unit is not known.
    pub unit_doubt: Option<UnitDoubt>,
    pub found: MonitorFindings,
}

impl Monitor {
    /// By what is claimed, and known already.
    pub fn new(claims: RecordingClaims, facts: Facts) -> Self {
        let channels = claims.channels();
        let stamped = claims.layout.field(Quantity::Time).is_some();
        Monitor {
            facts,
            channels,
            cells: CellCounts::new(channels),
            clock: stamped.then(|| ClockMonitor::new(facts.stamp_reading)),
            unsigned: Unsigned::default(),
            counted: LooksCounted::default(),
            quiet: QuietBlocks::default(),
            watch: UnitWatch::default(),
            axes: AxisValues::default(),
            temperature: Temperatures::default(),
            norms: claims.layout.guessed.then(Thinned::default),
            defects: Defects::new(
                facts.accel,
                facts.zero_offset,
                facts.resolution,
                facts.gyro.filter(|_| channels.gyro),
            ),
            claims,
        }
    }

    /// A row as it stands in the file, and with its cells filled; the line it stands in,
    /// and what parts it from the row before.
    #[inline]
    pub fn see(
        &mut self,
        raw: &Values,
        values: &Values,
        line: u64,
        parting: Option<Parting>,
    ) -> RowTime {
        self.cells.see(raw, line);
        self.unsigned
            .see([raw[ACCEL], raw[ACCEL + 1], raw[ACCEL + 2]]);
        let offset = self.facts.zero_offset;
        let accel = [values[ACCEL], values[ACCEL + 1], values[ACCEL + 2]].map(|v| v - offset);
        self.quiet.push(accel);
        self.watch.see(accel, line);
        if let Some(norms) = &mut self.norms {
            norms.push_with(|| accel.iter().map(|v| v * v).sum::<f64>().sqrt());
        }
        let rate = [values[GYRO], values[GYRO + 1], values[GYRO + 2]];
        if self.channels.gyro {
            self.counted.see(rate);
        }
        let ([ax, ay, az], [gx, gy, gz]) = (accel, rate);
        self.axes.see([ax, ay, az, gx, gy, gz]);
        if self.channels.temperature {
            self.temperature.see(values[TEMPERATURE]);
        }
        self.defects.see(values, line);
        self.see_time(raw, line, parting)
    }

    /// The time of a row, of which all else is known.
    #[inline]
    pub fn see_time(&mut self, raw: &Values, line: u64, parting: Option<Parting>) -> RowTime {
        match &mut self.clock {
            Some(clock) => clock.see(raw[TIME], line, parting),
            None => RowTime::UNKNOWN,
        }
    }

    /// What makes time of the next stamp.
    pub fn follower(&self) -> Option<Follower> {
        self.clock.as_ref()?.follower()
    }

    /// Goes on by another one.
    pub fn follow(&mut self, follower: Option<Follower>) {
        if let (Some(clock), Some(follower)) = (&mut self.clock, follower) {
            clock.follow(follower);
        }
    }

    /// Counts of cells so far.
    pub fn cells(&self) -> &CellCounts {
        &self.cells
    }

    /// Steps of ax … gz.
    pub fn resolution(&self) -> [f64; 6] {
        let [a, b, c] = self.axes.resolution(0);
        let [d, e, f] = match self.channels.gyro {
            true => self.axes.resolution(3),
            false => [0.0; 3],
        };
        [a, b, c, d, e, f]
    }

    /// What was found, after the last row, but for the [resolution](Self::resolution).
    /// Stamps that wrap or start anew were made to go
    /// on, or kept.
    pub fn finish(&self, treatment: Treatment) -> MonitorSummary {
        let mut found = MonitorFindings::default();
        let options = &self.claims.options;
        let unsigned = options.zero_offset.is_none() && self.unsigned.is_so();
        if unsigned {
            found.channels.push(Finding::new(
                FindingKind::UnsignedCounts,
                "unsigned 16-bit values around 32768: that is subtracted; the range is not known",
            ));
        }
        let celsius =
            !self.channels.temperature || self.temperature.is_celsius(&mut found.channels);
        let span_c = if celsius {
            self.temperature.span_c()
        } else {
            0.0
        };
        let clock_claims = self.claims.clock(span_c);
        let (timing, stamp_reading, origin_s) = match &self.clock {
            Some(clock) => {
                let kept = clock.finish(&clock_claims, treatment, &mut found.clock);
                (kept.timing, kept.stamp_reading, kept.origin_s)
            }
            None => (untimed(self.cells.rows(), &clock_claims), None, None),
        };
        if timing.rate_hz().is_none() && self.cells.rows() >= LEAST_ROWS {
            found.clock.push(Finding::new(
                FindingKind::RateUnknown,
                format!(
                    "no time stamps and no --rate: stills are looked for as at {} Hz",
                    Recording::ASSUMED_RATE_HZ
                ),
            ));
        }
        found.cells = self.cells.finding(&self.facts.cells);
        let quiet = self.quiet.finish();
        let (accel, unit_doubt) = decide_accel(
            quiet.map(|q| (q.norm, q.integers)),
            unsigned,
            self.claims.layout.accel_claim,
            options,
            &mut found.unit,
        );
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
                accel,
                gyro: self
                    .channels
                    .gyro
                    .then(|| self.claims.gyro_scale(self.counted)),
                resolution: self.facts.resolution,
                celsius,
            },
            timing,
            origin_s,
            unit_doubt,
            found,
        }
    }

    /// Of what was found about the `clock` keeps what concerns stamps that stay as they
    /// stand in the file.
    pub fn keep_stamps(&self, clock: &mut Vec<Finding>) {
        if self.facts.stamp_reading.is_some() {
            clock.clear();
        }
        clock.retain(|f| {
            matches!(
                f.kind,
                FindingKind::FrozenTime | FindingKind::TimeUnitUnknown
            )
        });
        if let Some(keeper) = &self.clock {
            keeper.report(Treatment::Kept, clock);
        }
    }

    /// Columns that were taken for an accelerometer by their numbers alone and do
    /// not behave like one: gravity never leaves an accelerometer, so that its
    /// magnitude at rest and in motion are alike.
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
    fn see(&mut self, value: f64) {
        self.low = self.low.min(value);
        self.high = self.high.max(value);
        self.some.push_with(|| value);
    }

    fn span_c(&self) -> f64 {
        (self.high - self.low).max(0.0)
    }

    /// Raw counts of a temperature are no °C.
    fn is_celsius(&self, findings: &mut Vec<Finding>) -> bool {
        is_celsius(self.some.items(), findings)
    }
}

/// Refuses rows whose unit changed among them, unless the user says that it did not.
///
/// # Errors
///
/// `unit-changed` (input), with the line.
pub(crate) fn refuse_unit_change(
    found: &MonitorFindings,
    options: &ReadOptions,
    name: &str,
) -> Result<()> {
    let changed = |f: &&Finding| f.kind == FindingKind::UnitChanged;
    let Some(finding) = found.unit.iter().find(changed) else {
        return Ok(());
    };
    let line = finding.lines.first().map_or(0, |l| l[0]);
    match options.accel_unit {
        Some(_) => Ok(()),
        None => Err(Error::input("unit-changed", finding.message.clone())
            .at(Path::new(name), Some(line))
            .with_hint(format!(
                "cut the file in front of line {line}, and give each part on its own; --accel-unit UNIT takes all rows in one unit all the same"
            ))),
    }
}

/// Raw counts of a temperature are no °C.
pub(crate) fn is_celsius(temperature: &[f64], findings: &mut Vec<Finding>) -> bool {
    let some = temperature.iter().copied().filter(|t| t.is_finite());
    let Some(middle) = median(&mut some.collect::<Vec<f64>>()) else {
        return true;
    };
    let fits = POSSIBLE_C.contains(&middle);
    if !fits {
        findings.push(Finding::new(
            FindingKind::TemperatureUnit,
            format!(
                "the temperature column is around {middle:.0}: no °C (raw counts?); it is not used"
            ),
        ));
    }
    fits
}

/// The gyroscope's unit before any turn has been looked at.
pub(crate) fn gyro_by_claim(
    counted: LooksCounted,
    layout: &Layout,
    options: &ReadOptions,
) -> GyroScale {
    let given = options.gyro_unit.map(|unit| (unit, Origin::Given));
    let claimed = layout.gyro_claim.map(|unit| (unit, Origin::Header));
    let seen = match counted.is_so() {
        true => (GyroUnit::Counts, Origin::Data),
        false => (GyroUnit::Unknown, Origin::Assumed),
    };
    let (unit, origin) = given.or(claimed).unwrap_or(seen);
    GyroScale {
        unit,
        lsb_per_deg_s: options
            .gyro_range_deg_s
            .map(|range| 32768.0 / range)
            .or(layout.gyro_lsb_per_deg_s),
        origin,
    }
}
