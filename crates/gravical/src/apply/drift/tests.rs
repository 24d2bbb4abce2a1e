use crate::apply::{ApplyOptions, ApplySummary, apply};
use crate::calibration_file::CalibrationFile;
use gravical_recording::bytes::from_reader;

/// Identity, bias 0.1 of x; ax drifts by 0.01 per °C and az by −0.002 about 25 °C, measured from 0
/// to 50 °C; ay was refused.
fn calibration() -> CalibrationFile {
    let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let zero = [[0.0; 3]; 3];
    let file = serde_json::json!({
        "acc_unit": "m/s^2", "gyr_unit": "deg/s", "from_acc_unit": "m/s^2", "cal_type": "Ferraris",
        "K_a": identity, "b_a": [0.1, 0, 0], "R_a": identity,
        "K_g": identity, "b_g": [0, 0, 0], "R_g": identity, "K_ga": zero,
    });
    let mut file = CalibrationFile::parse(file.to_string().as_bytes()).unwrap();
    let gyroscope = serde_json::json!({
        "input_unit": "rad/s", "output_unit": "rad/s", "bias": [0, 0, 0], "matrix": identity,
        "scale": [1, 1, 1], "orientation": identity, "g_sensitivity": zero,
    });
    file.gyroscope = Some(serde_json::from_value(gyroscope).unwrap());
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
    file.temperature_model = Some(serde_json::from_value(model).unwrap());
    file
}

fn run(text: &str) -> (ApplySummary, Vec<Vec<String>>) {
    let input = from_reader(
        Box::new(std::io::Cursor::new(text.as_bytes().to_vec())),
        false,
    )
    .unwrap();
    let mut out = Vec::new();
    let summary = apply(
        &calibration(),
        input,
        "ride.csv",
        &mut out,
        &ApplyOptions::default(),
    )
    .unwrap();
    let rows = String::from_utf8(out).unwrap();
    let cells = |line: &str| line.split(',').map(str::to_owned).collect();
    (summary, rows.lines().skip(1).map(cells).collect())
}

const HEADER: &str =
    "t_s,ax (m/s^2),ay (m/s^2),az (m/s^2),temp (C),gx (rad/s),gy (rad/s),gz (rad/s)\n";

fn ride(temperatures: &[&str]) -> String {
    let rows = temperatures
        .iter()
        .enumerate()
        .map(|(i, t)| format!("{i},0.5,0.2,9.8,{t},0.01,0.02,0.03\n"));
    HEADER.to_owned() + &rows.collect::<String>()
}

fn kinds(summary: &ApplySummary) -> Vec<&str> {
    let all = summary.findings.iter().map(|f| f.kind.name());
    all.filter(|k| k.starts_with("temperature")).collect()
}

#[test]
fn every_row_is_corrected_for_its_temperature() {
    let (summary, rows) = run(&ride(&["25", "35", "15.0"]));
    // raw − drift − bias
    assert_eq!(rows[0][1..4], ["0.400000", "0.200000", "9.800000"]);
    assert_eq!(rows[1][1..4], ["0.300000", "0.200000", "9.820000"]);
    assert_eq!(rows[2][1..4], ["0.500000", "0.200000", "9.780000"]);
    assert_eq!(rows[1][5..], ["0.010000", "0.010000", "0.030000"]);
    assert_eq!(rows[2][5..], ["0.010000", "0.030000", "0.030000"]);
    assert_eq!(rows[2][4], "15.0", "the temperature is kept as it is");
    let done = summary.temperature.unwrap();
    assert_eq!(done.channels, ["ax", "az", "gy"]);
    assert_eq!(done.rows_outside, 0);
}

#[test]
fn outside_the_range_the_edge_is_used_and_reported() {
    let (summary, rows) = run(&ride(&["50", "50.4", "90", "-30"]));
    // 0.5 − 0.25 − 0.1 at 50 °C and beyond, 0.5 + 0.25 − 0.1 at 0 °C.
    let ax: Vec<&str> = rows.iter().map(|r| r[1].as_str()).collect();
    assert_eq!(ax, ["0.150000", "0.150000", "0.150000", "0.650000"]);
    assert_eq!(kinds(&summary), ["temperature-outside"]);
    let reported = summary
        .findings
        .iter()
        .find(|f| f.kind.name() == "temperature-outside")
        .unwrap();
    assert_eq!((reported.count, &reported.lines[..]), (2, &[[4, 5]][..]));
    for number in ["0.0 to 50.0", "-30.0 to 90.0"] {
        assert!(reported.message.contains(number), "{}", reported.message);
    }
}

#[test]
fn an_empty_temperature_repeats_the_last_one() {
    let (summary, rows) = run(&ride(&["", "35", "", "nan", "-3276.8", "15"]));
    let ax: Vec<&str> = rows.iter().map(|r| r[1].as_str()).collect();
    assert_eq!(
        ax,
        [
            "0.300000", "0.300000", "0.300000", "0.300000", "0.300000", "0.500000"
        ]
    );
    assert!(kinds(&summary).is_empty());
}

#[test]
fn without_temperatures_drift_is_reported_but_not_subtracted() {
    let bare = "t_s,ax,ay,az\n0,0.5,0.2,9.8\n1,0.5,0.21,9.8\n";
    let (summary, rows) = run(bare);
    assert_eq!(rows[0][1], "0.400000");
    assert_eq!(kinds(&summary), ["temperature-not-applied"]);
    let reported = &summary
        .findings
        .iter()
        .find(|f| f.kind.name() == "temperature-not-applied")
        .unwrap();
    assert!(
        reported.message.contains("ax by up to 0.250 m/s^2"),
        "{}",
        reported.message
    );
    assert!(summary.temperature.is_none());

    // Raw counts of a thermometer are not °C.
    let (summary, rows) = run(&ride(&["-3400", "-3410", "-3420"]));
    assert_eq!(rows[2][1], "0.400000");
    assert_eq!(
        kinds(&summary),
        ["temperature-unit", "temperature-not-applied"]
    );
}
