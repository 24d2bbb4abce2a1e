//! GENEActiv `.bin` files: simulated ones against the truth, and damaged ones.

use gravical::recording::{ReadOptions, Recording, read_bytes, read_head};
use proptest::prelude::*;

use crate::geneactiv_bin::Device;
use crate::support::{finding, kinds};

const PAGE: u32 = 300;

fn read_bin(bytes: &[u8]) -> Recording {
    let recording = read_bytes(bytes, "wrist.bin", &ReadOptions::default()).unwrap();
    assert!(recording.ledger.balances(), "{}", recording.ledger.sum());
    recording
}

/// Counts of sample `k` of a slowly turning rest.
fn counts(k: u32) -> [i16; 3] {
    let angle = f64::from(k / 2000);
    let noise = f64::from(k * 7 % 5) - 2.0;
    [angle.sin(), angle.cos() * 0.8, angle.cos() * 0.6].map(|g| (g * 255.0 + noise).round() as i16)
}

fn celsius(page: u32) -> f64 {
    25.0 + f64::from(page % 80) / 10.0
}

fn pages(device: &Device, count: u32) -> Vec<String> {
    let page = |n: u32| {
        let samples: Vec<_> = (n * PAGE..(n + 1) * PAGE).map(counts).collect();
        device.page(n, u64::from(n * PAGE), celsius(n), &samples)
    };
    (0..count).map(page).collect()
}

fn file(device: &Device, pages: &[String]) -> Vec<u8> {
    let mut text = device.header(pages.len());
    pages.iter().for_each(|page| text.push_str(page));
    text.into_bytes()
}

/// The rows are those of these pages.
fn assert_is(recording: &Recording, device: &Device, pages: impl Iterator<Item = u32>) {
    let truth: Vec<u32> = pages.flat_map(|n| n * PAGE..(n + 1) * PAGE).collect();
    assert_eq!(recording.rows(), truth.len());
    let origin_s = recording.time_origin_s.unwrap();
    let times = recording.time_s.as_ref().unwrap();
    for (i, k) in truth.into_iter().enumerate() {
        let value = recording.accel.each_ref().map(|axis| axis[i]);
        assert_eq!(value, device.in_g(counts(k)), "row {i}");
        // Stamps have milliseconds.
        let time_s = device.start_s + f64::from(k) / device.rate_hz;
        assert!(
            (times[i] + origin_s - time_s).abs() < 2e-3,
            "row {i}: {}",
            times[i]
        );
        assert_eq!(
            recording.temperature_c.as_ref().unwrap()[i],
            celsius(k / PAGE)
        );
    }
}

#[test]
fn samples_times_and_temperatures_are_the_true_ones() {
    for rate_hz in [100.0, 66.7, 30.0] {
        let device = Device {
            rate_hz,
            ..Device::new()
        };
        let recording = read_bin(&file(&device, &pages(&device, 40)));
        assert_is(&recording, &device, 0..40);
        assert_eq!(
            recording.description,
            format!(
                "GENEActiv, nominal {rate_hz} Hz, ±8 g, worn: left wrist, battery 4.12 to 4.12 V"
            )
        );
        assert_eq!(recording.serial.as_deref(), Some("011073"));
        assert_eq!(recording.accel_scale.unit.name(), "g");
        let mean_hz = recording.timing.mean_rate_hz.unwrap();
        assert!((mean_hz - rate_hz).abs() < 1e-3, "{mean_hz}");
        assert!(recording.breaks.is_empty(), "{:?}", kinds(&recording));
    }
}

/// Line ends of another system, decimal commas, no end of the last line; and a packed file.
#[test]
fn other_writings_are_read() {
    let device = Device::new();
    let text = String::from_utf8(file(&device, &pages(&device, 20))).unwrap();
    let commas = |line: &str| match line.starts_with("Temp") || line.starts_with("Batt") {
        true => line.replace('.', ","),
        false => line.to_owned(),
    };
    let lines: Vec<String> = text.lines().map(commas).collect();
    assert_is(&read_bin(lines.join("\n").as_bytes()), &device, 0..20);
    let mut gz = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    std::io::Write::write_all(&mut gz, text.as_bytes()).unwrap();
    assert_is(&read_bin(&gz.finish().unwrap()), &device, 0..20);
}

