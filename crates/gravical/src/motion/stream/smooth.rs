//! Filters without look-ahead, by the names of `denoise`.

use gravical_core::filter::biquad::Biquad;

use crate::denoise::{Butterworth, FilterSpec, Passes, causal_coefficients};
use crate::{Error, Result};

/// The filters, one after the other.
#[derive(Debug, Clone, Default)]
pub(super) struct Chain(Vec<Step>);

#[derive(Debug, Clone)]
enum Step {
    Sections {
        axes: [Vec<Biquad<f64>>; 3],
        started: bool,
    },
    /// Weights over the last samples, from the oldest to the newest.
    Window {
        weights: Vec<f64>,
        last: Vec<[f64; 3]>,
        next: usize,
    },
}

impl Chain {
    /// # Errors
    ///
    /// `not-causal` (usage) for a filter that needs samples to come, `filter-range`
    /// (usage) for one that cannot be had at this rate.
    pub fn design(specs: &[FilterSpec], rate_hz: f64) -> Result<Self> {
        let steps = specs.iter().map(|spec| step(spec, rate_hz));
        Ok(Chain(steps.collect::<Result<_>>()?))
    }
}

fn step(spec: &FilterSpec, rate_hz: f64) -> Result<Step> {
    let window = |weights: Vec<f64>| Step::Window {
        weights,
        last: Vec::new(),
        next: 0,
    };
    let ahead = |hint: String| {
        Err(Error::usage(
            "not-causal",
            format!("{spec} needs later samples, which a causal computation does not have"),
        )
        .of_option("causal")
        .with_hint(hint))
    };
    match *spec {
        FilterSpec::SavitzkyGolay {
            window: width,
            order,
            derivative,
        } => {
            let weights = causal_coefficients(width, order, derivative, 1.0 / rate_hz)?;
            Ok(window(weights))
        }
        FilterSpec::Mean { window: width } => Ok(window(vec![1.0 / width as f64; width])),
        FilterSpec::Butterworth {
            order,
            band,
            passes: Passes::Causal,
        } => {
            let designed = Butterworth::new(order, band, Passes::Causal, rate_hz)?;
            Ok(Step::Sections {
                axes: std::array::from_fn(|_| designed.sections().to_vec()),
                started: false,
            })
        }
        FilterSpec::Butterworth { .. } => {
            let text = spec.to_string().replace("butter:", "butter1:");
            ahead(format!("{text} goes over the samples once, and delays"))
        }
        FilterSpec::Hampel { .. } => {
            ahead("run `gravical denoise` before, or leave --causal out".to_owned())
        }
    }
}

impl Chain {
    /// The next sample in, the filtered one out; the first counts as if it had been there
    /// for ever.
    #[inline]
    pub fn update(&mut self, input: [f64; 3]) -> [f64; 3] {
        let mut value = input;
        for step in &mut self.0 {
            value = step.update(value);
        }
        value
    }

    /// Forgets what was put in.
    pub fn reset(&mut self) {
        for step in &mut self.0 {
            match step {
                Step::Sections { started, .. } => *started = false,
                Step::Window { last, next, .. } => {
                    last.clear();
                    *next = 0;
                }
            }
        }
    }
}

impl Step {
    #[inline]
    fn update(&mut self, input: [f64; 3]) -> [f64; 3] {
        match self {
            Step::Sections { axes, started } => {
                let first = !std::mem::replace(started, true);
                std::array::from_fn(|i| {
                    axes[i].iter_mut().fold(input[i], |value, section| {
                        if first {
                            section.settle(value)
                        } else {
                            section.update(value)
                        }
                    })
                })
            }
            Step::Window {
                weights,
                last,
                next,
            } => {
                if last.is_empty() {
                    // The first counts as if it had been there for ever.
                    last.resize(weights.len(), input);
                }
                if let Some(place) = last.get_mut(*next) {
                    *place = input;
                }
                *next = if *next + 1 < last.len() { *next + 1 } else { 0 };
                let (newer, older) = last.split_at(*next);
                let mut sum = [0.0; 3];
                for (x, w) in older.iter().chain(newer).zip(weights.iter()) {
                    for i in 0..3 {
                        sum[i] += w * x[i];
                    }
                }
                sum
            }
        }
    }
}
