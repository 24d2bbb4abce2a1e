//! Filters and noise of plain arrays: evenly spaced samples without gaps, nothing else is known.

use gravical::denoise::{Filter, FilterSpec};
use gravical::noise::{Spacing, noise_of_samples};
use gravical::{Error, Result};
use gravical_signal::allan_variances;
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::error::OrRaise;
use crate::options::Options;
use crate::recording::json;
use crate::task;

/// Filters each row of `channels`, several at a time.
#[pyfunction]
pub fn filter_channels<'py>(
    py: Python<'py>,
    channels: PyReadonlyArray2<'py, f64>,
    options: Options<'py>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let specs = options.filter_chain()?;
    let rate = options.number("rate")?;
    let filters = designed(&specs, rate).or_raise(py)?;
    let channels = channels.as_array();
    let (rows, length) = channels.dim();
    // The one copy: the rows may be columns of what was given.
    let mut out: Vec<f64> = Vec::with_capacity(channels.len());
    for channel in channels.rows() {
        out.extend(channel.iter());
    }
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let each = length.max(1) * rows.div_ceil(threads).max(1);
    py.detach(|| {
        std::thread::scope(|scope| {
            for some in out.chunks_mut(each) {
                let filters = &filters;
                scope.spawn(move || {
                    for channel in some.chunks_mut(length.max(1)) {
                        for filter in filters {
                            filter.apply(channel);
                        }
                    }
                });
            }
        });
    });
    let out = Array2::from_shape_vec((rows, length), out);
    Ok(out
        .map_err(|e| PyValueError::new_err(e.to_string()))?
        .into_pyarray(py))
}

fn designed(specs: &[FilterSpec], rate: Option<f64>) -> Result<Vec<Filter>> {
    if specs.is_empty() {
        return Err(Error::usage("no-filter", "no filter was given")
            .with_hint("filter= one of: savgol:11,2, butter:4,5Hz, hampel:7,3, mean:5"));
    }
    specs
        .iter()
        .map(|spec| Filter::design(spec, rate))
        .collect()
}

/// One column.
type Column<'py> = Bound<'py, PyArray1<f64>>;

/// Averaging times, s, and Allan deviations; of octaves without `taus`.
#[pyfunction]
pub fn allan_deviation<'py>(
    py: Python<'py>,
    samples: PyReadonlyArray1<'py, f64>,
    rate: f64,
    taus: Option<Vec<f64>>,
) -> PyResult<(Column<'py>, Column<'py>)> {
    let samples = samples.as_slice()?;
    let m = match taus {
        Some(taus) => taus
            .iter()
            .map(|tau| (tau * rate).round() as usize)
            .collect(),
        None => Spacing::Octave.factors(samples.len() / 2),
    };
    let (tau, sigma): (Vec<f64>, Vec<f64>) = py.detach(|| {
        let variances = allan_variances(&[samples], &m).into_iter();
        variances.map(|v| (v.m as f64 / rate, v.variance.sqrt()))
            .unzip()
    });
    Ok((tau.into_pyarray(py), sigma.into_pyarray(py)))
}

/// Noise of one channel, as JSON.
#[pyfunction]
pub fn noise_of_channel(
    py: Python<'_>,
    channel: String,
    samples: PyReadonlyArray1<'_, f64>,
    rate: f64,
    options: Options<'_>,
) -> PyResult<String> {
    let wanted = options.noise()?;
    let samples: Vec<f64> = samples.as_array().iter().copied().collect();
    let (_, meter) = options.read(false)?;
    let run = move || Ok(noise_of_samples(&channel, &samples, 1.0 / rate, &wanted));
    json(&task::run(py, &meter, run)?)
}
