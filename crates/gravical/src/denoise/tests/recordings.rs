//! Filtering of recordings: short input, breaks, options.

use super::*;

fn denoised(csv: &str, filters: &[&str]) -> Denoised {
    let read = crate::recording::ReadOptions::default();
    let recording = crate::recording::read_bytes(csv.as_bytes(), "made.csv", &read).unwrap();
    let options = DenoiseOptions::new(filters.iter().map(|f| f.parse().unwrap()));
    denoise(recording, &options).unwrap()
}

#[test]
fn short_constant_and_huge_input_stays_finite() {
    let all = [
        "hampel:7,3",
        "savgol:5,2",
        "mean:3",
        "butter:4,5Hz",
        "highpass1:2,0.5Hz",
    ];
    for rows in [1, 2, 5, 40] {
        for value in ["9.81", "9e99", "-0.0", "1e-300"] {
            let mut csv = "t_ms,ax,ay,az,gx,gy,gz\n".to_owned();
            for i in 0..rows {
                csv += &format!("{},{value},1,9.81,,,\n", 10 * i);
            }
            // One row has no rate, which a filter in Hz needs.
            let filters = if rows == 1 { &all[..3] } else { &all[..] };
            let done = denoised(&csv, filters);
            assert_eq!(done.recording.rows(), rows);
            for channel in &done.recording.accel {
                assert!(
                    channel.iter().all(|v| v.is_finite()),
                    "{rows} {value} {channel:?}"
                );
            }
            if let Some(gyro) = &done.recording.gyro {
                assert!(gyro.iter().flatten().all(|v| v.is_nan()));
            }
        }
    }
}

#[test]
fn invalid_options_are_refused() {
    let csv = "t_ms,ax,ay,az\n0,0,0,9.8\n10,0,0,9.8\n20,0,0.1,9.8\n";
    let read = crate::recording::ReadOptions::default();
    let recording = || crate::recording::read_bytes(csv.as_bytes(), "made.csv", &read).unwrap();
    let code = |options: &DenoiseOptions| denoise(recording(), options).unwrap_err().code();
    let mean = FilterSpec::Mean { window: 3 };
    assert_eq!(code(&DenoiseOptions::default()), "no-filter");
    assert_eq!(
        code(&DenoiseOptions::new([FilterSpec::Mean { window: 2 }])),
        "filter-range"
    );
    let mut options = DenoiseOptions::new([mean]);
    options.channels = Channels::Gyro;
    assert_eq!(code(&options), "no-gyroscope");
}

#[test]
fn filters_do_not_cross_breaks_and_gaps() {
    let mut csv = "t_ms,ax,ay,az\n".to_owned();
    for i in 0..300 {
        // A step at blank rows, and one at a gap of 0.2 s.
        let level = [1.0, 5.0, -3.0][i / 100];
        csv += &format!(
            "{},{level},0,9.81\n",
            10 * i + if i < 200 { 0 } else { 200 }
        );
        if i == 99 {
            csv += "\n\n";
        }
    }
    for filter in [
        "savgol:21,3",
        "butter:4,1Hz",
        "butter1:2,1Hz",
        "mean:31",
        "hampel:31,0",
    ] {
        let done = denoised(&csv, &[filter]);
        assert_eq!(done.summary.segments, 3, "{filter}");
        for (i, x) in done.recording.accel[0].iter().enumerate() {
            assert!(
                (x - [1.0, 5.0, -3.0][i / 100]).abs() < 1e-9,
                "{filter} {i} {x}"
            );
        }
    }
}
