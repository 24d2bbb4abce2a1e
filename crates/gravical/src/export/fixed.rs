//! A matrix on 16-bit counts in integer arithmetic, for processors that have no floating-point unit.
//!
//! `out · 2^-bits = constant + Σ coarse · count + 2 · Σ fine · (count >> 8)`: the coefficients are
//! rounded to whole units of the result, and seven more bits of each act on the upper byte of its
//! count. On an 8-bit processor those cost a sixth of the time; without them the rounding of the
//! coefficients alone could be an error of a count.

/// Largest magnitude of an `int16_t` and of its upper byte.
const MOST_COUNT: f64 = 32768.0;
const MOST_BYTE: f64 = 128.0;
/// More fractional bits than a value below 1 needs.
const MOST_BITS: u32 = 30;

/// Three rows of whole numbers, and how far they are off.
pub(super) struct Fixed<const N: usize> {
    /// Fractional bits of the result.
    pub bits: u32,
    /// The rows.
    pub rows: [Row<N>; 3],
    /// The largest error of the result over all counts, in its unit: exact, since the error is
    /// linear in both bytes of each count.
    pub error: f64,
}

/// A row of whole numbers.
pub(super) struct Row<const N: usize> {
    /// In units of the result.
    pub constant: f64,
    /// Units of the result per count.
    pub coarse: [f64; N],
    /// 1/128 of that, at most 64 of them.
    pub fine: [f64; N],
    /// Largest error, units of the result.
    error: f64,
}

impl<const N: usize> Fixed<N> {
    /// `rows · counts + constants` with as many fractional bits as 32-bit sums can hold at every
    /// count; none where they cannot hold its whole part.
    pub fn new(rows: &[[f64; N]; 3], constants: &[f64; 3]) -> Option<Self> {
        (0..=MOST_BITS).rev().find_map(|bits| {
            let unit = f64::from(bits).exp2();
            let rows: [Row<N>; 3] =
                std::array::from_fn(|i| Row::new(&rows[i].map(|v| v * unit), constants[i] * unit));
            let error = rows.iter().fold(0.0_f64, |most, row| most.max(row.error)) / unit;
            let fits = rows.iter().all(Row::fits);
            fits.then_some(Fixed { bits, rows, error })
        })
    }
}

impl<const N: usize> Row<N> {
    /// `row` and `constant` are in units of the result.
    fn new(row: &[f64; N], constant: f64) -> Self {
        // Without the sign of a zero, which would be written.
        let whole = |v: f64| v.round() + 0.0;
        let coarse = row.map(whole);
        let rest: [f64; N] = std::array::from_fn(|j| row[j] - coarse[j]);
        let fine = rest.map(|v| whole(MOST_BYTE * v));
        // The lower bytes, 0 to 255, have no part in the fine sum: their middle is constant.
        let exact = constant + 127.5 * rest.iter().sum::<f64>();
        let rounded = whole(exact);
        let (mut low, mut high) = (constant - rounded, constant - rounded);
        for (rest, fine) in rest.iter().zip(&fine) {
            let of_upper = 256.0 * rest - 2.0 * fine;
            let upper = [-MOST_BYTE * of_upper, (MOST_BYTE - 1.0) * of_upper];
            let lower = [0.0, 255.0 * rest];
            low += upper[0].min(upper[1]) + lower[0].min(lower[1]);
            high += upper[0].max(upper[1]) + lower[0].max(lower[1]);
        }
        Row {
            constant: rounded,
            coarse,
            fine,
            error: low.abs().max(high.abs()),
        }
    }

    /// No sum of any of its terms overflows, at any count.
    fn fits(&self) -> bool {
        let sum = |of: &[f64; N]| of.iter().map(|v| v.abs()).sum::<f64>();
        let most = self.constant.abs()
            + MOST_COUNT * sum(&self.coarse)
            + 2.0 * MOST_BYTE * sum(&self.fine);
        most <= f64::from(i32::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the written integers make of counts, in whole numbers of 64 bits that stand for no
    /// fewer: `fits` says that 32 do.
    fn result<const N: usize>(row: &Row<N>, counts: [i16; N]) -> i64 {
        let terms = (0..N).map(|j| {
            row.coarse[j] as i64 * i64::from(counts[j])
                + 2 * row.fine[j] as i64 * i64::from(counts[j] >> 8)
        });
        row.constant as i64 + terms.sum::<i64>()
    }

    #[test]
    fn the_stated_error_is_the_largest_one() {
        let rows = [
            [6.1e-4, -1.3e-5, 7.7e-6],
            [0.0, -5.9e-4, 3.3e-7],
            [-2.5e-6, 9.9e-6, 6.02e-4],
        ];
        let constants = [-0.31, 0.0, 0.55];
        let fixed = Fixed::new(&rows, &constants).unwrap();
        // 20.7 m/s² need five bits, the sign one: 2^27 would not fit beside the roundings.
        assert_eq!(fixed.bits, 26);
        let unit = f64::from(fixed.bits).exp2();
        // Both ends of both bytes.
        let ends = [-32768_i16, -32513, 32512, 32767, 0, -1, 255];
        let mut most = 0.0_f64;
        for x in ends {
            for y in ends {
                for z in ends {
                    for i in 0..3 {
                        let counts = [x, y, z];
                        let is = result(&fixed.rows[i], counts);
                        assert!(i32::try_from(is).is_ok());
                        let exact: f64 = (0..3).map(|j| rows[i][j] * f64::from(counts[j])).sum();
                        most = most.max((is as f64 / unit - exact - constants[i]).abs());
                    }
                }
            }
        }
        assert!(
            (most / fixed.error - 1.0).abs() < 1e-6,
            "{most} {}",
            fixed.error
        );
        // Three coefficients, each to half of 1/128 at 2^15 counts and half a unit at half a byte.
        assert!(fixed.error < (3.0 * (128.0 + 64.0) + 0.5) / unit);
    }

    #[test]
    fn bits_follow_the_range() {
        let of = |scale: f64| {
            let rows = [[scale, 0.0, 0.0], [0.0, scale, 0.0], [0.0, 0.0, scale]];
            Fixed::new(&rows, &[0.0; 3]).map(|f| f.bits)
        };
        // 2^31 / 2^15 = 2^16 units a count: 1 is 15 bits, and the upper end is excluded.
        assert_eq!(of(1.0), Some(15));
        assert_eq!(of(0.5), Some(16));
        assert_eq!(of(1e-9), Some(30));
        assert_eq!(of(1e5), None);
        assert_eq!(of(f64::NAN), None);
    }
}
