//! Drift with temperature, taken off row by row.

use serde::Serialize;

use crate::calibration_file::{CHANNELS, CalibrationFile, TemperatureModel};
use crate::recording::layout::Layout;
use crate::recording::names::Quantity;
use crate::recording::row::{ACCEL, TEMPERATURE, Values};
use crate::recording::{Finding, LineSpans, POSSIBLE_C, is_celsius};
use crate::temperature::{cost_text, evaluate};

use super::head::Head;

/// So far beyond the range nothing is told, °C: thermometers are noisy.
const NEAR_C: f64 = 0.5;

/// What was done about drift with temperature.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TemperatureOutcome {
    /// Channels whose drift was taken off; empty when the recording has no
    /// temperatures.
    pub channels: Vec<String>,
    /// Range of the model, °C.
    pub range_c: [f64; 2],
    /// Rows more than 0.5 °C beyond it: there the drift at its edge is held.
    pub rows_outside: u64,
    /// Rows without a temperature, for which the last one before was taken.
    pub rows_held: u64,
    /// Rows whose drift was not taken off, since no temperature was known.
    pub rows_without: u64,
}

/// Follows the temperature.
pub(super) struct Drift {
    model: TemperatureModel,
    applied: Vec<usize>,
    /// Known last; NaN before the first.
    now_c: f64,
    /// What the drift and gain are at it.
    at: Correction,
    seen_c: [f64; 2],
    outside: LineSpans,
    held: LineSpans,
    without: LineSpans,
}

/// Of each channel: what is taken off, and what the rest is divided by.
#[derive(Clone, Copy)]
struct Correction {
    drift: [f64; 6],
    divisor: [f64; 6],
}

impl Correction {
    const NONE: Self = Correction {
        drift: [0.0; 6],
        divisor: [1.0; 6],
    };
}

impl Drift {
    /// None when the calibration has nothing to take off, or the recording no
    /// temperature to do it by: then a finding says what that may cost.
    pub fn new(
        calibration: &CalibrationFile,
        head: &Head,
        layout: &Layout,
        findings: &mut Vec<Finding>,
    ) -> Option<Self> {
        let model = calibration.temperature_model.as_ref()?;
        // Without a gyroscope's calibration its columns stay as they are.
        let channels = if calibration.gyroscope.is_some() && layout.has_gyro() {
            6
        } else {
            3
        };
        let applied: Vec<usize> = (0..channels)
            .filter(|i| model.channel(CHANNELS[*i]).is_some_and(|c| c.is_accepted()))
            .collect();
        if applied.is_empty() {
            return None;
        }
        let why = match layout.field(Quantity::Temperature) {
            None => Some("the recording has no temperatures"),
            Some(_) if !is_celsius(&head.temperature, findings) => {
                Some("the recording's temperatures are no °C")
            }
            Some(_) => None,
        };
        if let Some(why) = why {
            findings.push(Finding::warning(
                "temperature-not-applied",
                format!(
                    "{why}, so the calibration's drift with temperature is not taken off: {}",
                    cost_text(model)
                ),
            ));
            return None;
        }
        let mut drift = Drift {
            model: model.clone(),
            applied,
            now_c: f64::NAN,
            at: Correction::NONE,
            seen_c: [f64::INFINITY, f64::NEG_INFINITY],
            outside: LineSpans::default(),
            held: LineSpans::default(),
            without: LineSpans::default(),
        };
        // Rows before the first temperature are nearer to it than to none.
        if let Some(first) = head.temperature.iter().find(|t| POSSIBLE_C.contains(*t)) {
            drift.go_to(*first);
        }
        Some(drift)
    }

    fn go_to(&mut self, t_c: f64) {
        self.now_c = t_c;
        self.at = self.correction(t_c);
    }

    fn correction(&self, t_c: f64) -> Correction {
        let [low, high] = self.model.range_c;
        let x = t_c.clamp(low, high) - self.model.reference_c;
        let mut out = Correction::NONE;
        for &i in &self.applied {
            if let Some(channel) = self.model.channel(CHANNELS[i]) {
                out.drift[i] = evaluate(&channel.coefficients, x);
                out.divisor[i] = 1.0 + evaluate(&channel.scale_coefficients, x);
            }
        }
        out
    }

