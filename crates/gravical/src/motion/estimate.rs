//! Samples and what the engine makes of them.

use gravical_motion::{Motion, Move, PathNode, Samples};

use crate::Result;
use crate::denoise::{Filter, FilterSpec};

/// Rows that the mean of the student report is over.
const ROWS: usize = 500;

/// An estimate, and the samples that it is of.
#[derive(Debug, Clone)]
pub(super) struct Estimate {
    pub samples: Samples,
    pub motion: Motion,
}

impl Estimate {
    /// By the procedure of the student report: Savitzky–Golay, the mean of the first rows off, trapezoid. One move
    /// in the axes of the sensor, without rests and bands.
    ///
    /// # Errors
    ///
    /// None that can happen: the filter is one that can be designed.
    pub fn by_report(samples: Samples) -> Result<Self> {
        let t = &samples.time_s;
        let savgol = FilterSpec::SavitzkyGolay {
            window: 5,
            order: 2,
        };
        let filter = Filter::design(&savgol, None)?;
        let columns: [Vec<f64>; 3] = std::array::from_fn(|c| {
            let mut column: Vec<f64> = samples.force_mps2.iter().map(|f| f[c]).collect();
            for piece in &samples.pieces {
                filter.apply(&mut column[piece.clone()]);
            }
            let rows = &column[..ROWS.min(column.len())];
            let mean = rows.iter().sum::<f64>() / rows.len() as f64;
            column.iter_mut().for_each(|v| *v -= mean);
            column
        });
        let mut node = PathNode {
            sample: 0,
            position_m: [0.0; 3],
            position_sd_m: [f64::NAN; 3],
            velocity_mps: [0.0; 3],
            velocity_sd_mps: [f64::NAN; 3],
            attitude: [1.0, 0.0, 0.0, 0.0],
            attitude_sd_rad: [f64::NAN; 3],
        };
        let mut path = vec![node.clone()];
        for i in 1..t.len() {
            let h = t[i] - t[i - 1];
            for c in 0..3 {
                let faster = 0.5 * (columns[c][i - 1] + columns[c][i]) * h;
                node.position_m[c] += (node.velocity_mps[c] + 0.5 * faster) * h;
                node.velocity_mps[c] += faster;
            }
            node.sample = i;
            path.push(node.clone());
        }
        let whole = Move {
            samples: 0..node.sample,
            displacement_m: node.position_m,
            sd_m: [f64::NAN; 3],
            ..Move::default()
        };
        let motion = Motion {
            moves: vec![whole],
            path,
            ..Motion::default()
        };
        Ok(Estimate { samples, motion })
    }
}
