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

/// Ticks between two decimal logarithms: powers of ten, with 2 and 5 between them where these are
/// few.
pub(in crate::figure) fn log_ticks(from: f64, to: f64, most: usize) -> Vec<(f64, String)> {
    if !(from.is_finite() && to.is_finite() && to > from && to - from < 600.0) {
        return Vec::new();
    }
    let decades = to - from;
    let step = (decades / most.max(1) as f64).ceil().max(1.0);
    let mantissas: &[f64] = match decades < 2.5 {
        true => &[1.0, 2.0, 5.0],
        false => &[1.0],
    };
    let first = (from / step).floor() as i32;
    let powers = (first..).map(|k| (f64::from(k) * step).round() as i32);
    let powers = powers.take_while(|power| f64::from(*power) <= to + 1e-9);
    powers
        .flat_map(|power| mantissas.iter().map(move |m| (*m, power)))
        .map(|(m, power)| (f64::from(power) + m.log10(), log_label(m, power)))
        .filter(|(v, _)| (from - 1e-9..=to + 1e-9).contains(v))
        .collect()
}

/// A number of one digit times a power of ten.
fn log_label(mantissa: f64, power: i32) -> String {
    if (-2..=4).contains(&power) {
        let decimals = usize::try_from(-power).unwrap_or(0);
        return format!("{:.decimals$}", mantissa * 10_f64.powi(power));
    }
    let digits = power.to_string();
    let raised = digits.chars().map(|c| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        c => char::from_u32(0x2070 + c.to_digit(10).unwrap_or(0)).unwrap_or(c),
    });
    let raised: String = raised.collect();
    match mantissa == 1.0 {
        true => format!("10{raised}"),
        false => format!("{mantissa:.0}·10{raised}"),
    }
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
    fn powers_of_ten() {
        let labels = |from, to, most| -> Vec<String> {
            log_ticks(from, to, most)
                .into_iter()
                .map(|(_, l)| l)
                .collect()
        };
        assert_eq!(
            labels(-2.3, 4.2, 8),
            ["0.01", "0.1", "1", "10", "100", "1000", "10000"]
        );
        assert_eq!(labels(-6.0, 1.0, 4), ["10⁻⁶", "10⁻⁴", "0.01", "1"]);
        assert_eq!(labels(-3.1, -2.2, 5), ["10⁻³", "2·10⁻³", "5·10⁻³"]);
        assert!(labels(f64::NAN, 1.0, 4).is_empty() && labels(1.0, 1.0, 4).is_empty());
    }

    #[test]
    fn labels_are_short() {
        assert_eq!(label(-0.5, 1), "−0.5");
        assert_eq!(label(2.5e9, 0), "2.5e9");
        assert_eq!(label(3e-8, 9), "3e−8");
        assert_eq!(label(0.0, 2), "0.00");
    }
}