    /// The readings of a row as they would be at the reference temperature.
    /// `counts` is false for a row that may be none.
    #[inline]
    pub fn taken_off(&mut self, values: &Values, line: u64, counts: bool) -> Values {
        let t_c = values[TEMPERATURE];
        if POSSIBLE_C.contains(&t_c) {
            if t_c != self.now_c {
                self.go_to(t_c);
            }
        } else if counts {
            if self.now_c.is_nan() {
                self.without.push(line);
            } else {
                self.held.push(line);
            }
        }
        if counts && self.now_c.is_finite() {
            let [low, high] = self.model.range_c;
            if !(low - NEAR_C..=high + NEAR_C).contains(&self.now_c) {
                self.outside.push(line);
                self.seen_c = [
                    self.seen_c[0].min(self.now_c),
                    self.seen_c[1].max(self.now_c),
                ];
            }
        }
        let mut out = *values;
        for ((v, drift), divisor) in out[ACCEL..ACCEL + 6]
            .iter_mut()
            .zip(self.at.drift)
            .zip(self.at.divisor)
        {
            *v = (*v - drift) / divisor;
        }
        out
    }

    /// The accelerometer of a row at `t_c` without its drift; one without a
    /// temperature as it is.
    pub fn accel_at(&self, mut accel: [f64; 3], t_c: f64) -> [f64; 3] {
        if POSSIBLE_C.contains(&t_c) {
            let at = self.correction(t_c);
            for ((v, drift), divisor) in accel.iter_mut().zip(at.drift).zip(at.divisor) {
                *v = (*v - drift) / divisor;
            }
        }
        accel
    }

