//! Rows that are filtered in blocks, compared with whole stretches filtered by definition.

use super::*;
use crate::denoise::clock::{Clock, Step};
use crate::denoise::filter::Treatment;
use crate::denoise::samples::Samples;
use crate::recording::sample::Sample;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

const CLOCK: Clock = Clock {
    step_s: 0.01,
    tolerance_s: 0.0005,
    gap_s: 0.1,
};

/// All kinds of filters; the memory of the Butterworth filters is shorter than most stretches.
const FILTERS: [&[&str]; 10] = [
    &["savgol:5,2"],
    &["savgol:21,4,1"],
    &["savgol:8,3"],
    &["mean:9"],
    &["hampel:7,2"],
    &["butter:2,20Hz"],
    &["butter:4,10-30Hz"],
    &["butter1:3,5Hz"],
    &["hampel:5,2", "highpass:1,15Hz", "savgol:7,2"],
    &["butter:8,25Hz", "butter:1,10Hz"],
];

/// Rows in which faults of random kinds are more or less frequent.
fn random_rows(seed: u64) -> Vec<Sample> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let count = random.random_range(1..900);
    let mut shares = [0.0; 8];
    for share in &mut shares {
        if random.random_bool(0.4) {
            *share = [0.002, 0.02, 0.2][random.random_range(0..3)];
        }
    }
    let mut time_s = 0.0;
    // Channels that are empty together.
    let mut mask = [false; 6];
    (0..count)
        .map(|_| {
            let is = shares.map(|share| random.random_bool(share));
            time_s += match is {
                [true, ..] => 0.01 * f64::from(random.random_range(2..6)),
                [_, true, ..] => 0.014,
                [_, _, true, ..] => 0.0,
                [_, _, _, true, ..] => 0.3,
                [_, _, _, _, true, ..] => -0.05,
                _ => 0.01,
            };
            if is[5] {
                let pattern = random.random_range(0..6);
                mask = std::array::from_fn(|c| match pattern {
                    0 => c >= 3,
                    1 => c == 1,
                    2 => random.random_bool(0.5),
                    _ => false,
                });
            }
            Sample {
                time_s: if is[6] { f64::NAN } else { time_s },
                values: std::array::from_fn(|c| match mask[c] {
                    true => f64::NAN,
                    false => 10.0 * random.random::<f64>().powi(9) + random.random::<f64>(),
                }),
                temperature_c: f64::NAN,
                is_break: is[7] && shares[7] < 0.1,
            }
        })
        .collect()
}

/// The times of all rows, with missing ones interpolated.
fn times(rows: &[Sample]) -> Vec<f64> {
    let known: Vec<usize> = (0..rows.len())
        .filter(|i| rows[*i].time_s.is_finite())
        .collect();
    let time = |i: usize| rows[i].time_s;
    (0..rows.len())
        .map(|i| {
            let next = known.partition_point(|k| *k < i);
            let before = next.checked_sub(1).map(|k| known[k]);
            match (before, known.get(next).copied()) {
                (_, Some(next)) if next == i => time(i),
                (Some(a), Some(b)) => {
                    time(a) + (i - a) as f64 * ((time(b) - time(a)) / (b - a) as f64)
                }
                (Some(a), None) => time(a) + (i - a) as f64 * 0.01,
                (None, Some(b)) => time(b) - (b - i) as f64 * 0.01,
                (None, None) => i as f64 * 0.01,
            }
        })
        .collect()
}

/// Rows of the stretches of a channel.
fn stretches(rows: &[Sample], time: &[f64], channel: usize) -> Vec<Vec<usize>> {
    let mut all: Vec<Vec<usize>> = vec![Vec::new()];
    for (i, row) in rows.iter().enumerate() {
        let last = all.last_mut().unwrap();
        let step = last.last().map(|before| CLOCK.step(time[*before], time[i]));
        let is_empty = row.values[channel].is_nan();
        let parted = match is_empty {
            true => step == Some(Step::Gap),
            false => step.is_some_and(Step::parts),
        };
        if row.is_break || parted {
            all.push(Vec::new());
        }
        if !is_empty {
            all.last_mut().unwrap().push(i);
        }
    }
    all.retain(|rows| !rows.is_empty());
    all
}

/// Linear interpolation of the means of samples with equal time stamps; constant beyond the ends.
fn interpolated(stamps: &[f64], values: &[f64], at: &[f64]) -> Vec<f64> {
    let mut points: Vec<(f64, f64, f64)> = Vec::new();
    for (t, value) in stamps.iter().zip(values) {
        match points.last_mut() {
            Some((last, sum, count)) if last == t => (*sum, *count) = (*sum + value, *count + 1.0),
            _ => points.push((*t, *value, 1.0)),
        }
    }
    let value = |i: usize| points[i].1 / points[i].2;
    at.iter()
        .map(|t| {
            let after = points.partition_point(|p| p.0 <= *t);
            let i = after.saturating_sub(1);
            if after == 0 || after == points.len() {
                return value(i);
            }
            let share = (t - points[i].0) / (points[after].0 - points[i].0);
            value(i) + share * (value(after) - value(i))
        })
        .collect()
}

