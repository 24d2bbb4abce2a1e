//! `.cwa` files: real ones against their reference, simulated ones against the truth, and damaged
//! ones.

use std::path::Path;

use gravical::calibration_file::Grade;
use gravical::convert::{ConvertOptions, convert_file};
use gravical::poses::sections::parse_sections;
use gravical::poses::{SegmentOptions, segment};
use gravical::recording::{ReadOptions, Recording, read, read_bytes, read_samples};
use proptest::prelude::*;

use crate::cwa::{Coding, Counts, Device, seal};
use crate::support::{calibrated, close, data, finding, kinds, with_gravity};
use crate::wear::{self, Wear};

fn read_cwa(bytes: &[u8]) -> Recording {
    read_bytes(bytes, "wrist.cwa", &ReadOptions::default()).unwrap()
}

/// Absolute times of the rows, s since 1970.
fn times_s(recording: &Recording) -> Vec<f64> {
    let origin_s = recording.clock.start_s.unwrap();
    let times = recording.time_s.as_ref().unwrap();
    times.iter().map(|t| t + origin_s).collect()
}

/// Every channel of a row, in the order of the file.
fn row(recording: &Recording, i: usize) -> Vec<f64> {
    let gyro = recording.gyro.iter().flatten();
    let channels = recording.accel.iter().chain(gyro);
    channels.map(|c| c[i]).collect()
}

/// Blocks of a worn device.
fn worn(coding: Coding, blocks: usize) -> (Device, Vec<[u8; 512]>) {
    let mut device = Device::new(coding);
    let mut wear = Wear::new(&device, 20.0..60.0, 7);
    let blocks = (0..blocks).map(|_| wear.block(&mut device)).collect();
    (device, blocks)
}

fn file(device: &Device, blocks: &[[u8; 512]]) -> Vec<u8> {
    let mut bytes = device.header();
    blocks.iter().for_each(|block| bytes.extend(block));
    bytes
}

#[test]
fn real_files_have_the_samples_and_times_of_another_decoder() {
    let ax3 = "Axivity AX3, session 1020030004, nominal 200 Hz, ±8 g";
    let ax6 = "Axivity AX6, session 0, nominal 100 Hz, ±16 g, ±2000 °/s";
    let Some(data) = data() else { return };
    for (name, rate_hz, device, words) in
        [("ax3", 197.2, "51888", ax3), ("ax6", 98.4, "6011802", ax6)]
    {
        let file = |end: &str| data.join(format!("skdh-axivity/{name}_{end}"));
        let recording = read(file("sample.cwa"), &ReadOptions::default()).unwrap();
        let packed = std::fs::File::open(file("decoded.csv.gz")).unwrap();
        let text = std::io::read_to_string(flate2::read::GzDecoder::new(packed)).unwrap();
        let mut lines = text.lines().skip(1);
        let times = times_s(&recording);
        for (i, time) in times.iter().enumerate() {
            let cells = lines.next().unwrap().split(',');
            let cells: Vec<f64> = cells.map(|cell| cell.parse().unwrap()).collect();
            let (t, samples) = (cells[0], &cells[1..cells.len() - 1]);
            assert!((time - t).abs() < 0.02, "{name} row {i}: {time} and {t}");
            let own = row(&recording, i);
            assert_eq!(own.len(), samples.len());
            for (a, b) in own.iter().zip(samples) {
                // Six or seven digits are written; a count is far larger.
                let tolerance = 1e-6_f64.max(b.abs() * 1e-6);
                assert!((a - b).abs() <= tolerance, "{name} row {i}: {a} and {b}");
            }
            // By another formula of the same counts: 0.318269 raw − 54.424.
            let raw = (recording.temperature_c.as_ref().unwrap()[i] + 50.0) * 256.0 / 75.0;
            let theirs = cells[cells.len() - 1];
            close(0.318_269 * raw - 54.424, theirs, 0.006);
        }
        assert_eq!(lines.next(), None);
        close(recording.clock.mean_rate_hz.unwrap(), rate_hz, 0.1);
        assert_eq!(recording.format.serial().as_deref(), Some(device));
        let description = &recording.format.describe();
        assert!(description.starts_with(words), "{description}");
        let units = (recording.units.accel.unit.name(), recording.breaks.len());
        assert_eq!(units, ("g", 0));
    }
}

