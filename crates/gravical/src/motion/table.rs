//! Motion as a table: one row a sample, every column with its unit in its name.
//!
//! `t_s`; `raw_ax_mps2` … specific force by the nominal scale alone; `ax_mps2` …
//! calibrated; `still` 0 or 1; `qw`, `qx`, `qy`, `qz` attitude, sensor → frame
//! (Hamilton); `lin_ax_mps2` … acceleration in the frame without gravity;
//! `vx_mps` …, `px_m` …; with bands `sigma_vx_mps` …, `sigma_px_m` …. What is not
//! known is an empty field.

use std::io::{self, Write};

use super::{MotionSample, MotionSink, Track};
use crate::scan::write_fixed;

/// Names of the columns by the nominal scale alone, which a stream does not have.
const RAW: &str = ",raw_ax_mps2,raw_ay_mps2,raw_az_mps2";

/// Names of those that are always there, after the time.
const COLUMNS: &str = ",ax_mps2,ay_mps2,az_mps2,still,qw,qx,qy,qz,\
    lin_ax_mps2,lin_ay_mps2,lin_az_mps2,vx_mps,vy_mps,vz_mps,px_m,py_m,pz_m";

/// Names of those that come with bands.
const BANDS: &str = ",sigma_vx_mps,sigma_vy_mps,sigma_vz_mps,sigma_px_m,sigma_py_m,sigma_pz_m";

/// Decimals of accelerations, velocities and positions: 1 µm is below any
/// uncertainty there is.
const DECIMALS: u32 = 6;

/// Decimals of the attitude. Whoever turns gravity with it makes an error of
/// g · 1e-8, 5 µm in 10 s.
const ATTITUDE_DECIMALS: u32 = 8;

/// How much text is gathered before it is written.
const CHUNK: usize = 1 << 18;

/// Which columns there are, and how they are written.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layout {
    pub raw: bool,
    pub bands: bool,
    pub time_decimals: u32,
}

impl Layout {
    pub fn header(&self, text: &mut Vec<u8>) {
        text.extend_from_slice(b"t_s");
        let parts = [(self.raw, RAW), (true, COLUMNS), (self.bands, BANDS)];
        for (_, names) in parts.iter().filter(|(there, _)| *there) {
            text.extend_from_slice(names.as_bytes());
        }
        text.push(b'\n');
    }

    /// One line; `still` is empty where nothing tells.
    #[inline]
    pub fn row(&self, text: &mut Vec<u8>, sample: &MotionSample, still: Option<bool>) {
        write_fixed(text, sample.t_s, self.time_decimals);
        if self.raw {
            put(text, &sample.raw_mps2, DECIMALS);
        }
        put(text, &sample.force_mps2, DECIMALS);
        text.extend_from_slice(match still {
            Some(true) => b",1",
            Some(false) => b",0",
            None => b",",
        });
        put(text, &sample.attitude, ATTITUDE_DECIMALS);
        put(text, &sample.acceleration_mps2, DECIMALS);
        put(text, &sample.velocity_mps, DECIMALS);
        put(text, &sample.position_m, DECIMALS);
        if self.bands {
            put(text, &sample.sigma_velocity_mps, DECIMALS);
            put(text, &sample.sigma_position_m, DECIMALS);
        }
        text.push(b'\n');
    }
}

/// The table of a motion as CSV with a header, written as the samples come.
///
/// Time has 3, 6 or 9 decimals, the fewest that keep the recording's stamps;
/// the attitude has 8, all others have 6.
pub struct Table<'w> {
    out: &'w mut dyn Write,
    text: Vec<u8>,
    layout: Layout,
    /// What `out` said first; nothing is written after it.
    failed: Option<io::Error>,
}

impl<'w> Table<'w> {
    /// A table that goes to `out`.
    pub fn new(out: &'w mut dyn Write) -> Self {
        Table {
            out,
            text: Vec::with_capacity(CHUNK + 1024),
            layout: Layout {
                raw: true,
                bands: false,
                time_decimals: 9,
            },
            failed: None,
        }
    }

    /// Writes what is left.
    ///
    /// # Errors
    ///
    /// What the output said, now or before.
    pub fn finish(mut self) -> io::Result<()> {
        self.write();
        match self.failed {
            Some(error) => Err(error),
            None => self.out.flush(),
        }
    }

    fn write(&mut self) {
        if self.failed.is_none() {
            self.failed = self.out.write_all(&self.text).err();
        }
        self.text.clear();
    }
}

impl MotionSink for Table<'_> {
    fn begin(&mut self, t_s: &[f64], _breaks: &[usize], bands: bool) {
        self.layout.bands = bands;
        self.layout.time_decimals = time_decimals(t_s);
        self.layout.header(&mut self.text);
    }

    fn sample(&mut self, sample: &MotionSample) {
        let still = Some(sample.still);
        self.layout.row(&mut self.text, sample, still);
        if self.text.len() >= CHUNK {
            self.write();
        }
    }
}

#[inline]
fn put(text: &mut Vec<u8>, values: &[f64], decimals: u32) {
    for value in values {
        text.push(b',');
        write_fixed(text, *value, decimals);
    }
}

