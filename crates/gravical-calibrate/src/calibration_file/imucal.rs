//! Reading (2.0 and before) and writing of imucal's JSON.
//!
//! imucal calibrates by R⁻¹K⁻¹(r − b) in m/s² and °/s; this program uses the same model with
//! rad/s for the gyroscope, so that imucal's K_g is the scale · π/180. Without a gyroscope
//! identity and zero are written, because imucal requires the keys.

use gravical_core::matrix3::{diagonal, identity, inverse, mul};
use gravical_core::unit::{DEGREES_PER_RADIAN, RADIANS_PER_DEGREE, STANDARD_GRAVITY_MPS2};
use serde::{Deserialize, Serialize};

use crate::Result;
use crate::problem::Problem;
use crate::recording::units::{AccelUnit, GyroUnit};

use super::{
    Accelerometer, Calibration, FORMAT, GravitySource, Gyroscope, Method, Reliability, SensorInfo,
    creation_time, syntax, to_text,
};

type Matrix = [[f64; 3]; 3];

#[derive(Serialize, Deserialize)]
#[allow(non_snake_case)] // imucal's keys
struct Imucal {
    acc_unit: Option<String>,
    #[serde(alias = "gyro_unit")]
    gyr_unit: Option<String>,
    from_acc_unit: Option<String>,
    from_gyr_unit: Option<String>,
    comment: Option<String>,
    K_a: Matrix,
    R_a: Matrix,
    b_a: [f64; 3],
    K_g: Matrix,
    R_g: Matrix,
    K_ga: Matrix,
    b_g: [f64; 3],
    cal_type: String,
    #[serde(rename = "_format_version", default)]
    format_version: Option<String>,
}

/// Reads a calibration of imucal; the format before 2.0 has no version and no input units.
///
/// # Errors
///
/// `calibration-syntax` for missing keys, `calibration-format` for an output
/// unit other than m/s² and °/s or a version above 2, `calibration-values` for
/// singular matrices.
pub fn from_imucal(value: &serde_json::Value) -> Result<Calibration> {
    let file: Imucal = serde_json::from_value(value.clone()).map_err(|e| syntax(&e))?;
    if let Some(version) = &file.format_version
        && !version.starts_with("2.")
    {
        let version = version.clone();
        return Err(Problem::ImucalVersion { version }.error());
    }
    for (unit, wanted) in [(&file.acc_unit, "m/s^2"), (&file.gyr_unit, "deg/s")] {
        if let Some(unit) = unit.clone().filter(|unit| unit != wanted) {
            return Err(Problem::ImucalUnit { unit, wanted }.error());
        }
    }
    let accel_unit = file.from_acc_unit.as_deref().and_then(AccelUnit::parse);
    let gyro_unit = file.from_gyr_unit.as_deref().and_then(GyroUnit::parse);
    let matrix = inverse_of(&file.K_a, &file.R_a, 1.0)?;
    let accelerometer = Accelerometer {
        method: match file.cal_type.to_lowercase().as_str() {
            "ferraris" => Method::Ferraris,
            _ => Method::Unknown,
        },
        input_unit: accel_unit.unwrap_or_default(),
        bias: file.b_a,
        matrix,
        ..Accelerometer::default()
    };
    let no_gyro = file.K_g == identity::<f64>()
        && file.R_g == identity::<f64>()
        && file.b_g == [0.0; 3]
        && file.K_ga == [[0.0; 3]; 3];
    let gyroscope = || -> Result<Gyroscope> {
        let matrix = inverse_of(&file.K_g, &file.R_g, DEGREES_PER_RADIAN)?;
        Ok(Gyroscope {
            input_unit: gyro_unit.unwrap_or_default(),
            bias: file.b_g,
            matrix,
            g_sensitivity: file.K_ga,
            ..Gyroscope::default()
        })
    };
    let gyroscope = (!no_gyro).then(gyroscope).transpose()?;
    let file = Calibration {
        format: FORMAT.to_owned(),
        created: creation_time(),
        tool: "imucal".to_owned(),
        recorded: None,
        sensor: SensorInfo::default(),
        gravity_mps2: STANDARD_GRAVITY_MPS2,
        gravity_source: GravitySource::Standard,
        gravity_sd_mps2: 0.0,
        temperature_c: None,
        accelerometer,
        gyroscope,
        reliability: Reliability::default(),
        poses: Vec::new(),
        drift: None,
        inputs: Vec::new(),
        findings: Vec::new(),
        command: None,
    };
    file.check()?;
    Ok(file)
}

/// (K·R)⁻¹; `per_unit`: imucal's output units per output unit of this program.
fn inverse_of(k: &Matrix, r: &Matrix, per_unit: f64) -> Result<Matrix> {
    if *k != diagonal(std::array::from_fn(|i| k[i][i])) {
        return Err(Problem::ImucalNotDiagonal.error());
    }
    let singular = || Problem::ImucalSingular.error();
    let k_inverse = inverse(k).ok_or_else(singular)?;
    let r_inverse = inverse(r).ok_or_else(singular)?;
    Ok(mul(&r_inverse, &k_inverse).map(|row| row.map(|v| v / per_unit)))
}

/// Writes a calibration in imucal's format.
///
/// # Errors
///
/// `calibration-syntax` if the values cannot be written as JSON.
pub fn to_imucal(file: &Calibration) -> Result<String> {
    let a = &file.accelerometer;
    // imucal requires the keys.
    let none = || Gyroscope {
        input_unit: GyroUnit::DegreePerSecond,
        matrix: diagonal([RADIANS_PER_DEGREE; 3]),
        ..Gyroscope::default()
    };
    let gyro = file.gyroscope.clone().unwrap_or_else(none);
    let name = |unit: &str| match unit {
        "counts" => Some("a.u.".to_owned()),
        "unknown" => None,
        other => Some(other.to_owned()),
    };
    let imucal = Imucal {
        acc_unit: Some("m/s^2".to_owned()),
        gyr_unit: Some("deg/s".to_owned()),
        from_acc_unit: name(a.input_unit.name()),
        from_gyr_unit: name(gyro.input_unit.name()),
        comment: Some(format!(
            "{}, {}, verdict {}",
            file.tool,
            file.created,
            file.grade()
        )),
        K_a: diagonal(a.scale()),
        R_a: a.orientation(),
        b_a: a.bias,
        K_g: diagonal(gyro.scale().map(|s| s * RADIANS_PER_DEGREE)),
        R_g: gyro.orientation(),
        K_ga: gyro.g_sensitivity,
        b_g: gyro.bias,
        cal_type: "Ferraris".to_owned(),
        format_version: Some("2.0.0".to_owned()),
    };
    to_text(&imucal)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn old_format_is_read_and_other_units_are_refused() {
        let identity = identity::<f64>();
        let mut old = serde_json::json!({
            "acc_unit": "m/s^2", "gyro_unit": "deg/s", "cal_type": "Ferraris",
            "K_a": identity, "R_a": identity, "b_a": [-6.0, -48.2, -28.9],
            "K_g": identity, "R_g": identity, "b_g": [1.9, -4.4, -3.6],
            "K_ga": [[0.002, -0.016, 0.018], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
        });
        let file = from_imucal(&old).unwrap();
        assert_eq!(file.accelerometer.input_unit, AccelUnit::Unknown);
        assert!((file.gyroscope.unwrap().scale()[0].to_radians() - 1.0).abs() < 1e-12);
        old["acc_unit"] = "g".into();
        assert_eq!(from_imucal(&old).unwrap_err().code(), "calibration-format");
    }
}
