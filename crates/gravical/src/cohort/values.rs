//! What each command measures of an item: the columns of a summary behind the [common](super::COMMON)
//! ones.

use serde::{Deserialize, Serialize};

use super::row::{Columns, Outcome, kinds};
use crate::apply::ApplySummary;
use crate::calibration_file::{CalibrationFile, Deviations, Grade};
use crate::check::{CheckReport, Judgement};
use crate::finding::Finding;
use crate::noise::{NoiseResult, Term, duration_text};
use crate::numfmt::unit;

/// A type with columns whose names are those of its fields.
macro_rules! columns {
    ($(#[$doc:meta])* $name:ident { $($field:ident: $type:ty,)* }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
        pub struct $name {
            $(#[allow(missing_docs)] pub $field: $type,)*
        }

        impl Columns for $name {
            const NAMES: &'static [&'static str] = &[$(stringify!($field),)*];
        }
    };
}

columns! {
    /// The parameters of a calibration with their standard deviations, in the units of its file.
    CalibrationValues {
        sensor_id: Option<String>,
        input_unit: String,
        bias_x: f64,
        bias_y: f64,
        bias_z: f64,
        bias_x_sd: Option<f64>,
        bias_y_sd: Option<f64>,
        bias_z_sd: Option<f64>,
        scale_x: f64,
        scale_y: f64,
        scale_z: f64,
        scale_x_sd: Option<f64>,
        scale_y_sd: Option<f64>,
        scale_z_sd: Option<f64>,
        worst_direction_error_mps2: Option<f64>,
        predicted_norm_error_mps2: Option<f64>,
        leave_one_out_rms_mps2: Option<f64>,
        poses: usize,
        temperature_c: Option<f64>,
        gyro_unit: Option<String>,
        gyro_bias_x: Option<f64>,
        gyro_bias_y: Option<f64>,
        gyro_bias_z: Option<f64>,
        findings: String,
    }
}

impl From<&CalibrationFile> for CalibrationValues {
    fn from(file: &CalibrationFile) -> Self {
        let a = &file.accelerometer;
        let sd = |of: fn(&Deviations) -> [f64; 3], axis: usize| {
            a.deviations.as_ref().map(|d| of(d)[axis])
        };
        let gyroscope = file.gyroscope.as_ref();
        let gyro_bias = |axis: usize| gyroscope.map(|g| g.bias[axis]);
        CalibrationValues {
            sensor_id: file.sensor.id.clone(),
            input_unit: a.input_unit.name().to_owned(),
            bias_x: a.bias[0],
            bias_y: a.bias[1],
            bias_z: a.bias[2],
            bias_x_sd: sd(|d| d.bias, 0),
            bias_y_sd: sd(|d| d.bias, 1),
            bias_z_sd: sd(|d| d.bias, 2),
            scale_x: a.scale[0],
            scale_y: a.scale[1],
            scale_z: a.scale[2],
            scale_x_sd: sd(|d| d.scale, 0),
            scale_y_sd: sd(|d| d.scale, 1),
            scale_z_sd: sd(|d| d.scale, 2),
            worst_direction_error_mps2: a.worst_direction.as_ref().map(|w| w.error_mps2),
            predicted_norm_error_mps2: a.predicted_norm_error_mps2,
            leave_one_out_rms_mps2: a.leave_one_out_rms_mps2,
            poses: a.poses.len(),
            temperature_c: file.temperature_c.map(|t| t.mean),
            gyro_unit: gyroscope.map(|g| g.input_unit.name().to_owned()),
            gyro_bias_x: gyro_bias(0),
            gyro_bias_y: gyro_bias(1),
            gyro_bias_z: gyro_bias(2),
            findings: kinds(&file.findings),
        }
    }
}

columns! {
    /// The numbers of a check.
    CheckValues {
        static_intervals: usize,
        rms_mps2: f64,
        predicted_rms_mps2: Option<f64>,
        worst_error_mps2: Option<f64>,
        worst_z: Option<f64>,
        p_value: Option<f64>,
        gyroscope: Option<String>,
        findings: String,
    }
}

impl From<&CheckReport> for CheckValues {
    fn from(report: &CheckReport) -> Self {
        let worst = report.static_intervals.get(report.worst);
        let gyroscope = report.gyroscope.as_ref();
        CheckValues {
            static_intervals: report.static_intervals.len(),
            rms_mps2: report.rms_mps2,
            predicted_rms_mps2: report.predicted_rms_mps2,
            worst_error_mps2: worst.map(|s| s.error_mps2),
            worst_z: worst.and_then(|s| s.z),
            p_value: report.p_value,
            gyroscope: gyroscope.map(|g| g.judgement.name().to_owned()),
            findings: kinds(&report.findings),
        }
    }
}

columns! {
    /// The numbers of an application.
    ApplyValues {
        input_unit: String,
        lines: u64,
        rows: u64,
        rows_without_acceleration: u64,
        quiet_norm_mps2: Option<f64>,
        findings: String,
    }
}

impl From<&ApplySummary> for ApplyValues {
    fn from(summary: &ApplySummary) -> Self {
        ApplyValues {
            input_unit: summary.accelerometer.unit.name().to_owned(),
            lines: summary.lines,
            rows: summary.rows,
            rows_without_acceleration: summary.rows_without_acceleration,
            quiet_norm_mps2: summary.quiet_norm_mps2,
            findings: kinds(&summary.findings),
        }
    }
}

columns! {
    /// Noise density, bias instability and random walk of each channel, in m/s², rad/s, seconds and
    /// hertz; of a term that the recording does not determine, nothing.
    NoiseValues {
        rate_hz: f64,
        used_s: f64,
        ax_n: Option<f64>,
        ay_n: Option<f64>,
        az_n: Option<f64>,
        ax_b: Option<f64>,
        ay_b: Option<f64>,
        az_b: Option<f64>,
        ax_k: Option<f64>,
        ay_k: Option<f64>,
        az_k: Option<f64>,
        gx_n: Option<f64>,
        gy_n: Option<f64>,
        gz_n: Option<f64>,
        gx_b: Option<f64>,
        gy_b: Option<f64>,
        gz_b: Option<f64>,
        gx_k: Option<f64>,
        gy_k: Option<f64>,
        gz_k: Option<f64>,
        findings: String,
    }
}

impl From<&NoiseResult> for NoiseValues {
    fn from(result: &NoiseResult) -> Self {
        let of = |name: &str, term| Some(result.channel(name)?.estimate(term)?.value);
        NoiseValues {
            rate_hz: result.rate_hz,
            used_s: result.used_s,
            ax_n: of("ax", Term::N),
            ay_n: of("ay", Term::N),
            az_n: of("az", Term::N),
            ax_b: of("ax", Term::B),
            ay_b: of("ay", Term::B),
            az_b: of("az", Term::B),
            ax_k: of("ax", Term::K),
            ay_k: of("ay", Term::K),
            az_k: of("az", Term::K),
            gx_n: of("gx", Term::N),
            gy_n: of("gy", Term::N),
            gz_n: of("gz", Term::N),
            gx_b: of("gx", Term::B),
            gy_b: of("gy", Term::B),
            gz_b: of("gz", Term::B),
            gx_k: of("gx", Term::K),
            gy_k: of("gy", Term::K),
            gz_k: of("gz", Term::K),
            findings: kinds(&result.findings),
        }
    }
}

impl From<&CalibrationFile> for Outcome<CalibrationValues> {
    fn from(file: &CalibrationFile) -> Self {
        Outcome {
            verdict: file.verdict.grade.name().to_owned(),
            is_poor: file.verdict.grade == Grade::Poor,
            reasons: file.verdict.reasons.clone(),
            values: file.into(),
        }
    }
}

impl From<&CheckReport> for Outcome<CheckValues> {
    fn from(report: &CheckReport) -> Self {
        let judgement = report.verdict.judgement;
        Outcome {
            verdict: judgement.name().to_owned(),
            is_poor: judgement == Judgement::DoesNotFit,
            reasons: report.verdict.reasons.clone(),
            values: report.into(),
        }
    }
}

impl From<&ApplySummary> for Outcome<ApplyValues> {
    fn from(summary: &ApplySummary) -> Self {
        Outcome {
            verdict: "done".to_owned(),
            is_poor: false,
            reasons: vec![with_kinds(
                format!("{} rows", summary.rows),
                &summary.findings,
            )],
            values: summary.into(),
        }
    }
}

impl From<&NoiseResult> for Outcome<NoiseValues> {
    fn from(result: &NoiseResult) -> Self {
        let used = format!("{} at rest", duration_text(result.used_s));
        Outcome {
            verdict: "analysed".to_owned(),
            is_poor: false,
            reasons: vec![with_kinds(used, &result.findings)],
            values: result.into(),
        }
    }
}

fn with_kinds(mut reason: String, findings: &[Finding]) -> String {
    let kinds = kinds(findings);
    if !kinds.is_empty() {
        reason.push_str("; ");
        reason.push_str(&kinds);
    }
    reason
}

/// A table of one command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CommandColumns {
    /// Name of the command.
    pub command: &'static str,
    /// Its columns, in order.
    pub names: &'static [&'static str],
    /// The column by which items are compared: the larger, the worse.
    pub worst: &'static str,
    /// Unit of that column.
    pub worst_unit: &'static str,
    /// Columns of the three axes that belong together.
    pub axes: &'static [AxisColumns],
}

