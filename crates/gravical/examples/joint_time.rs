//! How long the joint fit takes.
use gravical::estimate::joint::*;
use gravical::simulate::means::*;
fn cpu() -> f64 {
    let s = std::fs::read_to_string("/proc/self/schedstat").unwrap_or_default();
    s.split(' ')
        .next()
        .and_then(|t| t.parse::<f64>().ok())
        .unwrap_or(0.0)
        * 1e-6
}
fn main() {
    let only: Option<usize> = std::env::args().nth(1).and_then(|a| a.parse().ok());
    for frees in [0, 6, 32] {
        if only.is_some_and(|o| o != frees) {
            continue;
        }
        let o = MeansOptions::default();
        let mut sets = Vec::new();
        for i in 0..10 {
            let mut part = Part::draw(&o, 5, i);
            let mut plan = Planned::six_faces();
            plan.extend(part.random_poses(frees));
            let means = part.place(&plan);
            sets.push(
                means
                    .iter()
                    .map(|m| JointPose {
                        mean: m.mean,
                        standard_error: [o.noise_mps2; 3],
                        role: Role::Open,
                    })
                    .collect::<Vec<_>>(),
            );
        }
        let options = JointOptions {
            gravity: 9.80665,
            nominal: Some(1.0),
            prior: true,
            tilt: None,
            quantisation: [0.0; 3],
            start: None,
        };
        let start = cpu();
        let mut n = 0.0;
        let mut sum = 0.0;
        let mut loo = 0.0;
        while n < 10.0 || cpu() - start < 300.0 {
            for set in &sets {
                let f = joint(set, &options).unwrap();
                n += 1.0;
                if n <= 10.0 {
                    sum += f.tilt;
                    for p in &f.poses {
                        loo += p.left_out_error.unwrap_or(0.0).abs();
                    }
                }
            }
            if only.is_some() {
                break;
            }
        }
        println!(
            "{} poses: {:.3} ms each; check {sum:.12} {loo:.12}",
            6 + frees,
            (cpu() - start) / n
        );
    }
}