    /// The findings and what was done, after the last row.
    pub fn finish(&self, findings: &mut Vec<Finding>) -> TemperatureOutcome {
        let [low, high] = self.model.range_c;
        if !self.outside.is_empty() {
            let [coldest, warmest] = self.seen_c;
            let mut beyond = Vec::new();
            if coldest < low {
                beyond.push(format!("down to {coldest:.1} °C"));
            }
            if warmest > high {
                beyond.push(format!("up to {warmest:.1} °C"));
            }
            findings.push(
                Finding::warning(
                    "temperature-outside",
                    format!(
                        "{} rows are outside of the {low:.1} to {high:.1} °C that the drift was measured in ({}): the drift at the edge is taken off there, and may be wrong",
                        self.outside.count(),
                        beyond.join(", ")
                    ),
                )
                .at_lines(&self.outside),
            );
        }
        if !self.held.is_empty() {
            findings.push(
                Finding::note(
                    "temperature-held",
                    format!(
                        "{} rows have no temperature: the last one known was taken",
                        self.held.count()
                    ),
                )
                .at_lines(&self.held),
            );
        }
        if !self.without.is_empty() {
            findings.push(
                Finding::warning(
                    "temperature-not-applied",
                    format!(
                        "{} rows come before the first temperature, so the calibration's drift is not taken off there: {}",
                        self.without.count(),
                        cost_text(&self.model)
                    ),
                )
                .at_lines(&self.without),
            );
        }
        TemperatureOutcome {
            channels: self
                .applied
                .iter()
                .map(|i| CHANNELS[*i].to_owned())
                .collect(),
            range_c: self.model.range_c,
            rows_outside: self.outside.count(),
            rows_held: self.held.count(),
            rows_without: self.without.count(),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::apply::{ApplyOptions, ApplySummary, apply};
    use crate::calibration_file::CalibrationFile;
    use crate::recording::open::from_reader;

    /// Twice the reading, bias 0.1; ax drifts by 0.01 per °C and az has a gain of
    /// 0.1 % per °C about 25 °C, measured from 0 to 50 °C; ay was refused.
    fn calibration(with_model: bool) -> CalibrationFile {
        let mut value = serde_json::json!({
            "format": "gravical-calibration/1", "created": "", "tool": "",
            "sensor": {"id": null, "model": null},
            "gravity_mps2": 9.80665, "gravity_source": "standard", "temperature_c": null,
            "accelerometer": {
                "method": "ferraris", "input_unit": "m/s^2", "output_unit": "m/s^2",
                "bias": [0.1, 0.0, 0.0], "matrix": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
                "scale": [1.0, 1.0, 1.0], "orientation": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
                "covariance": null, "positions": [], "errors": null, "scale_deviation_percent": null,
                "degrees_of_freedom": 0, "leave_one_out_rms_mps2": null,
                "predicted_norm_error_mps2": null, "placement_tilt_deg": null},
            "gyroscope": {"input_unit": "rad/s", "output_unit": "rad/s", "bias": [0.0, 0.0, 0.0],
                "matrix": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], "scale": [1.0, 1.0, 1.0],
                "orientation": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
                "g_sensitivity": [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]},
            "inputs": [], "findings": [], "verdict": {"grade": "not-verifiable", "reasons": []}
        });
        if with_model {
            let channel = |name: &str, verdict: &str, drift: &[f64], gain: &[f64]| {
                serde_json::json!({
                    "channel": name, "input_unit": "m/s^2", "verdict": verdict, "reason": "",
                    "order": 1, "r2_cooling_to_warming": null, "r2_warming_to_cooling": null,
                    "slope": null, "slope_cooling": null, "slope_warming": null, "hysteresis": null,
                    "drift_rms": 0.0, "residual_rms": null, "coefficients": drift,
                    "scale_coefficients": gain, "scale_observed": false})
            };
            value["temperature_model"] = serde_json::json!({
            "reference_c": 25.0, "reference_source": "session", "range_c": [0.0, 50.0],
            "poses": 1, "sweeps": [], "inputs": [], "channels": [
                channel("ax", "accepted", &[0.01], &[]),
                channel("ay", "refused", &[], &[]),
                channel("az", "accepted", &[0.0], &[0.001]),
                channel("gy", "accepted", &[0.001, 0.0001], &[]),
            ]});
        }
        CalibrationFile::parse(value.to_string().as_bytes()).unwrap()
    }

    fn run(with_model: bool, text: &str) -> (ApplySummary, Vec<Vec<String>>) {
        let input = from_reader(
            Box::new(std::io::Cursor::new(text.as_bytes().to_vec())),
            false,
        )
        .unwrap();
        let mut out = Vec::new();
        let summary = apply(
            &calibration(with_model),
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
        let all = summary.findings.iter().map(|f| f.kind.as_str());
        all.filter(|k| k.starts_with("temperature")).collect()
    }

    #[test]
    fn every_row_by_its_own_temperature() {
        let (summary, rows) = run(true, &ride(&["25", "35", "15.0"]));
        // (raw − drift)/(1 + gain) − bias
        assert_eq!(rows[0][1..4], ["0.400000", "0.200000", "9.800000"]);
        assert_eq!(rows[1][1..4], ["0.300000", "0.200000", "9.702970"]);
        assert_eq!(rows[2][1..4], ["0.500000", "0.200000", "9.898990"]);
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
    fn beyond_the_range_the_edge_is_held_and_told() {
        let (summary, rows) = run(true, &ride(&["50", "50.4", "90", "-30"]));
        // 0.5 − 0.25 − 0.1 at 50 °C and beyond, 0.5 + 0.25 − 0.1 at 0 °C.
        let ax: Vec<&str> = rows.iter().map(|r| r[1].as_str()).collect();
        assert_eq!(ax, ["0.150000", "0.150000", "0.150000", "0.650000"]);
        assert_eq!(kinds(&summary), ["temperature-outside"]);
        let told = summary
            .findings
            .iter()
            .find(|f| f.kind == "temperature-outside")
            .unwrap();
        assert_eq!((told.count, &told.lines[..]), (2, &[[4, 5]][..]));
        for number in ["0.0 to 50.0", "down to -30.0", "up to 90.0"] {
            assert!(told.message.contains(number), "{}", told.message);
        }
    }

    #[test]
    fn an_empty_temperature_is_the_last_one() {
        let (summary, rows) = run(true, &ride(&["", "35", "", "nan", "-3276.8", "15"]));
        let ax: Vec<&str> = rows.iter().map(|r| r[1].as_str()).collect();
        assert_eq!(
            ax,
            [
                "0.300000", "0.300000", "0.300000", "0.300000", "0.300000", "0.500000"
            ]
        );
        assert_eq!(kinds(&summary), ["temperature-held"]);
        assert_eq!(summary.temperature.unwrap().rows_held, 4);
    }

    #[test]
    fn without_temperatures_nothing_is_taken_off_and_the_cost_is_told() {
        let bare = "t_s,ax,ay,az\n0,0.5,0.2,9.8\n1,0.5,0.21,9.8\n";
        let (summary, rows) = run(true, bare);
        assert_eq!(rows[0][1], "0.400000");
        assert_eq!(kinds(&summary), ["temperature-not-applied"]);
        let told = &summary
            .findings
            .iter()
            .find(|f| f.kind == "temperature-not-applied")
            .unwrap();
        assert!(
            told.message.contains("ax by up to 0.250 m/s^2"),
            "{}",
            told.message
        );
        assert!(summary.temperature.is_none());

        // Raw counts of a thermometer are no °C.
        let (summary, rows) = run(true, &ride(&["-3400", "-3410", "-3420"]));
        assert_eq!(rows[2][1], "0.400000");
        assert_eq!(
            kinds(&summary),
            ["temperature-unit", "temperature-not-applied"]
        );
    }

    #[test]
    fn without_a_model_nothing_changes() {
        let text = ride(&["25", "35", "90"]);
        let (summary, rows) = run(false, &text);
        assert!(
            rows.iter()
                .all(|r| r[1] == "0.400000" && r[3] == "9.800000")
        );
        assert_eq!(kinds(&summary), [""; 0]);
        assert!(summary.temperature.is_none());
    }
}
