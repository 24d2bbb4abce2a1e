//! Ticks of an axis.

/// Round values between `from` and `to`, about `most` of them, and the
/// decimals that distinguish them.
pub(in crate::figure) fn ticks(from: f64, to: f64, most: usize) -> (Vec<f64>, usize) {
    let span = to - from;
    if !(span.is_finite() && span > 0.0) {
        return (Vec::new(), 0);
    }
    let raw = span / most.max(1) as f64;
    let power = 10f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .map(|m| m * power)
        .into_iter()
        .find(|s| *s >= 0.8 * raw)
        .unwrap_or(10.0 * power);
    if !(step > 0.0 && step.is_finite()) {
        return (Vec::new(), 0);
    }
    let first = (from / step - 1e-6).ceil();
    let values = (0..=most + most / 2 + 1)
        .map(|k| (first + k as f64) * step)
        .take_while(|v| *v <= to + 1e-6 * step)
        .map(|v| if v == 0.0 { 0.0 } else { v })
        .collect();
    (
        values,
        (-step.log10() - 1e-9).ceil().clamp(0.0, 12.0) as usize,
    )
}

/// A tick's label: plain up to six digits, else a power of ten.
pub(in crate::figure) fn label(value: f64, decimals: usize) -> String {
    let size = value.abs();
    let text = if size >= 1e7 || (size > 0.0 && size < 1e-6) {
        // The step decides how many digits of the mantissa matter: at most six.
        let short = format!("{value:.5e}");
        let (mantissa, power) = short.split_once('e').unwrap_or((&short, "0"));
        let mantissa = mantissa.trim_end_matches('0').trim_end_matches('.');
        format!("{mantissa}e{power}")
    } else {
        format!("{value:.decimals$}")
    };
    // A minus sign is as wide as a digit; a hyphen is not.
    text.replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn round_steps() {
        assert_eq!(
            ticks(0.0, 1.0, 5),
            (vec![0.0, 0.2, 0.4, 0.6000000000000001, 0.8, 1.0], 1)
        );
        assert_eq!(ticks(-9.9, 10.2, 4).0, vec![-5.0, 0.0, 5.0, 10.0]);
        let (v, d) = ticks(9.803, 9.809, 4);
        assert_eq!(
            v.iter().map(|v| label(*v, d)).collect::<Vec<_>>(),
            ["9.804", "9.806", "9.808"]
        );
    }

    #[test]
    fn nothing_to_divide() {
        for (a, b) in [
            (1.0, 1.0),
            (2.0, 1.0),
            (f64::NAN, 1.0),
            (f64::NEG_INFINITY, f64::INFINITY),
        ] {
            assert!(ticks(a, b, 5).0.is_empty());
        }
        assert!(ticks(0.0, 5e-324, 5).0.len() < 8);
        assert!(ticks(-1e308, 0.7e308, 5).0.len() < 8);
        assert!(ticks(1e15, 1e15 + 1.0, 5).0.len() < 8);
    }

    #[test]
    fn labels_are_short() {
        assert_eq!(label(-0.5, 1), "−0.5");
        assert_eq!(label(2.5e9, 0), "2.5e9");
        assert_eq!(label(3e-8, 9), "3e−8");
        assert_eq!(label(0.0, 2), "0.00");
    }
}
