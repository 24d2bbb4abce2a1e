//! Motion of recordings whose story is known: what is missing, replaced, given or asked for. How
//! accurate it is, and what is a rest, is tested in `gravical-motion`.

use gravical::motion::{
    Ends, MotionJudgement, MotionOptions, MotionResult, MotionStepper, Readings, motion,
    write_table,
};
use gravical::noise::{NoiseOptions, noise_of};
use gravical::recording::{ReadOptions, Recording, parse_columns, read, read_bytes};
use gravical::simulate::{LineOptions, Scenario, SimulateOptions, simulate, write};

/// Noise without a generator: the same every time, about ±1.7.
fn noise(i: usize, channel: usize) -> f64 {
    let x = ((i * 12 + channel + 1) as f64 * 12.9898).sin() * 43758.5453;
    3.46 * (x - x.floor() - 0.5)
}

/// A recording at 100 Hz of `seconds`: acceleration along x and rate about y as
/// functions of time; `keep` says which rows are written.
fn record(
    seconds: f64,
    acceleration: impl Fn(f64) -> f64,
    with_gyro: bool,
    keep: impl Fn(f64) -> bool,
) -> Recording {
    let mut text = "t_s,ax (m/s^2),ay (m/s^2),az (m/s^2)".to_owned();
    text += if with_gyro {
        ",gx (rad/s),gy (rad/s),gz (rad/s)\n"
    } else {
        "\n"
    };
    for i in 0..(100.0 * seconds) as usize {
        let t = 0.01 * i as f64;
        if !keep(t) {
            continue;
        }
        text += &format!(
            "{t:.3},{:.5},{:.5},{:.5}",
            acceleration(t) + 0.02 * noise(i, 0),
            0.02 * noise(i, 1),
            9.80665 + 0.02 * noise(i, 2)
        );
        if with_gyro {
            for c in 3..6 {
                text += &format!(",{:.6}", 0.001 * noise(i, c));
            }
        }
        text += "\n";
    }
    read_bytes(text.as_bytes(), "story.csv", &ReadOptions::default()).unwrap()
}

/// From 5 s on 1 m/s² for half a second, then `cruise` seconds at 0.5 m/s, then
/// back to rest.
fn ride(cruise: f64) -> impl Fn(f64) -> f64 {
    move |t: f64| {
        if (5.0..5.5).contains(&t) {
            1.0
        } else if (5.5 + cruise..6.0 + cruise).contains(&t) {
            -1.0
        } else {
            0.0
        }
    }
}

/// The recording of a simulation, through its file.
fn recorded(options: &SimulateOptions) -> Recording {
    let folder = tempfile::tempdir().unwrap();
    let files = write(&simulate(options).unwrap(), folder.path(), false).unwrap();
    let csv = files
        .iter()
        .find(|p| p.extension().is_some_and(|e| e == "csv"));
    read(csv.unwrap(), &ReadOptions::default()).unwrap()
}

fn computed(recording: &Recording) -> MotionResult {
    motion(recording, None, &MotionOptions::default())
        .unwrap()
        .result
}

fn kinds(result: &MotionResult) -> Vec<&str> {
    result.findings.iter().map(|f| f.kind.name()).collect()
}

#[test]
fn constant_speed_is_no_rest() {
    for with_gyro in [true, false] {
        let result = computed(&record(20.0, ride(6.0), with_gyro, |_| true));
        assert_eq!(result.moves.len(), 1, "{:?}", result.rests);
        let one = &result.moves[0];
        let (way, sigma) = (one.displacement_m.unwrap()[0], one.sigma_m.unwrap()[0]);
        // 0.5 m/s over six seconds and two halves of half a second.
        assert!((way - 3.25).abs() < 2.0 * sigma, "{way} ± {sigma}");
        assert_eq!(kinds(&result).contains(&"no-gyro"), !with_gyro);
    }
}