/// The example of the documents: three minutes of a worn device.
#[test]
fn the_example_is_what_is_written_here() {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/simulated-wear/wrist.cwa");
    let mut device = Device {
        true_rate_hz: 100.0,
        ..Device::new(Coding::Packed)
    };
    let mut wear = Wear::new(&device, 5.0..30.0, 1);
    let blocks: Vec<_> = (0..150).map(|_| wear.block(&mut device)).collect();
    assert!(std::fs::read(path).unwrap() == file(&device, &blocks));
}

#[test]
fn samples_times_and_temperatures_are_the_true_ones() {
    for coding in [Coding::Packed, Coding::Plain, Coding::WithGyro] {
        let mut device = Device::new(coding);
        let mut wear = Wear::new(&device, 20.0..60.0, 3);
        let (mut blocks, mut truth) = (Vec::new(), Vec::new());
        for _ in 0..100 {
            let (raw, celsius) = (wear.temperature(), wear.temperature_c());
            let samples: Vec<Counts> = (0..coding.samples())
                .map(|_| wear.next(&device, celsius))
                .collect();
            blocks.push(device.block(&samples, raw));
            truth.extend(samples.iter().map(|s| (*s, celsius)));
        }
        let recording = read_cwa(&file(&device, &blocks));
        assert_eq!(recording.rows(), truth.len());
        let times = times_s(&recording);
        for (i, (counts, celsius)) in truth.iter().enumerate() {
            let scale = |axis: usize| match axis {
                0..3 => device.accel_g(),
                _ => device.gyro_deg_s(),
            };
            for (axis, own) in row(&recording, i).into_iter().enumerate() {
                assert_eq!(
                    own,
                    f64::from(counts[axis]) * scale(axis),
                    "{coding:?} row {i}"
                );
            }
            close(times[i], device.time_s(i as u64), 1e-4);
            // The converter has 0.3 °C.
            close(recording.temperature_c.as_ref().unwrap()[i], *celsius, 0.15);
        }
        close(
            recording.clock.mean_rate_hz.unwrap(),
            device.true_rate_hz,
            0.01,
        );
        assert_eq!(recording.units.accel.unit.name(), "g");
        let gyro = recording.units.gyro.map(|g| g.unit.name());
        assert_eq!(gyro.is_some(), coding == Coding::WithGyro);
        assert!(gyro.is_none_or(|unit| unit == "deg/s"), "{gyro:?}");
        assert!(recording.breaks.is_empty(), "{:?}", kinds(&recording));
    }
}

#[test]
fn damage_is_named_and_the_rest_is_read_in_its_own_time() {
    let (device, blocks) = worn(Coding::Packed, 60);
    let mut damaged = blocks.clone();
    // Block 51 twice more, out of order.
    damaged.insert(55, blocks[50]);
    // Block 41 twice.
    damaged.insert(40, blocks[40]);
    // Block 31 changed, blocks 11 and 12 missing.
    damaged[30][100] ^= 1;
    damaged.drain(10..12);
    // Never written, and cut off.
    damaged.push([0xff; 512]);
    damaged.push(blocks[0]);
    let mut bytes = file(&device, &damaged);
    bytes.truncate(bytes.len() - 100);
    let recording = read_cwa(&bytes);
    assert_eq!(recording.rows(), 57 * 120);
    // A line is a sample or a skipped block.
    assert_eq!(recording.ledger.lines, 57 * 120 + 5);
    assert_eq!(recording.breaks, [10 * 120, 28 * 120]);
    let found = recording.findings.iter();
    let of_blocks: Vec<&str> = found
        .filter(|f| f.kind == "corrupt-block")
        .map(|f| &*f.message)
        .collect();
    let places = [
        "damaged; skipped, first: block 29 at byte 15360: wrong checksum",
        "not later than the one before (repeated or out of order); skipped, first: block 40 at byte 20992",
    ];
    assert_eq!(of_blocks.len(), places.len());
    for (said, place) in of_blocks.into_iter().zip(places) {
        let is_it = said.starts_with(&format!("2 blocks: {place}"));
        assert!(is_it, "{said}");
    }
    finding(&recording, "gap");
    // Rows keep the time of their sample.
    let times = times_s(&recording);
    let expected = (0..60_u64).filter(|block| ![10, 11, 30].contains(block));
    let expected = expected.flat_map(|block| block * 120..(block + 1) * 120);
    for (time, k) in times.iter().zip(expected) {
        close(*time, device.time_s(k), 1e-3);
    }
}

