//! `.gt3x` files: simulated ones against the truth, and damaged ones.

use gravical::recording::{ReadOptions, Recording, read, read_bytes, read_head};
use proptest::prelude::*;

use crate::gt3x::{Coding, activity, archive, info, parameters, record};
use crate::support::{finding, kinds};

/// 2024-03-01 08:00.
const START: u32 = 1_709_280_000;
const RATE: u32 = 30;

fn read_gt3x(bytes: &[u8]) -> Recording {
    let recording = read_bytes(bytes, "wrist.gt3x", &ReadOptions::default()).unwrap();
    assert!(recording.ledger.balances(), "{}", recording.ledger.sum());
    recording
}

/// Why a file is refused.
fn refusal(bytes: &[u8]) -> (&'static str, String) {
    let error = read_bytes(bytes, "wrist.gt3x", &ReadOptions::default()).unwrap_err();
    (error.code(), error.to_string())
}

/// A second of samples at a slowly turning rest, in counts.
fn second(number: u32, rate: u32, counts_per_g: f64) -> Vec<[i16; 3]> {
    let sample = |i: u32| {
        let angle = f64::from(number / 20);
        let noise = f64::from((number * rate + i) * 7 % 5) - 2.0;
        [angle.sin(), angle.cos() * 0.8, angle.cos() * 0.6]
            .map(|g| (g * counts_per_g + noise).round() as i16)
    };
    (0..rate).map(sample).collect()
}

/// Records of a device at 256 counts per g.
fn records(coding: Coding, seconds: u32) -> Vec<Vec<u8>> {
    let one = |n| activity(coding, START + n, &second(n, RATE, 256.0));
    (0..seconds).map(one).collect()
}

/// The file of these records.
fn file(records: &[Vec<u8>]) -> Vec<u8> {
    let mut log = record(
        6,
        START - 60,
        br#"{"MetadataType":"Bio","SubjectName":"a"}"#,
    );
    log.extend(parameters(START - 60, 256.0));
    log.extend(records.concat());
    let info = info("MOS2D12345678", RATE, "");
    archive(&[("log.bin", &log), ("info.txt", info.as_bytes())])
}