/// Writes the table of a track that is there as a whole.
///
/// # Errors
///
/// What `out` says.
pub fn write_table(track: &Track, out: &mut dyn Write) -> io::Result<()> {
    let mut table = Table::new(out);
    table.begin(&track.t_s, &track.breaks, track.bands);
    (0..track.t_s.len()).for_each(|i| table.sample(&track.at(i)));
    table.finish()
}

/// The fewest of 3, 6 and 9 decimals that keep every stamp to a nanosecond:
/// stamps in ms have three, those of 1024 Hz more than six.
pub(super) fn time_decimals(t_s: &[f64]) -> u32 {
    for (decimals, power) in [(3, 1e3), (6, 1e6)] {
        let kept = |t: &f64| {
            let scaled = t * power;
            (scaled - scaled.round()).abs() <= 1e-9 * power
        };
        if t_s.iter().filter(|t| t.is_finite()).all(kept) {
            return decimals;
        }
    }
    9
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{ReadOptions, read_bytes};

    /// A track whose every value is another.
    fn track(rows: usize, bands: bool) -> Track {
        let value = |i: usize, column: usize| (column + 1) as f64 + 1e-3 * i as f64;
        let column = |c: usize| (0..rows).map(|i| value(i, c)).collect::<Vec<f64>>();
        let vectors = |c: usize| {
            (0..rows)
                .map(|i| [value(i, c), value(i, c + 1), value(i, c + 2)])
                .collect::<Vec<_>>()
        };
        let none = Vec::new;
        Track {
            bands,
            t_s: (0..rows).map(|i| 0.01 * i as f64).collect(),
            raw_mps2: [column(1), column(2), column(3)],
            force_mps2: [column(4), column(5), column(6)],
            still: (0..rows).map(|i| i % 2 == 0).collect(),
            attitude: vec![[1.0, 0.0, 0.0, 0.0]; rows],
            acceleration_mps2: vectors(12),
            velocity_mps: vectors(15),
            position_m: vectors(18),
            sigma_velocity_mps: if bands { vectors(21) } else { none() },
            sigma_position_m: if bands { vectors(24) } else { none() },
            ..Track::default()
        }
    }

    fn text(track: &Track) -> String {
        let mut out = Vec::new();
        write_table(track, &mut out).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn every_row_has_every_column_in_its_place() {
        for bands in [false, true] {
            let text = text(&track(3, bands));
            let mut lines = text.lines();
            let names: Vec<&str> = lines.next().unwrap().split(',').collect();
            assert_eq!(names.len(), if bands { 27 } else { 21 });
            for (i, line) in lines.enumerate() {
                let fields: Vec<&str> = line.split(',').collect();
                assert_eq!(fields.len(), names.len());
                for (k, (name, field)) in names.iter().zip(&fields).enumerate() {
                    match *name {
                        "t_s" => assert_eq!(*field, format!("0.0{i}0")),
                        "still" => assert_eq!(*field, if i % 2 == 0 { "1" } else { "0" }),
                        q if q.starts_with('q') => assert_eq!(field.len(), 10, "{name}"),
                        _ => assert_eq!(*field, format!("{}.00{i}000", k + 1), "{name}"),
                    }
                }
            }
        }
    }

    #[test]
    fn our_own_reader_takes_either_acceleration() {
        let table = text(&track(30, true));
        for (columns, x) in [
            (None, 2.007),
            (Some("t=t_s,ax=ax_mps2,ay=ay_mps2,az=az_mps2"), 5.007),
        ] {
            let options = ReadOptions {
                columns: columns.map(|c| c.parse().unwrap()),
                ..ReadOptions::default()
            };
            let recording = read_bytes(table.as_bytes(), "motion.csv", &options).unwrap();
            assert_eq!(recording.accel_at(7), [x, x + 1.0, x + 2.0]);
            assert!((recording.time_s.as_ref().unwrap()[7] - 0.07).abs() < 1e-12);
        }
    }

    #[test]
    fn what_is_not_known_is_an_empty_field() {
        let mut track = track(2, true);
        track.position_m[1] = [f64::NAN; 3];
        track.sigma_position_m[1] = [f64::INFINITY; 3];
        let text = text(&track);
        let last = text.lines().last().unwrap();
        assert!(last.contains(",,,,22.001000,"), "{last}");
        assert!(last.ends_with("24.001000,,,"), "{last}");
        assert!(!text.contains("NaN") && !text.contains("inf"));
        // Without a sample there is the header.
        assert_eq!(super::tests::text(&Track::default()).lines().count(), 1);
    }

    #[test]
    fn stamps_keep_their_digits() {
        assert_eq!(time_decimals(&[0.0, 0.016, 123_456.789]), 3);
        assert_eq!(time_decimals(&[0.0, 0.0035]), 6);
        assert_eq!(time_decimals(&[0.0, 1.0 / 1024.0]), 9);
        assert_eq!(time_decimals(&[f64::NAN, 1.5]), 3);
    }
}
