//! Results that are presented: as JSON, as a report, as figures.

use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use gravical::Error;
use gravical::TOOL;
use gravical::calibration_file::{InputFile, creation_time};
use gravical::check::CheckReport;
use gravical::compare::Comparison;
use gravical::denoise::DenoiseSummary;
use gravical::export::kalibr;
use gravical::inspect::Inspection;
use gravical::motion::{Motion, Track, write_table};
use gravical::noise::NoiseResult;
use gravical::output::write_atomic;
use gravical::recording::Recording;
use gravical::targets::check_targets;
use gravical_report::document::{Detail, Document};
use gravical_report::figure::{self, Figure, svg};
use gravical_report::report::{self, Provenance};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::exceptions::{PyKeyError, PyValueError};
use pyo3::prelude::*;

use crate::error::OrRaise;
use crate::recording::{json, view};

/// Name, title, caption and SVG.
pub type Drawn = (String, String, String, String);

/// The result of a verb.
#[derive(Clone)]
pub enum Kind {
    /// Of `inspect`.
    Inspection(Box<Inspection>),
    /// Of `check`.
    Check(Box<CheckReport>),
    /// Of `compare`.
    Comparison(Box<Comparison>),
    /// Of `noise`.
    Noise(Box<NoiseResult>),
    /// Of `denoise`.
    Denoise(Box<DenoiseSummary>),
    /// Of `motion`, with what is said of its recording.
    Motion(Arc<Motion>, Arc<Recording>),
}

/// A result and its files.
#[pyclass(frozen, module = "gravical._gravical")]
pub struct Outcome {
    /// What was found.
    pub kind: Kind,
    inputs: Vec<InputFile>,
    /// Columns of a motion, once they are asked for.
    track: OnceLock<Track>,
}

impl Outcome {
    /// A result of these files.
    pub fn new(kind: Kind, inputs: Vec<InputFile>) -> Self {
        Outcome {
            kind,
            inputs,
            track: OnceLock::new(),
        }
    }

    fn motion(&self) -> PyResult<&Motion> {
        match &self.kind {
            Kind::Motion(motion, _) => Ok(motion),
            _ => Err(PyValueError::new_err("this is not a result of motion")),
        }
    }

    fn columns(&self, py: Python<'_>) -> PyResult<&Track> {
        let motion = self.motion()?;
        Ok(py.detach(|| self.track.get_or_init(|| motion.track())))
    }

    fn drawn(&self) -> Vec<Figure> {
        match &self.kind {
            Kind::Noise(result) => figure::noise::figures(result),
            Kind::Motion(motion, _) => figure::motion::figures(motion),
            _ => Vec::new(),
        }
    }

    fn presented<'a>(&'a self, figures: &'a [Figure]) -> Document<'a> {
        let document = match &self.kind {
            Kind::Inspection(result) => report::inspection(result),
            Kind::Check(result) => report::check(result),
            Kind::Comparison(result) => report::comparison(result),
            Kind::Noise(result) => report::noise(result, figures),
            Kind::Denoise(result) => report::denoise(result),
            Kind::Motion(motion, recording) => report::motion(&motion.result, recording, figures),
        };
        document.with_provenance(&Provenance {
            tool: TOOL,
            command: None,
            created: &creation_time(),
            inputs: &self.inputs,
        })
    }
}

/// The figures as names and SVG.
pub fn svgs(figures: &[Figure]) -> Vec<Drawn> {
    let drawn = figures.iter().map(|f| {
        let svg = svg::standalone(f);
        (f.name.clone(), f.title.clone(), f.caption.clone(), svg)
    });
    drawn.collect()
}

/// A document in one of three formats.
pub fn rendered(document: &Document<'_>, format: &str) -> PyResult<String> {
    match format {
        "html" => Ok(document.to_html()),
        "markdown" => Ok(document.to_markdown(None)),
        "text" => Ok(document.to_text(Detail::Full)),
        "summary" => Ok(document.to_text(Detail::Summary)),
        _ => Err(PyValueError::new_err(format!("no format {format:?}"))),
    }
}

#[pymethods]
impl Outcome {
    fn json(&self) -> PyResult<String> {
        match &self.kind {
            Kind::Inspection(result) => json(result),
            Kind::Check(result) => json(result),
            Kind::Comparison(result) => json(result),
            Kind::Noise(result) => json(result),
            Kind::Denoise(result) => json(result),
            Kind::Motion(motion, _) => json(&motion.result),
        }
    }

    fn figures(&self, py: Python<'_>) -> Vec<Drawn> {
        py.detach(|| svgs(&self.drawn()))
    }

    fn document(&self, py: Python<'_>, format: &str) -> PyResult<String> {
        py.detach(|| {
            let figures = self.drawn();
            rendered(&self.presented(&figures), format)
        })
    }

    /// Writes the table of a motion.
    fn table(&self, py: Python<'_>, path: PathBuf, force: bool) -> PyResult<()> {
        let motion = self.motion()?;
        let write = || {
            check_output(&path, &self.inputs, force)?;
            write_atomic(&path, force, |out| {
                write_table(motion, out).map_err(|e| Error::io(&path, e))
            })
        };
        py.detach(write).or_raise(py)
    }

    /// The noise for Kalibr.
    fn kalibr(&self, py: Python<'_>, upper_limit: bool) -> PyResult<String> {
        let Kind::Noise(result) = &self.kind else {
            return Err(PyValueError::new_err("this is not a result of noise"));
        };
        let written = kalibr(&result.section(), None, upper_limit);
        Ok(written.or_raise(py)?.text)
    }

    /// A column of a motion's track, flat.
    fn track<'py>(this: &Bound<'py, Self>, name: &str) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let values = column(this.get().columns(this.py())?, name);
        let values = values.ok_or_else(|| PyKeyError::new_err(name.to_owned()))?;
        Ok(view(values, this.clone().into_any()))
    }

    /// True at rest.
    fn still<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let still = PyArray1::from_slice(py, &self.columns(py)?.still);
        still.readwrite().make_nonwriteable();
        Ok(still)
    }
}

/// Checks that a result replaces none of the files that it was computed from.
pub fn check_output(path: &Path, inputs: &[InputFile], force: bool) -> gravical::Result<()> {
    let inputs: Vec<PathBuf> = inputs.iter().map(|i| PathBuf::from(&i.path)).collect();
    check_targets(&[path.to_owned()], &inputs, force)
}

/// A column of the table, by name; its memory is that of the track.
fn column<'a>(track: &'a Track, name: &str) -> Option<&'a [f64]> {
    let of = |columns: &'a Vec<[f64; 3]>| columns.as_flattened();
    Some(match name {
        "t" => &track.t_s,
        "attitude" => track.attitude.as_flattened(),
        "acceleration" => of(&track.acceleration_mps2),
        "velocity" => of(&track.velocity_mps),
        "position" => of(&track.position_m),
        "sigma_velocity" => of(&track.sigma_velocity_mps),
        "sigma_position" => of(&track.sigma_position_m),
        "raw_x" => &track.raw_mps2[0],
        "raw_y" => &track.raw_mps2[1],
        "raw_z" => &track.raw_mps2[2],
        "force_x" => &track.force_mps2[0],
        "force_y" => &track.force_mps2[1],
        "force_z" => &track.force_mps2[2],
        _ => return None,
    })
}
