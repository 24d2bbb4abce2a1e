//! A sensor in a few lines, for tests that need a known recording rather than
//! physics: `simulate` is for those. Shared by the tests of both crates.
#![allow(dead_code)] // each test crate uses its part

/// g of every synthetic session, m/s².
pub const GRAVITY: f64 = 9.81;

/// The six faces with the names that six files have.
pub const FACES: [(&str, [f64; 3]); 6] = [
    ("x_axis_pos", [1.0, 0.0, 0.0]),
    ("x_axis_neg", [-1.0, 0.0, 0.0]),
    ("y_axis_pos", [0.0, 1.0, 0.0]),
    ("y_axis_neg", [0.0, -1.0, 0.0]),
    ("z_axis_pos", [0.0, 0.0, 1.0]),
    ("z_axis_neg", [0.0, 0.0, -1.0]),
];

/// Repeatable noise, near enough to normal: Knuth's congruence, twelve uniform
/// numbers summed.
pub struct Noise(u64);

impl Noise {
    pub fn new(seed: u64) -> Self {
        let mut noise = Noise(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5851_f42d);
        for _ in 0..8 {
            noise.uniform();
        }
        noise
    }

    pub fn uniform(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

/// raw = matrix · a + bias, with white noise, in m/s² times `unit`.
#[derive(Clone)]
pub struct Sensor {
    pub matrix: [[f64; 3]; 3],
    pub bias: [f64; 3],
    pub noise: f64,
    /// File units per m/s².
    pub unit: f64,
    /// Digits after the point.
    pub decimals: usize,
}

impl Default for Sensor {
    fn default() -> Self {
        Sensor {
            matrix: [
                [1.012, 0.004, -0.007],
                [-0.006, 0.991, 0.009],
                [0.005, -0.008, 1.021],
            ],
            bias: [0.31, -0.22, 0.43],
            noise: 0.03,
            unit: 1.0,
            decimals: 4,
        }
    }
}

impl Sensor {
    /// What it reads at rest with `up` up, m/s² times the unit, without noise.
    pub fn truth(&self, up: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| {
            let force: f64 = (0..3).map(|j| self.matrix[i][j] * GRAVITY * up[j]).sum();
            (force + self.bias[i]) * self.unit
        })
    }

    /// `rows` readings at rest.
    pub fn hold(&self, up: [f64; 3], rows: usize, seed: u64) -> Vec<[f64; 3]> {
        let mut noise = Noise::new(seed);
        let still = self.truth(up);
        (0..rows)
            .map(|_| still.map(|v| v + self.noise * self.unit * noise.normal()))
            .collect()
    }

    /// Text of a number as this sensor writes it.
    pub fn text(&self, value: f64) -> String {
        format!("{value:.*}", self.decimals)
    }

    /// A file of one hold, `t_ms,ax,ay,az` at 100 Hz.
    pub fn file(&self, up: [f64; 3], rows: usize, seed: u64) -> String {
        let mut out = "t_ms,ax,ay,az\n".to_owned();
        for (i, row) in self.hold(up, rows, seed).iter().enumerate() {
            let [x, y, z] = row.map(|value| self.text(value));
            out += &format!("{},{x},{y},{z}\n", 10 * i);
        }
        out
    }
}

/// Lines of a recording in the report's columns: time in ms, accelerometer,
/// temperature, gyroscope (rad/s), at rest with z up.
pub fn report_lines(header: &str, rows: usize) -> Vec<String> {
    let sensor = Sensor::default();
    let mut noise = Noise::new(77);
    let mut lines = vec![header.to_owned()];
    for (i, a) in sensor.hold([0.0, 0.0, 1.0], rows, 5).iter().enumerate() {
        let g: [f64; 3] = std::array::from_fn(|k| 0.01 * k as f64 + 0.002 * noise.normal());
        let ([x, y, z], [u, v, w]) = (a, g);
        let (t_ms, t_c) = (120 + 10 * i, 25.0 + 0.03 * noise.normal());
        lines.push(format!(
            "{t_ms},{x:.4},{y:.4},{z:.4},{t_c:.2},{u:.5},{v:.5},{w:.5}"
        ));
    }
    lines
}

/// The folder with real recordings; prints that a test is skipped without it.
pub fn data() -> Option<std::path::PathBuf> {
    let Some(folder) = std::env::var_os("GRAVICAL_DATA") else {
        println!("skipped: GRAVICAL_DATA is not set");
        return None;
    };
    let folder = std::path::PathBuf::from(folder);
    assert!(
        folder.join("README.md").is_file(),
        "GRAVICAL_DATA is {}, where no recordings are",
        folder.display()
    );
    Some(folder)
}
