//! The unit of time stamps, guessed from their steps.

use gravical_recording::TimeUnit;

use super::Claims;
use crate::finding::{Finding, FindingKind};

const GUESSED: [TimeUnit; 4] = [
    TimeUnit::Second,
    TimeUnit::Millisecond,
    TimeUnit::Microsecond,
    TimeUnit::Nanosecond,
];

/// Plausible sampling rates, Hz.
const PLAUSIBLE_HZ: std::ops::RangeInclusive<f64> = 0.9..=20_000.0;

/// Seconds since 1970 from 2000 to 2100.
const DATES_S: std::ops::Range<f64> = 946_684_800.0..4_102_444_800.0;

/// The unit for which the median step gives a plausible rate; of several, the one nearest to 100
/// Hz. `first` is the first stamp, `steps` the number of steps.
pub(super) fn guess_unit(
    first: f64,
    steps: usize,
    median: f64,
    claims: &Claims,
    findings: &mut Vec<Finding>,
) -> Option<TimeUnit> {
    let mut fitting: Vec<(TimeUnit, f64)> = GUESSED
        .into_iter()
        .map(|u| (u, 1.0 / (median * u.seconds())))
        .filter(|(_, rate)| PLAUSIBLE_HZ.contains(rate))
        .collect();
    if let Some(nominal) = claims.nominal_rate_hz
        && let Some(at) = fitting
            .iter()
            .position(|(_, rate)| (rate / nominal - 1.0).abs() < 0.5)
    {
        return Some(fitting[at].0);
    }
    // A stamp counted from 1970 is a plausible date in one unit only.
    let date = |u: TimeUnit| first.is_finite() && DATES_S.contains(&(first * u.seconds()));
    if let Some((unit, _)) = fitting.iter().find(|(u, _)| date(*u)) {
        return Some(*unit);
    }
    // The temperature of a sensor changes by at most 2 °C per second.
    let slowest_s = claims.temperature_span_c / 2.0;
    let calm: Vec<_> = fitting
        .iter()
        .copied()
        .filter(|(_, rate)| steps as f64 / rate >= slowest_s)
        .collect();
    let by_temperature = calm.len() < fitting.len() && !calm.is_empty();
    if !calm.is_empty() {
        fitting = calm;
    }
    fitting.sort_by(|a, b| {
        let far = |rate: f64| (rate / 100.0).ln().abs();
        far(a.1).total_cmp(&far(b.1))
    });
    let &(unit, rate) = fitting.first()?;
    if by_temperature || fitting.len() > 1 {
        findings.push(Finding::new(
            FindingKind::TimeUnitAssumed,
            format!(
                "the time stamps are assumed to be in {} ({rate:.2} Hz){}; --time-unit overrides it",
                unit.name(),
                if by_temperature {
                    ", since in a finer unit the temperature would change impossibly fast"
                } else {
                    ""
                }
            ),
        ));
    }
    Some(unit)
}
