//! Texts of options: filters, and where it rested.

use std::sync::OnceLock;

use gravical::denoise::{DenoiseOptions, Filter, FilterSpec, Passes, denoise};
use gravical::motion::Intervals;
use gravical::motion::{Motion, MotionOptions, motion};
use gravical::recording::{ReadOptions, Recording, read_bytes};

/// Longer texts only make a run slower.
const MOST: usize = 300;

/// Filters with wider windows are parsed, not run: what they do is what narrower ones
/// do, more slowly.
const WIDEST: usize = 301;

/// What the middle of a long constant may be off by behind a filter that keeps it,
/// relative: polynomials of order 12, and low cutoffs, cost this many digits.
const KEPT: f64 = 1e-4;

/// A push along x between two rests: ten seconds at 50 Hz, with noise, one sample
/// lost and one stamp late.
pub(crate) fn push() -> &'static Recording {
    static PUSH: OnceLock<Recording> = OnceLock::new();
    PUSH.get_or_init(|| {
        let mut text = String::from("time_s,ax_mps2,ay_mps2,az_mps2\n");
        for i in (0..500_u32).filter(|i| *i != 77) {
            let t = f64::from(i) * 0.02 + if i == 333 { 0.009 } else { 0.0 };
            let push = match i {
                200..300 => (std::f64::consts::PI * (f64::from(i) / 50.0 - 4.0)).sin(),
                _ => 0.0,
            };
            let noise = f64::from(i * 7919 % 13) * 1e-3;
            text.push_str(&format!(
                "{t:.3},{:.4},{noise:.4},{:.4}\n",
                push + noise,
                9.8 + noise
            ));
        }
        match read_bytes(text.as_bytes(), "push.csv", &ReadOptions::default()) {
            Ok(recording) => recording,
            Err(e) => unreachable!("{e}"),
        }
    })
}

/// Its motion.
pub(crate) fn pushed() -> &'static Motion {
    static PUSHED: OnceLock<Motion> = OnceLock::new();
    PUSHED.get_or_init(|| match motion(push(), None, &MotionOptions::default()) {
        Ok(motion) => motion,
        Err(e) => unreachable!("{e}"),
    })
}

fn text(data: &[u8]) -> Option<&str> {
    std::str::from_utf8(data.get(..data.len().min(MOST))?).ok()
}

/// A filter as text: what is accepted is in its ranges and says the same when it is
/// written and read again; where it can be had at a rate, it gives finite samples, as
/// many as there were, and keeps a constant that it claims to keep.
pub fn filter(data: &[u8]) {
    let Some(Ok(spec)) = text(data).map(str::parse::<FilterSpec>) else {
        return;
    };
    assert!(spec.validate().is_ok(), "{spec}");
    match spec.to_string().parse::<FilterSpec>() {
        Ok(again) => assert_eq!(again, spec, "{spec}"),
        Err(e) => unreachable!("{spec}: {e}"),
    }
    let window = match spec {
        FilterSpec::SavitzkyGolay { window, .. } | FilterSpec::Hampel { window, .. } => window,
        FilterSpec::Butterworth { .. } => 0,
    };
    if window > WIDEST {
        return;
    }
    for rate_hz in [None, Some(50.0), Some(1e4), Some(0.01)] {
        let Ok(filter) = Filter::design(&spec, rate_hz) else {
            continue;
        };
        let is_gain = |gain: f64| gain.is_finite() && gain >= 0.0;
        let gain = filter.noise_gain();
        assert!(gain.is_none_or(is_gain), "{spec} at {rate_hz:?}: {gain:?}");
        let mut samples: Vec<f64> = (0..1000_u32).map(|i| f64::from(i * i % 101)).collect();
        filter.apply(&mut samples);
        assert_eq!(samples.len(), 1000);
        let is_finite = samples.iter().all(|v| v.is_finite());
        assert!(is_finite, "{spec} at {rate_hz:?}");
        let passes = match spec {
            FilterSpec::Butterworth { passes, .. } => Some(passes),
            _ => None,
        };
        if spec.keeps_constants() && passes != Some(Passes::Causal) {
            let mut constant = vec![9.81; 1000];
            filter.apply(&mut constant);
            let off = (constant[500] / 9.81 - 1.0).abs();
            assert!(off < KEPT, "{spec} at {rate_hz:?}: {off}");
        }
    }
    if let Ok(done) = denoise(push().clone(), &DenoiseOptions::new([spec])) {
        assert_eq!(done.recording.rows(), push().rows(), "{spec}");
        let all = done.recording.accel.iter().flatten();
        assert!(all.into_iter().all(|v| v.is_finite()), "{spec}");
    }
}

/// Spans of rest as text: each has a start before its end; motion with them is
/// refused or has rests within the recording, in order.
pub fn intervals(data: &[u8]) {
    let Some(Ok(intervals)) = text(data).map(str::parse::<Intervals>) else {
        return;
    };
    assert!(!intervals.as_slice().is_empty());
    for (start, end) in intervals.as_slice() {
        assert!(start.is_finite() && start < end, "{intervals:?}");
    }
    let options = MotionOptions {
        rests: Some(intervals.clone()),
        ..MotionOptions::default()
    };
    let Ok(motion) = motion(push(), None, &options) else {
        return;
    };
    let result = &motion.result;
    let mut last_s = f64::NEG_INFINITY;
    for span in &result.rests {
        assert!(
            span.start_s <= span.end_s && last_s <= span.start_s,
            "{intervals:?}: {result:?}"
        );
        last_s = span.end_s;
    }
    assert!(last_s <= result.duration_s, "{intervals:?}");
    for p in motion.samples().flat_map(|s| s.state.position_m) {
        assert!(!p.is_infinite(), "{intervals:?}");
    }
}
