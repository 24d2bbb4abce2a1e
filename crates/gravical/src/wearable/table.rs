//! The table: one row an epoch, every column with its unit in its name.

use std::io::Write as _;

use super::Zone;
use super::measures::Epoch;
use crate::scan::write_fixed;

/// Columns behind the first one.
const COLUMNS: [&str; 15] = [
    "ax_mean_g",
    "ay_mean_g",
    "az_mean_g",
    "norm_mean_g",
    "ax_sd_mg",
    "ay_sd_mg",
    "az_sd_mg",
    "norm_sd_mg",
    "enmo_mg",
    "mad_mg",
    "angle_z_deg",
    "nonwear",
    "temperature_c",
    "samples",
    "missing",
];

/// Decimals of values in g, in mg, of angles and of temperatures: a digit more than a sensor is
/// worth.
const DECIMALS_G: u32 = 5;
const DECIMALS_MG: u32 = 3;
const DECIMALS_DEG: u32 = 3;
const DECIMALS_C: u32 = 2;

/// The first column.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum TimeColumn {
    /// Date and time in a zone; the time of the first sample, s since 1970.
    Dates { origin_s: f64, zone: Zone },
    /// Seconds since the first sample.
    Relative,
}

impl TimeColumn {
    /// Where the time of the rows is 0, in the time of the epochs.
    #[inline]
    pub fn origin_s(&self) -> f64 {
        match self {
            TimeColumn::Dates { origin_s, .. } => *origin_s,
            TimeColumn::Relative => 0.0,
        }
    }

    /// Its name.
    pub fn name(&self) -> &'static str {
        match self {
            TimeColumn::Dates { .. } => "time",
            TimeColumn::Relative => "t_s",
        }
    }

    /// A time in it as text.
    pub fn text(&self, time_s: i64) -> String {
        match self {
            TimeColumn::Dates { zone, .. } => zone.text(time_s),
            TimeColumn::Relative => time_s.to_string(),
        }
    }

    /// Names of all columns.
    pub fn columns(&self) -> impl Iterator<Item = &'static str> {
        std::iter::once(self.name()).chain(COLUMNS)
    }

    /// Appends the line of names.
    pub fn header(&self, out: &mut Vec<u8>) {
        let names: Vec<&str> = self.columns().collect();
        out.extend_from_slice(names.join(",").as_bytes());
        out.push(b'\n');
    }
}

/// Appends the row of an epoch that starts at `start_s`; what is not known is an empty field.
pub(super) fn write_row(
    out: &mut Vec<u8>,
    time: &TimeColumn,
    start_s: i64,
    epoch: &Epoch,
    nonwear: Option<bool>,
) {
    match time {
        TimeColumn::Dates { zone, .. } => zone.write(out, start_s),
        TimeColumn::Relative => put(out, start_s),
    }
    let mut field = |value: f64, decimals: u32| {
        out.push(b',');
        write_fixed(out, value, decimals);
    };
    let m = &epoch.measures;
    m.mean_g.iter().for_each(|v| field(*v, DECIMALS_G));
    m.sd_g.iter().for_each(|v| field(1e3 * v, DECIMALS_MG));
    field(1e3 * m.enmo_g, DECIMALS_MG);
    field(1e3 * m.mad_g, DECIMALS_MG);
    field(m.angle_z_deg, DECIMALS_DEG);
    out.extend_from_slice(match nonwear {
        Some(true) => b",1",
        Some(false) => b",0",
        None => b",",
    });
    out.push(b',');
    write_fixed(out, m.temperature_c, DECIMALS_C);
    out.push(b',');
    put(out, m.samples);
    out.push(b',');
    put(out, epoch.missing);
    out.push(b'\n');
}

fn put(out: &mut Vec<u8>, number: impl std::fmt::Display) {
    // Writing into memory does not fail.
    let _ = write!(out, "{number}");
}