#[test]
fn the_first_bytes_end_with_a_whole_page() {
    let device = Device::new();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("anything.txt");
    std::fs::write(&path, file(&device, &pages(&device, 200))).unwrap();
    let head = read_head(&path, &ReadOptions::default()).unwrap();
    assert!(head.ledger.lines == head.ledger.rows && head.rows().is_multiple_of(300));
    assert!((60..70).contains(&(head.rows() / 300)), "{}", head.rows());
}

#[test]
fn damage_is_named_and_the_rest_is_read() {
    let device = Device::new();
    let clean = pages(&device, 40);
    let mut damaged = clean.clone();
    // A digit that is none, a line that is lost, and a page whose first line is damaged.
    damaged[5] = damaged[5].replacen("00", "0x", 30);
    damaged[10] = damaged[10].replace("Page Time", "Page#Time");
    damaged[15] = damaged[15].replacen("Recorded", "Recor\0ed", 1);
    // Again, late, and a digit that is missing.
    damaged.insert(36, clean[34].clone());
    damaged.insert(36, clean[35].clone());
    damaged[30] = clean[30].replace("00", "0");
    damaged.drain(20..22);
    // Cut off.
    damaged.push(clean[0][..1000].to_owned());
    let recording = read_bin(&file(&device, &damaged));
    let lost = [5, 10, 15, 20, 21, 30];
    assert_is(&recording, &device, (0..40).filter(|n| !lost.contains(n)));
    assert_eq!(recording.ledger.lines, 34 * 300 + 7);
    assert_eq!(recording.breaks, [5, 9, 13, 17, 25].map(|n| n * 300));
    let message = |kind: &str| finding(&recording, kind).message.clone();
    let corrupt = message("corrupt-block");
    let byte = device.header(damaged.len()).len() + clean[..5].concat().len();
    assert!(
        corrupt.starts_with("5 blocks") && corrupt.contains(&format!("page 6 at byte {byte}:")),
        "{corrupt} {byte}"
    );
    let missing = message("missing-blocks");
    assert!(
        missing.starts_with("2 pages missing by the sequence numbers"),
        "{missing}"
    );
    assert!(message("repeated-block").contains("the one before"));
    assert!(message("late-block").starts_with("1 block"));
}

#[test]
fn a_page_that_lost_samples_is_not_stretched() {
    let device = Device::new();
    let mut all = pages(&device, 20);
    // Ten samples less in the middle, and in the last page, which may be shorter.
    for page in [9, 19] {
        let length = all[page].trim_end().len();
        all[page].replace_range(length - 120..length, "");
    }
    let recording = read_bin(&file(&device, &all));
    assert_eq!(recording.rows(), 18 * 300 + 290);
    assert_eq!(recording.breaks, [9 * 300]);
    assert!(
        finding(&recording, "corrupt-block")
            .message
            .contains("fewer samples")
    );
}

#[test]
fn a_header_without_gains_is_refused() {
    let device = Device::new();
    let text = String::from_utf8(file(&device, &pages(&device, 2))).unwrap();
    for line in ["y gain", "z offset", "Measurement Frequency"] {
        let text = text.replacen(line, "x", 1);
        let error = read_bytes(text.as_bytes(), "x.bin", &ReadOptions::default()).unwrap_err();
        assert_eq!(error.code(), "header-incomplete", "{line}");
        assert!(error.hint().is_some_and(|hint| hint.contains("CSV")));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Whatever happens to the bytes, they are read or skipped.
    #[test]
    fn any_bytes_are_read_or_skipped(
        changes in prop::collection::vec((any::<usize>(), any::<u8>()), 0..20),
        cut in any::<usize>(),
        noise in prop::collection::vec(any::<u8>(), 0..300),
        at in any::<usize>(),
    ) {
        let device = Device::new();
        let mut bytes = file(&device, &pages(&device, 8));
        for (at, value) in changes {
            let at = at % bytes.len();
            bytes[at] = value;
        }
        let at = at % bytes.len();
        bytes.splice(at..at, noise);
        for length in [bytes.len(), cut % bytes.len()] {
            bytes.truncate(length);
            if let Ok(recording) = read_bytes(&bytes, "x.bin", &ReadOptions::default()) {
                prop_assert!(recording.ledger.balances());
                let times = recording.time_s.unwrap_or_default();
                prop_assert!(times.iter().all(|t| t.is_finite()));
            }
        }
    }
}
