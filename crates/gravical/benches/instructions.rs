//! Instructions, counted under valgrind: the only stable figure on a machine
//! that others use too.
//!
//! `cargo bench --bench instructions` needs valgrind and `gungraun-runner` of
//! the version that Cargo.lock names for gungraun. Without `--bench`, as
//! `cargo test --all-targets` calls it, nothing is done.

/// Rows of the recording.
#[cfg(unix)]
const ROWS: usize = 10_000;

#[cfg(unix)]
#[path = "../../../tests/support/means.rs"]
#[allow(dead_code, reason = "the examples use more of it")]
mod means;

#[cfg(unix)]
mod counted {
    use std::fmt::Write;
    use std::hint::black_box;

    use gravical::apply::{ApplyOptions, apply};
    use gravical::calibration_file::CalibrationFile;
    use gravical::core::calibration::Calibration;
    use gravical::recording::bytes::{Input, from_reader};
    use gravical::recording::{ReadOptions, Recording, read_bytes};
    use gravical_fit::{Hint, Options, Pose, fit};
    use gungraun::{library_benchmark, library_benchmark_group};

    use super::ROWS;
    use super::means::{NOISE_MPS2, Part, Planned};

    const CALIBRATION: &str = r#"{
        "acc_unit": "m/s^2", "gyr_unit": "deg/s", "from_acc_unit": "m/s^2", "cal_type": "Ferraris",
        "K_a": [[1.02, 0, 0], [0, 0.99, 0], [0, 0, 1.01]], "b_a": [0.1, -0.2, 0.05],
        "R_a": [[1, 0.01, 0], [0, 1, 0.02], [0.01, 0, 1]],
        "K_g": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "b_g": [0, 0, 0],
        "R_g": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
        "K_ga": [[0, 0, 0], [0, 0, 0], [0, 0, 0]]
    }"#;

    /// The columns of the report, noise in the last digits.
    fn recording() -> Vec<u8> {
        let mut text =
            String::from("Timestamp,aX (g),aY (g),aZ (g),Temp (C),gX (°/s),gY (°/s),gZ (°/s)\n");
        let mut state = 1_u32;
        let mut noise = || {
            // Numerical Recipes' generator: any would do.
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 16) / 65536.0 - 0.5
        };
        for i in 0..ROWS {
            let _ = writeln!(
                text,
                "{},{:.4},{:.4},{:.4},{:.2},{:.4},{:.4},{:.4}",
                10 * i,
                0.1 + 0.2 * noise(),
                -0.2 + 0.2 * noise(),
                9.8 + 0.2 * noise(),
                27.0 + 0.1 * noise(),
                0.1 * noise(),
                0.1 * noise(),
                0.1 * noise()
            );
        }
        text.into_bytes()
    }

    fn calibrated() -> (CalibrationFile, Input, Vec<u8>) {
        let calibration = CalibrationFile::parse(CALIBRATION.as_bytes());
        let input = from_reader(Box::new(std::io::Cursor::new(recording())), false);
        match (calibration, input) {
            (Ok(calibration), Ok(input)) => (calibration, input, Vec::with_capacity(2 << 20)),
            _ => unreachable!("both are written here"),
        }
    }

    #[library_benchmark]
    #[bench::report(recording())]
    fn read(bytes: Vec<u8>) -> gravical::Result<Recording> {
        let done = read_bytes(black_box(&bytes), "report.csv", &ReadOptions::default());
        assert!(done.is_ok());
        done
    }

    #[library_benchmark]
    #[bench::report(calibrated())]
    fn calibrate_rows((calibration, input, mut out): (CalibrationFile, Input, Vec<u8>)) -> Vec<u8> {
        let options = ApplyOptions::default();
        let done = apply(
            black_box(&calibration),
            input,
            "report.csv",
            &mut out,
            &options,
        );
        assert!(done.is_ok());
        out
    }

    /// Six faces and random poses, nothing said of them.
    fn session(frees: usize) -> Vec<Pose> {
        let mut part = Part::draw(NOISE_MPS2, 5, 0);
        let mut planned = Planned::six_faces();
        planned.extend(part.random_poses(frees));
        part.place(&planned)
            .iter()
            .map(|m| Pose {
                mean: m.mean,
                sd: [NOISE_MPS2; 3],
                hint: Hint::Open,
                temperature_c: None,
            })
            .collect()
    }

    // With the tilt estimated, bad poses looked for and every pose left out once.
    #[library_benchmark]
    #[bench::poses_12(session(6))]
    #[bench::poses_38(session(32))]
    fn fit_poses(poses: Vec<Pose>) -> bool {
        let options = Options {
            nominal: Some(1.0),
            ..Options::default()
        };
        fit(black_box(&poses), &options).is_ok_and(|fit| !fit.left_out().is_empty())
    }

    fn single() -> Calibration<f32> {
        Calibration {
            matrix: [
                [5.9e-4, 1e-5, 0.0],
                [0.0, 6.0e-4, 2e-5],
                [1e-5, 0.0, 5.8e-4],
            ],
            bias: [120.0, -340.0, 800.0],
        }
    }

    // What a microcontroller does with every sample; .ci/run counts it for a Cortex-M4F.
    #[library_benchmark]
    #[bench::counts(single())]
    fn sample(calibration: Calibration<f32>) -> [f32; 3] {
        let counts: [i16; 3] = black_box([130, -300, 17_600]);
        black_box(&calibration).apply(counts.map(f32::from))
    }

    library_benchmark_group!(
        name = recordings,
        benchmarks = [read, calibrate_rows, fit_poses]
    );
    library_benchmark_group!(name = samples, benchmarks = [sample]);
    gungraun::main!(library_benchmark_groups = recordings, samples);

    pub fn run() {
        main();
    }
}

fn main() {
    #[cfg(unix)]
    if std::env::args().any(|a| a == "--bench" || a == "--gungraun-run") {
        counted::run();
    }
}
