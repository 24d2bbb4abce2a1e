//! Convolution of samples with a window of weights.

/// Number of samples processed at once, so that they stay in the first-level cache.
const BLOCK: usize = 1024;

/// Appends Σ_k w_k x_(i+k) for every i whose window is inside `x`. A value does not depend on where
/// `x` begins and ends.
pub(super) fn convolve(x: &[f64], weights: &[f64], out: &mut Vec<f64>) {
    if weights.is_empty() || x.len() < weights.len() {
        return;
    }
    let from = out.len();
    out.resize(from + x.len() + 1 - weights.len(), 0.0);
    for (at, out) in out[from..].chunks_mut(BLOCK).enumerate() {
        weighted_sums(&x[at * BLOCK..], weights, out);
    }
}

/// out_i = Σ_k w_k x_(i+k).
fn weighted_sums(x: &[f64], weights: &[f64], out: &mut [f64]) {
    let (mut first, mut at) = (true, 0);
    for part in weights.chunks(8) {
        let x = &x[at..];
        // A constant number of weights stays in registers.
        match part.len() {
            1 => taps::<1>(x, part, out, first),
            2 => taps::<2>(x, part, out, first),
            3 => taps::<3>(x, part, out, first),
            4 => taps::<4>(x, part, out, first),
            5 => taps::<5>(x, part, out, first),
            6 => taps::<6>(x, part, out, first),
            7 => taps::<7>(x, part, out, first),
            _ => taps::<8>(x, part, out, first),
        }
        first = false;
        at += part.len();
    }
}

#[inline(always)]
fn taps<const K: usize>(x: &[f64], weights: &[f64], out: &mut [f64], first: bool) {
    let Ok(weights) = <&[f64; K]>::try_from(weights) else {
        return;
    };
    let sum = |x: &[f64]| {
        let mut sum = weights[0] * x[0];
        for k in 1..K {
            sum += weights[k] * x[k];
        }
        sum
    };
    if first {
        for (out, x) in out.iter_mut().zip(x.windows(K)) {
            *out = sum(x);
        }
    } else {
        for (out, x) in out.iter_mut().zip(x.windows(K)) {
            *out += sum(x);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn convolution_is_right_for_all_lengths() {
        for window in (1..30).chain([101]) {
            for n in [
                window - 1,
                window,
                window + 1,
                BLOCK - 1,
                BLOCK + window,
                3 * BLOCK + 7,
            ] {
                let weights: Vec<f64> = (0..window).map(|k| 1.0 + (k * k % 7) as f64).collect();
                let x: Vec<f64> = (0..n).map(|i| (i * 31 % 17) as f64).collect();
                let mut y = vec![0.5];
                convolve(&x, &weights, &mut y);
                // Whole numbers: the sum does not depend on the order.
                let sum = |x: &[f64]| x.iter().zip(&weights).map(|(x, w)| x * w).sum();
                let want = x.windows(window).map(sum);
                let want: Vec<f64> = std::iter::once(0.5).chain(want).collect();
                assert_eq!(y, want, "{window} {n}");
            }
        }
    }
}
