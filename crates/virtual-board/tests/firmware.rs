//! The firmware on the emulated board.
#![cfg(feature = "emulator")]
#![allow(clippy::unwrap_used)] // helpers of a test may panic as it does

mod board;

use board::{Board, board, faulty, line, text};
use gravical::recording::frame::{Frame, SampleFrame, decode_frame};
use gravical::recording::{ReadOptions, read_bytes};
use virtual_board::sensor::{Reading, SensorOptions};

const G: f64 = 9.80665;

/// A reading in counts of the default ranges.
fn counts(reading: &Reading, lsb_per_g: f64, lsb_per_deg_s: f64) -> [i32; 7] {
    let round = |v: f64| v.round() as i32;
    let [ax, ay, az] = reading.accel_mps2.map(|v| round(v / G * lsb_per_g));
    let [gx, gy, gz] = reading.gyro_deg_s.map(|v| round(v * lsb_per_deg_s));
    let temperature = round((reading.temperature_c - 36.53) * 340.0);
    [ax, ay, az, temperature, gx, gy, gz]
}

/// The rows of whole lines.
fn rows(text: &str) -> Vec<Vec<f64>> {
    let end = text.rfind('\n').unwrap_or(0);
    text[..end]
        .lines()
        .filter(|l| l.starts_with(|c: char| c.is_ascii_digit()))
        .map(|l| l.split(',').map(|f| f.parse().unwrap()).collect())
        .collect()
}

fn notices(text: &str) -> Vec<&str> {
    text.lines().filter(|l| l.starts_with('#')).collect()
}

#[test]
fn it_says_what_it_is_and_the_reader_reads_it() {
    let Some(mut board) = board(SensorOptions::default()) else {
        return;
    };
    let text = board.text(6.0);
    let mut lines = text.lines();
    assert_eq!(
        lines.next().unwrap(),
        "# gravical mpu6050_logger 1.0, MPU6050, accelerometer +-2 g, gyroscope +-500 deg/s, \
         low-pass 44 Hz, rate 100.00 Hz, format 0"
    );
    assert_eq!(
        lines.next().unwrap(),
        "Timestamp (ms),aX (m/s^2),aY (m/s^2),aZ (m/s^2),Temp (C),\
         gX (deg/s),gY (deg/s),gZ (deg/s)"
    );
    // The last line may be cut.
    let whole = &text[..=text.rfind('\n').unwrap()];
    assert_eq!(notices(whole).len(), 1, "{:?}", notices(whole));
    let recording = read_bytes(whole.as_bytes(), "board.csv", &ReadOptions::default()).unwrap();
    assert!(recording.rows() > 575);
    assert_eq!(recording.accel_scale.unit.name(), "m/s^2");
    assert_eq!(recording.gyro_scale.unwrap().unit.name(), "deg/s");
    assert!(recording.temperature_c.is_some());
    let kinds: Vec<&str> = recording.findings.iter().map(|f| f.kind.as_str()).collect();
    assert!(kinds.iter().all(|k| *k == "metadata-lines"), "{kinds:?}");
    assert!((recording.timing.rate_hz().unwrap() - 100.0).abs() < 0.1);

    // Every row is what the sensor was fed, within its rounding.
    let fed = board.fed.borrow();
    let rows = rows(whole);
    let fits = |row: &[f64], reading: &Reading| {
        let counts = counts(reading, 16384.0, 65.5).map(f64::from);
        (0..7).all(|i| {
            let (exact, last_digit) = match i {
                0..3 => (counts[i] * G / 16384.0, 1e-4),
                3 => (counts[i] / 340.0 + 36.53, 1e-2),
                _ => (counts[i] / 65.5, 1e-3),
            };
            (row[i + 1] - exact).abs() < 0.51 * last_digit + 1e-5 * exact.abs()
        })
    };
    let at = fed.iter().position(|r| fits(&rows[0], r)).unwrap();
    assert!(at < 5, "{at}");
    for (row, reading) in rows.iter().zip(&fed[at..]) {
        assert!(fits(row, reading), "{row:?} {reading:?}");
    }
}