#[test]
fn a_pause_is_no_slow_sample() {
    let mut device = Device::new(Coding::Plain);
    let mut wear = Wear::new(&device, 20.0..60.0, 5);
    let mut blocks: Vec<_> = (0..20).map(|_| wear.block(&mut device)).collect();
    // The device loses 0.6 s, but no number.
    device.samples += 59;
    blocks.extend((0..20).map(|_| wear.block(&mut device)));
    let recording = read_cwa(&file(&device, &blocks));
    assert_eq!(recording.breaks, [20 * 80]);
    finding(&recording, "gap");
    let times = times_s(&recording);
    let steps = times.windows(2).map(|w| w[1] - w[0]);
    let long: Vec<f64> = steps.filter(|s| *s > 0.0105).collect();
    assert_eq!(long.len(), 1, "{long:?}");
    close(long[0], 60.0 / 98.4, 1e-3);
}

#[test]
fn another_session_and_a_clock_that_was_set_back_begin_anew() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wrist.cwa");
    let (device, blocks) = worn(Coding::Packed, 20);
    for (session, later_s) in [(18, 3600.0), (device.session, -86_400.0)] {
        let mut other = Device {
            session,
            start_s: device.start_s + later_s,
            ..Device::new(Coding::Packed)
        };
        let mut wear = Wear::new(&other, 20.0..60.0, 8);
        let mut all = blocks.clone();
        all.extend((0..20).map(|_| wear.block(&mut other)));
        let bytes = file(&device, &all);
        let recording = read_cwa(&bytes);
        assert_eq!(recording.rows(), 40 * 120);
        assert_eq!(recording.breaks, [20 * 120]);
        assert!(!kinds(&recording).contains(&"corrupt-block"));
        assert!(kinds(&recording).contains(&"restarted-time") || later_s > 0.0);
        // Dates are those of the stamps.
        std::fs::write(&path, &bytes).unwrap();
        let options = ConvertOptions {
            absolute_time: true,
            ..ConvertOptions::default()
        };
        let mut table = Vec::new();
        convert_file(&path, &ReadOptions::default(), &options, &mut table).unwrap();
        let table = String::from_utf8(table).unwrap();
        let cells = table.lines().filter_map(|line| line.split(',').next());
        let times: Vec<f64> = cells.filter_map(|cell| cell.parse().ok()).collect();
        for (row, time_s) in [
            (0, device.time_s(0)),
            (20 * 120 - 1, device.time_s(20 * 120 - 1)),
            (20 * 120, other.time_s(0)),
            (40 * 120 - 1, other.time_s(20 * 120 - 1)),
        ] {
            close(times[row], time_s, 1e-3);
        }
    }
}

