//! What is written: columns of a virtual sensor whose truth is known.

use gravical::simulate::{
    LineOptions, PosesOptions, Row, Scenario, SensorOptions, SimulateOptions, SimulatedFile,
    SixPositionOptions, simulate,
};

use super::{Rate, Scene};

/// One file before it is written.
#[derive(Debug, Clone, Default)]
pub struct Columns {
    /// Its name without an ending.
    pub stem: String,
    /// s from the first row.
    pub t_s: Vec<f64>,
    pub accel_mps2: [Vec<f64>; 3],
    pub gyro_rad_s: [Vec<f64>; 3],
    pub temperature_c: Vec<f64>,
    /// Rows before which the logger was paused.
    pub pauses: Vec<usize>,
}

/// A session: its files.
#[derive(Debug, Clone)]
pub struct Session {
    pub rate_hz: f64,
    pub files: Vec<Columns>,
}

impl Columns {
    pub fn rows(&self) -> usize {
        self.t_s.len()
    }

    fn part(&self, rows: std::ops::Range<usize>, stem: &str) -> Self {
        let cut = |v: &Vec<f64>| v[rows.clone()].to_vec();
        let from = self.t_s[rows.start];
        Columns {
            stem: stem.to_owned(),
            t_s: cut(&self.t_s).into_iter().map(|t| t - from).collect(),
            accel_mps2: self.accel_mps2.each_ref().map(cut),
            gyro_rad_s: self.gyro_rad_s.each_ref().map(cut),
            temperature_c: cut(&self.temperature_c),
            pauses: Vec::new(),
        }
    }

    /// Goes on with another one, after a pause of five seconds.
    fn go_on_with(&mut self, next: &Columns) {
        self.pauses.push(self.rows());
        let from = self.t_s.last().copied().unwrap_or(0.0) + 5.0;
        self.t_s.extend(next.t_s.iter().map(|t| from + t));
        for i in 0..3 {
            self.accel_mps2[i].extend(&next.accel_mps2[i]);
            self.gyro_rad_s[i].extend(&next.gyro_rad_s[i]);
        }
        self.temperature_c.extend(&next.temperature_c);
    }
}

/// The session of a scene, the same for the same rate.
pub fn session(scene: Scene, rate: Rate) -> Session {
    // Fewer rows where there are many of them.
    let hold_s = if rate == Rate::Hz1000 { 2.5 } else { 4.0 };
    let six = |continuous| {
        Scenario::SixPosition(SixPositionOptions {
            hold_s,
            continuous,
            turn_rest_s: 2.0,
        })
    };
    let scenario = match scene {
        Scene::Poses | Scene::TwoRecordings => Scenario::Poses(PosesOptions { hold_s, free: 6 }),
        Scene::Turns => six(true),
        Scene::SixFiles | Scene::AxisFiles => six(false),
        Scene::Line => Scenario::Line(LineOptions::default()),
    };
    let mut options = SimulateOptions::new(scenario);
    options.seed = 11;
    options.rate_hz = rate.hz();
    // Rounding is the business of the writing.
    options.sensor = SensorOptions {
        quantise: false,
        accel_range_g: 16,
        ..SensorOptions::default()
    };
    let simulated = simulate(&options).unwrap();
    let columns = |f: &SimulatedFile| {
        let column = |value: &dyn Fn(&Row) -> f64| f.rows.iter().map(value).collect();
        let times = (0..f.rows.len()).map(|row| row as f64 / rate.hz());
        Columns {
            stem: f.name.trim_end_matches(".csv").to_owned(),
            t_s: times.collect(),
            accel_mps2: [0, 1, 2].map(|i| column(&|row| row.reading.accel_mps2[i])),
            gyro_rad_s: [0, 1, 2].map(|i| column(&|row| row.reading.gyro_rad_s[i])),
            temperature_c: column(&|row| row.reading.temperature_c),
            pauses: Vec::new(),
        }
    };
    let mut files: Vec<Columns> = simulated.files.iter().map(columns).collect();
    match scene {
        Scene::AxisFiles => {
            let both = |(pair, axis): (&[Columns], char)| {
                let mut both = pair[0].clone();
                both.stem = format!("{axis}_axis");
                both.go_on_with(&pair[1]);
                both
            };
            files = files.chunks(2).zip(['x', 'y', 'z']).map(both).collect();
        }
        Scene::TwoRecordings => {
            // Cut in the middle of the sixth hold, so that both halves have it.
            let truth = &simulated.truth.files[0].poses[5];
            let at_s = 0.5 * (truth.start_s + truth.end_s);
            let whole = &files[0];
            let cut = whole.t_s.partition_point(|t| *t < at_s);
            let evening = whole.part(cut..whole.rows(), "evening");
            files = vec![whole.part(0..cut, "morning"), evening];
        }
        _ => {}
    }
    let rate_hz = rate.hz();
    Session { rate_hz, files }
}
