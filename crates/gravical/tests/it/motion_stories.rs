//! Motion on recordings whose story is known: constant speed, gaps, walks, and
//! what is missing.

use gravical::motion::{
    Ends, MotionOptions, MotionResult, Table, motion, motion_into, write_table,
};
use gravical::recording::{
    AccelUnit, ReadOptions, Recording, SampleColumns, TimeUnit, read, read_bytes,
};
use gravical::simulate::{LineOptions, Scenario, SimulateOptions, StaticOptions, simulate, write};

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
        let moved = result.moves[0].displacement_m.unwrap()[0];
        // 0.5 m/s over six seconds and two halves of half a second.
        assert!((moved - 3.25).abs() < 0.1, "{moved}");
        assert!(kinds(&result).contains(&"constant-speed"));
        assert_eq!(kinds(&result).contains(&"no-gyro"), !with_gyro);
    }
}

/// A line of the virtual sensor between rests of 5 s.
fn line(seed: u64, distance_m: f64, move_time_s: f64) -> MotionResult {
    let mut options = SimulateOptions::new(Scenario::Line(LineOptions {
        distance_m,
        offset_m: 0.0,
        move_time_s,
        ..LineOptions::default()
    }));
    options.seed = seed;
    computed(&recorded(&options))
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

#[test]
fn a_small_move_is_no_rest() {
    // Ten times the noise of a move that is known as a whole, and more.
    for (distance_m, move_s) in [(0.05, 2.0), (0.1, 2.0), (0.1, 4.0)] {
        for seed in [1, 2, 3, 22] {
            let result = line(seed, distance_m, move_s);
            assert_eq!(result.moves.len(), 1, "{distance_m} m, seed {seed}");
            let (p, sigma) = (result.r#final.position_m, result.r#final.sigma_m);
            let off = p.unwrap()[1] - distance_m;
            assert!(off.abs() < 4.0 * sigma.unwrap()[1], "seed {seed}: {off}");
        }
    }
}

#[test]
fn a_slow_move_without_a_gyroscope_is_not_parted_by_tilts() {
    // In the middle of it the acceleration hardly changes: as if laid down askew.
    for seed in [21, 59] {
        let mut options = SimulateOptions::new(Scenario::Line(LineOptions {
            distance_m: 0.5,
            move_time_s: 8.0,
            ..LineOptions::default()
        }));
        options.seed = seed;
        options.sensor.accel_noise_mps_rts = 0.002;
        let file = simulate(&options).unwrap().files.swap_remove(0);
        let columns = SampleColumns {
            time: Some(&file.t_s),
            accel: file.accel_mps2.each_ref().map(|c| &c[..]),
            ..SampleColumns::default()
        };
        let units = ReadOptions {
            accel_unit: Some(AccelUnit::MetrePerSecondSquared),
            time_unit: Some(TimeUnit::Second),
            ..ReadOptions::default()
        };
        let recording = Recording::from_samples("slow", &columns, &units).unwrap();
        let end = computed(&recording).r#final;
        let (p, sigma) = (end.position_m.unwrap(), end.sigma_m.unwrap());
        let off = (p[0].hypot(p[1]) - 0.5).abs();
        assert!(off < 3.0 * sigma[1], "seed {seed}: {p:?} {sigma:?}");
    }
}

#[test]
fn an_open_end_without_a_gyroscope_may_be_a_tilt() {
    // Picked up at the end: half a second at 2 m/s², or a tilt of 12°.
    let lifted = |t: f64| if t > 9.5 { 2.0 } else { 0.0 };
    let sigma = |with_gyro: bool| {
        let result = computed(&record(10.0, lifted, with_gyro, |_| true));
        let last = result.moves.last().unwrap();
        assert_eq!(last.ends, Ends::FromRest);
        (last.displacement_m.unwrap()[0], last.sigma_m.unwrap()[0])
    };
    let ((way, unknown), (_, followed)) = (sigma(false), sigma(true));
    assert!(way > 0.2 && unknown >= way, "{way} {unknown}");
    assert!(followed < 0.1 * way, "{way} {followed}");
}

#[test]
fn a_turn_beyond_the_range_of_the_gyroscope_loses_its_move() {
    let swing = |most: f64| {
        let mut text =
            "t_s,ax (m/s^2),ay (m/s^2),az (m/s^2),gx (rad/s),gy (rad/s),gz (rad/s)\n".to_owned();
        for i in 0..1200 {
            let s = 0.01 * f64::from(i) - 5.0;
            let inside = (0.0..2.0).contains(&s);
            let w = std::f64::consts::PI;
            let (angle, rate) = match inside {
                true => (0.4 * (w * s).sin(), 0.4 * w * (w * s).cos()),
                false => (0.0, 0.0),
            };
            let n = |c| noise(i as usize, c);
            text += &format!(
                "{:.3},{:.5},{:.5},{:.5},{:.6},{:.6},{:.6}\n",
                s + 5.0,
                -9.80665 * angle.sin() + 0.02 * n(0),
                0.02 * n(1),
                9.80665 * angle.cos() + 0.02 * n(2),
                0.001 * n(3),
                (rate + 0.001 * n(4)).clamp(-most, most),
                0.001 * n(5)
            );
        }
        computed(&read_bytes(text.as_bytes(), "swing.csv", &ReadOptions::default()).unwrap())
    };
    let whole = swing(10.0);
    assert!(whole.moves.iter().all(|m| m.usable), "{:?}", whole.moves);
    let clipped = swing(1.0);
    let lost: Vec<_> = clipped.moves.iter().filter(|m| !m.usable).collect();
    assert_eq!(lost.len(), 1, "{:?}", clipped.moves);
    assert!(lost[0].displacement_m.is_none());
    assert!(
        lost[0]
            .reason
            .as_ref()
            .unwrap()
            .contains("range of the gyroscope")
    );
    assert!(clipped.r#final.position_m.is_none());
    assert!(kinds(&clipped).contains(&"move-unusable"));
}

#[test]
fn a_slow_start_belongs_to_the_move_that_stops_at_once() {
    // 10 mm/s² hide in the noise of a second; the stop is noticed.
    let creep = |t: f64| match t - 8.0 {
        s if (0.0..3.6).contains(&s) => 0.01,
        s if (3.6..4.0).contains(&s) => -0.09,
        _ => 0.0,
    };
    let result = computed(&record(20.0, creep, true, |_| true));
    assert_eq!(result.moves.len(), 1, "{:?}", result.rests);
    let one = &result.moves[0];
    assert!((one.start_s - 8.0).abs() < 1.0, "{}", one.start_s);
    let way = one.displacement_m.unwrap()[0];
    assert!((way - 0.072).abs() < 4.0 * one.sigma_m.unwrap()[0], "{way}");
}

#[test]
fn what_no_model_knows_of_widens_the_band_by_what_it_may_have_done() {
    let right = computed(&record(20.0, ride(1.0), true, |_| true));
    // The bias was another one for half a second: 50 mm/s are left at the end.
    let wrong = |t: f64| ride(1.0)(t) + if (6.0..6.5).contains(&t) { 0.1 } else { 0.0 };
    let wrong = computed(&record(20.0, wrong, true, |_| true));
    let [a, b] = [&right.moves[0], &wrong.moves[0]];
    assert!(a.closure_sigmas.unwrap() < 4.0 && a.reason.is_none());
    assert!(b.closure_sigmas.unwrap() > 4.0 && b.reason.is_some());
    assert!(!kinds(&right).contains(&"closure-contradicts"));
    assert!(kinds(&wrong).contains(&"closure-contradicts"));
    let [narrow, wide] = [a, b].map(|m| m.sigma_m.unwrap()[0]);
    // What the data sheet leaves open is in both; the rest is one step of the velocity at an
    // unknown moment.
    let step = 0.05 * (b.end_s - b.start_s) / 12.0_f64.sqrt();
    let more = (wide * wide - narrow * narrow).sqrt();
    assert!(more > 0.9 * step && more < 1.5 * step, "{narrow} {wide}");
}

#[test]
fn what_is_not_seen_to_move_is_not_certain_to_rest() {
    for (with_gyro, distance_m) in [(true, 0.0), (true, 0.004), (false, 0.0), (false, 0.004)] {
        // The smoothest path from rest to rest in 2 s.
        let hidden = |t: f64| {
            let s = ((t - 6.0) / 2.0).clamp(0.0, 1.0);
            distance_m / 4.0 * 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s)
        };
        let recording = record(15.0, hidden, with_gyro, |_| true);
        let whole = motion(&recording, None, &MotionOptions::default()).unwrap();
        let result = whole.result;
        assert!(result.moves.is_empty(), "{:?}", result.rests);
        let sigma = result.r#final.sigma_m.unwrap()[0];
        assert!(
            sigma > 0.5 * distance_m && sigma > 0.01 && sigma < 3.0,
            "{sigma}"
        );
        assert!(kinds(&result).contains(&"slow-moves-hidden"));
        let all = &result.visible_moves;
        assert!(
            all.windows(2).all(|w| w[0].distance_m < w[1].distance_m),
            "{all:?}"
        );
        let of_2_s = all.iter().find(|v| v.seconds == 2.0).unwrap().distance_m;
        assert!(of_2_s > 0.01 && of_2_s < 0.05, "{of_2_s}");
        let last = whole.track.sigma_position_m.last().unwrap();
        assert_eq!(*last, result.r#final.sigma_m.unwrap());
        assert_eq!(whole.track.sigma_position_m[0].map(|s| s < 1e-3), [true; 3]);
    }
}

#[test]
fn a_rest_that_nothing_confirms_gives_no_band() {
    // Quiet for 1.2 s in the middle of two shakes.
    let shake = |t: f64| match t {
        t if (2.0..3.2).contains(&t) => 0.0,
        t => 2.0 * (9.0 * t).sin(),
    };
    let result = computed(&record(5.0, shake, true, |_| true));
    assert_eq!(result.rests.len(), 1, "{:?}", result.rests);
    assert!(kinds(&result).contains(&"rest-unconfirmed"));
    assert!(result.moves.iter().all(|m| !m.usable && m.reason.is_some()));
    assert!(result.r#final.sigma_m.is_none());
}

#[test]
fn a_bias_that_drifts_in_the_rest_after_a_move_shows_as_tilt() {
    // 0.1 m/s² come in the move and stay: the tilt at its end is off by half a degree.
    let drift = |t: f64| ride(1.0)(t) + 0.05 * (t - 5.0).clamp(0.0, 2.0);
    let result = computed(&record(20.0, drift, true, |_| true));
    let one = &result.moves[0];
    assert!(one.closure_sigmas.unwrap() > 4.0 && one.reason.is_some());
    let off = one.displacement_m.unwrap()[0] - 0.75;
    assert!(off.abs() < 2.0 * one.sigma_m.unwrap()[0], "{off}");
}

#[test]
fn rests_by_hand_are_believed() {
    let options = MotionOptions {
        rests_s: Some(vec![(0.0, 4.9), (7.0, 9.0), (12.2, f64::INFINITY)]),
        ..MotionOptions::default()
    };
    let recording = record(20.0, ride(6.0), true, |_| true);
    let result = motion(&recording, None, &options).unwrap().result;
    assert_eq!(result.moves.len(), 2);
    assert!(result.moves.iter().all(|m| m.ends == Ends::RestToRest));
}

#[test]
fn a_gap_in_one_move_keeps_the_others() {
    let two = |t: f64| ride(0.5)(t) + ride(0.5)(t - 7.0);
    let whole = computed(&record(20.0, two, true, |_| true));
    assert_eq!(whole.moves.len(), 2);
    let torn = computed(&record(20.0, two, true, |t| !(5.3..6.1).contains(&t)));
    assert!(!torn.moves[0].usable && torn.moves[1].usable);
    let (a, b) = (whole.moves[1].displacement_m, torn.moves[1].displacement_m);
    assert!((a.unwrap()[0] - b.unwrap()[0]).abs() < 0.02);
    assert!(torn.r#final.position_m.is_none() && torn.r#final.sigma_m.is_none());
    assert!(kinds(&torn).contains(&"move-unusable"));
    // The same gap at rest loses nothing.
    let quiet = computed(&record(20.0, two, true, |t| !(2.0..2.8).contains(&t)));
    assert_eq!(quiet.moves.len(), 2);
    assert!(quiet.r#final.position_m.is_some());
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
fn never_at_rest_is_said() {
    let result = computed(&record(10.0, |t| 2.0 * (9.0 * t).sin(), false, |_| true));
    assert!(
        kinds(&result).contains(&"no-static-interval"),
        "{:?}",
        result.rests
    );
    assert!(result.moves.iter().all(|m| m.ends == Ends::Free));
}

#[test]
fn a_gap_right_after_the_first_row_leaves_no_position() {
    let recording = record(8.0, ride(0.2), true, |t| !(0.005..=1.0).contains(&t));
    let result = motion(&recording, None, &MotionOptions::report())
        .unwrap()
        .result;
    assert!(result.r#final.position_m.is_none(), "{:?}", result.r#final);
    assert!(result.budget_m.is_none());
    assert!(result.moves.iter().all(|m| !m.usable));
}

#[test]
fn without_a_rest_there_is_no_band() {
    let result = computed(&record(10.0, |t| 2.0 * (9.0 * t).sin(), true, |_| true));
    assert!(kinds(&result).contains(&"no-static-interval"));
    assert!(result.r#final.sigma_m.is_none() && result.budget_m.is_none());
}

#[test]
fn a_velocity_at_the_start_beside_a_rest_is_told() {
    let recording = record(12.0, ride(1.0), true, |_| true);
    let options = MotionOptions {
        v0_mps: Some([1.0, 0.0, 0.0]),
        ..MotionOptions::default()
    };
    let result = motion(&recording, None, &options).unwrap().result;
    assert!(kinds(&result).contains(&"v0-not-used"));
    let plain = computed(&recording);
    assert_eq!(result.r#final, plain.r#final);
    // Without zero velocity it counts from the first sample on.
    let open = |v0: f64| {
        let options = MotionOptions {
            v0_mps: Some([v0, 0.0, 0.0]),
            zero_velocity: false,
            ..MotionOptions::default()
        };
        let result = motion(&recording, None, &options).unwrap().result;
        result.r#final.position_m.unwrap()[0]
    };
    assert!((open(1.0) - open(0.0) - 11.99).abs() < 1e-6);
}

#[test]
fn a_turn_makes_the_way_after_it_uncertain_across() {
    // Half a turn about the vertical in place, a rest, then along x.
    let turned = |turn: bool| {
        let mut text =
            "t_s,ax (m/s^2),ay (m/s^2),az (m/s^2),gx (rad/s),gy (rad/s),gz (rad/s)\n".to_owned();
        for i in 0..1600_usize {
            let t = 0.01 * i as f64;
            let spin = if turn && (4.0..6.0).contains(&t) {
                let tau = (t - 4.0) / 2.0;
                std::f64::consts::PI * 15.0 * (tau * (1.0 - tau)).powi(2)
            } else {
                0.0
            };
            text += &format!(
                "{t:.2},{:.5},{:.5},{:.5},{:.6},{:.6},{:.6}\n",
                ride(1.0)(t - 5.0) + 0.02 * noise(i, 0),
                0.02 * noise(i, 1),
                9.80665 + 0.02 * noise(i, 2),
                0.001 * noise(i, 3),
                0.001 * noise(i, 4),
                spin + 0.001 * noise(i, 5)
            );
        }
        let recording = read_bytes(text.as_bytes(), "turn.csv", &ReadOptions::default()).unwrap();
        let result = computed(&recording);
        let last = result.moves.last().unwrap();
        let (way, sigma) = (last.displacement_m.unwrap(), last.sigma_m.unwrap());
        (way[0], sigma[1])
    };
    let (straight, without) = turned(false);
    let (back, with) = turned(true);
    assert!(straight > 0.7 && back < -0.7, "{straight} {back}");
    // 3 % of half a turn is 5.4°: 9 cm across a way of a metre.
    let expected = 0.03 * std::f64::consts::PI * back.abs();
    assert!(
        with > 0.9 * expected.hypot(without),
        "{with} {without} {expected}"
    );
    assert!(
        with < 1.3 * expected.hypot(without),
        "{with} {without} {expected}"
    );
}

#[test]
fn a_table_that_is_written_on_the_way_is_the_one_of_the_whole() {
    let two = |t: f64| ride(0.5)(t) + ride(0.5)(t - 7.0);
    let report = MotionOptions::report();
    let open = MotionOptions {
        zero_velocity: false,
        ..MotionOptions::default()
    };
    let usual = MotionOptions::default();
    for (options, keep) in [
        (&usual, (|_| true) as fn(f64) -> bool),
        (&usual, |t| !(5.3..6.1).contains(&t)),
        // In motion at the start, which is computed backwards, and at the end.
        (&usual, |t| (5.25..13.0).contains(&t)),
        // One move of more rows than are computed at a time.
        (&open, |_| true),
        (&report, |_| true),
    ] {
        let recording = record(60.0, two, true, keep);
        let whole = motion(&recording, None, options).unwrap();
        let mut expected = Vec::new();
        write_table(&whole.track, &mut expected).unwrap();
        let mut text = Vec::new();
        let mut table = Table::new(&mut text);
        let result = motion_into(&mut recording.clone(), None, options, Some(&mut table)).unwrap();
        table.finish().unwrap();
        assert!(text == expected);
        assert_eq!(
            text.iter().filter(|b| **b == b'\n').count(),
            1 + recording.rows()
        );
        assert_eq!(result, whole.result);
        // Without a table only the ends are computed.
        let result = motion_into(&mut recording.clone(), None, options, None).unwrap();
        assert_eq!(result, whole.result);
    }
}

#[test]
fn ten_minutes_of_rest_while_the_sensor_warms_up_are_one_rest() {
    for (seed, low_pass_hz) in [(1, 44.0), (2, 44.0), (1, 10.0), (2, 5.0)] {
        let mut options = SimulateOptions::new(Scenario::Static(StaticOptions {
            duration_s: 600.0,
            soak: None,
        }));
        options.seed = seed;
        options.sensor.low_pass_hz = Some(low_pass_hz);
        let result = computed(&recorded(&options));
        assert!(
            result.moves.is_empty(),
            "{low_pass_hz} Hz: {:?}",
            result.moves
        );
        assert_eq!(result.rests.len(), 1, "{low_pass_hz} Hz");
    }
}

#[test]
fn a_line_is_one_move_at_any_rate_and_however_slow() {
    for (rate_hz, move_time_s) in [
        (25.0, 2.0),
        (50.0, 2.0),
        (400.0, 2.0),
        (100.0, 8.0),
        (100.0, 16.0),
    ] {
        for seed in 0..4 {
            let mut options = SimulateOptions::new(Scenario::Line(LineOptions {
                move_time_s,
                ..LineOptions::default()
            }));
            (options.seed, options.rate_hz) = (seed, rate_hz);
            let result = computed(&recorded(&options));
            assert_eq!(
                result.moves.len(),
                1,
                "{rate_hz} Hz, {move_time_s} s, seed {seed}"
            );
        }
    }
}