/// Where the first of these records begins in `log.bin`, as a file has it.
fn before() -> usize {
    record(6, 0, br#"{"MetadataType":"Bio","SubjectName":"a"}"#).len() + parameters(0, 256.0).len()
}

/// Absolute times of the rows, s since 1970.
fn times_s(recording: &Recording) -> Vec<f64> {
    let origin_s = recording.time_origin_s.unwrap();
    let times = recording.time_s.as_ref().unwrap();
    times.iter().map(|t| t + origin_s).collect()
}

/// The rows are these seconds of samples, at their times.
fn assert_is(recording: &Recording, seconds: impl Iterator<Item = u32>, rate: u32, scale: f64) {
    let truth: Vec<_> = seconds
        .flat_map(|n| {
            let samples = second(n, rate, scale).into_iter().zip(0..);
            samples.map(move |(s, i)| (f64::from(START + n) + f64::from(i) / f64::from(rate), s))
        })
        .collect();
    assert_eq!(recording.rows(), truth.len());
    let times = times_s(recording);
    for (i, (time_s, counts)) in truth.iter().enumerate() {
        for (axis, count) in counts.iter().enumerate() {
            let g = f64::from(*count) / scale;
            assert_eq!(recording.accel[axis][i], g, "row {i} axis {axis}");
        }
        assert!(
            (times[i] - time_s).abs() < 1e-6,
            "row {i}: {} and {time_s}",
            times[i]
        );
    }
}

#[test]
fn samples_and_times_are_the_true_ones() {
    for coding in [Coding::Packed, Coding::Plain] {
        let recording = read_gt3x(&file(&records(coding, 200)));
        assert_is(&recording, 0..200, RATE, 256.0);
        assert_eq!(
            recording.description,
            "ActiGraph wGT3XBT, nominal 30 Hz, ±8 g, firmware 1.9.2"
        );
        assert_eq!(recording.serial.as_deref(), Some("MOS2D12345678"));
        assert_eq!(recording.accel_scale.unit.name(), "g");
        assert!((recording.timing.mean_rate_hz.unwrap() - 30.0).abs() < 1e-6);
        assert!(recording.breaks.is_empty(), "{:?}", kinds(&recording));
        assert!(recording.gyro.is_none() && recording.temperature_c.is_none());
    }
}

/// A scale that is no power of two, an odd number of samples in a second, and the order of members.
#[test]
fn the_scale_is_that_of_the_file_or_of_the_serial_number() {
    for (serial, more, scale) in [
        ("TAS1H30182785", "Acceleration Scale: 200.5\r\n", 200.5),
        ("NEO1C16110020", "", 341.0),
        ("MOS2D12345678", "", 256.0),
        ("TAS1H30182785", "Acceleration Scale: 341,0\r\n", 341.0),
    ] {
        let one = |n| activity(Coding::Packed, START + n, &second(n, 25, scale));
        let log: Vec<u8> = (0..60).flat_map(one).collect();
        let info = info(serial, 25, more);
        let members: [(&str, &[u8]); 2] = [("info.txt", info.as_bytes()), ("LOG.BIN", &log)];
        assert_is(&read_gt3x(&archive(&members)), 0..60, 25, scale);
    }
    let info = info("TAS1H30182785", 25, "");
    let log = activity(Coding::Packed, START, &second(0, 25, 256.0));
    let (code, text) = refusal(&archive(&[
        ("info.txt", info.as_bytes()),
        ("log.bin", &log),
    ]));
    assert!(
        code == "header-incomplete" && text.contains("scale"),
        "{text}"
    );
}

#[test]
fn a_file_is_recognised_by_its_content_and_unpacked() {
    let bytes = file(&records(Coding::Plain, 60));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("anything.csv");
    std::fs::write(&path, &bytes).unwrap();
    assert_is(
        &read(&path, &ReadOptions::default()).unwrap(),
        0..60,
        RATE,
        256.0,
    );
    let mut gz = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    std::io::Write::write_all(&mut gz, &bytes).unwrap();
    let packed = gz.finish().unwrap();
    assert_is(&read_gt3x(&packed), 0..60, RATE, 256.0);
    // Without its end, which is behind all of the archive.
    let cut = read_gt3x(&packed[..packed.len() - 4]);
    assert_is(&cut, 0..60, RATE, 256.0);
    // The first 256 KiB of a longer one end with a whole record.
    std::fs::write(&path, file(&records(Coding::Plain, 2000))).unwrap();
    let head = read_head(&path, &ReadOptions::default()).unwrap();
    assert!(head.ledger.lines == head.ledger.rows && head.rows().is_multiple_of(30));
    assert!(
        (1300..2000).contains(&(head.rows() / 30)),
        "{}",
        head.rows()
    );
}

#[test]
fn sleep_is_a_gap_and_never_filled() {
    let mut seconds = records(Coding::Packed, 120);
    // Sleep begins and ends, and the device is docked.
    seconds[30] = record(3, START + 30, &[8]);
    seconds[89] = record(3, START + 89, &[9]);
    seconds.drain(31..89);
    seconds.push(record(0, START + 130, &[0]));
    seconds.insert(5, record(2, START + 5, &4100_u16.to_le_bytes()));
    let recording = read_gt3x(&file(&seconds));
    assert_is(&recording, (0..30).chain(90..120), RATE, 256.0);
    assert_eq!(recording.breaks, [30 * 30]);
    let missing = &finding(&recording, "missing-blocks").message;
    assert!(
        missing.starts_with("60 seconds missing") && missing.contains("61.0 s after"),
        "{missing}"
    );
    assert!(
        finding(&recording, "other-records")
            .message
            .starts_with("1 record without samples")
    );
    assert!(
        recording.description.ends_with("battery 4.10 to 4.10 V"),
        "{}",
        recording.description
    );
}

#[test]
fn a_clock_that_was_set_begins_anew() {
    // An hour back, years back, and a single stamp far ahead.
    for (other, far) in [
        (START - 3600, false),
        (946_684_800, false),
        (START + 60, true),
    ] {
        let mut seconds = records(Coding::Plain, 60);
        if far {
            let ahead = activity(Coding::Plain, u32::MAX - 1, &second(60, RATE, 256.0));
            seconds.push(ahead);
        }
        let later = (0..60).map(|n| activity(Coding::Plain, other + n, &second(n, RATE, 256.0)));
        seconds.extend(later);
        let recording = read_gt3x(&file(&seconds));
        assert_eq!(recording.rows(), (120 + usize::from(far)) * 30);
        assert!(!kinds(&recording).contains(&"late-block"));
        assert_eq!(recording.breaks.len(), 1 + usize::from(far));
    }
}

#[test]
fn damage_is_named_and_the_rest_is_read() {
    for coding in [Coding::Packed, Coding::Plain] {
        let clean = records(coding, 60);
        let length = clean[0].len();
        let mut damaged = clean.clone();
        // A changed sample, a changed size, a lost separator, zeros and noise between records.
        damaged[10][50] ^= 1;
        damaged[20][6] ^= 0x7f;
        damaged[30][0] = 0;
        damaged[40].splice(0..0, [0; 7]);
        damaged[50].splice(0..0, [1, 0x1e, 3, 0x1e, 4]);
        // Repeated, late, of an unknown kind, and cut off.
        damaged.insert(46, clean[44].clone());
        damaged.insert(46, clean[45].clone());
        damaged.insert(5, record(27, START + 5, &[1, 2, 3]));
        damaged.push(clean[0][..length / 2].to_vec());
        let recording = read_gt3x(&file(&damaged));
        assert_is(
            &recording,
            (0..60).filter(|n| ![10, 20, 30].contains(n)),
            RATE,
            256.0,
        );
        assert_eq!(recording.ledger.lines, 57 * 30 + 7);
        assert_eq!(recording.breaks, [10 * 30, 19 * 30, 28 * 30]);
        let message = |kind: &str| finding(&recording, kind).message.clone();
        let corrupt = message("corrupt-block");
        // Two records before the first second, and one of an unknown kind.
        let byte = before() + 10 * length + record(27, 0, &[1, 2, 3]).len();
        assert!(
            corrupt.starts_with("5 blocks")
                && corrupt.contains(&format!("record 14 at byte {byte}: wrong checksum")),
            "{corrupt}"
        );
        assert!(message("repeated-block").starts_with("1 block"));
        assert!(message("late-block").starts_with("1 block"));
        assert!(message("other-records").contains("1 record of kind 27"));
    }
}

#[test]
fn an_archive_that_would_fill_the_memory_is_refused() {
    let info = info("MOS2D12345678", RATE, "Acceleration Scale: 256.0\r\n");
    let zeros = vec![0; 20 << 20];
    let (_, text) = refusal(&archive(&[
        ("log.bin", &zeros),
        ("info.txt", info.as_bytes()),
    ]));
    assert!(text.contains("more than 200 times its size"), "{text}");
}

#[test]
fn other_archives_are_refused_by_name() {
    let info = info("NEO1C16110020", 30, "");
    let info = ("info.txt", info.as_bytes());
    for (bytes, code, words) in [
        (
            archive(&[("activity.bin", b"\0"), info]),
            "old-gt3x",
            "before 3.0",
        ),
        (
            archive(&[("table.csv", b"1,2,3\n"), info]),
            "is-an-archive",
            "ZIP archive",
        ),
        (
            b"PK\x03\x04 and no more".to_vec(),
            "unreadable",
            "copy the file again",
        ),
        (
            archive(&[("log.bin", b"\x1e"), ("info.txt", b"Firmware: 1\n")]),
            "header-incomplete",
            "CSV",
        ),
    ] {
        let error = read_bytes(&bytes, "x.gt3x", &ReadOptions::default()).unwrap_err();
        let text = format!("{error} {}", error.hint().unwrap_or_default());
        assert!(
            error.code() == code && text.contains(words),
            "{}: {text}",
            error.code()
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Whatever happens to the records, each second is read or missing, and nothing else is read.
    #[test]
    fn changed_records_are_skipped(
        flips in prop::collection::vec((0..20_usize, any::<usize>(), 1..=255_u8), 0..6),
        cut in 0..2000_usize,
    ) {
        let mut seconds = records(Coding::Packed, 20);
        let mut changed = std::collections::BTreeSet::new();
        for (second, at, bits) in flips {
            // Another flip may restore the checksum.
            if changed.insert(second) {
                let at = at % seconds[second].len();
                seconds[second][at] ^= bits;
            }
        }
        let length = seconds.concat().len();
        let mut log = seconds.concat();
        log.truncate(length - cut);
        if let Ok(recording) = read_bytes(&file(&[log]), "x.gt3x", &ReadOptions::default()) {
            prop_assert!(recording.ledger.balances());
            let rows = recording.rows();
            let whole = (length - cut) / (length / 20);
            let intact = (0..whole).filter(|n| !changed.contains(n)).count();
            prop_assert_eq!(rows, 30 * intact);
        }
    }

    /// No bytes in an archive, and no archive, stop the reader.
    #[test]
    fn any_bytes_are_read_or_refused(
        noise in prop::collection::vec(any::<u8>(), 0..3000),
        at in any::<usize>(),
        bits in any::<u8>(),
    ) {
        let name = "x.gt3x";
        let mut sprinkled = noise.clone();
        sprinkled.iter_mut().step_by(37).for_each(|byte| *byte = 0x1e);
        for log in [noise, sprinkled] {
            let bytes = file(&[log]);
            if let Ok(recording) = read_bytes(&bytes, name, &ReadOptions::default()) {
                prop_assert!(recording.ledger.balances());
            }
            let mut bytes = file(&records(Coding::Plain, 10));
            let at = at % bytes.len();
            bytes[at] ^= bits;
            let _ = read_bytes(&bytes, name, &ReadOptions::default());
            bytes.truncate(at);
            let _ = read_bytes(&bytes, name, &ReadOptions::default());
        }
    }
}