#[test]
fn stamps_show_the_clock_of_the_sensor() {
    for ppm in [0.0, 8000.0, -8000.0] {
        let Some(mut board) = board(SensorOptions {
            clock_error_ppm: ppm,
            ..SensorOptions::default()
        }) else {
            return;
        };
        board.run(0.5);
        let before = board.uno.sensor().samples().1;
        board.uno.take_bus();
        let sent = board.run(8.0);
        let text = text(&sent);
        let stamps: Vec<f64> = rows(text.split_once('\n').unwrap().1)
            .iter()
            .map(|r| r[0] * 1e3)
            .collect();
        let (rate_hz, sd_us) = line(&stamps[..stamps.len() - 1]);
        report(
            &mut board,
            "text, 115200 baud",
            rate_hz,
            sd_us,
            sent.len(),
            8.0,
        );
        assert!(
            (rate_hz - 100.0 * (1.0 + ppm * 1e-6)).abs() < 0.01,
            "{rate_hz}"
        );
        assert!(sd_us < 400.0, "{sd_us}");
        assert_eq!(board.uno.sensor().samples().1, before, "none was missed");
    }
}

/// Sets a board up by commands, lets it settle and returns what it sends then.
fn after(board: &mut Board, commands: &str, seconds: f64) -> Vec<virtual_board::uno::Sent> {
    board.run(0.5);
    board.uno.send(commands.as_bytes());
    board.run(0.4);
    board.uno.take_bus();
    board.fed.borrow_mut().clear();
    board.run(seconds)
}

fn report(board: &mut Board, what: &str, rate_hz: f64, sd_us: f64, bytes: usize, seconds: f64) {
    let bus = board.uno.take_bus();
    let busy_us = bus.busy_cycles as f64 / bus.bursts as f64 / 16.0;
    eprintln!(
        "{what}: {rate_hz:.2} Hz, stamps {sd_us:.0} us, line {:.0} %, processor {:.0} % \
         ({busy_us:.0} us a sample)",
        100.0 * bytes as f64 * 10.0 / board.uno.baud() / seconds,
        busy_us * rate_hz / 1e4,
    );
}

#[test]
fn counts_at_200_hz() {
    let Some(mut board) = board(SensorOptions::default()) else {
        return;
    };
    let sent = after(&mut board, "r200\nf1\n", 5.0);
    let text = text(&sent);
    assert!(notices(&text).is_empty(), "{:?}", notices(&text));
    let rows = rows(text.split_once('\n').unwrap().1);
    let stamps: Vec<f64> = rows.iter().map(|r| r[0] * 1e3).collect();
    let (rate_hz, sd_us) = line(&stamps[..stamps.len() - 1]);
    assert!((rate_hz - 200.0).abs() < 0.05, "{rate_hz}");
    report(
        &mut board,
        "counts, 115200 baud",
        rate_hz,
        sd_us,
        sent.len(),
        5.0,
    );
    let fed = board.fed.borrow();
    let first = rows[0][1..].to_vec();
    let at = fed
        .iter()
        .position(|r| counts(r, 16384.0, 65.5).map(f64::from)[..] == first[..])
        .unwrap();
    assert!(at < 3);
    for (row, reading) in rows[..rows.len() - 1].iter().zip(&fed[at..]) {
        assert_eq!(row[1..], counts(reading, 16384.0, 65.5).map(f64::from));
    }
}

#[test]
fn the_reader_knows_counts() {
    let Some(mut board) = board(SensorOptions::default()) else {
        return;
    };
    board.uno.run(0.3);
    board.uno.take_sent();
    board.uno.send(b"r200\nf1\n");
    let text = board.text(5.0);
    let from = text.rfind("# gravical").unwrap();
    let text = &text[from..=text.rfind('\n').unwrap()];
    assert!(text.contains("rate 200.00 Hz, format 1\nTimestamp (ms),ax,ay,az,temp,gx,gy,gz\n"));
    let recording = read_bytes(text.as_bytes(), "counts.csv", &ReadOptions::default()).unwrap();
    let kinds: Vec<&str> = recording.findings.iter().map(|f| f.kind.as_str()).collect();
    assert_eq!(recording.accel_scale.unit.name(), "counts", "{kinds:?}");
    assert_eq!(recording.accel_scale.lsb_per_g, Some(16384.0));
    assert!((recording.timing.rate_hz().unwrap() - 200.0).abs() < 0.2);
}

/// What decodes of the bytes after the first zero, and how many frames did not.
fn frames(bytes: &[u8]) -> (Vec<SampleFrame>, Vec<String>, usize) {
    let (mut samples, mut lines, mut bad) = (Vec::new(), Vec::new(), 0);
    let first = bytes.iter().position(|b| *b == 0).unwrap();
    let last = bytes.iter().rposition(|b| *b == 0).unwrap();
    for frame in bytes[first + 1..last].split(|b| *b == 0) {
        match decode_frame(frame) {
            Ok(Frame::Sample(sample)) => samples.push(sample),
            Ok(Frame::Text(line)) => lines.push(line),
            Err(_) => bad += 1,
        }
    }
    (samples, lines, bad)
}

