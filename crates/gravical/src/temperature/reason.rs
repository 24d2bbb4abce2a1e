//! Texts of the reasons for accepting or refusing a drift.

use crate::calibration_file::SweepDirection;

use super::tested::{LEAST_R2, Tested};

/// A value with three significant digits.
pub fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let magnitude = value.abs().log10().floor();
    if (-4.0..6.0).contains(&magnitude) {
        let decimals = (2.0 - magnitude).clamp(0.0, 6.0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.2e}")
    }
}

/// A value with its unit, if known.
pub(crate) fn in_unit(value: f64, unit: &str) -> String {
    match unit {
        "unknown" => format!("{} of an unknown unit", short(value)),
        known => format!("{} {known}", short(value)),
    }
}

/// R² with two decimals, never rounded up to the limit.
pub fn r2_text(r2: f64) -> String {
    let rounded = if r2 < LEAST_R2 && r2 > LEAST_R2 - 0.01 {
        LEAST_R2 - 0.01
    } else {
        r2
    };
    if rounded < -99.0 {
        return "< -99".to_owned();
    }
    format!("{rounded:.2}")
}

pub(super) fn one_direction(direction: SweepDirection) -> String {
    let verb = match direction {
        SweepDirection::Cooling => "fell",
        SweepDirection::Warming => "rose",
    };
    format!(
        "the temperature only {verb}: with one sweep the drift cannot be tested; also record the opposite direction"
    )
}

pub(super) fn little_shared(shared_c: f64, needed_c: f64) -> String {
    format!(
        "cooling and warming share only {shared_c:.1} °C; more than {needed_c:.0} °C are needed to test one with the other"
    )
}

pub(super) fn no_fit() -> String {
    "its means do not determine a polynomial, or do not vary".to_owned()
}

pub(super) fn accepted(tested: &Tested, scale_unknown: bool) -> String {
    let mut text = format!(
        "fitted to cooling it predicts warming with R² {}, fitted to warming it predicts cooling with {}",
        r2_text(tested.to_warming),
        r2_text(tested.to_cooling)
    );
    if tested.shape.with_scale {
        text.push_str("; bias and scale distinguished by the poses");
    }
    if scale_unknown {
        text.push_str(
            "; gravity on the axis has one direction only, so drifts of bias and scale cannot be distinguished: all drift is assigned to the bias, which is right near this pose",
        );
    }
    text
}

pub(super) fn no_drift(rms: f64, noise: f64, unit: &str) -> String {
    format!(
        "no drift beyond the noise: the readings vary by {} rms, and the standard error of their means is {}",
        in_unit(rms, unit),
        short(noise)
    )
}

pub(super) fn unpredictable(tested: &Tested, hysteresis: Option<f64>, unit: &str) -> String {
    let warming = r2_text(tested.to_warming);
    let cooling = r2_text(tested.to_cooling);
    let apart = hysteresis.map_or_else(String::new, |h| {
        format!(
            " (a difference of up to {} at the same temperature)",
            in_unit(h, unit)
        )
    });
    let cause = format!("hysteresis or drift with time{apart}");
    match (tested.to_warming >= LEAST_R2, tested.to_cooling >= LEAST_R2) {
        (true, false) => format!(
            "it predicts in one direction only: fitted to cooling it predicts warming with R² {warming}, but fitted to warming it predicts cooling with {cooling}: {cause}"
        ),
        (false, true) => format!(
            "it predicts in one direction only: fitted to warming it predicts cooling with R² {cooling}, but fitted to cooling it predicts warming with {warming}: {cause}"
        ),
        _ => format!(
            "fitted to cooling it predicts warming with R² {warming}, fitted to warming it predicts cooling with {cooling}; {LEAST_R2} is needed: {cause}"
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_short_and_not_rounded_up_to_the_limit() {
        assert_eq!(short(0.012345), "0.0123");
        assert_eq!(short(123.45), "123");
        assert_eq!(short(1.2345e-7), "1.23e-7");
        assert_eq!(r2_text(0.697), "0.69");
        assert_eq!(r2_text(0.703), "0.70");
        assert_eq!(r2_text(-0.4), "-0.40");
    }
}
