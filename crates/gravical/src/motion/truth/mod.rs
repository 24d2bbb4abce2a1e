//! Motion against a reference: a track of the same motion that somebody else
//! measured, with a camera or on a rail.
//!
//! Both tracks start at 0 at their first common time. The reference is brought
//! onto the recording's clock by an offset (`offset`) and into the frame of the
//! result by a rotation (`align`); then errors stand beside the uncertainties
//! of their axes (`compare`).
//!
//! What an alignment takes out is not judged any more: the offset hides a delay,
//! the yaw hides the heading, the full rotation hides an error of the tilt.

mod align;
mod columns;
mod compare;
mod line;
mod offset;
mod read;
#[cfg(test)]
mod tests;

pub use super::result::TruthAlign;

use super::Motion;
use crate::{Error, Result};

pub use columns::LengthUnit;
pub use read::{Reference, read_reference};

/// How a reference is compared.
#[derive(Debug, Clone, Default)]
pub struct TruthOptions {
    /// Names of its columns. Default: `t_s,px_m,py_m,pz_m` and what else is
    /// called a position.
    pub columns: Option<TruthColumns>,
    /// How it is turned. Default: as the data ask for; that is by a yaw, or by a
    /// full rotation where its z is not up.
    pub align: Option<TruthAlign>,
    /// Added to the reference's stamps, s. Default: found by the speeds; 0 for
    /// columns of the recording itself.
    pub offset_s: Option<f64>,
}

impl TruthOptions {
    /// Checks ranges.
    ///
    /// # Errors
    ///
    /// `option-range` (usage).
    pub fn validate(&self) -> Result<()> {
        match self.offset_s {
            Some(offset) if !offset.is_finite() => Err(Error::range(
                "offset_s",
                format!("{offset} is no number of seconds"),
            )),
            _ => Ok(()),
        }
    }
}

/// Columns of a reference by name: `t=time,px=pos_x,py=pos_y,pz=pos_z`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TruthColumns {
    /// Time stamps; not needed where the reference stands in the recording.
    pub time: Option<String>,
    /// Position along x, y and z.
    pub position: [String; 3],
}

impl std::str::FromStr for TruthColumns {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let wrong = |what: String| {
            Error::usage("truth-columns", what)
                .with_hint("write it as t=TIME,px=X,py=Y,pz=Z, with the names of the columns")
        };
        let mut time = None;
        let mut position = [None, None, None];
        for pair in text.split(',') {
            let Some((channel, name)) = pair.split_once('=') else {
                return Err(wrong(format!("\"{pair}\" has no =")));
            };
            let slot = match channel.trim() {
                "t" => &mut time,
                "px" => &mut position[0],
                "py" => &mut position[1],
                "pz" => &mut position[2],
                other => return Err(wrong(format!("there is no channel \"{other}\""))),
            };
            *slot = Some(name.trim().to_owned());
        }
        match position {
            [Some(x), Some(y), Some(z)] => Ok(TruthColumns {
                time,
                position: [x, y, z],
            }),
            _ => Err(wrong("px, py and pz have to be named".to_owned())),
        }
    }
}

/// Compares `motion` with `reference`: its result gets the comparison and what
/// is odd about it, its track the reference.
///
/// # Errors
///
/// `truth-overlap` (input) when the two have no time in common; `option-range`
/// (usage).
pub fn add_comparison(
    motion: &mut Motion,
    reference: &Reference,
    options: &TruthOptions,
) -> Result<()> {
    options.validate()?;
    let mut findings = reference.findings.clone();
    let (comparison, track) = compare::compare(motion, reference, options, &mut findings)?;
    for finding in &mut findings {
        finding.file.get_or_insert_with(|| reference.source.clone());
    }
    motion.result.findings.extend(findings);
    motion.result.truth = Some(comparison);
    motion.track.reference = Some(track);
    Ok(())
}