#[test]
fn binary_at_500_hz() {
    for (rate, ppm) in [(500.0, 0.0), (500.0, 8000.0), (500.0, -8000.0)] {
        let Some(mut board) = board(SensorOptions {
            clock_error_ppm: ppm,
            ..SensorOptions::default()
        }) else {
            return;
        };
        after(&mut board, &format!("r{rate}\nf2\n"), 0.1);
        let before = board.uno.sensor().samples().1;
        board.uno.take_bus();
        board.fed.borrow_mut().clear();
        let sent = board.run(5.0);
        assert!((board.uno.baud() - 250_000.0).abs() < 1.0);
        let bytes: Vec<u8> = sent.iter().map(|s| s.byte).collect();
        let (samples, lines, bad) = frames(&bytes);
        let stamps: Vec<f64> = samples.iter().map(|s| f64::from(s.time_us)).collect();
        let (rate_hz, sd_us) = line(&stamps);
        report(
            &mut board,
            "binary, 250000 baud",
            rate_hz,
            sd_us,
            sent.len(),
            5.0,
        );
        let unread = board.uno.sensor().samples().1 - before;
        eprintln!("  {unread} not read, {lines:?}");
        assert_eq!(bad, 0);
        assert_eq!(lines, Vec::<String>::new());
        assert!(
            (rate_hz - rate * (1.0 + ppm * 1e-6)).abs() < 0.1,
            "{rate_hz}"
        );
        for pair in samples.windows(2) {
            assert_eq!(pair[1].sequence, pair[0].sequence.wrapping_add(1));
        }
        let fed = board.fed.borrow();
        let of = |s: &SampleFrame| {
            let mut all = s.accel.to_vec();
            all.push(s.temperature);
            all.extend(s.gyro);
            all.into_iter().map(i32::from).collect::<Vec<_>>()
        };
        // A simulated row lasts for several samples here, and the first samples may
        // have been fed before.
        let differ = (0..20)
            .map(|at| {
                samples[5..]
                    .iter()
                    .zip(&fed[at..])
                    .filter(|(s, r)| of(s)[..] != counts(r, 16384.0, 65.5)[..])
                    .count()
            })
            .min();
        assert_eq!(differ, Some(0));
    }
}

#[test]
fn binary_carries_the_lines_too() {
    let Some(mut board) = faulty("no-answer@2-2.5") else {
        return;
    };
    board.run(0.5);
    board.uno.send(b"r500\nf2\n");
    let bytes: Vec<u8> = board.run(4.0).iter().map(|s| s.byte).collect();
    let (samples, lines, _) = frames(&bytes);
    assert!(samples.len() > 1200);
    assert!(
        lines
            .iter()
            .any(|l| l.starts_with("# gravical") && l.ends_with("rate 500.00 Hz, format 2")),
        "{lines:?}"
    );
    assert!(
        lines.iter().any(|l| l.starts_with("# no answer")),
        "{lines:?}"
    );
    // And back to text.
    board.uno.send(b"f0\nr100\n");
    board.run(0.5);
    assert!((board.uno.baud() / 115_200.0 - 1.0).abs() < 0.03);
    let text = board.text(1.0);
    assert!(rows(text.split_once('\n').unwrap().1).len() > 95);
}

/// Rows in each second of the text's own time.
fn seconds(text: &str) -> Vec<usize> {
    let mut counts = vec![0; 64];
    for row in rows(text) {
        counts[(row[0] / 1e3) as usize] += 1;
    }
    counts
}

#[test]
fn a_sensor_that_comes_and_goes() {
    let Some(mut board) = faulty("no-answer@2-4") else {
        return;
    };
    let text = board.text(7.0);
    let said = notices(&text);
    let missing = said
        .iter()
        .filter(|l| l.starts_with("# no answer from a sensor"))
        .count();
    assert!((2..=3).contains(&missing), "once a second: {said:?}");
    assert_eq!(
        said.iter().filter(|l| l.starts_with("# gravical")).count(),
        2
    );
    assert!(
        said.contains(&"# overruns 0, i2c errors 1, restarts 1"),
        "{said:?}"
    );
    let rows = seconds(&text);
    assert!(
        rows[1] >= 99 && rows[2] + rows[3] < 5 && rows[4] > 60 && rows[5] >= 99,
        "{rows:?}"
    );
}

