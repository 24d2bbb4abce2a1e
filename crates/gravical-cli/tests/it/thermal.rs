//! Drift with temperature: the real soak says what is known about it, and what
//! was put into a virtual sensor is taken off again.

use serde_json::Value;

use crate::support::*;

const SOAK: &str = "tofupilot-thermal/part1_rows0-5249.tsv";

fn channel<'a>(model: &'a Value, name: &str) -> &'a Value {
    let mut all = list(&model["channels"]);
    all.find(|c| c["channel"] == name).unwrap()
}

fn accepted(model: &Value) -> Vec<&str> {
    let corrected = list(&model["channels"]).filter(|c| c["verdict"] == "corrected");
    corrected.map(|c| text(&c["channel"])).collect()
}

/// R² of both ways, the worse first.
fn r2(model: &Value, name: &str) -> [f64; 2] {
    let ways = ["r2_cooling_to_warming", "r2_warming_to_cooling"];
    let [a, b] = ways.map(|way| number(&channel(model, name)[way]));
    [a.min(b), a.max(b)]
}

#[test]
fn the_drone_in_its_chamber_shows_which_drift_is_predictable() {
    let Some(data) = data() else { return };
    let inspected = json(&data, &format!("inspect {SOAK}"), 0);
    let model = &inspected["recordings"][0]["temperature_drift"];
    let range = numbers(&model["range_c"]);
    close(range[0], -17.6, 0.1);
    close(range[1], 49.0, 0.2);

    // Predictable both ways: acc x and gyro y, nothing else.
    assert_eq!(accepted(model), ["ax", "gy"]);
    let [low, high] = r2(model, "ax");
    assert!(low > 0.80 && high < 0.92, "ax {low} {high}");
    let [low, high] = r2(model, "gy");
    assert!(low > 0.77 && high < 0.99, "gy {low} {high}");
    // The others are not: acc z is curved.
    for (name, most) in [("ay", 0.0), ("az", 0.6), ("gx", 0.0), ("gz", 0.0)] {
        assert!(r2(model, name)[1] < most, "{name} {:?}", r2(model, name));
        let reason = text(&channel(model, name)["reason"]);
        assert!(reason.contains("hysteresis or drift with time"), "{reason}");
        assert!(channel(model, name)["per_c"].is_null());
    }

    // Acc x drifts by 1.4 (warming) to 1.6 mm/s² per °C (cooling).
    close(number(&channel(model, "ax")["per_c"]), 1.48e-3, 0.05e-3);
    // Gyro y by 4.4e-4 rad/s per °C.
    close(number(&channel(model, "gy")["per_c"]), 4.37e-4, 0.05e-4);
}

/// Writes `soak.csv`: the sensor that `truth` describes at rest with z up, in a chamber that goes from 45 to 5
/// °C and back within 900 s; its gyroscope drifts by 0.01 °/s per °C.
fn write_soak(at: &std::path::Path, truth: &Value) {
    let [accel, gyro] = ["accelerometer", "gyroscope"].map(|sensor| &truth[sensor]);
    let (matrix, bias) = (numbers(&accel["matrix"]), numbers(&accel["bias_mps2"]));
    let drift = numbers(&accel["bias_drift_mps2_per_c"]);
    let rate = numbers(&gyro["bias_rad_s"]);
    let mut noise = Noise::new(3);
    let mut text =
        "Timestamp (ms),aX (m/s^2),aY (m/s^2),aZ (m/s^2),Temp (C),gX (rad/s),gY (rad/s),gZ (rad/s)\n"
            .to_owned();
    for i in 0..45_000 {
        let turn = std::f64::consts::TAU * f64::from(i) / 45_000.0;
        let warmer_c = 20.0 * turn.cos();
        let [x, y, z] = [0, 1, 2].map(|k| {
            matrix[3 * k + 2] * 9.80665 + bias[k] + drift[k] * warmer_c + 0.02 * noise.normal()
        });
        let [p, q, r] = [0, 1, 2].map(|k| rate[k] + 1.745e-4 * warmer_c + 6e-4 * noise.normal());
        let (t_ms, t_c) = (20 * i, 25.0 + warmer_c);
        text += &format!("{t_ms},{x:.6},{y:.6},{z:.6},{t_c:.3},{p:.6},{q:.6},{r:.6}\n");
    }
    write(at, "soak.csv", &text);
}

