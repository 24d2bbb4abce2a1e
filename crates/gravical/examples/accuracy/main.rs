//! scratch
mod runs;
use gravical::simulate::means::MeansOptions;
use runs::*;
const TILTS: [f64; 4] = [0.1, 1.0, 2.0, 3.0];
fn rms(v: &[Option<Outcome>], f: impl Fn(&Outcome) -> f64) -> f64 {
    let n = v.iter().flatten().count() as f64;
    (v.iter().flatten().map(|o| f(o).powi(2)).sum::<f64>() / n).sqrt()
}
fn cell(v: &[Option<Outcome>]) -> String {
    let mg = 1000.0 / 9.80665;
    let missing = v.iter().filter(|o| o.is_none()).count();
    let miss = if missing > 0 {
        format!(" ({missing} none)")
    } else {
        String::new()
    };
    format!(
        "{:.2}/{:.3}/{:.2}{miss}",
        rms(v, |o| o.errors.norm_mps2) * mg,
        rms(v, |o| o.errors.bias_mps2) * mg,
        rms(v, |o| o.errors.direction_rad).to_degrees()
    )
}
fn coverage(v: &[Option<Outcome>], which: impl Fn(&Outcome) -> [f64; 3]) -> f64 {
    let (mut inside, mut n) = (0.0, 0.0);
    for o in v.iter().flatten() {
        let k = o.fit.as_ref().map_or(1.96, |f| f.coverage_factor_95());
        for z in which(o) {
            n += 1.0;
            if z.abs() <= k {
                inside += 1.0;
            }
        }
    }
    inside / n
}
fn main() {
    let count: usize = std::env::args()
        .nth(1)
        .and_then(|a| a.parse().ok())
        .unwrap_or(500);
    let seed = 1;
    let session = |tilt: f64, plan: Plan| Session {
        means: MeansOptions {
            tilt_sd_rad: tilt.to_radians(),
            ..MeansOptions::default()
        },
        plan,
        tilt_given: true,
        roles_told: true,
    };
    let g = 9.80665;
    println!(
        "none {}",
        cell(&session(1.0, Plan::Faces(1)).by(seed, count, |_| Some((
            [[1., 0., 0.], [0., 1., 0.], [0., 0., 1.]],
            [0.0; 3]
        ))))
    );
    let row = |name: &str, plan: Plan, given: bool, told: bool, means: MeansOptions| {
        let mut line = String::new();
        let mut cov = String::new();
        for t in TILTS {
            let s = Session {
                means: MeansOptions {
                    tilt_sd_rad: t.to_radians(),
                    ..means
                },
                plan,
                tilt_given: given,
                roles_told: told,
            };
            let start = std::time::Instant::now();
            let v = s.joint(seed, count);
            line += &format!("{} | ", cell(&v));
            let z = |f: fn(&gravical::simulate::means::Scores) -> [f64; 3]| {
                coverage(&v, |o| o.scores.as_ref().map_or([9.0; 3], f))
            };
            let mut tilts: Vec<f64> = v
                .iter()
                .flatten()
                .filter_map(|o| o.fit.as_ref().map(|f| f.tilt.to_degrees()))
                .collect();
            tilts.sort_by(f64::total_cmp);
            let bads: usize = v
                .iter()
                .flatten()
                .map(|o| {
                    o.fit
                        .as_ref()
                        .unwrap()
                        .poses
                        .iter()
                        .filter(|p| p.bad.is_some())
                        .count()
                })
                .sum();
            let me = v
                .iter()
                .flatten()
                .map(|o| o.fit.as_ref().unwrap().model_error)
                .fold(0.0, |a, b| a + b)
                / count as f64;
            cov += &format!(
                "b{:.3} k{:.3} n{:.3} t{:.2}({:.2}-{:.2}) bad{bads} me{:.2e} {:.1}ms | ",
                z(|s| s.bias),
                z(|s| s.scale),
                z(|s| s.norm),
                tilts[tilts.len() / 2],
                tilts[tilts.len() / 10],
                tilts[tilts.len() * 9 / 10],
                me,
                start.elapsed().as_secs_f64() * 1e3 / count as f64
            );
        }
        println!("{name}: {line}\n      {cov}");
    };
    let d = MeansOptions::default();
    for t in TILTS {
        println!(
            "ferraris {t} {}",
            cell(&session(t, Plan::Faces(1)).by(seed, count, |m| ferraris(m, g)))
        );
    }
    row("6", Plan::Faces(1), true, true, d);
    row("6 est", Plan::Faces(1), false, true, d);
    row("6+6 spread", Plan::Spread(6), true, true, d);
    row("6+6 random", Plan::Random(6), true, true, d);
    row("6+6 spread est", Plan::Spread(6), false, true, d);
    row("6+12 random est", Plan::Random(12), false, true, d);
    row("6+12 spread est", Plan::Spread(12), false, true, d);
    row("6+12 spread est open", Plan::Spread(12), false, false, d);
    row("6+18 spread", Plan::Spread(18), true, true, d);
    row("6+18 random", Plan::Random(18), true, true, d);
    row("4x", Plan::Faces(4), true, true, d);
    row("4x est", Plan::Faces(4), false, true, d);
    row("6+3 proposed", Plan::Proposed(3), true, true, d);
    row("6+3 random", Plan::Random(3), true, true, d);
    row("6+6 open", Plan::Spread(6), true, false, d);
    row("6+6 est open random", Plan::Random(6), false, false, d);
    row(
        "6+6 board",
        Plan::Spread(6),
        true,
        true,
        MeansOptions {
            board_turn_rad: 3f64.to_radians(),
            ..d
        },
    );
}
