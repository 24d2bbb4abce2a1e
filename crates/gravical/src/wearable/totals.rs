//! Sums over the epochs: of the recording, and of each day.

use std::collections::BTreeMap;

use jiff::civil::Date;
use serde::Serialize;

use super::measures::Epoch;
use super::table::TimeColumn;

/// Seconds of a day of a recording without dates.
const DAY_S: i64 = 86_400;

/// Time worn and activity, of a day or of the whole recording.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Worn {
    /// Number of epochs.
    pub epochs: u64,
    /// Epochs without samples.
    pub epochs_empty: u64,
    /// Time worn, s: whole epochs with samples.
    pub wear_s: u64,
    /// Time not worn, s.
    pub nonwear_s: u64,
    /// Time with samples in which wear cannot be judged, s.
    pub unjudged_s: u64,
    /// Mean of ENMO over the epochs with samples that are not known to be non-wear, mg; null
    /// without any.
    pub enmo_mg: Option<f64>,
    #[serde(skip)]
    enmo_epochs: u64,
}

/// A day of a recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Day {
    /// Local date (`2026-03-29`), or `day 1`, `day 2` … from the first sample.
    pub day: String,
    /// Its sums.
    #[serde(flatten)]
    pub worn: Worn,
}

/// Sums so far.
#[derive(Debug, Clone, Default)]
pub(super) struct Totals {
    pub all: Worn,
    dates: BTreeMap<Date, Worn>,
    days: BTreeMap<i64, Worn>,
    pub samples: u64,
    pub missing: u64,
    /// Start of the first epoch and end of the last one, s.
    pub span_s: Option<[i64; 2]>,
}

impl Worn {
    fn add(&mut self, epoch_s: i64, epoch: &Epoch, nonwear: Option<bool>) {
        self.epochs += 1;
        if epoch.measures.samples == 0 {
            self.epochs_empty += 1;
            return;
        }
        let time = match nonwear {
            Some(true) => &mut self.nonwear_s,
            Some(false) => &mut self.wear_s,
            None => &mut self.unjudged_s,
        };
        *time += epoch_s.unsigned_abs();
        let enmo_mg = 1e3 * epoch.measures.enmo_g;
        if nonwear != Some(true) && enmo_mg.is_finite() {
            self.enmo_epochs += 1;
            let mean = self.enmo_mg.unwrap_or(0.0);
            self.enmo_mg = Some(mean + (enmo_mg - mean) / self.enmo_epochs as f64);
        }
    }
}

impl Totals {
    pub fn add(
        &mut self,
        time: &TimeColumn,
        start_s: i64,
        epoch_s: i64,
        epoch: &Epoch,
        nonwear: Option<bool>,
    ) {
        self.samples += epoch.measures.samples;
        self.missing += epoch.missing;
        let [first, last] = self.span_s.unwrap_or([start_s, start_s]);
        self.span_s = Some([first.min(start_s), last.max(start_s + epoch_s)]);
        self.all.add(epoch_s, epoch, nonwear);
        let day = match time {
            TimeColumn::Dates { zone, .. } => {
                zone.date(start_s).map(|d| self.dates.entry(d).or_default())
            }
            TimeColumn::Relative => {
                let day = start_s.div_euclid(DAY_S);
                Some(self.days.entry(day).or_default())
            }
        };
        if let Some(day) = day {
            day.add(epoch_s, epoch, nonwear);
        }
    }

    /// The days, in order.
    pub fn days(&self) -> Vec<Day> {
        let dates = self.dates.iter().map(|(date, worn)| Day {
            day: date.to_string(),
            worn: worn.clone(),
        });
        let days = self.days.iter().map(|(number, worn)| Day {
            day: format!("day {}", number + 1),
            worn: worn.clone(),
        });
        dates.chain(days).collect()
    }
}
