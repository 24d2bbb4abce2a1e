//! Convolution of samples with a window of weights, in place.

/// Number of samples processed at once, so that they stay in the first-level cache.
const BLOCK: usize = 1024;

/// y_i = Σ_k w_k x_(i−left+k) for every i whose window is inside; the others are unchanged.
/// `weights` must not be longer than `x`.
pub(super) fn convolve(x: &mut [f64], weights: &[f64], left: usize) {
    let window = weights.len();
    let right = window.saturating_sub(left + 1);
    if window == 0 || x.len() < window {
        return;
    }
    // The original samples of a block, with neighbours on both sides.
    let mut before = Vec::with_capacity(BLOCK + window);
    before.extend_from_slice(&x[..left]);
    let (mut at, end) = (left, x.len() - right);
    while at < end {
        let stop = (at + BLOCK).min(end);
        before.extend_from_slice(&x[at..stop + right]);
        weighted_sums(&before, weights, &mut x[at..stop]);
        before.drain(..stop - at);
        before.truncate(left);
        at = stop;
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
            for left in [0, window / 2, window - 1] {
                for n in [window, window + 1, BLOCK - 1, BLOCK + window, 3 * BLOCK + 7] {
                    if n < window {
                        continue;
                    }
                    let weights: Vec<f64> = (0..window).map(|k| 1.0 + (k * k % 7) as f64).collect();
                    let x: Vec<f64> = (0..n).map(|i| (i * 31 % 17) as f64).collect();
                    let mut y = x.clone();
                    convolve(&mut y, &weights, left);
                    for i in 0..n {
                        let inside = i >= left && i + window - left <= n;
                        let want = if inside {
                            (0..window).map(|k| weights[k] * x[i - left + k]).sum()
                        } else {
                            x[i]
                        };
                        // Whole numbers: the sum does not depend on the order.
                        assert_eq!(y[i], want, "{window} {left} {n} {i}");
                    }
                }
            }
        }
    }
}
