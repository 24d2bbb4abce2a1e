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