/// What was put into the sensor of a folder.
fn truth(at: &std::path::Path, folder: &str) -> Value {
    serde_json::from_str(&read(at, &format!("{folder}/truth.json"))).unwrap()
}

/// Six placements of a virtual sensor that drifts by 1 mg per °C in `six`, and `soak.csv` of the same one.
fn virtual_session(seed: u32) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let six = format!(
        "simulate six-position -o six --hold 10 --tilt 0 --temperature-rise 0 --seed {seed} \
         --decimals 6 --temperature-drift 1 -q --rate 50"
    );
    ends(at, &six, 0);
    write_soak(at, &truth(at, "six"));
    folder
}

#[test]
fn a_model_of_a_soak_is_added_and_taken_off_again() {
    let folder = virtual_session(5);
    let at = folder.path();
    let line = "six --method ferraris --thermal soak.csv --gravity 9.80665 -o cal.json";
    let made = calibrate(at, line, 0);
    let model = &made["drift"];
    assert_eq!(accepted(model), ["ax", "ay", "az", "gx", "gy", "gz"]);
    close(number(&model["reference_c"]), 25.0, 0.1);

    let put = numbers(&truth(at, "six")["accelerometer"]["bias_drift_mps2_per_c"]);
    for (name, put) in ["ax", "ay", "az"].iter().zip(put) {
        let found = number(&channel(model, name)["per_c"]);
        close(found, put, 0.01 * put.abs());
    }

    // 40 °C of 9.8 mm/s² each are 0.39 m/s²: only noise is left of it.
    ends(at, "apply cal.json soak.csv -o out.csv", 0);
    let text = read(at, "out.csv");
    for axis in 0..3 {
        let cells = text.lines().skip(1).map(|l| l.split(',').nth(1 + axis));
        let column: Vec<f64> = cells.map(|c| c.unwrap().parse().unwrap()).collect();
        let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
        // Half a minute each: a standard error of 0.6 mm/s².
        for part in column.chunks_exact(1500) {
            close(mean(part), mean(&column), 4e-3);
        }
    }

    // No target but gravical's own holds it.
    let err = ends(at, "export cal.json --to c", 0).err;
    assert!(err.contains("drift with temperature"), "{err}");
    for (soak, code) in [
        ("six/x_axis_pos.csv", "temperature-span"),
        ("nowhere.csv", "not-found"),
    ] {
        fails(at, &format!("calibrate six --thermal {soak}"), 3, code);
    }
}

#[test]
fn placements_at_other_temperatures_are_brought_to_one() {
    let folder = virtual_session(9);
    let at = folder.path();
    // The same six placements while the part warms by 10 °C.
    let line = "simulate six-position -o warm --hold 10 --tilt 0 --temperature-rise 20 --seed 9 \
                --decimals 6 --temperature-drift 1 -q --rate 50";
    ends(at, line, 0);
    let truth = truth(at, "warm");
    let at_25 = numbers(&truth["accelerometer"]["bias_mps2"]);
    let drift = numbers(&truth["accelerometer"]["bias_drift_mps2_per_c"]);
    let off = |thermal: &str| {
        let line = format!("warm --method ferraris --gravity 9.80665 {thermal}");
        let made = calibrate(at, &line, 0);
        let warmer = number(&made["temperature_c"]["mean"]) - 25.0;
        let bias = numbers(&made["accelerometer"]["bias"]);
        let errors = (0..3).map(|i| (bias[i] - at_25[i] - drift[i] * warmer).abs());
        errors.fold(0.0, f64::max)
    };
    let (plain, brought) = (off(""), off("--thermal soak.csv"));
    assert!(plain > 0.02 && brought < 0.003, "{plain} {brought}");
}
