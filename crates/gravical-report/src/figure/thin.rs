//! Thinning by smallest and largest: of each stretch of time the extremes stay.

use super::{Mark, Role, Series};

/// Samples above which a series is thinned.
pub const LIMIT: usize = 8000;

/// Stretches of equal time that a thinned series consists of: two to three for
/// each dot of a plot that fills a page, so that zooming in shows more.
pub const BUCKETS: usize = 2000;

/// When samples were taken, and where some are missing.
#[derive(Debug, Clone, Copy)]
pub struct Times<'a> {
    /// Time of each, s; must not run backwards.
    pub t_s: &'a [f64],
    /// Samples before which others are missing, in order: no line leads to them.
    pub breaks: &'a [usize],
}

impl<'a, T: AsRef<[f64]> + ?Sized> From<&'a T> for Times<'a> {
    fn from(t_s: &'a T) -> Self {
        Times {
            t_s: t_s.as_ref(),
            breaks: &[],
        }
    }
}

/// A line through samples; `point` gives the coordinates of each.
///
/// Time need not be a coordinate: a trajectory is thinned by time as well. The line
/// breaks where samples are missing and where a value is not finite, once for each
/// stretch.
#[must_use]
pub fn line<'a>(
    name: &str,
    role: Role,
    times: impl Into<Times<'a>>,
    point: impl Fn(usize) -> (f64, f64),
) -> Series {
    Samples::of(times.into()).line(name, role, point)
}

/// A band through samples; `ends` gives lower and upper end of each.
#[must_use]
pub fn band<'a>(
    name: &str,
    role: Role,
    times: impl Into<Times<'a>>,
    ends: impl Fn(usize) -> (f64, f64),
) -> Series {
    let times = times.into();
    let (samples, t) = (Samples::of(times), times.t_s);
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
pub(super) struct Samples<'a, T> {
    /// How many.
    pub count: usize,
    /// See [`Times`].
    pub breaks: &'a [usize],
    /// Time of each; must not run backwards.
    pub time: T,
    /// See [`LIMIT`].
    pub limit: usize,
    /// See [`BUCKETS`].
    pub buckets: usize,
}

impl<'a> Samples<'a, Box<dyn Fn(usize) -> f64 + 'a>> {
    fn of(Times { t_s: t, breaks }: Times<'a>) -> Self {
        Samples {
            count: t.len(),
            breaks,
            time: Box::new(|i| t.get(i).copied().unwrap_or(f64::NAN)),
            limit: LIMIT,
            buckets: BUCKETS,
        }
    }
}

impl<T: Fn(usize) -> f64> Samples<'_, T> {
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
        let parted = |i: usize| self.breaks.binary_search(&i).is_ok();
        if count <= self.limit {
            for i in 0..count {
                all(&[], parted(i));
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
            // What is missing for longer than a stretch parts stretches; for less it
            // cannot be seen.
            all(&[], parted(i));
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
    fn no_line_leads_over_missing_samples() {
        for rows in [100_u32, 100_000] {
            let middle = rows as usize / 2;
            let t: Vec<f64> = (0..rows)
                .map(|i| {
                    f64::from(i)
                        + if i as usize >= middle {
                            f64::from(rows)
                        } else {
                            0.0
                        }
                })
                .collect();
            let times = Times {
                t_s: &t,
                breaks: &[middle],
            };
            let s = line("a", Role::Raw, times, |i| (t[i], 1.0));
            let gaps: Vec<usize> = (0..s.x.len()).filter(|i| s.x[*i].is_nan()).collect();
            let [at] = gaps[..] else { panic!("{gaps:?}") };
            assert_eq!((s.x[at - 1], s.x[at + 1]), (t[middle - 1], t[middle]));
            let b = band("b", Role::Raw, times, |_| (0.0, 1.0));
            assert_eq!(b.low.iter().filter(|v| v.is_nan()).count(), 1);
        }
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