/// Columns of the three axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AxisColumns {
    /// What they are.
    pub what: &'static str,
    /// Their unit.
    pub unit: ColumnUnit,
    /// Their names.
    pub names: [&'static str; 3],
}

/// Unit of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnUnit {
    /// That of the accelerometer in the recording.
    Input,
    /// The same for each m/s².
    InputPerMps2,
    /// That of the gyroscope in the recording.
    Gyro,
    /// Always this one.
    Is(&'static str),
}

/// Units by the ending of a name.
const ENDINGS: [(&str, &str); 5] = [
    ("_mps2", "m/s²"),
    ("_c", "°C"),
    ("_hz", "Hz"),
    ("_s", "s"),
    ("_mg", "mg"),
];

impl CommandColumns {
    /// Unit of the column `name`, in a row whose column `input_unit` or `gyro_unit` is `text` of it.
    pub(super) fn unit<'a>(&self, name: &str, text: impl Fn(&str) -> Option<&'a str>) -> String {
        let own = name.strip_suffix("_sd").unwrap_or(name);
        let axes = self.axes.iter().find(|axes| axes.names.contains(&own));
        let read = |column: &str| unit(text(column).unwrap_or_default());
        match axes.map(|axes| axes.unit) {
            Some(ColumnUnit::Input) => read("input_unit"),
            Some(ColumnUnit::InputPerMps2) => match read("input_unit") {
                same if same == "m/s²" => String::new(),
                other => format!("{other}/(m/s²)"),
            },
            Some(ColumnUnit::Gyro) => read("gyro_unit"),
            Some(ColumnUnit::Is(unit)) => unit.to_owned(),
            None => {
                let ending = ENDINGS.iter().find(|(ending, _)| name.ends_with(ending));
                ending.map_or(String::new(), |(_, unit)| (*unit).to_owned())
            }
        }
    }
}

