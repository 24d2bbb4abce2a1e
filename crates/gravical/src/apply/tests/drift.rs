//! Subtraction of the drift with temperature.

use super::*;

/// Identity, bias 0.1 of x; ax drifts by 0.01 per °C and az by −0.002 about 25 °C, measured from 0
/// to 50 °C; ay was refused.
fn drifting() -> Calibration {
    let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut file = with_gyro("rad/s");
    (file.accelerometer.matrix, file.accelerometer.bias) = (identity, [0.1, 0.0, 0.0]);
    let gyro = file.gyroscope.as_mut().unwrap();
    (gyro.matrix, gyro.bias, gyro.g_sensitivity) = (identity, [0.0; 3], [[0.0; 3]; 3]);
    let channel = |name: &str, verdict: &str, drift: Option<f64>| {
        serde_json::json!({
            "channel": name, "input_unit": "m/s^2", "verdict": verdict, "reason": "",
            "r2_cooling_to_warming": null, "r2_warming_to_cooling": null, "per_c": drift})
    };
    let model = serde_json::json!({
    "reference_c": 25.0, "range_c": [0.0, 50.0],
    "channels": [
        channel("ax", "corrected", Some(0.01)),
        channel("ay", "not-corrected", None),
        channel("az", "corrected", Some(-0.002)),
        channel("gy", "corrected", Some(0.001)),
    ]});
    file.drift = Some(serde_json::from_value(model).unwrap());
    file
}

/// The summary, and the cells of the rows.
fn table(text: &str) -> (ApplySummary, Vec<Vec<String>>) {
    let (out, summary) = run(&drifting(), text);
    let cells = |line: &str| line.split(',').map(str::to_owned).collect();
    (summary, out.lines().skip(1).map(cells).collect())
}

const HEADER: &str =
    "t_s,ax (m/s^2),ay (m/s^2),az (m/s^2),temp (C),gx (rad/s),gy (rad/s),gz (rad/s)";

fn ride(temperatures: &[&str]) -> String {
    let row = |i: usize| format!("{i},0.5,0.2,9.8,{},0.01,0.02,0.03", temperatures[i]);
    still(HEADER, temperatures.len(), row)
}

fn kinds(summary: &ApplySummary) -> Vec<&str> {
    let all = summary.findings.iter().map(|f| &*f.kind);
    all.filter(|k| k.starts_with("temperature")).collect()
}

#[test]
fn every_row_is_corrected_for_its_temperature() {
    let (summary, rows) = table(&ride(&["25", "35", "15.0"]));
    // raw − drift − bias
    assert_eq!(rows[0][1..4], ["0.400000", "0.200000", "9.800000"]);
    assert_eq!(rows[1][1..4], ["0.300000", "0.200000", "9.820000"]);
    assert_eq!(rows[2][1..4], ["0.500000", "0.200000", "9.780000"]);
    assert_eq!(rows[1][5..], ["0.010000", "0.010000", "0.030000"]);
    assert_eq!(rows[2][5..], ["0.010000", "0.030000", "0.030000"]);
    assert_eq!(rows[2][4], "15.0", "the temperature is kept as it is");
    let done = summary.temperature.unwrap();
    assert_eq!(done.channels, ["ax", "az", "gy"]);
}

#[test]
fn outside_the_range_the_edge_is_used_and_reported() {
    let (summary, rows) = table(&ride(&["50", "50.4", "90", "-30"]));
    // 0.5 − 0.25 − 0.1 at 50 °C and beyond, 0.5 + 0.25 − 0.1 at 0 °C.
    let ax: Vec<&str> = rows.iter().map(|r| r[1].as_str()).collect();
    assert_eq!(ax, ["0.150000", "0.150000", "0.150000", "0.650000"]);
    assert_eq!(kinds(&summary), ["temperature-outside"]);
    let reported = finding(&summary, "temperature-outside");
    assert_eq!((reported.count, &reported.lines[..]), (2, &[[4, 5]][..]));
    for number in ["0.0 to 50.0", "-30.0 to 90.0"] {
        assert!(reported.message.contains(number), "{}", reported.message);
    }
}

#[test]
fn an_empty_temperature_repeats_the_last_one() {
    let (summary, rows) = table(&ride(&["", "35", "", "nan", "-3276.8", "15"]));
    assert!(rows[..5].iter().all(|row| row[1] == "0.300000"));
    assert_eq!(rows[5][1], "0.500000");
    assert!(kinds(&summary).is_empty());
}

#[test]
fn without_temperatures_drift_is_reported_but_not_subtracted() {
    let bare = "t_s,ax,ay,az\n0,0.5,0.2,9.8\n1,0.5,0.21,9.8\n";
    let (summary, rows) = table(bare);
    assert_eq!(rows[0][1], "0.400000");
    assert_eq!(kinds(&summary), ["temperature-not-applied"]);
    let cost = &finding(&summary, "temperature-not-applied").message;
    assert!(cost.contains("ax by up to 0.250 m/s^2"), "{cost}");
    assert!(summary.temperature.is_none());

    // Raw counts of a thermometer are not °C.
    let (summary, rows) = table(&ride(&["-3400", "-3410", "-3420"]));
    assert_eq!(rows[2][1], "0.400000");
    let both = ["temperature-unit", "temperature-not-applied"];
    assert_eq!(kinds(&summary), both);
}