#[test]
fn no_sensor_at_all_and_another_one() {
    let Some(mut board) = faulty("no-answer@0-2.2,who-am-i=0x70@2.2-5") else {
        return;
    };
    let text = board.text(7.0);
    let said = notices(&text);
    let count = |what: &str| said.iter().filter(|l| l.starts_with(what)).count();
    assert!((2..=4).contains(&count("# no answer")), "{said:?}");
    assert!(
        (2..=4).contains(&count(
            "# the sensor says it is 0x70, not an MPU6050 (0x68)"
        )),
        "{said:?}"
    );
    assert_eq!(count("# gravical"), 1);
    let rows = seconds(&text);
    assert!(
        rows[..5].iter().sum::<usize>() == 0 && rows[6] >= 99,
        "{rows:?}"
    );
}

#[test]
fn a_stuck_bus_and_a_dip_of_the_supply() {
    let Some(mut board) = faulty("stuck-bus@2-3,dip@5") else {
        return;
    };
    let text = board.text(8.0);
    let said = notices(&text);
    let rows = seconds(&text);
    assert!(said.iter().any(|l| l.ends_with("restarts 2")), "{said:?}");
    assert_eq!(
        said.iter().filter(|l| l.starts_with("# gravical")).count(),
        3
    );
    assert!(rows[1] >= 99 && rows[2] < 5 && rows[4] >= 99, "{rows:?}");
    assert!(rows[5] > 60 && rows[6] >= 99, "{rows:?}");
    assert_eq!(board.uno.resets(), 0);
}

#[test]
fn the_watchdog_ends_a_hang() {
    let Some(mut board) = faulty("hang@2") else {
        return;
    };
    let text = board.text(7.0);
    assert_eq!(board.uno.resets(), 1);
    let said = notices(&text);
    assert_eq!(
        said.iter()
            .filter(|l| l.contains("restarted by the watchdog"))
            .count(),
        1,
        "{said:?}"
    );
    let after = &text[text.find("# restarted").unwrap()..];
    assert!(rows(after).len() > 200, "{}", rows(after).len());
}

#[test]
fn commands() {
    let Some(mut board) = board(SensorOptions::default()) else {
        return;
    };
    board.run(0.5);
    for (command, says) in [
        ("a4\n", "accelerometer +-4 g"),
        ("a16\r\n", "accelerometer +-16 g"),
        ("a5\n", "accelerometer +-8 g"),
        ("g2000\n", "gyroscope +-2000 deg/s"),
        ("g 250\n", "gyroscope +-250 deg/s"),
        ("d184\n", "low-pass 184 Hz"),
        ("d260\n", "low-pass 184 Hz"),
        ("d5\n", "low-pass 5 Hz"),
        ("r50\n", "rate 50.00 Hz"),
        ("r0\n", "rate 4.00 Hz"),
        ("r100\n", "rate 100.00 Hz"),
        ("f7\n", "format 0"),
        (
            "?\n",
            "accelerometer +-8 g, gyroscope +-250 deg/s, low-pass 5 Hz, rate 100.00 Hz",
        ),
    ] {
        board.uno.send(command.as_bytes());
        let text = board.text(0.8);
        // To say all of it takes longer than two samples.
        let said: Vec<&str> = notices(&text)
            .into_iter()
            .filter(|l| !l.starts_with("# overruns"))
            .collect();
        assert_eq!(said.len(), 1, "{command:?} {said:?}");
        assert!(said[0].contains(says), "{command:?} {said:?}");
        let norm = rows(text.rsplit_once("(deg/s)\n").unwrap().1)
            .first()
            .map(|r| r[1..4].iter().map(|v| v * v).sum::<f64>().sqrt());
        assert!(
            norm.is_none_or(|n| (n - G).abs() < 1.0),
            "{command:?} {norm:?}"
        );
    }
    board.uno.send(b"x\nhello\n\n\n99\n");
    let text = board.text(0.5);
    assert!(
        notices(&text)
            .iter()
            .all(|l| l.starts_with("# not a command"))
    );
    assert!(!notices(&text).is_empty());
    board.uno.send(b"p\n");
    board.run(0.1);
    assert!(rows(&board.text(1.0)).is_empty());
    board.uno.send(b"s\n");
    board.run(0.1);
    let text = board.text(1.0);
    assert!(notices(&text).is_empty(), "a pause is no overrun: {text}");
    assert!(rows(text.split_once('\n').unwrap().1).len() > 95);
}