#[test]
fn a_gap_in_one_move_keeps_the_others() {
    let two = |t: f64| ride(0.5)(t) + ride(0.5)(t - 7.0);
    let whole = computed(&record(20.0, two, true, |_| true));
    assert_eq!(whole.moves.len(), 2);
    let torn = computed(&record(20.0, two, true, |t| !(5.3..6.1).contains(&t)));
    assert!(torn.moves[0].unusable.is_some() && torn.moves[1].unusable.is_none());
    let (a, b) = (whole.moves[1].displacement_m, torn.moves[1].displacement_m);
    assert!((a.unwrap()[0] - b.unwrap()[0]).abs() < 0.02);
    assert!(torn.r#final.position_m.is_none() && torn.r#final.sigma_m.is_none());
    assert!(kinds(&torn).contains(&"move-unusable"));
    // The same gap at rest loses nothing.
    let quiet = computed(&record(20.0, two, true, |t| !(2.0..2.8).contains(&t)));
    let known = quiet.moves.iter().filter_map(|m| m.displacement_m);
    assert!(
        known.filter(|d| d[0] > 0.1).count() == 2,
        "{:?}",
        quiet.moves
    );
}

#[test]
fn the_start_and_the_end_may_be_in_motion() {
    let result = computed(&record(12.0, ride(2.0), true, |t| t < 6.0));
    assert_eq!(result.moves.last().unwrap().ends, Ends::FromRest);
    assert!(kinds(&result).contains(&"ends-moving"));
    // From the middle of the first push on: 0.25 m/s and more before the rest.
    let result = computed(&record(14.0, ride(1.0), true, |t| t > 5.25));
    let first = &result.moves[0];
    assert_eq!(first.ends, Ends::ToRest);
    let way = first.displacement_m.unwrap()[0];
    let exact = 0.09375 + 0.5 + 0.125;
    assert!((way - exact).abs() < 0.05, "{way}");
    assert!((way - exact).abs() < 3.0 * first.sigma_m.unwrap()[0] + 1e-3);
}

#[test]
fn without_a_rest_nothing_is_computed_and_that_is_said() {
    for with_gyro in [true, false] {
        let shaken = record(10.0, |t| 2.0 * (9.0 * t).sin(), with_gyro, |_| true);
        let whole = motion(&shaken, None, &MotionOptions::default()).unwrap();
        let result = &whole.result;
        assert_eq!(result.verdict.judgement, MotionJudgement::NotUsable);
        assert!(kinds(result).contains(&"no-static-interval"));
        assert!(result.moves.is_empty() && result.r#final.position_m.is_none());
        assert!(whole.samples().all(|s| s.position_m[0].is_nan()));
        assert_eq!(whole.samples().count(), shaken.rows());
    }
}

#[test]
fn a_velocity_at_the_start_counts_without_zero_velocity() {
    let recording = record(12.0, ride(1.0), true, |_| true);
    let with = |v0: f64, zero_velocity: bool| {
        let options = MotionOptions {
            v0_mps: Some([v0, 0.0, 0.0]),
            zero_velocity: Some(zero_velocity),
            ..MotionOptions::default()
        };
        motion(&recording, None, &options).unwrap().result
    };
    let ignored = with(1.0, true);
    assert!(kinds(&ignored).contains(&"v0-not-used"));
    assert_eq!(ignored.r#final, computed(&recording).r#final);
    let at = |v0: f64| with(v0, false).r#final.position_m.unwrap()[0];
    assert!((at(1.0) - at(0.0) - 11.99).abs() < 1e-6);
}

#[test]
fn clipped_values_and_spikes_are_replaced_and_in_the_band() {
    // 2 g are reached for a tenth of a second; or one row is off by 40 m/s².
    let push = |t: f64| match t - 5.0 {
        s if (0.0..0.3).contains(&s) => 22.0 * (std::f64::consts::PI * s / 0.3).sin(),
        s if (0.3..0.6).contains(&s) => -22.0 * (std::f64::consts::PI * (s - 0.3) / 0.3).sin(),
        _ => 0.0,
    };
    let right = computed(&record(12.0, push, true, |_| true)).moves[0]
        .displacement_m
        .unwrap()[0];
    let clipped = |t: f64| push(t).clamp(-19.6133, 19.6133);
    let spiked = |t: f64| push(t) + if (t - 5.15).abs() < 0.004 { 40.0 } else { 0.0 };
    let read = |story: &dyn Fn(f64) -> f64| {
        let mut recording = record(12.0, story, true, |_| true);
        for x in &mut recording.accel[0] {
            *x = if x.abs() < 30.0 {
                x.clamp(-19.6133, 19.6133)
            } else {
                *x
            };
        }
        computed(&recording)
    };
    for (result, spike) in [(read(&clipped), false), (read(&spiked), true)] {
        let one = &result.moves[0];
        assert!(one.replaced > 0 && kinds(&result).contains(&"values-replaced"));
        let (way, sigma) = (one.displacement_m.unwrap()[0], one.sigma_m.unwrap()[0]);
        assert!(
            (way - right).abs() < 2.5 * sigma,
            "{spike}: {way} ± {sigma}, {right}"
        );
        assert!(sigma < 0.3 * right, "{spike}: {sigma}");
    }
}

#[test]
fn a_sensor_that_hangs_is_named_and_leaves_no_displacement() {
    let recording = record(14.0, ride(1.0), true, |_| true);
    let mut hung = recording.clone();
    for channel in hung.accel.iter_mut().chain(hung.gyro.iter_mut().flatten()) {
        let last = channel[560];
        channel[560..700].fill(last);
    }
    let result = computed(&hung);
    assert!(kinds(&result).contains(&"sensor-hung"));
    assert!(result.moves.len() == 1 && result.moves[0].unusable.is_some());
    assert_eq!(result.verdict.judgement, MotionJudgement::NotUsable);
    assert_eq!(result.rests.len(), 2);
}

/// A second estimate, because of a noise file, filters or a calibration in doubt, is of the same rows and
/// rests as the first.
#[test]
fn what_is_computed_twice_forgets_nothing() {
    let recording = record(20.0, ride(1.0), true, |t| !(1.0..4.0).contains(&t));
    let noise = noise_of(
        &record(60.0, |_| 0.0, true, |_| true),
        &NoiseOptions::default(),
    );
    let options = [
        MotionOptions::default(),
        MotionOptions {
            noise: Some(noise.unwrap().section()),
            ..MotionOptions::default()
        },
        MotionOptions {
            smooth: vec!["savgol:5,2".parse().unwrap()],
            ..MotionOptions::default()
        },
    ];
    let results = options.map(|o| motion(&recording, None, &o).unwrap().result);
    for result in &results {
        assert!(result.moves[0].unusable.is_some(), "{:?}", result.moves);
        assert!(result.r#final.position_m.is_none());
        assert_eq!(result.verdict.judgement, MotionJudgement::PartlyOpen);
        assert_eq!(result.moves.len(), results[0].moves.len());
    }
    // Filters hide noise and do not make it less.
    let sigma = |r: &MotionResult| r.moves[1].sigma_m.unwrap()[2];
    assert!((sigma(&results[2]) / sigma(&results[0]) - 1.0).abs() < 0.1);

    // A hang stays one where filters, or a drift with temperature, make its rows differ.
    let mut hung = record(14.0, ride(1.0), true, |_| true);
    for channel in hung.accel.iter_mut().chain(hung.gyro.iter_mut().flatten()) {
        let last = channel[560];
        channel[560..700].fill(last);
    }
    for options in &options_of_filters() {
        let result = motion(&hung, None, options).unwrap().result;
        assert!(result.moves.len() == 1 && result.moves[0].unusable.is_some());
    }
}

fn options_of_filters() -> [MotionOptions; 2] {
    ["savgol:5,2", "butter:4,5Hz"].map(|filter| MotionOptions {
        smooth: vec![filter.parse().unwrap()],
        ..MotionOptions::default()
    })
}

#[test]
fn a_first_row_of_zeros_is_no_gravity() {
    let mut recording = record(14.0, ride(1.0), true, |_| true);
    (0..3).for_each(|c| recording.accel[c][0] = 0.0);
    let result = computed(&recording);
    let way = result.moves.last().unwrap().displacement_m.unwrap()[0];
    assert!((way - 0.75).abs() < 0.1, "{way}");
}

#[test]
fn the_procedure_of_the_report_is_worse_and_says_so() {
    // 3° of wobble leave g·A·T²/2π = 327 mm of 0.7 m where nothing is rotated.
    let wobbling = recorded(&SimulateOptions::new(Scenario::Line(LineOptions {
        tilt_change_deg: 3.0,
        ..LineOptions::default()
    })));
    let report = motion(&wobbling, None, &MotionOptions::report())
        .unwrap()
        .result;
    let way = report.moves[0].displacement_m.unwrap()[1];
    assert!((way - 0.7).abs() > 0.15, "{way}");
    assert!(report.moves[0].sigma_m.is_none() && report.rests.is_empty());
    assert_eq!(report.verdict.judgement, MotionJudgement::Open);
    assert!(!kinds(&report).contains(&"averaged-rows-move"));
    // From 3 s on it moves: the 500 rows hold no rest.
    let early = record(12.0, |t| ride(1.0)(t + 2.0), true, |_| true);
    let report = motion(&early, None, &MotionOptions::report())
        .unwrap()
        .result;
    assert!(kinds(&report).contains(&"averaged-rows-move"));
    for impossible in [
        MotionOptions {
            zero_velocity: Some(true),
            ..MotionOptions::report()
        },
        MotionOptions {
            causal: true,
            ..MotionOptions::report()
        },
    ] {
        let error = motion(&early, None, &impossible).unwrap_err();
        assert_eq!(error.code(), "option-range");
    }
}

#[test]
fn a_causal_run_has_bands_and_ends_near_the_whole_one() {
    let recording = recorded(&SimulateOptions::new(
        Scenario::Line(LineOptions::default()),
    ));
    let causal = MotionOptions {
        causal: true,
        ..MotionOptions::default()
    };
    let (whole, causal) = (
        computed(&recording),
        motion(&recording, None, &causal).unwrap(),
    );
    let end = |r: &MotionResult| (r.r#final.position_m.unwrap(), r.r#final.sigma_m.unwrap());
    let ((a, _), (b, sigma)) = (end(&whole), end(&causal.result));
    for k in 0..3 {
        assert!(
            (a[k] - b[k]).abs() < 2.0 * sigma[k],
            "{a:?} {b:?} {sigma:?}"
        );
    }
}

#[test]
fn sample_by_sample_it_is_the_causal_run() {
    let recording = record(16.0, ride(1.0), true, |_| true);
    let options = MotionOptions {
        causal: true,
        p0_m: [1.0, 0.0, 0.0],
        ..MotionOptions::default()
    };
    let whole = motion(&recording, None, &options).unwrap();
    let mut stepper = MotionStepper::new(&recording, None, &options).unwrap();
    let gyro = recording.gyro.as_ref().unwrap();
    let mut last_band = 0.0;
    for (i, t_s) in recording.time_s.as_ref().unwrap().iter().enumerate() {
        let readings = Readings {
            t_s: Some(*t_s),
            accel: recording.accel_at(i),
            gyro: gyro.each_ref().map(|c| c[i]),
            temperature_c: f64::NAN,
        };
        assert!(stepper.update(&readings));
        assert!(!stepper.update(&readings), "its time is not later");
        last_band = stepper.now().sigma_position_m[0];
    }
    let (now, end) = (stepper.now(), &whole.result.r#final);
    let (p, sigma) = (end.position_m.unwrap(), end.sigma_m.unwrap());
    for k in 0..3 {
        assert!(
            (now.position_m[k] - p[k]).abs() < 1e-9,
            "{:?} {p:?}",
            now.position_m
        );
        assert!((now.sigma_position_m[k] - sigma[k]).abs() < 1e-9);
    }
    assert!(now.still && last_band > 0.0);
    assert_eq!(stepper.samples() as usize, 2 * recording.rows());
}

#[test]
fn smoothing_keeps_the_rests_and_hardly_moves_the_end() {
    let recording = recorded(&SimulateOptions::new(
        Scenario::Line(LineOptions::default()),
    ));
    let plain = computed(&recording);
    for filter in ["savgol:5,2", "butter:4,5Hz"] {
        let options = MotionOptions {
            smooth: vec![filter.parse().unwrap()],
            ..MotionOptions::default()
        };
        let smooth = motion(&recording, None, &options).unwrap().result;
        assert_eq!(smooth.rests, plain.rests);
        let (a, b) = (
            plain.r#final.position_m.unwrap(),
            smooth.r#final.position_m.unwrap(),
        );
        assert!(
            (0..3).all(|k| (a[k] - b[k]).abs() < 0.01),
            "{filter}: {a:?} {b:?}"
        );
    }
}

#[test]
fn the_table_has_a_line_for_every_sample_in_every_case() {
    let two = |t: f64| ride(0.5)(t) + ride(0.5)(t - 7.0);
    let open = MotionOptions {
        zero_velocity: Some(false),
        ..MotionOptions::default()
    };
    let plain = MotionOptions {
        no_bands: true,
        ..MotionOptions::default()
    };
    let usual = MotionOptions::default();
    for (options, columns, keep) in [
        (&usual, 27, (|_| true) as fn(f64) -> bool),
        (&usual, 27, |t| !(5.3..6.1).contains(&t)),
        (&usual, 27, |t| (5.25..13.0).contains(&t)),
        (&open, 27, |_| true),
        (&plain, 21, |_| true),
        (&MotionOptions::report(), 21, |_| true),
    ] {
        let recording = record(20.0, two, true, keep);
        let whole = motion(&recording, None, options).unwrap();
        let mut table = Vec::new();
        write_table(&whole, &mut table).unwrap();
        let table = String::from_utf8(table).unwrap();
        assert_eq!(table.lines().count(), 1 + recording.rows());
        for line in table.lines() {
            assert_eq!(line.split(',').count(), columns, "{line}");
        }
        assert!(!table.contains("NaN") && !table.contains("inf"));
        // Read again, the calibrated columns are an accelerometer.
        let options = ReadOptions {
            columns: Some(parse_columns("t=t_s,ax=ax_mps2,ay=ay_mps2,az=az_mps2").unwrap()),
            ..ReadOptions::default()
        };
        let again = read_bytes(table.as_bytes(), "motion.csv", &options).unwrap();
        let track = whole.track();
        assert!((again.accel[2][70] - track.force_mps2[2][70]).abs() < 1e-6);
        assert_eq!(track.position_m.len(), track.t_s.len());
    }
}

#[test]
fn rests_by_hand_are_believed() {
    let options = MotionOptions {
        rests: Some(gravical::motion::Intervals(vec![
            (0.0, 4.9),
            (7.0, 9.0),
            (12.2, f64::INFINITY),
        ])),
        ..MotionOptions::default()
    };
    let recording = record(20.0, ride(6.0), true, |_| true);
    let result = motion(&recording, None, &options).unwrap().result;
    assert_eq!(result.moves.len(), 2);
    assert!(result.moves.iter().all(|m| m.ends == Ends::RestToRest));
}
