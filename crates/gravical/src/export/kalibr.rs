//! Kalibr: the noise of the IMU.

use super::Export;
use super::template::{Values, fill_template, nine_digits};
use crate::calibration_file::NoiseSection;
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
        for (quantity, symbol) in [("noise_density", 'N'), ("random_walk", 'K')] {
            let key = format!("{sensor}_{quantity}");
            let (value, is_limit) = find_largest(noise, sensor, symbol, upper_limit)?;
            values.text(&key, format!("{value:.4e}"));
            if is_limit {
                values.text(&format!("{key}_limit"), ", upper limit (95 %)");
                notes.push(format!("{key} is an upper limit"));
            }
        }
    }
    let text = fill_template(include_str!("templates/kalibr.yaml.in"), &values);
    Ok(Export { text, notes })
}

/// The largest of the axes, and whether it is an upper limit.
fn find_largest(
    noise: &NoiseSection,
    sensor: &str,
    symbol: char,
    upper_limit: bool,
) -> Result<(f64, bool)> {
    let letter = &sensor[..1];
    let channels = noise.channels.iter();
    let channels = channels.filter(|c| c.channel.starts_with(letter));
    let (mut largest, mut count) = ((0.0, false), 0);
    for channel in channels {
        count += 1;
        let (known, limit) = match symbol {
            'N' => (channel.n, channel.n_at_most),
            _ => (channel.k, channel.k_at_most),
        };
        let value = match (known, limit.filter(|_| upper_limit)) {
            (Some(value), _) => (value, false),
            (None, Some(limit)) => (limit, true),
            (None, None) => {
                let what = format!("{symbol} of {} is not determined", channel.channel);
                return Err(unknown(&what, upper_limit));
            }
        };
        if value.0 > largest.0 {
            largest = value;
        }
    }
    if count != 3 {
        let what = format!("the noise of the {sensor} is not known");
        return Err(unknown(&what, true));
    }
    Ok(largest)
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