/// A whole stretch of a channel, filtered at once.
fn by_definition(filter: &Filter, time: &[f64], x: &mut Vec<f64>, treatment: &mut Treatment) {
    let n = x.len();
    treatment.samples += n;
    if n < filter.shortest() {
        treatment.too_short += n;
        treatment.short_stretches += 1;
        return;
    }
    let steps: Vec<f64> = time.windows(2).map(|t| t[1] - t[0]).collect();
    let mut uneven = vec![0];
    for t in time.windows(2) {
        let last = uneven[uneven.len() - 1];
        uneven.push(last + usize::from(CLOCK.step(t[0], t[1]) == Step::Uneven));
    }
    let is_even = uneven[n - 1] == 0;
    if filter.butterworth().is_none() && !is_even {
        let channels = vec![x.clone()];
        let samples = Samples {
            time_s: time.to_vec(),
            uneven,
            channels,
        };
        let mut out = filter.over_window(&samples, 0..n, treatment);
        *x = std::mem::take(&mut out.channels[0]);
    } else if is_even {
        treatment.replaced += filter.apply(x);
    } else if steps
        .iter()
        .all(|s| super::super::grid::is_on_grid(*s, 0.01))
    {
        let mut place = 0.0;
        let mut places = vec![place];
        for step in &steps {
            place += (step / 0.01).round();
            places.push(place);
        }
        let grid: Vec<f64> = (0..=place as usize).map(|k| k as f64).collect();
        let mut even = interpolated(&places, x, &grid);
        if even.len() < filter.shortest() {
            treatment.too_short += n;
            treatment.short_stretches += 1;
            return;
        }
        filter.apply(&mut even);
        *x = places.iter().map(|p| even[*p as usize]).collect();
        places.dedup();
        treatment.filled += even.len() - places.len();
    } else {
        let count = ((time[n - 1] - time[0]) / 0.01).ceil() as usize + 1;
        let grid: Vec<f64> = (0..count).map(|k| time[0] + k as f64 * 0.01).collect();
        let mut even = interpolated(time, x, &grid);
        if even.len() < filter.shortest() {
            treatment.too_short += n;
            treatment.short_stretches += 1;
            return;
        }
        filter.apply(&mut even);
        let grid: Vec<f64> = (0..count).map(|k| k as f64).collect();
        let at: Vec<f64> = time.iter().map(|t| (t - time[0]) / 0.01).collect();
        *x = interpolated(&grid, &even, &at);
        treatment.resampled += n;
    }
}

/// All rows, each stretch at once.
fn whole(filters: &[Filter], rows: &[Sample]) -> ([Vec<f64>; 6], Vec<Treatment>) {
    let time = times(rows);
    let mut treatments = vec![Treatment::default(); filters.len()];
    let channels = std::array::from_fn(|c| {
        let mut all: Vec<f64> = rows.iter().map(|row| row.values[c]).collect();
        let stretches = stretches(rows, &time, c);
        for (filter, treatment) in filters.iter().zip(&mut treatments) {
            for rows in &stretches {
                let mut x: Vec<f64> = rows.iter().map(|i| all[*i]).collect();
                let time: Vec<f64> = rows.iter().map(|i| time[*i]).collect();
                by_definition(filter, &time, &mut x, treatment);
                rows.iter().zip(x).for_each(|(i, x)| all[*i] = x);
            }
        }
        all
    });
    (channels, treatments)
}

fn in_blocks(setup: &Setup, rows: &[Sample]) -> ([Vec<f64>; 6], Done) {
    let mut out: [Vec<f64>; 6] = Default::default();
    let mut run = Run::new(setup, Vec::new());
    let mut receive = |cells: &[Vec<f64>; 6], rows: usize| {
        for (out, cells) in out.iter_mut().zip(cells) {
            out.extend_from_slice(&cells[..rows]);
        }
        Ok(())
    };
    for row in rows {
        run.push(*row, &mut receive).unwrap();
    }
    let done = run.finish(&mut receive).unwrap();
    (out, done)
}

