use crate::apply::{ApplyOptions, ApplySummary, apply};
use crate::calibration_file::CalibrationFile;
use crate::recording::Finding;
use gravical_core::matrix3::diagonal;
use gravical_recording::bytes::from_reader;
use serde_json::json;

/// Identity, bias 0.1 of x; ax drifts by 0.01 per °C and az by −0.002 about 25 °C, measured from 0
/// to 50 °C; ay was refused.
fn calibration() -> CalibrationFile {
    let (one, none) = (diagonal([1.0; 3]), [[0.0; 3]; 3]);
    let imucal = json!({
        "acc_unit": "m/s^2", "gyr_unit": "deg/s", "from_acc_unit": "m/s^2", "cal_type": "Ferraris",
        "K_a": one, "b_a": [0.1, 0.0, 0.0], "R_a": one,
        "K_g": one, "b_g": [0, 0, 0], "R_g": one, "K_ga": none,
    });
    let mut file = CalibrationFile::parse(imucal.to_string().as_bytes()).unwrap();
    let gyroscope = json!({
        "input_unit": "rad/s", "output_unit": "rad/s", "bias": [0.0, 0.0, 0.0], "matrix": one,
        "scale": [1.0, 1.0, 1.0], "orientation": one, "g_sensitivity": none,
    });
    file.gyroscope = Some(serde_json::from_value(gyroscope).unwrap());
    let channel = |name: &str, verdict: &str, drift: &[f64]| {
        json!({
            "channel": name, "input_unit": "m/s^2", "verdict": verdict, "reason": "",
            "order": 1, "coefficients": drift,
        })
    };
    let model = json!({
        "reference_c": 25.0, "range_c": [0.0, 50.0], "inputs": [],
        "channels": [
            channel("ax", "corrected", &[0.01]),
            channel("ay", "not-corrected", &[]),
            channel("az", "corrected", &[-0.002]),
            channel("gy", "corrected", &[0.001, 0.0001]),
        ],
    });
    file.temperature_model = Some(serde_json::from_value(model).unwrap());
    file
}

fn run(text: &str) -> (ApplySummary, Vec<Vec<String>>) {
    let bytes = std::io::Cursor::new(text.as_bytes().to_vec());
    let input = from_reader(Box::new(bytes), false).unwrap();
    let mut out = Vec::new();
    let options = ApplyOptions::default();
    let summary = apply(&calibration(), input, "ride.csv", &mut out, &options).unwrap();
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

fn temperatures(summary: &ApplySummary) -> Vec<&Finding> {
    let all = summary.findings.iter();
    all.filter(|f| f.kind.name().starts_with("temperature"))
        .collect()
}

#[test]
fn every_row_is_corrected_for_its_temperature() {
    let (summary, rows) = run(&ride(&["25", "35", "15.0"]));
    // raw − drift − bias
    assert_eq!(rows[0][1..4], ["0.400000", "0.200000", "9.800000"]);
    assert_eq!(rows[1][1..4], ["0.300000", "0.200000", "9.820000"]);
    assert_eq!(rows[2][1..4], ["0.500000", "0.200000", "9.780000"]);
    // gy: 0.001 x + 0.0001 x²
    assert_eq!(rows[1][5..], ["0.010000", "0.000000", "0.030000"]);
    assert_eq!(rows[2][5..], ["0.010000", "0.020000", "0.030000"]);
    assert_eq!(rows[2][4], "15.0", "the temperature is kept as it is");
    let done = summary.temperature.unwrap();
    assert_eq!(done.channels, ["ax", "az", "gy"]);
    assert_eq!(
        (done.rows_outside, done.rows_held, done.rows_without),
        (0, 0, 0)
    );
}

#[test]
fn outside_the_range_the_edge_is_used_and_reported() {
    let (summary, rows) = run(&ride(&["50", "50.4", "90", "-30"]));
    // 0.5 − 0.25 − 0.1 at 50 °C and beyond, 0.5 + 0.25 − 0.1 at 0 °C.
    let ax: Vec<&str> = rows.iter().map(|r| r[1].as_str()).collect();
    assert_eq!(ax, ["0.150000", "0.150000", "0.150000", "0.650000"]);
    let found = temperatures(&summary);
    let [reported] = found[..] else {
        panic!("{:?}", summary.findings)
    };
    assert_eq!(reported.kind.name(), "temperature-outside");
    assert_eq!((reported.count, &reported.lines[..]), (2, &[[4, 5]][..]));
    assert!(reported.message.contains("-30.0 to 90.0"), "{reported:?}");
}

#[test]
fn an_empty_temperature_repeats_the_last_one() {
    let (summary, rows) = run(&ride(&["", "35", "", "nan", "-3276.8", "15"]));
    assert!(rows[..5].iter().all(|r| r[1] == "0.300000"), "{rows:?}");
    assert_eq!(rows[5][1], "0.500000");
    assert!(temperatures(&summary).is_empty());
    assert_eq!(summary.temperature.unwrap().rows_held, 4);
}

#[test]
fn without_temperatures_drift_is_reported_but_not_subtracted() {
    let bare = "t_s,ax,ay,az\n0,0.5,0.2,9.8\n1,0.5,0.21,9.8\n".to_owned();
    // Raw counts of a thermometer are not °C.
    let counts = ride(&["-3400", "-3410", "-3420"]);
    for text in [bare, counts] {
        let (summary, rows) = run(&text);
        assert!(rows.iter().all(|row| row[1] == "0.400000"), "{rows:?}");
        let found = temperatures(&summary);
        let reported = found.last().unwrap();
        assert_eq!(reported.kind.name(), "temperature-not-applied");
        let says = reported.message.contains("ax by up to 0.250 m/s^2");
        assert!(says && summary.temperature.is_none(), "{reported:?}");
    }
}