#[test]
fn too_fast_is_said() {
    for (commands, seconds) in [("r500\n", 5.0), ("r1000\nf2\n", 5.0)] {
        let Some(mut board) = board(SensorOptions::default()) else {
            return;
        };
        board.run(0.5);
        board.uno.send(commands.as_bytes());
        board.run(0.3);
        board.uno.take_bus();
        let (samples, unread) = board.uno.sensor().samples();
        let sent = board.run(seconds);
        let lines: Vec<String> = if commands.contains("f2") {
            let bytes: Vec<u8> = sent.iter().map(|s| s.byte).collect();
            let (frames, lines, bad) = frames(&bytes);
            assert_eq!(bad, 0);
            let stamps: Vec<f64> = frames.iter().map(|f| f64::from(f.time_us)).collect();
            let (rate_hz, sd_us) = line(&stamps);
            report(
                &mut board,
                "binary, too fast",
                rate_hz,
                sd_us,
                sent.len(),
                seconds,
            );
            lines
        } else {
            notices(&text(&sent))
                .into_iter()
                .map(str::to_owned)
                .collect()
        };
        let told: Vec<u64> = lines
            .iter()
            .filter_map(|l| {
                l.strip_prefix("# overruns ")?
                    .split(',')
                    .next()?
                    .parse()
                    .ok()
            })
            .collect();
        let (all, lost) = board.uno.sensor().samples();
        let (all, lost) = (all - samples, lost - unread);
        let (first, last) = (told[0], told[told.len() - 1]);
        eprintln!("{commands:?}: {lost} of {all} lost, told {first} to {last}");
        // Told once a second: the first and the last are up to a second apart from
        // the ends.
        let share = (last - first) as f64 / lost as f64;
        assert!((0.5..1.05).contains(&share), "{share}");
    }
}

#[test]
fn time_goes_on_after_microseconds_wrap() {
    let Some(mut board) = board(SensorOptions::default()) else {
        return;
    };
    let Ok(symbols) = std::process::Command::new("avr-nm")
        .arg(board::firmware().unwrap())
        .output()
    else {
        eprintln!("skipped: no avr-nm");
        return;
    };
    let symbols = String::from_utf8(symbols.stdout).unwrap();
    let line = symbols
        .lines()
        .find(|l| l.ends_with(" timer0_overflow_count"))
        .unwrap();
    let address = u16::from_str_radix(&line[4..8], 16).unwrap();
    board.run(0.05);
    // 1024 us each: 2 s before 2^32 us.
    let overflows: u32 = (1 << 22) - 2000;
    assert!(board.uno.poke(address, &overflows.to_le_bytes()));
    let rows = rows(&board.text(5.0));
    assert!(rows[0][0] > 4_292_000.0 && rows[rows.len() - 1][0] > 4_297_000.0);
    for pair in rows.windows(2) {
        let step_ms = pair[1][0] - pair[0][0];
        assert!((9.0..=11.0).contains(&step_ms), "{pair:?}");
    }
}

#[test]
#[ignore = "prints the figures of docs/firmware.md"]
fn figures() {
    for (format, rate) in [
        (0, 100),
        (0, 125),
        (0, 166),
        (0, 200),
        (0, 250),
        (1, 200),
        (1, 250),
        (1, 333),
        (2, 333),
        (2, 500),
        (2, 1000),
    ] {
        // As far off as the data sheet allows, so that stamps meet every phase.
        let Some(mut board) = board(SensorOptions {
            clock_error_ppm: 3100.0,
            ..SensorOptions::default()
        }) else {
            return;
        };
        board.run(0.5);
        board.uno.send(format!("r{rate}\nf{format}\n").as_bytes());
        board.run(0.5);
        board.uno.take_bus();
        let (all, lost) = board.uno.sensor().samples();
        let sent = board.run(4.0);
        let (all_now, lost_now) = board.uno.sensor().samples();
        let stamps: Vec<f64> = if format == 2 {
            let bytes: Vec<u8> = sent.iter().map(|s| s.byte).collect();
            let (samples, _, _) = frames(&bytes);
            samples.iter().map(|s| f64::from(s.time_us)).collect()
        } else {
            let text = text(&sent);
            let rows = rows(text.split_once('\n').unwrap().1);
            rows.iter().map(|r| r[0] * 1e3).collect()
        };
        let (rate_hz, sd_us) = line(&stamps);
        let what = format!(
            "format {format} rate {rate}: {} of {} lost",
            lost_now - lost,
            all_now - all
        );
        report(&mut board, &what, rate_hz, sd_us, sent.len(), 4.0);
    }
}