/// Of more than 2²⁰ samples, means of 39 at 98.4 Hz; across a gap there is none.
#[test]
fn a_long_file_is_held_as_means_of_its_samples() {
    let (device, mut blocks) = worn(Coding::Packed, 9000);
    blocks.drain(4000..4002);
    let bytes = file(&device, &blocks);
    let means = read_cwa(&bytes);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wrist.cwa");
    std::fs::write(&path, &bytes).unwrap();
    let samples = read_samples(&path, &ReadOptions::default()).unwrap();
    assert!(means.is_averaged() && !samples.is_averaged());
    assert_eq!(samples.rows(), 8998 * 120);
    let [before, after] = [4000 * 120 / 39, 4998 * 120 / 39];
    assert_eq!(means.rows(), before + after);
    assert_eq!(means.breaks, [before]);
    let averaged = &finding(&means, "samples-averaged").message;
    assert!(averaged.contains("of 39 neighbours"), "{averaged}");
    let (times, all) = (times_s(&means), times_s(&samples));
    for (row, first) in [
        (0, 0),
        (777, 777 * 39),
        (before, 4000 * 120),
        (before + 9, 4000 * 120 + 351),
    ] {
        let mean = |values: &[f64]| values[first..first + 39].iter().sum::<f64>() / 39.0;
        assert_eq!(means.line(row), samples.line(first));
        close(times[row], mean(&all), 1e-5);
        close(means.accel[1][row], mean(&samples.accel[1]), 1e-12);
    }
    close(
        means.clock.rate_hz().unwrap(),
        device.true_rate_hz / 39.0,
        1e-3,
    );
    // Numbers of rows are those of samples to whoever gives them.
    let options = SegmentOptions {
        sections: Some(parse_sections(b"+x,0,100\n").unwrap()),
        ..SegmentOptions::default()
    };
    assert_eq!(segment(&[means], &options).unwrap_err().code(), "averaged");
}

sampled! {
    wear_in_a_file_calibrates_the_sensor(6.0, 14.0);
}

/// Half a day in a file: offset, gain and drift of the sensor are those of the simulation.
fn wear_in_a_file_calibrates_the_sensor(hours: f64) {
    let mut device = Device::new(Coding::Plain);
    let mut wear = Wear::new(&device, 20.0..200.0, 11);
    let blocks = (hours * 3600.0 * device.true_rate_hz) as usize / Coding::Plain.samples();
    let blocks: Vec<_> = (0..blocks).map(|_| wear.block(&mut device)).collect();
    let recording = read_cwa(&file(&device, &blocks));
    let file = calibrated(&[recording], &with_gravity(9.80665)).calibration;
    let reasons = &file.verdict().reasons;
    assert_eq!(file.verdict().grade, Grade::Good, "{reasons:?}");
    let drift = file.drift.as_ref().unwrap();
    for i in 0..3 {
        let slope = wear::DRIFT_G_PER_C[i];
        close(drift.channels[i].per_c.unwrap(), slope, 3e-5);
        let bias = wear::OFFSET_G[i] + slope * (drift.reference_c - 25.0);
        close(file.accelerometer.bias[i], bias, 5e-4);
        close(file.accelerometer.scale()[i] * 9.80665, wear::GAIN[i], 5e-4);
    }
}

/// Changes a file in one of five ways; true if a field of a block changed under a right checksum.
fn damage(blocks: &mut Vec<[u8; 512]>, (kind, at, to, value): (u8, usize, usize, u8)) -> bool {
    let at = at % blocks.len();
    match kind {
        0 => blocks[at][usize::from(value)] ^= value | 1,
        1 => drop(blocks.remove(at)),
        2 => blocks.insert(to % blocks.len(), blocks[at]),
        3 => blocks[at] = [0xff; 512],
        _ => {
            blocks[at][to] = value;
            seal(&mut blocks[at]);
        }
    }
    kind > 3
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Whatever happens to the blocks of a file, each is read or skipped.
    #[test]
    fn every_block_is_rows_or_was_skipped(
        changes in prop::collection::vec((0..5_u8, 0..30_usize, 0..30_usize, any::<u8>()), 0..8),
        cut in 0..512_usize,
    ) {
        let (device, mut blocks) = worn(Coding::Packed, 30);
        let mut fields_changed = false;
        for change in changes {
            fields_changed |= damage(&mut blocks, change);
        }
        let mut bytes = file(&device, &blocks);
        bytes.truncate((bytes.len() - cut).max(1026));
        if let Ok(recording) = read_bytes(&bytes, "wrist.cwa", &ReadOptions::default()) {
            let skipped = recording.ledger.total();
            let blocks = (bytes.len() - 1024).div_ceil(512);
            if !fields_changed {
                prop_assert_eq!(recording.rows(), 120 * (blocks - skipped));
            }
            let times = recording.time_s.unwrap_or_default();
            prop_assert!(times.iter().all(|t| t.is_finite()));
        }
    }

}
