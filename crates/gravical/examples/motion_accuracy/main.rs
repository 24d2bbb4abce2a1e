//! Accuracy of motion by experiment.
use gravical::motion::{MotionOptions, motion, Calibrated};
use gravical::recording::{ReadOptions, read};
use gravical::simulate::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let a: Vec<String> = std::env::args().collect();
    let wobble: f64 = a[1].parse()?;
    let move_s: f64 = a[2].parse()?;
    let seeds: u64 = a[3].parse()?;
    let auto = a[4] == "auto";
    let zv = a[5] == "on";
    let folder = tempfile::tempdir()?;
    let (mut sum, mut n) = ([0.0; 3], 0.0);
    let (mut in1, mut in2) = ([0.0; 3], [0.0; 3]);
    let mut sig = [0.0; 3];
    for seed in 1..=seeds {
        let mut options = SimulateOptions::new(Scenario::Line(LineOptions { wobble_deg: wobble, move_time_s: move_s, ..LineOptions::default() }));
        options.seed = seed;
        let s = simulate(&options)?;
        write(&s, folder.path(), true)?;
        let recording = read(&folder.path().join("line.csv"), &ReadOptions::default())?;
        let mut m = MotionOptions { clock_error: 0.0, zero_velocity: zv, ..Default::default() };
        if !auto { m.rests.given_s = Some(vec![(0.0, 5.0), (5.0 + move_s, 20.0)]); }
        let r = motion(&recording, None::<Calibrated>, &m)?.result;
        if seed == 1 { println!("{}", serde_json::to_string_pretty(&r)?); }
        let Some(p) = r.r#final.position_m else { println!("none"); continue };
        let sg = r.r#final.sigma_m.unwrap();
        let truth = s.truth.files[0].moves[0].displacement_m;
        // the frame: x along sensor's x made horizontal; attitude of the pose
        let q = s.files[0].path.state_at(0.0).attitude;
        let m3 = gravical_core::strapdown::matrix(&q);
        let yaw = m3[1][0].atan2(m3[0][0]);
        let (sn, cs) = yaw.sin_cos();
        let t = [cs * truth[0] + sn * truth[1], -sn * truth[0] + cs * truth[1], truth[2]];
        n += 1.0;
        for i in 0..3 {
            let e = p[i] - t[i];
            sum[i] += e * e;
            sig[i] += sg[i];
            if e.abs() <= sg[i] { in1[i] += 1.0; }
            if e.abs() <= 2.0 * sg[i] { in2[i] += 1.0; }
        }
    }
    println!("rms mm {:?}", sum.map(|s: f64| 1e3 * (s / n).sqrt()));
    println!("mean sigma mm {:?}", sig.map(|s: f64| 1e3 * s / n));
    println!("in 1σ {:?} 2σ {:?}", in1.map(|s: f64| s / n), in2.map(|s| s / n));
    Ok(())
}