fn setup(filters: &[&str], edge: Edge, rows: &[Sample], block: usize) -> Setup {
    let mut scout = GridScout::new(CLOCK);
    let mut filler = StampFiller::new(CLOCK.step_s);
    rows.iter()
        .flat_map(|row| filler.push(*row))
        .for_each(|row| scout.push(row));
    filler.finish().into_iter().for_each(|row| scout.push(row));
    Setup {
        filters: filters.iter().map(|f| designed(f, 100.0, edge)).collect(),
        clock: CLOCK,
        off_grid: scout.finish(),
        stamped: true,
        channels: (0..6).collect(),
        block,
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn blocks_of_any_size_equal_the_whole(
        seed: u64,
        which in 0..FILTERS.len(),
        edge in 0_usize..4,
        block in 1_usize..300,
    ) {
        let rows = random_rows(seed);
        let edge = [Edge::Interp, Edge::Nearest, Edge::Mirror, Edge::Constant][edge];
        let setup = setup(FILTERS[which], edge, &rows, block);
        let (want, treatments) = whole(&setup.filters, &rows);
        let (got, done) = in_blocks(&setup, &rows);
        prop_assert_eq!(&done.treatments, &treatments);
        let empty = rows.iter().flat_map(|r| r.values).filter(|v| v.is_nan()).count();
        prop_assert_eq!(done.counts.empty, empty);
        let exact = setup.filters.iter().all(|f| f.butterworth().is_none());
        // The largest value is 11; a derivative is in 1/s.
        let allowed = if exact { 0.0 } else { 11e-12 };
        for (got, want) in got.iter().zip(&want) {
            prop_assert_eq!(got.len(), rows.len());
            for (row, (got, want)) in got.iter().zip(want).enumerate() {
                prop_assert!(
                    (got - want).abs() <= allowed || got.is_nan() && want.is_nan(),
                    "row {}: {} {}", row, got, want
                );
            }
        }
    }
}

/// Poses at 100 Hz, in more rows than a recording that is kept in memory: with labels, gaps, breaks,
/// uneven, lost and missing time stamps, and empty cells.
fn long_recording() -> String {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let mut text = "t_ms,ax,ay,az,gx (rad/s),gy (rad/s),gz (rad/s),label\n".to_owned();
    let mut t_ms = 0.0;
    for i in 0..270_000_u32 {
        let (pose, within) = (i / 9000, i % 9000);
        let turning = within < 300;
        t_ms += match i % 50_000 {
            12_000 => 30.0,
            20_000 => 500.0,
            30_000 => -40.0,
            40_000..41_000 => 10.0 + 8.0 * f64::from(i % 2) - 4.0,
            _ => 10.0,
        };
        if i % 90_000 == 70_000 {
            text += "\n\n";
        }
        let stamp = match i % 60_000 {
            25_000..25_050 => String::new(),
            _ => format!("{t_ms:.0}"),
        };
        text += &stamp;
        let swing = if turning {
            (0.02 * f64::from(within)).sin()
        } else {
            0.0
        };
        for c in 0..6 {
            let level = if pose % 3 == c {
                9.81
            } else {
                0.3 * f64::from(c)
            };
            let noise = 0.05 * (random.random::<f64>() - 0.5);
            let empty = c == 4 && i % 7000 == 50 || c >= 3 && i % 100_000 > 99_000 && i % 3 > 0;
            match empty {
                true => text.push(','),
                false if c < 3 => text += &format!(",{:.4}", level + noise + swing),
                false => text += &format!(",{:.4}", 0.1 * noise + swing),
            }
        }
        text += if pose % 2 == 0 { ",even\n" } else { ",odd\n" };
    }
    text
}

#[test]
fn a_long_file_is_filtered_as_in_memory() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("long.csv");
    let text = long_recording();
    std::fs::write(&path, &text).unwrap();
    let read = crate::recording::ReadOptions::default();
    let recording = crate::recording::read(&path, &read).unwrap();
    let filters = ["hampel:7,3", "savgol:11,3", "butter:4,5Hz"];
    let options = DenoiseOptions::new(filters.map(|f| f.parse().unwrap()));
    let memory = denoise(recording, &options).unwrap();
    let mut out = Vec::new();
    let file = denoise_file(&path, &read, &options, &mut out).unwrap();
    assert!(memory.summary.static_intervals > 20);

    let json = |summary: &DenoiseSummary| {
        let mut json = serde_json::to_value(summary).unwrap();
        json["columns"] = Value::Null;
        json
    };
    assert_eq!(json(&file.summary), json(&memory.summary));
    let kinds: Vec<&str> = memory
        .summary
        .findings
        .iter()
        .map(|f| f.kind.name())
        .collect();
    for kind in [
        "parted",
        "resampled",
        "lost-samples-filled",
        "stamps-filled",
        "empty-kept",
    ] {
        assert!(kinds.contains(&kind), "{kind}: {kinds:?}");
    }
    let written = String::from_utf8(out).unwrap();
    assert_eq!(written.lines().count(), text.lines().count());
    let recording = &memory.recording;
    let channels = recording
        .accel
        .iter()
        .chain(recording.gyro.as_ref().unwrap());
    let channels: Vec<&Vec<f64>> = channels.collect();
    let mut row = 0;
    for (line, before) in written.lines().zip(text.lines()).skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let recorded: Vec<&str> = before.split(',').collect();
        assert_eq!((cells[0], cells.last()), (recorded[0], recorded.last()));
        if line.is_empty() {
            continue;
        }
        for (cell, channel) in cells[1..7].iter().zip(&channels) {
            match cell.parse::<f64>() {
                Ok(value) => assert!((value - channel[row]).abs() < 0.51e-6, "{row}"),
                Err(_) => assert!(cell.is_empty() && channel[row].is_nan(), "{row}"),
            }
        }
        row += 1;
    }
    assert_eq!(row, recording.rows());
}
