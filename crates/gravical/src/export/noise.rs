//! What other programs take of the noise of an IMU.

use super::template::{Values, fill_template, nine_digits};
use super::{Export, ExportOptions, Form, Target};
use crate::Result;
use crate::noise::{ChannelNoise, NoiseResult, Term};
use crate::problem::Problem;

/// Writes the noise for a target that holds noise: density N and random walk K of accelerometer and
/// gyroscope, each the largest of the three axes; or the variances of white noise, N² times the rate, of each axis.
///
/// # Errors
///
/// `export-option` (usage) as [`Target::check`]; `noise-unknown` (input) where N or K of a channel is not determined;
/// with `upper_limit` its upper limit is taken, and only a channel without one is refused.
pub fn export_noise(
    noise: &NoiseResult,
    target: &Target,
    options: &ExportOptions,
) -> Result<Export> {
    target.check(options)?;
    let Form::Noise(template) = target.form else {
        return Err(Problem::CalibrationOfNoise {
            target: target.name,
        }
        .error());
    };
    let mut notes = Vec::new();
    let mut values = Values::new(nine_digits);
    values.text("rate_hz", format!("{:.4}", noise.rate_hz));
    for sensor in ["accelerometer", "gyroscope"] {
        for (quantity, term) in [("noise_density", Term::N), ("random_walk", Term::K)] {
            if term == Term::K && !template.contains(quantity) {
                continue;
            }
            let key = format!("{sensor}_{quantity}");
            let axes = find_axes(noise, sensor, term, options.upper_limit)?;
            if term == Term::N {
                let variances = axes.map(|(density, _)| density * density * noise.rate_hz);
                values.vector(&format!("{sensor}_variance"), &variances);
                let is_limit = axes.iter().any(|(_, is_limit)| *is_limit);
                let kind = if is_limit {
                    "upper limits (95 %)"
                } else {
                    "estimates"
                };
                values.text(&format!("{sensor}_kind"), kind);
            }
            let largest =
                axes.into_iter().fold(
                    (0.0, false),
                    |most, axis| {
                        if axis.0 > most.0 { axis } else { most }
                    },
                );
            values.text(&key, format!("{:.4e}", largest.0));
            if axes.iter().any(|(_, is_limit)| *is_limit) {
                notes.push(format!("{key} is an upper limit"));
            }
            if largest.1 {
                values.text(&format!("{key}_limit"), ", upper limit (95 %)");
            }
        }
    }
    let text = fill_template(template, &values);
    Ok(Export { text, notes })
}

/// The term of each axis, and whether it is an upper limit.
fn find_axes(
    noise: &NoiseResult,
    sensor: &'static str,
    term: Term,
    upper_limit: bool,
) -> Result<[(f64, bool); 3]> {
    let channels = noise.channels.iter();
    let channels = channels.filter(|c| c.channel.starts_with(&sensor[..1]));
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
    let values = channels.map(value).collect::<Result<Vec<(f64, bool)>>>()?;
    let axes = <[(f64, bool); 3]>::try_from(values);
    axes.map_err(|_| Problem::NoiseUnknown { sensor }.error())
}
