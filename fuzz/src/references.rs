//! References of `motion --truth`.

use std::fs;
use std::path::Path;

use gravical::motion::truth::{
    Reference, TruthAlign, TruthColumns, TruthOptions, add_comparison, read_reference,
};
use gravical::motion::{Motion, MotionOptions, motion};
use gravical::recording::{ReadOptions, Recording, read};

use super::options::{push, pushed};

/// Longer inputs only make a run slower.
const MOST: usize = 16 << 10;

/// `--truth-columns` by the low two bits of the first byte.
const COLUMNS: [Option<&str>; 4] = [
    None,
    Some("t=t_s,px=px_m,py=py_m,pz=pz_m"),
    Some("t=time,px=x,py=y,pz=z"),
    Some("px=px_m,py=py_m,pz=pz_m"),
];

/// Two bytes choose options, a table follows. In the first: which columns are named
/// (see [`COLUMNS`]), and 4 when the table is the recording itself; in the second:
/// how it is turned, and 4 for an offset. A digit from `0` to `7` is both.
///
/// What is accepted has stamps in order with a position each; the comparison is
/// refused or finite.
pub fn reference(data: &[u8]) {
    let [first, second, table @ ..] = data else {
        return;
    };
    let table = &table[..table.len().min(MOST)];
    let Ok(file) = tempfile::NamedTempFile::new() else {
        return;
    };
    if fs::write(file.path(), table).is_err() {
        return;
    }
    let columns = COLUMNS[usize::from(first & 3)];
    let columns = columns.and_then(|c| c.parse::<TruthColumns>().ok());
    let options = TruthOptions {
        columns: columns.clone(),
        align: [
            None,
            Some(TruthAlign::Yaw),
            Some(TruthAlign::Rotation),
            Some(TruthAlign::None),
        ][usize::from(second & 3)],
        offset_s: (second & 4 != 0).then_some(0.5),
    };
    if first & 4 == 0 {
        let read = |r| read_reference(file.path(), columns.as_ref(), r, Path::new("push.csv"));
        if let Ok(reference) = read(push()) {
            compared(pushed().clone(), &reference, &options);
        }
        return;
    }
    let Ok(recording) = read(file.path(), &ReadOptions::default()) else {
        return;
    };
    let own = |r: &Recording| read_reference(file.path(), columns.as_ref(), r, file.path());
    let without = MotionOptions {
        bands: false,
        ..MotionOptions::default()
    };
    if let (Ok(reference), Ok(motion)) = (own(&recording), motion(&recording, None, &without)) {
        assert!(reference.same_file);
        compared(motion, &reference, &options);
    }
}

fn compared(mut motion: Motion, reference: &Reference, options: &TruthOptions) {
    assert_eq!(reference.t_s.len(), reference.position.len());
    assert!(reference.t_s.len() >= 2, "{reference:?}");
    assert!(reference.t_s.iter().all(|t| t.is_finite()));
    assert!(reference.t_s.is_sorted(), "{:?}", reference.t_s);
    assert!(reference.position.iter().flatten().all(|v| v.is_finite()));
    if add_comparison(&mut motion, reference, options).is_err() {
        return;
    }
    let Some(c) = &motion.result.truth else {
        unreachable!("compared, and nothing is said");
    };
    for v in [
        c.end_error_m,
        c.rmse_m,
        c.path_m,
        c.from_s,
        c.to_s,
        c.time_offset_s,
    ] {
        assert!(v.is_finite(), "{c:?}");
    }
    assert!(c.rotation_deg.iter().all(|v| v.is_finite()), "{c:?}");
    assert!(c.from_s <= c.to_s && c.points > 0, "{c:?}");
    let Some(track) = &motion.track.reference else {
        unreachable!("compared, and no track");
    };
    assert_eq!(track.t_s.len(), track.position_m.len());
}