/// The tables of all commands that work on many items.
pub const COMMANDS: [CommandColumns; 4] = [
    CommandColumns {
        command: "calibrate",
        names: CalibrationValues::NAMES,
        worst: "worst_direction_error_mps2",
        worst_unit: "m/s²",
        axes: &[
            AxisColumns {
                what: "bias",
                unit: ColumnUnit::Input,
                names: ["bias_x", "bias_y", "bias_z"],
            },
            AxisColumns {
                what: "scale",
                unit: ColumnUnit::InputPerMps2,
                names: ["scale_x", "scale_y", "scale_z"],
            },
            AxisColumns {
                what: "gyroscope bias",
                unit: ColumnUnit::Gyro,
                names: ["gyro_bias_x", "gyro_bias_y", "gyro_bias_z"],
            },
        ],
    },
    CommandColumns {
        command: "check",
        names: CheckValues::NAMES,
        worst: "rms_mps2",
        worst_unit: "m/s²",
        axes: &[],
    },
    CommandColumns {
        command: "apply",
        names: ApplyValues::NAMES,
        worst: "rows_without_acceleration",
        worst_unit: "",
        axes: &[],
    },
    CommandColumns {
        command: "noise",
        names: NoiseValues::NAMES,
        worst: "az_n",
        worst_unit: "m/s²/√Hz",
        axes: &[
            AxisColumns {
                what: "accelerometer N",
                unit: ColumnUnit::Is("m/s²/√Hz"),
                names: ["ax_n", "ay_n", "az_n"],
            },
            AxisColumns {
                what: "gyroscope N",
                unit: ColumnUnit::Is("rad/s/√Hz"),
                names: ["gx_n", "gy_n", "gz_n"],
            },
        ],
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_column_of_the_worst_exists_and_no_column_is_nested() {
        for table in COMMANDS {
            assert!(table.names.contains(&table.worst), "{}", table.command);
        }
        for value in [
            serde_json::to_value(CalibrationValues::default()).unwrap(),
            serde_json::to_value(CheckValues::default()).unwrap(),
            serde_json::to_value(ApplyValues::default()).unwrap(),
            serde_json::to_value(NoiseValues::default()).unwrap(),
        ] {
            let fields = value.as_object().unwrap();
            assert!(fields.values().all(|v| !v.is_object() && !v.is_array()));
        }
    }
}
