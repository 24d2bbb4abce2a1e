//! Kalibr: the noise of the IMU.

use super::Export;
use super::template::{Values, fill_template, nine_digits};
use crate::Result;
use crate::noise::{ChannelNoise, NoiseResult, Term};
use crate::problem::Problem;

/// The `imu.yaml` of Kalibr: noise density N and random walk K of accelerometer and gyroscope, each
/// the largest of the three axes.
///
/// # Errors
///
/// `noise-unknown` (input) where N or K of a channel is not determined; with `upper_limit` its upper
/// limit is taken, and only a channel without one is refused.
pub fn kalibr(noise: &NoiseResult, upper_limit: bool) -> Result<Export> {
    let mut notes = Vec::new();
    let mut values = Values::new(nine_digits);
    values.text("rate_hz", format!("{:.4}", noise.rate_hz));
    for sensor in ["accelerometer", "gyroscope"] {
        for (quantity, term) in [("noise_density", Term::N), ("random_walk", Term::K)] {
            let key = format!("{sensor}_{quantity}");
            let (value, is_limit) = find_largest(noise, sensor, term, upper_limit)?;
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
    noise: &NoiseResult,
    sensor: &'static str,
    term: Term,
    upper_limit: bool,
) -> Result<(f64, bool)> {
    let own = noise.channels.iter();
    let own = own.filter(|c| c.channel.starts_with(&sensor[..1]));
    let value = |channel: &ChannelNoise| {
        let known = channel.estimate(term).map(|e| (e.value, false));
        let limit = || Some((channel.missing(term)?.limit.at_most?, true));
        let value = known.or_else(|| limit().filter(|_| upper_limit));
        value.ok_or_else(|| {
            let unknown = Problem::TermUnknown {
                term,
                channel: channel.channel.clone(),
                upper_limit,
            };
            match unknown.error() {
                unknown if upper_limit => unknown,
                unknown => unknown.advise("upper_limit", "true"),
            }
        })
    };
    let values = own.map(value).collect::<Result<Vec<(f64, bool)>>>()?;
    let largest = values.iter().copied().max_by(|a, b| a.0.total_cmp(&b.0));
    let largest = largest.filter(|_| values.len() == 3);
    largest.ok_or_else(|| Problem::NoiseUnknown { sensor }.error())
}
