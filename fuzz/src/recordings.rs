//! Recordings: what has to hold of any that the reader accepts, and of what
//! segmentation, inspection and calibration make of it.

use gravical::calibrate::{CalibrateOptions, calibrate};
use gravical::calibration_file::Calibration;
use gravical::inspect::inspect;
use gravical::poses::sections::Section;
use gravical::poses::{SegmentOptions, Segmentation, segment};
use gravical::recording::{Finding, ReadOptions, Recording, read_bytes};
use gravical_report::document::Detail;
use gravical_report::{figure, report};

/// Longer inputs only make a run slower.
const MOST: usize = 64 << 10;

/// What an input starts with whose next [`OPTIONS`] bytes choose options; no
/// recording starts so.
const WITH_OPTIONS: u8 = 1;
const OPTIONS: usize = 8;

/// Parts several recordings in such an input.
const NEXT_RECORDING: u8 = 0x1e;

/// Bytes of a recording; or, behind a byte 1, eight bytes that choose options
/// and then up to three recordings with a byte 0x1e between them.
pub fn reader(data: &[u8]) {
    let data = &data[..data.len().min(MOST)];
    match data {
        [WITH_OPTIONS, rest @ ..] if rest.len() >= OPTIONS => {
            let (choice, files) = rest.split_at(OPTIONS);
            with_options(choice, files);
        }
        _ => {
            if let Ok(recording) = read_bytes(data, "fuzzed.csv", &ReadOptions::default()) {
                check_recording(&recording);
                check_session(&[recording], &SegmentOptions::default());
            }
        }
    }
}

fn with_options(choice: &[u8], files: &[u8]) {
    let pick = |at: usize| usize::from(choice.get(at).copied().unwrap_or(0));
    let options = ReadOptions {
        columns: chosen(COLUMNS, pick(0)).and_then(|text| text.parse().ok()),
        accel_unit: serde_json::from_value(chosen(ACCEL_UNITS, pick(1)).into()).unwrap_or_default(),
        gyro_unit: serde_json::from_value(chosen(GYRO_UNITS, pick(1) / 8).into())
            .unwrap_or_default(),
        time_unit: serde_json::from_value(chosen(TIME_UNITS, pick(2)).into()).unwrap_or_default(),
        hash: pick(2) & 0x80 != 0,
        sensor: (pick(1) & 0x80 != 0).then(|| "1".to_owned()),
        rate_hz: number(RATES_HZ, pick(3)),
        accel_range_g: number(RANGES, pick(4)),
        gyro_range_deg_s: number(RANGES, pick(4) / 16),
        zero_offset: number(OFFSETS, pick(5)),
        ..ReadOptions::default()
    };
    let names = match pick(6) / 16 % 4 {
        0 => ["session.csv", "x_axis_neg.csv", "z_rot.csv"],
        1 => ["xplus.txt", "-y.csv.gz", "z_p"],
        2 => ["x_axis.csv", "folder/y.csv", "−z.csv"],
        _ => ["", "/", "ünïcode+.csv"],
    };
    let mut recordings = Vec::new();
    for (name, bytes) in names.iter().zip(files.split(|b| *b == NEXT_RECORDING)) {
        if let Ok(recording) = read_bytes(bytes, name, &options) {
            check_recording(&recording);
            recordings.push(recording);
        }
    }
    let rows = recordings.first().map_or(0, Recording::rows);
    let section = |&(label, from, to): &Stretch| Section {
        label: label.to_owned(),
        rows: rows * from / 100..(rows * to / 100).max(rows * from / 100 + 1),
    };
    let axes = chosen(AXES, pick(7) / 8).and_then(|text| text.parse().ok());
    let options = SegmentOptions {
        sections: SECTIONS[pick(7) % SECTIONS.len()].map(|l| l.iter().map(section).collect()),
        axes: axes.unwrap_or_default(),
    };
    check_session(&recordings, &options);
    for recording in recordings {
        check_session(&[recording], &options);
    }
}

/// One of the texts of a list; `-` is none.
fn chosen(list: &str, at: usize) -> Option<&str> {
    let all: Vec<&str> = list.split(' ').collect();
    Some(all[at % all.len()]).filter(|text| *text != "-")
}

fn number(list: &str, at: usize) -> Option<f64> {
    chosen(list, at)?.parse().ok()
}

const COLUMNS: &str = "- ax,ay,az t,ax,ay,az t,ax,ay,az,gx,gy,gz,temp ax,ay,az,gx,gy,gz \
    _,ax,ay,az,_,label ax,ax,ay,az,t,t ax=x,ay=y,az=z t=t,ax=ax,ay=ay,az=az,gx=gx,gy=gx,gz=gx \
    label=part,ax=ax,ay=ax,az=az";
const ACCEL_UNITS: &str = "- m/s^2 g mg counts unknown";
const GYRO_UNITS: &str = "- rad/s deg/s counts unknown";
const TIME_UNITS: &str = "- s ms us ns";
const RATES_HZ: &str =
    "- 100 62.5 0.5 1e5 1e20 1.7976931348623157e308 2.2250738585072014e-308 5e-324 inf nan 0 -1";
