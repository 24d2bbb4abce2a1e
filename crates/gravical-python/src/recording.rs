//! Recordings, and arrays that share their memory.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use gravical::recording::{self, Meter, ReadOptions, TableColumn, read_joined};
use gravical::{Error, Result};
use numpy::ndarray::ArrayView1;
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::error::raised;
use crate::keywords::Keywords;
use crate::task;

/// A recording in columns; its arrays are views of them.
#[pyclass(frozen, module = "gravical._gravical")]
pub struct Recording {
    /// Shared with what is computed from it.
    pub shared: Arc<recording::Recording>,
}

/// A read-only array over `values`, which belong to `owner` and live as long as it does.
#[allow(unsafe_code)]
pub fn view<'py>(values: &[f64], owner: Bound<'py, PyAny>) -> Bound<'py, PyArray1<f64>> {
    let view = ArrayView1::from(values);
    // SAFETY: the owner is a frozen class that never changes the values; the array keeps the owner
    // alive.
    let array = unsafe { PyArray1::borrow_from_array(&view, owner) };
    array.readwrite().make_nonwriteable();
    array
}

/// What a recording is made of.
#[derive(FromPyObject)]
pub enum Source<'py> {
    /// The content of a file.
    Bytes(Vec<u8>),
    /// Names of columns, and columns.
    Table(Vec<String>, Vec<Column<'py>>),
    /// One file, or one recording in memory, for another name.
    One(Inputs),
}

/// A column of a table, held by Python.
#[derive(FromPyObject)]
pub enum Column<'py> {
    /// Float64 without gaps.
    Numbers(PyReadonlyArray1<'py, f64>),
    /// Labels, and what else is no number.
    Texts(Vec<String>),
}

/// Reads a recording; `name` is that of bytes and tables, and replaces that of a file.
#[pyfunction]
pub fn read(
    py: Python<'_>,
    source: Source<'_>,
    name: Option<String>,
    mut keywords: Keywords,
) -> PyResult<Recording> {
    let given = name.clone().unwrap_or_default();
    let rows = match source {
        Source::One(inputs) => task::run(py, move |meter| {
            let reading = Reading::new(inputs, &mut keywords, meter)?;
            keywords.end()?;
            Ok(Arc::unwrap_or_clone(
                reading.one(|path, how| recording::read(path, how))?,
            ))
        })?,
        Source::Bytes(bytes) => task::run(py, move |meter| {
            let options = keywords.reading(meter)?;
            keywords.end()?;
            recording::read_bytes(&bytes, &given, &options)
        })?,
        Source::Table(names, columns) => {
            let failed = |e: Error| raised(py, &e);
            let options = keywords.reading(&Meter::default()).map_err(failed)?;
            keywords.end().map_err(failed)?;
            let columns = columns.iter().map(|column| match column {
                Column::Numbers(numbers) => Ok(TableColumn::Numbers(numbers.as_slice()?)),
                Column::Texts(texts) => Ok(TableColumn::Texts(texts)),
            });
            let columns = columns.collect::<PyResult<Vec<_>>>()?;
            py.detach(|| recording::Recording::from_table(&given, &names, &columns, &options))
                .map_err(failed)?
        }
    };
    let shared = Arc::new(match name {
        Some(name) => rows.with_name(&name),
        None => rows,
    });
    Ok(Recording { shared })
}

/// The recordings that a verb is given.
#[derive(FromPyObject)]
pub enum Inputs {
    /// Files, or a folder.
    Paths(Vec<PathBuf>),
    /// In memory.
    Recordings(Vec<Py<Recording>>),
}

/// [`recording::read`], or [`recording::read_samples`] for what needs every sample.
pub type Read = fn(&Path, &ReadOptions) -> Result<recording::Recording>;

/// The recordings of a call, and how files are read.
pub struct Reading {
    /// Files, or what is in memory.
    pub inputs: Inputs,
    /// The gyroscope of the one recording, in a second file.
    pub gyro: Option<PathBuf>,
    /// How the files are read.
    pub options: ReadOptions,
}

impl Reading {
    /// Takes the keywords of reading where there are files.
    pub fn new(inputs: Inputs, keywords: &mut Keywords, meter: &Meter) -> Result<Self> {
        let gyro = keywords.path("gyro")?;
        let options = match (&inputs, &gyro) {
            (Inputs::Paths(_), _) => keywords.reading(meter)?,
            (Inputs::Recordings(_), None) => ReadOptions {
                meter: Some(meter.clone()),
                ..ReadOptions::default()
            },
            (Inputs::Recordings(_), Some(_)) => {
                return Err(Error::usage("usage", "gyro=: it joins two files")
                    .with_hint("read both first: gravical.read(path, gyro=path)"));
            }
        };
        Ok(Reading {
            inputs,
            gyro,
            options,
        })
    }

    /// The one recording; a file is read by `read`.
    pub fn one(&self, read: Read) -> Result<Arc<recording::Recording>> {
        match &self.inputs {
            Inputs::Paths(paths) if paths.len() == 1 => {
                let (path, gyro) = (&paths[0], self.gyro.as_deref());
                Ok(Arc::new(read_joined(path, gyro, &self.options, read)?))
            }
            Inputs::Recordings(all) if all.len() == 1 => Ok(all[0].get().shared.clone()),
            _ => {
                let what = "one recording is needed, not several";
                Err(Error::usage("usage", what))
            }
        }
    }
}

/// Recordings for one who keeps them.
pub fn owned(recordings: &[Py<Recording>]) -> Vec<recording::Recording> {
    let shared = recordings.iter().map(|r| r.get().shared.clone());
    shared.map(Arc::unwrap_or_clone).collect()
}

#[pymethods]
impl Recording {
    /// What is known of it, as JSON.
    fn facts(&self) -> String {
        let r = &*self.shared;
        let facts = serde_json::json!({
            "name": r.name,
            "description": r.format.describe(),
            "rows": r.rows(),
            "column_names": r.format.names,
            "accel_unit": r.units.accel.unit.name(),
            "gyro_unit": r.units.gyro.map(|scale| scale.unit.name()),
            "zero_offset": r.units.zero_offset,
            "breaks": r.breaks,
            "rate_hz": r.clock.rate_hz(),
            "recorded": r.recorded_at().map(|time| time.to_string()),
            "findings": r.findings,
        });
        facts.to_string()
    }

    /// The channels that there are, as read-only views.
    fn columns<'py>(this: &Bound<'py, Self>) -> Vec<(&'static str, Bound<'py, PyArray1<f64>>)> {
        let r = &*this.get().shared;
        let time = r.time_s.iter().map(|t| ("t", t));
        let accel = ["ax", "ay", "az"].into_iter().zip(&r.accel);
        let gyro = ["gx", "gy", "gz"].into_iter().zip(r.gyro.iter().flatten());
        let temperature = r.temperature_c.iter().map(|t| ("temperature", t));
        let all = time.chain(accel).chain(gyro).chain(temperature);
        all.map(|(name, values)| (name, view(values, this.clone().into_any())))
            .collect()
    }

    /// Different labels, and for every row the index of its own.
    fn labels(&self) -> Option<(Vec<String>, Vec<u32>)> {
        let labels = self.shared.labels.as_ref()?;
        Some((labels.names.clone(), labels.of_row.clone()))
    }
}
