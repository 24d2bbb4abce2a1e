//! Arguments of `gravical simulate`.

use std::path::PathBuf;

use gravical::simulate::{
    FileFormat, FileOptions, LineOptions, PosesOptions, Scenario, SensorOptions, SimulateOptions,
    SixPositionOptions, SoakOptions, StaticOptions,
};

/// Simulate recordings of an MPU6050 with known true errors
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: gravical simulate poses -o sim --seed 3 --free 8")]
pub struct Args {
    #[command(subcommand)]
    scenario: Command,
}

impl Args {
    /// Whether the truth and errors are printed as JSON.
    pub fn json(&self) -> bool {
        match &self.scenario {
            Command::SixPosition { shared, .. }
            | Command::Poses { shared, .. }
            | Command::Static { shared, .. }
            | Command::Line { shared, .. } => shared.json,
        }
    }
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    /// Six face poses, one file each, or one continuous session with turns
    SixPosition {
        /// Duration of each pose, s
        #[arg(long, value_name = "S", default_value_t = 10.0)]
        hold: f64,
        /// One recording, session.csv: the six poses with movements by hand between them, then a
        /// full turn about each axis
        #[arg(long)]
        continuous: bool,
        /// Rest before and after each turn, s
        #[arg(long, value_name = "S", default_value_t = 3.0, requires = "continuous")]
        rest: f64,
        /// Angle of each turn, right-handed about the axis, °
        #[arg(
            long,
            value_name = "DEG",
            default_value_t = -360.0,
            allow_negative_numbers = true,
            requires = "continuous"
        )]
        turn_angle: f64,
        #[command(flatten)]
        shared: Box<Shared>,
    },
    /// Six face poses and free poses in one recording: poses.csv
    Poses {
        /// Duration of each pose, s
        #[arg(long, value_name = "S", default_value_t = 4.0)]
        hold: f64,
        /// Number of free poses after the six faces
        #[arg(long, value_name = "N", default_value_t = 6)]
        free: u32,
        #[command(flatten)]
        shared: Box<Shared>,
    },
    /// At rest with z up: static.csv
    Static {
        /// Length of the recording, s
        #[arg(long, value_name = "S", default_value_t = 10.0)]
        duration: f64,
        /// In a thermal chamber that goes from HIGH to LOW °C and back
        #[arg(
            long,
            value_name = "HIGH,LOW",
            value_parser = two_numbers,
            allow_hyphen_values = true
        )]
        soak: Option<(f64, f64)>,
        /// Drift of the gyroscope's bias in the chamber, °/s per °C
        #[arg(long, value_name = "DEG_S_C", default_value_t = 0.0, requires = "soak")]
        gyro_drift: f64,
        #[command(flatten)]
        shared: Box<Shared>,
    },
    /// Rest, one smooth straight move, rest: line.csv
    Line {
        /// Displacement along y, m
        #[arg(
            long,
            value_name = "M",
            default_value_t = 0.7,
            allow_negative_numbers = true
        )]
        distance: f64,
        /// Duration of the move, s
        #[arg(long, value_name = "S", default_value_t = 2.0)]
        move_time: f64,
        /// Rest before and after the move, s
        #[arg(long, value_name = "S", default_value_t = 5.0)]
        rest: f64,
        #[command(flatten)]
        shared: Box<Shared>,
    },
}