const RANGES: &str = "- 2 16 2000 1.7976931348623157e308 5e-324 0 nan";
const OFFSETS: &str = "- 0 32768 -0.5 1.7976931348623157e308 -1.7976931348623157e308 inf nan";
const AXES: &str = "- x,-z,y z,x,y -x,-y,z";
/// Label, start and end in percent of the rows.
type Stretch = (&'static str, usize, usize);
const SECTIONS: [Option<&[Stretch]>; 5] = [
    None,
    Some(&[("x_p", 0, 100)]),
    Some(&[("x_p", 0, 30), ("x_a", 30, 60), ("x_rot", 60, 100)]),
    Some(&[("pose 7", 50, 20), ("-z", 0, 101)]),
    Some(&[]),
];

fn check_recording(r: &Recording) {
    let rows = r.rows();
    assert!(rows > 0, "a recording without rows");
    assert_eq!(r.ledger.rows(), rows, "{}", r.ledger.sum());

    let gyro = r.gyro.iter().flatten();
    let channels = r.accel.iter().chain(gyro).chain(&r.temperature_c);
    for channel in channels.chain(&r.time_s) {
        assert_eq!(channel.len(), rows);
        let is_infinite = channel.iter().any(|v| v.is_infinite());
        assert!(!is_infinite, "an infinite value");
    }
    assert!(r.accel.iter().flatten().any(|v| v.is_finite()));
    assert!(r.units.zero_offset.is_finite());
    assert_eq!(r.gyro.is_some(), r.units.gyro.is_some());
    if let Some(labels) = &r.labels {
        assert_eq!(labels.of_row.len(), rows);
        let mut of_row = labels.of_row.iter();
        assert!(of_row.all(|i| (*i as usize) < labels.names.len()));
    }

    assert!(r.breaks.windows(2).all(|w| w[0] < w[1]), "{:?}", r.breaks);
    let mut breaks = r.breaks.iter();
    assert!(breaks.all(|b| (1..=rows).contains(b)), "{:?}", r.breaks);
    let mut next = 0;
    for part in r.segments() {
        let follows = part.start == next && part.end > part.start;
        assert!(follows, "{:?}", r.segments());
        next = part.end;
    }
    assert_eq!(next, rows, "segments do not cover the rows");

    let mut before = 0;
    for row in 0..rows {
        let line = r.line(row);
        assert!(line > before, "row {row}: line {line} after {before}");
        before = line;
    }
    assert!(before <= r.ledger.lines as u64);

    let timing = &r.clock;
    let rates = timing.median_rate_hz.into_iter().chain(timing.mean_rate_hz);
    for rate in rates.chain(timing.nominal_rate_hz) {
        assert!(rate > 0.0 && rate.is_finite(), "{timing:?}");
    }
    for length in [timing.duration_s, timing.jitter_s].into_iter().flatten() {
        assert!(length >= 0.0 && length.is_finite(), "{timing:?}");
    }
    if let Some(share) = timing.missing_share {
        assert!((0.0..=1.0).contains(&share), "{timing:?}");
    }
    let gyro = r.units.gyro.and_then(|s| s.nominal());
    for nominal in r.units.accel.nominal().into_iter().chain(gyro) {
        assert!(nominal > 0.0 && nominal.is_finite(), "a scale of {nominal}");
    }
    check_findings(&r.findings, r.ledger.lines as u64);
}

fn check_findings(findings: &[Finding], lines: u64) {
    for finding in findings {
        assert!(!finding.kind.is_empty() && !finding.message.is_empty());
        let mut before = 0;
        for &[from, to] in &finding.lines {
            assert!(before < from && from <= to && to <= lines, "{finding:?}");
            before = to;
        }
    }
}

fn check_session(recordings: &[Recording], options: &SegmentOptions) {
    for recording in recordings {
        let found = inspect(recording, &options.axes);
        let figures = figure::inspection::inspection(&found, recording);
        let report = report::inspection(&found, &figures);
        assert!(!report.to_html().is_empty() && !report.to_text(Detail::Full).is_empty());
    }
    check_segment(recordings, options);
    let options = CalibrateOptions {
        segment: options.clone(),
        ..CalibrateOptions::default()
    };
    if let Ok(calibrated) = calibrate(recordings, &options) {
        let report = report::calibration(&calibrated.calibration, None, &[]);
        assert!(!report.to_text(Detail::Full).is_empty());
        let text = calibrated.calibration.to_json();
        let text = text.unwrap_or_else(|e| unreachable!("calibrated and not writable: {e}"));
        assert!(Calibration::parse(text.as_bytes()).is_ok(), "{text}");
        super::calibration_file(text.as_bytes());
    }
}

fn check_segment(recordings: &[Recording], options: &SegmentOptions) {
    let Ok(found) = segment(recordings, options) else {
        return;
    };
    let Segmentation { poses, noise, .. } = &found;
    for placement in poses {
        let of = recordings.get(placement.recording);
        let of = of.map_or(0, Recording::rows);
        assert!(placement.rows.end <= of, "{placement:?} of {of}");
        let rows = placement.rows.len();
        assert!(rows > 0, "{placement:?}");
        assert!(placement.count <= rows, "{placement:?}");
        let mut mean = placement.mean.iter();
        assert!(mean.all(|m| m.is_finite()), "{placement:?}");
        assert!(placement.clipped <= 3 * rows, "{placement:?}");
        let mut errors = placement.standard_error.iter().flatten();
        let is_error = |e: &f64| *e >= 0.0 && e.is_finite();
        assert!(errors.all(is_error), "{placement:?}");
    }
    assert!(noise.vif >= 1.0, "{noise:?}");
}
