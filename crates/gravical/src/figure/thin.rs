//! Thinning by smallest and largest: of each stretch of time the extremes stay.

use super::{Mark, Role, Series};

/// Samples above which a series is thinned.
pub const LIMIT: usize = 8000;

/// Stretches of equal time that a thinned series consists of: two to three for
/// each dot of a plot that fills a page, so that zooming in shows more.
pub const BUCKETS: usize = 2000;

/// A line through the samples at times `t` (which must not run backwards);
/// `point` gives the coordinates of a sample.
///
/// Time need not be a coordinate: a trajectory is thinned by time as well. What
/// is not finite breaks the line, once for each stretch.
#[must_use]
pub fn line(name: &str, role: Role, t: &[f64], point: impl Fn(usize) -> (f64, f64)) -> Series {
    Samples::of(t).line(name, role, point)
}

/// A band through the samples at times `t`; `ends` gives lower and upper end.
#[must_use]
pub fn band(name: &str, role: Role, t: &[f64], ends: impl Fn(usize) -> (f64, f64)) -> Series {
    let samples = Samples::of(t);
    let (mut x, mut low, mut high) = (Vec::new(), Vec::new(), Vec::new());
    samples.keep(
        |i| {
            let (l, h) = ends(i);
            [l, h]
        },
        |i| {
            let (l, h) = i.map_or((f64::NAN, f64::NAN), &ends);
            x.push(i.map_or(f64::NAN, |i| t.get(i).copied().unwrap_or(f64::NAN)));
            low.push(l);
            high.push(h);
        },
    );
    Series {
        mark: Mark::Band,
        samples: t.len(),
        ..Series::band(name, role, x, low, high)
    }
}

/// Samples whose times stand in no column.
pub(super) struct Samples<T> {
    /// How many.
    pub count: usize,
    /// Time of each; must not run backwards.
    pub time: T,
    /// See [`LIMIT`].
    pub limit: usize,
    /// See [`BUCKETS`].
    pub buckets: usize,
}

impl<'a> Samples<Box<dyn Fn(usize) -> f64 + 'a>> {
    fn of(t: &'a [f64]) -> Self {
        Samples {
            count: t.len(),
            time: Box::new(|i| t.get(i).copied().unwrap_or(f64::NAN)),
            limit: LIMIT,
            buckets: BUCKETS,
        }
    }
}

impl<T: Fn(usize) -> f64> Samples<T> {
    /// As [`line`].
    pub fn line(&self, name: &str, role: Role, point: impl Fn(usize) -> (f64, f64)) -> Series {
        let mut x = Vec::new();
        let mut y = Vec::new();
        self.keep(
            |i| {
                let (x, y) = point(i);
                [x, y]
            },
            |i| {
                let p = i.map_or((f64::NAN, f64::NAN), &point);
                x.push(p.0);
                y.push(p.1);
            },
        );
        Series {
            samples: self.count,
            ..Series::line(name, role, x, y)
        }
    }

