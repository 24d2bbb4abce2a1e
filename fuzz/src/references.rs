//! References of `motion --truth`.

use std::fs;
use std::path::Path;
use std::sync::OnceLock;

use gravical::motion::truth::{Reference, add_comparison, read_reference};
use gravical::motion::{Motion, MotionOptions, motion};
use gravical::recording::{ReadOptions, Recording, read, read_bytes};

/// Longer inputs only make a run slower.
const MOST: usize = 16 << 10;

/// A push along x between two rests: ten seconds at 50 Hz, with noise, one sample
/// lost and one stamp late.
fn push() -> &'static Recording {
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
            let (x, z) = (push + noise, 9.8 + noise);
            text.push_str(&format!("{t:.3},{x:.4},{noise:.4},{z:.4}\n"));
        }
        read_bytes(text.as_bytes(), "push.csv", &ReadOptions::default())
            .unwrap_or_else(|e| unreachable!("{e}"))
    })
}

/// Its motion.
fn pushed() -> &'static Motion {
    static PUSHED: OnceLock<Motion> = OnceLock::new();
    PUSHED.get_or_init(|| {
        motion(push(), None, &MotionOptions::default()).unwrap_or_else(|e| unreachable!("{e}"))
    })
}

/// A byte chooses options, a table follows: with an odd one the table is the recording itself.
///
/// What is accepted has stamps in order with a position each; the comparison is
/// refused or finite.
pub fn reference(data: &[u8]) {
    let [first, table @ ..] = data else {
        return;
    };
    let table = &table[..table.len().min(MOST)];
    let Ok(file) = tempfile::NamedTempFile::new() else {
        return;
    };
    if fs::write(file.path(), table).is_err() {
        return;
    }
    if first & 1 == 0 {
        if let Ok(reference) = read_reference(file.path(), push(), Path::new("push.csv")) {
            compared(pushed().clone(), &reference);
        }
        return;
    }
    let Ok(recording) = read(file.path(), &ReadOptions::default()) else {
        return;
    };
    let own = |r: &Recording| read_reference(file.path(), r, file.path());
    let usual = MotionOptions::default();
    if let (Ok(reference), Ok(motion)) = (own(&recording), motion(&recording, None, &usual)) {
        assert!(reference.same_file);
        compared(motion, &reference);
    }
}

fn compared(mut motion: Motion, reference: &Reference) {
    assert_eq!(reference.t_s.len(), reference.position_m.len());
    assert!(reference.t_s.len() >= 2, "{reference:?}");
    assert!(reference.t_s.iter().all(|t| t.is_finite()));
    assert!(reference.t_s.is_sorted(), "{:?}", reference.t_s);
    assert!(reference.position_m.iter().flatten().all(|v| v.is_finite()));
    if add_comparison(&mut motion, reference).is_err() {
        return;
    }
    let Some(c) = &motion.result.truth else {
        unreachable!("compared, and nothing is said");
    };
    let mut lengths_m = [c.end_error_m, c.rmse_m, c.path_m].into_iter();
    assert!(lengths_m.all(f64::is_finite), "{c:?}");
    let mut others = [c.from_s, c.to_s, c.time_offset_s, c.yaw_deg].into_iter();
    assert!(others.all(f64::is_finite), "{c:?}");
    assert!(c.from_s <= c.to_s && c.points > 0, "{c:?}");
    let Some(track) = &motion.reference else {
        unreachable!("compared, and no track");
    };
    assert_eq!(track.t_s.len(), track.position_m.len());
}