#[derive(Debug, clap::Args)]
pub struct Shared {
    /// Folder to write to, created if missing
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Random seed; the same seed and options give the same files
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Local gravity, m/s²
    #[arg(long, value_name = "MPS2", default_value_t = 9.80665)]
    gravity: f64,
    /// Tilt of a pose, ° (standard deviation of each of two components)
    #[arg(long, value_name = "DEG", default_value_t = 1.0)]
    tilt: f64,
    /// Overwrite existing files
    #[arg(long)]
    pub force: bool,
    /// Print errors only
    #[arg(short, long)]
    pub quiet: bool,
    /// Print the truth as JSON
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    board: Board,
    #[command(flatten)]
    sensor: Sensor,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Board and file")]
struct Board {
    /// True sampling rate, Hz
    #[arg(long, value_name = "HZ", default_value_t = 100.0)]
    rate: f64,
    /// Jitter of the time stamps, ± ms
    #[arg(long, value_name = "MS", default_value_t = 0.0)]
    jitter: f64,
    /// Share of lost rows, 0 to 0.9
    #[arg(long, value_name = "FRACTION", default_value_t = 0.0)]
    drop: f64,
    /// Header that names g and °/s although the values are in m/s² and rad/s, as the logger of the
    /// student report wrote it
    #[arg(long)]
    wrong_header: bool,
    /// Raw counts instead of m/s² and rad/s
    #[arg(long, conflicts_with_all = ["wrong_header", "decimals"])]
    raw: bool,
    /// Decimal places
    #[arg(long, value_name = "N", default_value_t = 4)]
    decimals: u8,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Sensor")]
struct Sensor {
    /// Range of the accelerometer, g: 2, 4, 8 or 16
    #[arg(long, value_name = "G", default_value_t = 2)]
    range: u32,
    /// Factor on all noise; 0 switches it off
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0)]
    noise: f64,
    /// Scale error of the accelerometer, % (standard deviation)
    #[arg(long, value_name = "PERCENT", default_value_t = 2.0)]
    scale_sd: f64,
    /// Warming of the sensor above 25 °C, °C
    #[arg(
        long,
        value_name = "C",
        default_value_t = 1.5,
        allow_negative_numbers = true
    )]
    temperature_rise: f64,
    /// Drift of the accelerometer's bias, mg per °C; 0 switches it off
    #[arg(long, value_name = "MG_C", default_value_t = 0.5)]
    temperature_drift: f64,
}

impl Args {
    /// Options of the library, and those of the command itself.
    pub fn options(&self) -> (SimulateOptions, &Shared) {
        let (scenario, shared) = match &self.scenario {
            Command::SixPosition {
                hold,
                continuous,
                rest,
                turn_angle,
                shared,
            } => (
                Scenario::SixPosition(SixPositionOptions {
                    hold_s: *hold,
                    continuous: *continuous,
                    rest_s: *rest,
                    turn_angle_deg: *turn_angle,
                    ..SixPositionOptions::default()
                }),
                shared,
            ),
            Command::Poses { hold, free, shared } => (
                Scenario::Poses(PosesOptions {
                    hold_s: *hold,
                    free: *free,
                }),
                shared,
            ),
            Command::Static {
                duration,
                soak,
                gyro_drift,
                shared,
            } => (
                Scenario::Static(StaticOptions {
                    duration_s: *duration,
                    soak: soak.map(|(high_c, low_c)| SoakOptions {
                        high_c,
                        low_c,
                        hysteresis_c: 0.0,
                        gyro_drift_deg_s_per_c: *gyro_drift,
                    }),
                }),
                shared,
            ),
            Command::Line {
                distance,
                move_time,
                rest,
                shared,
            } => (
                Scenario::Line(LineOptions {
                    distance_m: *distance,
                    move_time_s: *move_time,
                    rest_s: *rest,
                    ..LineOptions::default()
                }),
                shared,
            ),
        };
        (shared.options(scenario), shared)
    }
}

impl Shared {
    fn options(&self, scenario: Scenario) -> SimulateOptions {
        SimulateOptions {
            seed: self.seed,
            gravity_mps2: self.gravity,
            rate_hz: self.board.rate,
            stamp_jitter_ms: self.board.jitter,
            dropped_fraction: self.board.drop,
            tilt_sd_deg: self.tilt,
            sensor: self.sensor.options(),
            file: self.board.file(),
            ..SimulateOptions::new(scenario)
        }
    }
}

impl Board {
    fn file(&self) -> FileOptions {
        FileOptions {
            format: match (self.raw, self.wrong_header) {
                (true, _) => FileFormat::Raw,
                (false, true) => FileFormat::WrongHeader,
                (false, false) => FileFormat::TrueHeader,
            },
            decimals: self.decimals,
        }
    }
}

impl Sensor {
    fn options(&self) -> SensorOptions {
        SensorOptions {
            accel_range_g: self.range,
            scale_sd_percent: self.scale_sd,
            temperature_rise_c: self.temperature_rise,
            bias_drift_mg_per_c: self.temperature_drift,
            ..SensorOptions::default()
        }
        .with_noise_factor(self.noise)
    }
}

fn two_numbers(text: &str) -> Result<(f64, f64), String> {
    let (high, low) = text
        .split_once(',')
        .ok_or("expected two temperatures such as 50,-10")?;
    let number = |t: &str| t.trim().parse().map_err(|e| format!("{t}: {e}"));
    Ok((number(high)?, number(low)?))
}