    /// Calls `take` with the samples to keep, in order of time; none where the
    /// line breaks.
    fn keep(&self, value: impl Fn(usize) -> [f64; 2], mut take: impl FnMut(Option<usize>)) {
        let mut broken = true;
        let mut all = |indices: &[usize], gap: bool| {
            for &i in indices {
                take(Some(i));
                broken = false;
            }
            if gap && !broken {
                take(None);
                broken = true;
            }
        };
        let (count, t) = (self.count, &self.time);
        if count <= self.limit {
            for i in 0..count {
                let known = value(i).iter().all(|v| v.is_finite());
                all(if known { std::slice::from_ref(&i) } else { &[] }, !known);
            }
            return;
        }
        let first = (0..count).map(t).find(|v| v.is_finite());
        let last = (0..count).rev().map(t).find(|v| v.is_finite());
        let Some((start, end)) = first.zip(last) else {
            return;
        };
        let width = (end - start) / self.buckets as f64;
        let bucket_of = |i: usize| {
            let place = (t(i) - start) / width;
            // A time that is not known stays where it was counted.
            if place.is_finite() {
                place as usize
            } else {
                i * self.buckets / count
            }
        };
        let mut i = 0;
        while i < count {
            let bucket = bucket_of(i);
            let mut gap = false;
            // First, last, and the smallest and largest of either coordinate.
            let mut kept: Option<([usize; 6], [[f64; 2]; 2])> = None;
            while i < count && bucket_of(i) == bucket {
                let v = value(i);
                if v.iter().all(|v| v.is_finite()) {
                    let (k, [low, high]) = kept.get_or_insert(([i; 6], [v, v]));
                    k[1] = i;
                    for c in 0..2 {
                        if v[c] < low[c] {
                            (k[2 + c], low[c]) = (i, v[c]);
                        }
                        if v[c] > high[c] {
                            (k[4 + c], high[c]) = (i, v[c]);
                        }
                    }
                } else {
                    gap = true;
                }
                i += 1;
            }
            if let Some((mut k, _)) = kept {
                k.sort_unstable();
                let mut distinct = k.to_vec();
                distinct.dedup();
                all(&distinct, gap);
            } else {
                all(&[], gap);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_series_stay_as_they_are() {
        let t = [0.0, 1.0, 2.0, 3.0];
        let s = line("a", Role::Raw, &t, |i| {
            (t[i], [5.0, f64::NAN, f64::NAN, 7.0][i])
        });
        assert_eq!(s.samples, 4);
        assert_eq!(s.x.len(), 3, "one break for two missing values");
        assert_eq!((s.y[0], s.y[2]), (5.0, 7.0));
        assert!(s.y[1].is_nan());
    }

    #[test]
    fn one_spike_among_a_million_stays() {
        let t: Vec<f64> = (0..1_000_000).map(|i| i as f64 * 0.01).collect();
        let s = line("a", Role::Raw, &t, |i| {
            let spike = match i {
                123_457 => 50.0,
                765_431 => -60.0,
                _ => 0.0,
            };
            (t[i], spike + (i as f64).sin())
        });
        assert!(s.x.len() <= 6 * BUCKETS, "{}", s.x.len());
        assert_eq!(s.samples, 1_000_000);
        let largest = s.y.iter().copied().fold(f64::MIN, f64::max);
        let smallest = s.y.iter().copied().fold(f64::MAX, f64::min);
        assert!(largest > 48.9 && smallest < -58.9);
        assert!(s.x.is_sorted(), "in order of time");
        assert_eq!((s.x[0], *s.x.last().unwrap()), (0.0, t[999_999]));
    }

    #[test]
    fn a_pause_takes_no_points_and_time_may_stand_still() {
        let mut t: Vec<f64> = (0..20_000).map(f64::from).collect();
        for v in &mut t[10_000..] {
            *v += 1e9;
        }
        let s = line("a", Role::Raw, &t, |i| (t[i], 1.0));
        assert!(s.x.len() >= 2 && s.x.len() < 6 * BUCKETS);
        let same = vec![3.0; 20_000];
        let s = line("a", Role::Raw, &same, |i| (same[i], i as f64));
        assert!(!s.y.is_empty() && s.y.len() < LIMIT);
        let none = vec![f64::NAN; 20_000];
        assert!(line("a", Role::Raw, &none, |i| (none[i], 1.0)).x.is_empty());
    }

    #[test]
    fn bands_keep_their_widest() {
        let t: Vec<f64> = (0..100_000).map(f64::from).collect();
        let s = band("b", Role::Calibrated, &t, |i| {
            if i == 777 { (-9.0, 9.0) } else { (-1.0, 1.0) }
        });
        assert!(s.low.contains(&-9.0) && s.high.contains(&9.0));
        assert_eq!(s.x.len(), s.low.len());
    }
}
