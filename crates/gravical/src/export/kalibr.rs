//! Kalibr: the noise of the IMU.

use super::Export;
use crate::calibration_file::{CalibrationFile, NoiseParameters, NoiseSection};
use crate::{Error, Result};

/// The `imu.yaml` of Kalibr: noise density N and random walk K of accelerometer and gyroscope, each
/// the largest of the three axes. Kalibr reads no calibration; that of the accelerometer is a
/// comment.
///
/// # Errors
///
/// `noise-unknown` (input) where N or K of a channel is not determined; with `upper_limit` its upper
/// limit is taken, and only a channel without one is refused.
pub fn kalibr(
    noise: &NoiseSection,
    calibration: Option<&CalibrationFile>,
    upper_limit: bool,
) -> Result<Export> {
    let mut notes = Vec::new();
    let mut text = "# IMU noise for Kalibr, from an Allan deviation by gravical. Each value is the largest of\n# the three axes.\n".to_owned();
    if let Some(file) = calibration {
        text += "# Kalibr reads no calibration: apply this one before, calibrated = matrix (raw - bias), m/s^2\n";
        let a = &file.accelerometer;
        for row in a.matrix {
            text += &format!("#   {:.9e}, {:.9e}, {:.9e}\n", row[0], row[1], row[2]);
        }
        let [x, y, z] = a.bias;
        text += &format!(
            "#   bias {x:.9e}, {y:.9e}, {z:.9e} {}\n",
            a.input_unit.name()
        );
        notes.push(
            "Kalibr reads no calibration: apply it before; the matrix is a comment".to_owned(),
        );
    }
    text += "rostopic: /imu0\n";
    text += &format!("update_rate: {:.4}  # Hz\n", noise.rate_hz);
    let of = |name: &str, sensor: char, term: usize, unit: &str| -> Result<(String, bool)> {
        let (value, limit) = largest(noise, sensor, term, upper_limit)?;
        let what = if limit { ", upper limit (95 %)" } else { "" };
        Ok((format!("{name}: {value:.4e}  # {unit}{what}\n"), limit))
    };
    for (name, sensor, term, unit) in [
        ("accelerometer_noise_density", 'a', 0, "m/s^2/sqrt(Hz)"),
        ("accelerometer_random_walk", 'a', 2, "m/s^3/sqrt(Hz)"),
        ("gyroscope_noise_density", 'g', 0, "rad/s/sqrt(Hz)"),
        ("gyroscope_random_walk", 'g', 2, "rad/s^2/sqrt(Hz)"),
    ] {
        let (line, limit) = of(name, sensor, term, unit)?;
        text += &line;
        if limit {
            notes.push(format!("{name} is an upper limit"));
        }
    }
    Ok(Export { text, notes })
}

/// The largest of the axes, and whether it is an upper limit.
fn largest(
    noise: &NoiseSection,
    sensor: char,
    term: usize,
    upper_limit: bool,
) -> Result<(f64, bool)> {
    let symbol = ["N", "B", "K"][term];
    let name = match sensor {
        'a' => "accelerometer",
        _ => "gyroscope",
    };
    let own: Vec<&NoiseParameters> = noise
        .channels
        .iter()
        .filter(|c| c.channel.starts_with(sensor))
        .collect();
    let mut most = (0.0, false);
    for channel in &own {
        let known = [channel.n, channel.b, channel.k][term];
        let limit =
            [channel.n_at_most, channel.b_at_most, channel.k_at_most][term].filter(|_| upper_limit);
        let value = match (known, limit) {
            (Some(value), _) => (value, false),
            (None, Some(limit)) => (limit, true),
            (None, None) => {
                return Err(unknown(
                    format!("{symbol} of {} is not determined", channel.channel),
                    upper_limit,
                ));
            }
        };
        if value.0 > most.0 {
            most = value;
        }
    }
    match own.len() {
        3 => Ok(most),
        _ => Err(unknown(
            format!("the noise of the {name} is not known"),
            true,
        )),
    }
}

fn unknown(what: String, limits_used: bool) -> Error {
    let hint = match limits_used {
        false => {
            "record longer (`gravical noise` says how long), or take upper limits: --upper-limit"
        }
        true => "record accelerometer and gyroscope at rest, with more decimals or for longer",
    };
    Error::input(
        "noise-unknown",
        format!("Kalibr wants numbers above zero, but {what}"),
    )
    .with_hint(hint)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn section(k: Option<f64>) -> NoiseSection {
        let channels = ["ax", "ay", "az", "gx", "gy", "gz"];
        let parameters = |(i, channel): (usize, &&str)| NoiseParameters {
            channel: (*channel).to_owned(),
            n: Some(1e-3 * (i + 1) as f64),
            b: None,
            k,
            n_at_most: None,
            b_at_most: None,
            k_at_most: Some(2e-4),
        };
        NoiseSection {
            rate_hz: 100.0,
            used_s: 7200.0,
            channels: channels.iter().enumerate().map(parameters).collect(),
        }
    }

    #[test]
    fn keys_and_values_that_kalibr_reads() {
        let text = kalibr(&section(Some(1e-5)), None, false).unwrap().text;
        let lines: Vec<&str> = text.lines().filter(|l| !l.starts_with('#')).collect();
        let values = lines.iter().map(|l| l.split_once(": ").unwrap());
        let value = |key: &str| -> f64 {
            let (_, text) = values.clone().find(|(k, _)| *k == key).unwrap();
            text.split_once("  #").unwrap().0.parse().unwrap()
        };
        assert_eq!(lines[0], "rostopic: /imu0");
        assert_eq!(value("update_rate"), 100.0);
        assert_eq!(value("accelerometer_noise_density"), 3e-3);
        assert_eq!(value("gyroscope_noise_density"), 6e-3);
        assert_eq!(value("accelerometer_random_walk"), 1e-5);
        assert_eq!(value("gyroscope_random_walk"), 1e-5);
    }

    #[test]
    fn what_is_unknown_is_refused_or_a_limit() {
        let error = kalibr(&section(None), None, false).unwrap_err();
        assert_eq!(error.code(), "noise-unknown");
        assert!(error.hint().unwrap().contains("--upper-limit"));
        let export = kalibr(&section(None), None, true).unwrap();
        assert!(
            export
                .text
                .contains("accelerometer_random_walk: 2.0000e-4  # m/s^3/sqrt(Hz), upper limit")
        );
        assert_eq!(export.notes.len(), 2);
        let mut without_gyro = section(Some(1e-5));
        without_gyro.channels.truncate(3);
        assert!(kalibr(&without_gyro, None, true).is_err());
    }
}
