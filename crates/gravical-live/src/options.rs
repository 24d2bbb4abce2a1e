//! How a session is guided.

use gravical_calibrate::gravity::Gravity;
use gravical_calibrate::recording::ReadOptions;

/// How a session is guided.
#[derive(Debug, Clone)]
pub struct LiveOptions {
    /// How the recording is read where it does not say so itself.
    pub read: ReadOptions,
    /// Local gravity.
    pub gravity: Gravity,
    /// Rest before the noise is known, s. Default 3.
    pub floor_s: f64,
    /// Rest before a capture begins, s. Default 0.5.
    pub settle_s: f64,
    /// Length of a capture, s. Default 2.5: with the rest before it a hold of three seconds.
    pub capture_s: f64,
    /// Accept every steady hold: repeats, and free poses before the faces, too. Default false.
    pub any_pose: bool,
}

impl Default for LiveOptions {
    fn default() -> Self {
        LiveOptions {
            read: ReadOptions::default(),
            gravity: Gravity::default(),
            floor_s: 3.0,
            settle_s: 0.5,
            capture_s: 2.5,
            any_pose: false,
        }
    }
}
