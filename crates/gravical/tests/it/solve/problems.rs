//! The nonlinear regression problems of NIST's Statistical Reference Datasets.

use std::f64::consts::PI;
use std::path::Path;

use gravical::estimate::solve::{Jacobian, Problem, Shape};

use super::dual::{Dual, dual};

/// A problem with what is certified of it.
pub struct Nist {
    pub name: String,
    pub starts: [Vec<f64>; 2],
    pub certified: Vec<f64>,
    pub sd: Vec<f64>,
    pub rss: f64,
    pub freedom: usize,
    /// y and up to two x.
    rows: Vec<(f64, [f64; 2])>,
}

impl Nist {
    pub fn read(name: &str) -> Nist {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/reference/nist");
        let text = std::fs::read_to_string(folder.join(format!("{name}.txt"))).unwrap();
        let mut out = Nist {
            name: name.to_owned(),
            starts: [Vec::new(), Vec::new()],
            certified: Vec::new(),
            sd: Vec::new(),
            rss: f64::NAN,
            freedom: 0,
            rows: Vec::new(),
        };
        for line in text.lines() {
            let mut words = line.split_whitespace();
            let key = words.next().unwrap_or("#");
            if key == "#" || key == "problem" {
                continue;
            }
            let v: Vec<f64> = words.map(|w| w.parse().unwrap()).collect();
            match key {
                "parameter" => {
                    out.starts[0].push(v[0]);
                    out.starts[1].push(v[1]);
                    out.certified.push(v[2]);
                    out.sd.push(v[3]);
                }
                "rss" => out.rss = v[0],
                "freedom" => out.freedom = v[0] as usize,
                "row" => out
                    .rows
                    .push((v[0], [v[1], v.get(2).copied().unwrap_or(0.0)])),
                other => panic!("{name}: {other}"),
            }
        }
        assert_eq!(out.rows.len() - out.certified.len(), out.freedom, "{name}");
        out
    }

    pub fn rows(&self) -> usize {
        self.rows.len()
    }

    /// Residual of row `i` with its derivatives.
    pub fn residual(&self, b: &[f64], i: usize) -> Dual {
        let (y, x) = self.rows[i];
        let b: Vec<Dual> = b
            .iter()
            .enumerate()
            .map(|(j, v)| Dual::parameter(*v, j))
            .collect();
        // Nelson's model is of log y.
        let y = if self.name == "Nelson" { y.ln() } else { y };
        model(&self.name, &b, x) - y
    }
}

fn model(name: &str, b: &[Dual], [x1, x2]: [f64; 2]) -> Dual {
    let x = dual(x1);
    let one = dual(1.0);
    match name {
        "Misra1a" | "BoxBOD" => b[0] * (one - (-b[1] * x).exp()),
        "Misra1b" => b[0] * (one - one / (b[1] * x * 0.5 + 1.0).square()),
        "Misra1c" => b[0] * (one - (b[1] * x * 2.0 + 1.0).pow(dual(-0.5))),
        "Misra1d" => b[0] * b[1] * x / (b[1] * x + 1.0),
        "Chwirut1" | "Chwirut2" => (-b[0] * x).exp() / (b[1] + b[2] * x),
        "DanWood" => b[0] * x.pow(b[1]),
        "ENSO" => {
            let wave = |period: Dual, c: Dual, s: Dual| {
                let phase = x * (2.0 * PI) / period;
                c * phase.cos() + s * phase.sin()
            };
            b[0] + wave(dual(12.0), b[1], b[2]) + wave(b[3], b[4], b[5]) + wave(b[6], b[7], b[8])
        }
        "Eckerle4" => b[0] / b[1] * (((x - b[2]) / b[1]).square() * -0.5).exp(),
        "Gauss1" | "Gauss2" | "Gauss3" => {
            let peak = |h: Dual, at: Dual, w: Dual| h * (-((x - at) / w).square()).exp();
            b[0] * (-b[1] * x).exp() + peak(b[2], b[3], b[4]) + peak(b[5], b[6], b[7])
        }
        "Hahn1" | "Thurber" => {
            (b[0] + x * (b[1] + x * (b[2] + x * b[3]))) / (x * (b[4] + x * (b[5] + x * b[6])) + 1.0)
        }
        "Kirby2" => (b[0] + x * (b[1] + x * b[2])) / (x * (b[3] + x * b[4]) + 1.0),
        "Lanczos1" | "Lanczos2" | "Lanczos3" => {
            let term = |k: usize| b[k] * (-b[k + 1] * x).exp();
            term(0) + term(2) + term(4)
        }
        "MGH09" => b[0] * (x * x + x * b[1]) / (x * x + x * b[2] + b[3]),
        "MGH10" => b[0] * (b[1] / (x + b[2])).exp(),
        "MGH17" => b[0] + b[1] * (-x * b[3]).exp() + b[2] * (-x * b[4]).exp(),
        "Nelson" => b[0] - b[1] * x * (-b[2] * x2).exp(),
        "Rat42" => b[0] / ((b[1] - b[2] * x).exp() + 1.0),
        "Rat43" => b[0] / ((b[1] - b[2] * x).exp() + 1.0).pow(one / b[3]),
        "Roszman1" => b[0] - b[1] * x - (b[2] / (x - b[3])).atan() * (1.0 / PI),
        "Bennett5" => b[0] * (b[1] + x).pow(-one / b[2]),
        other => panic!("{other} has no model"),
    }
}

impl Problem for Nist {
    type State = Vec<f64>;

    fn shared(&self) -> usize {
        self.certified.len()
    }

    fn blocks(&self) -> usize {
        self.rows.len()
    }

    fn shape(&self, _block: usize) -> Shape {
        Shape {
            residuals: 1,
            local: 0,
        }
    }

    fn evaluate(&self, b: &Vec<f64>, i: usize, r: &mut [f64], jacobian: Option<Jacobian<'_>>) {
        let residual = self.residual(b, i);
        r[0] = residual.value;
        if let Some(j) = jacobian {
            j.shared.copy_from_slice(&residual.by[..b.len()]);
        }
    }

    fn moved(&self, b: &Vec<f64>, step: &[f64], _local: &[f64]) -> Vec<f64> {
        b.iter().zip(step).map(|(b, s)| b + s).collect()
    }
}
