//! How a sensor sits in its case, and how the case lies.

use gravical_fit::Face;
use serde::{Deserialize, Serialize};

use crate::attitude::AXES;
use crate::problem::Problem;
use crate::{Error, Result};

/// Angle to the nearest face up to which a pose is one on it, degrees.
pub const MAX_FACE_ANGLE_DEG: f64 = 25.0;

/// How the board sits in its case: row i says which board axis, with sign, is
/// the case's axis i.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct AxisMap {
    /// Sensor axes along the case's x,y,z, e.g. y,-x,z
    #[cfg_attr(feature = "clap", arg(id = "axes", long = "axes", value_name = "X,Y,Z", value_parser = parse_rows, default_value = "x,y,z", allow_hyphen_values = true, hide_default_value = true, hide_short_help = true))]
    rows: [(usize, bool); 3],
}

/// The option `--axes` of every verb that turns readings into the axes of the case.
#[cfg(feature = "clap")]
fn parse_rows(text: &str) -> Result<[(usize, bool); 3]> {
    text.parse::<AxisMap>().map(|map| map.rows)
}

impl Default for AxisMap {
    fn default() -> Self {
        AxisMap {
            rows: [(0, true), (1, true), (2, true)],
        }
    }
}

impl AxisMap {
    /// A board reading seen in the case's axes.
    pub fn to_case(&self, board: [f64; 3]) -> [f64; 3] {
        self.rows
            .map(|(axis, same)| if same { board[axis] } else { -board[axis] })
    }

    /// The case's axis along which the board's axis `board` lies.
    pub fn case_axis(&self, board: usize) -> usize {
        self.rows
            .iter()
            .position(|(axis, _)| *axis == board)
            .unwrap_or(board)
    }

    /// The map whose case calls the faces of this one's case by other names:
    /// `sent` is what the names call each face that the data show, in the order of
    /// [`Face::all`]. None where no way of mounting and no sign of the sensor
    /// explains them.
    pub fn renamed(&self, sent: &[Face; 6]) -> Option<AxisMap> {
        let mut rows = self.rows;
        for (row, face) in rows.iter_mut().zip(Face::all().into_iter().step_by(2)) {
            let shown = Face::all()[sent.iter().position(|s| *s == face)?];
            if sent[shown.opposite().index()] != face.opposite() {
                return None;
            }
            let (axis, same) = self.rows[shown.axis];
            *row = (axis, shown.up == same);
        }
        let map = AxisMap { rows };
        (!map.mirrors() || map.inverts()).then_some(map)
    }

    /// The map of a case whose z and x point up where these axes of the board do; none of one axis.
    fn of_up(z: Face, x: Face) -> Option<AxisMap> {
        let y = (0..3).find(|y| ![z.axis, x.axis].contains(y) && z.axis != x.axis)?;
        let rows = |same| [(x.axis, x.up), (y, same), (z.axis, z.up)];
        let maps = [true, false].map(|same| AxisMap { rows: rows(same) });
        maps.into_iter().find(|map| !map.mirrors())
    }

    /// Each sign turns the hand over, and so does a swap of two axes.
    fn mirrors(&self) -> bool {
        let [(a, _), (b, _), _] = self.rows;
        let even = (b + 3 - a) % 3 == 1;
        let flips = self.rows.iter().filter(|(_, same)| !same).count();
        even != (flips % 2 == 0)
    }

    /// `-x,-y,-z`: no mounting, but an accelerometer that reads −g on the axis
    /// that points up, as phones do.
    fn inverts(&self) -> bool {
        self.rows == [(0, false), (1, false), (2, false)]
    }

    /// The map of angular rates, which are axial: the sign of an accelerometer's
    /// axes is none of the gyroscope's.
    pub fn of_rates(self) -> AxisMap {
        let flip = self.mirrors();
        AxisMap {
            rows: self.rows.map(|(axis, same)| (axis, same != flip)),
        }
    }
}

/// What two placements say of the axes of the case: they are as `axes` has them if it lay with its z up in the one,
/// and with its x up in the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct CaseAxes {
    /// Number of the first placement on a face, from 1.
    pub z_up: usize,
    /// Number of the first one after it on another axis.
    pub x_up: usize,
    /// The map.
    #[serde(serialize_with = "as_text")]
    pub axes: AxisMap,
}

fn as_text<S: serde::Serializer>(axes: &AxisMap, to: S) -> std::result::Result<S::Ok, S::Error> {
    to.collect_str(axes)
}

impl CaseAxes {
    /// Of mean specific forces at rest in the axes of the board, in order; none where fewer than two axes were up.
    pub fn of(means: impl IntoIterator<Item = [f64; 3]>) -> Option<CaseAxes> {
        let faces = (1..).zip(means.into_iter().map(Face::nearest));
        let mut faces = faces.filter(|(_, (_, angle_deg))| *angle_deg <= MAX_FACE_ANGLE_DEG);
        let (z_up, (z, _)) = faces.next()?;
        faces.find_map(|(x_up, (x, _))| {
            let axes = AxisMap::of_up(z, x)?;
            Some(CaseAxes { z_up, x_up, axes })
        })
    }
}

impl CaseAxes {
    /// What to give, if the case lay so; `what` is a pose or an interval.
    pub fn advice(&self, what: &str) -> String {
        let CaseAxes { z_up, x_up, axes } = self;
        format!(
            "If the case lay with z up in {what} {z_up} and x up in {what} {x_up}, `--axes {axes}` gives its axes."
        )
    }
}

impl std::fmt::Display for AxisMap {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [x, y, z] = self
            .rows
            .map(|(axis, same)| format!("{}{}", if same { "" } else { "-" }, AXES[axis]));
        write!(f, "{x},{y},{z}")
    }
}

impl std::str::FromStr for AxisMap {
    type Err = Error;

    /// `x,-z,y`: the case's x is the board's x, its y the board's −z, its z the
    /// board's y. `-x,-y,-z` is the one map that mirrors: an accelerometer whose
    /// signs are the other way round.
    fn from_str(text: &str) -> Result<Self> {
        let given = || text.to_owned();
        let row = |part: &str| {
            let part = part.trim().to_lowercase();
            let is_named = |face: &Face| [&part, &format!("+{part}")].contains(&&face.name());
            let face = Face::all().into_iter().find(is_named);
            face.map(|face| (face.axis, face.up))
        };
        let rows: Option<Vec<(usize, bool)>> = text.split(',').map(row).collect();
        let rows = rows.ok_or_else(|| Problem::NoAxis { text: given() }.error())?;
        let is_complete = (0..3).all(|axis: usize| rows.iter().any(|row| row.0 == axis));
        let rows = <[(usize, bool); 3]>::try_from(rows).ok();
        let rows = rows.filter(|_| is_complete);
        let rows = rows.ok_or_else(|| Problem::NotEachOnce { text: given() }.error())?;
        let map = AxisMap { rows };
        if map.mirrors() && !map.inverts() {
            return Err(Problem::Mirrors { text: given() }.error());
        }
        Ok(map)
    }
}
