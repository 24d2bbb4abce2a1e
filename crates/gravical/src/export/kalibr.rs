//! Kalibr: the noise of the IMU.

use super::Export;
use super::template::{Values, fill_template, nine_digits};
use crate::calibration_file::{NoiseParameters, NoiseSection};
use crate::{Error, Result};

/// The `imu.yaml` of Kalibr: noise density N and random walk K of accelerometer and gyroscope, each
/// the largest of the three axes.
///
/// # Errors
///
/// `noise-unknown` (input) where N or K of a channel is not determined; with `upper_limit` its upper
/// limit is taken, and only a channel without one is refused.
pub fn kalibr(noise: &NoiseSection, upper_limit: bool) -> Result<Export> {
    let mut notes = Vec::new();
    let mut values = Values::new(nine_digits);
    values.text("rate_hz", format!("{:.4}", noise.rate_hz));
    for sensor in ["accelerometer", "gyroscope"] {
        let axes = noise.channels.iter();
        let axes = axes.filter(|c| c.channel.starts_with(&sensor[..1]));
        let axes: Vec<&NoiseParameters> = axes.collect();
        if axes.len() != 3 {
            let what = format!("the noise of the {sensor} is not known");
            return Err(unknown(&what, true));
        }
        for (quantity, symbol) in [("noise_density", 'N'), ("random_walk", 'K')] {
            let (mut largest, mut is_limit) = (0.0, false);
            for axis in &axes {
                let (known, limit) = match symbol {
                    'N' => (axis.n, axis.n_at_most),
                    _ => (axis.k, axis.k_at_most),
                };
                let what = || format!("{symbol} of {} is not determined", axis.channel);
                let value = known.or(limit.filter(|_| upper_limit));
                let value = value.ok_or_else(|| unknown(&what(), upper_limit))?;
                if value > largest {
                    (largest, is_limit) = (value, known.is_none());
                }
            }
            let key = format!("{sensor}_{quantity}");
            values.text(&key, format!("{largest:.4e}"));
            if is_limit {
                values.text(&format!("{key}_limit"), ", upper limit (95 %)");
                notes.push(format!("{key} is an upper limit"));
            }
        }
    }
    let text = fill_template(include_str!("templates/kalibr.yaml.in"), &values);
    Ok(Export { text, notes })
}

fn unknown(what: &str, limits_used: bool) -> Error {
    let message = format!("Kalibr wants numbers above zero, but {what}");
    let error = Error::input("noise-unknown", message);
    if limits_used {
        error.with_hint(
            "record accelerometer and gyroscope at rest, with more decimals or for longer",
        )
    } else {
        error
            .with_hint("record longer (`gravical noise` says how long), or take upper limits")
            .advise("upper_limit", "true")
    }
}
