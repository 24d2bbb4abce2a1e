//! Recordings, and arrays that share their memory.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use gravical::output;
use gravical::recording::{self, TableColumn, join_gyroscope};
use numpy::ndarray::ArrayView1;
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1};
use pyo3::exceptions::{PyKeyError, PyRuntimeError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::error::OrRaise;
use crate::options::Options;
use crate::task;

/// A recording in columns; its arrays are views of them.
#[pyclass(frozen, module = "gravical._gravical")]
pub struct Recording {
    /// Shared with what is computed from it.
    pub shared: Arc<recording::Recording>,
}

impl From<recording::Recording> for Recording {
    fn from(recording: recording::Recording) -> Self {
        Recording {
            shared: Arc::new(recording),
        }
    }
}

/// A read-only array over `values`, which belong to `owner` and live as long as it does.
#[allow(unsafe_code)]
pub fn view<'py>(values: &[f64], owner: Bound<'py, PyAny>) -> Bound<'py, PyArray1<f64>> {
    let view = ArrayView1::from(values);
    // SAFETY: the owner is a frozen class that holds the values behind an `Arc` and never changes
    // them; the array keeps the owner alive.
    let array = unsafe { PyArray1::borrow_from_array(&view, owner) };
    array.readwrite().make_nonwriteable();
    array
}

/// A column of a table, held by Python.
enum Held<'py> {
    Numbers(PyReadonlyArray1<'py, f64>),
    Texts(Vec<String>),
}

fn held<'py>(columns: &[Bound<'py, PyAny>]) -> PyResult<Vec<Held<'py>>> {
    let one = |column: &Bound<'py, PyAny>| match column.extract() {
        Ok(numbers) => Ok(Held::Numbers(numbers)),
        Err(_) => column.extract().map(Held::Texts),
    };
    columns.iter().map(one).collect()
}

fn table<'a>(held: &'a [Held<'_>]) -> PyResult<Vec<TableColumn<'a>>> {
    let one = |column: &'a Held<'_>| match column {
        Held::Numbers(numbers) => Ok(TableColumn::Numbers(numbers.as_slice()?)),
        Held::Texts(texts) => Ok(TableColumn::Texts(texts)),
    };
    held.iter().map(one).collect()
}

/// The JSON of the program.
pub fn json(value: &impl serde::Serialize) -> PyResult<String> {
    serde_json::to_string(value).map_err(|e| PyRuntimeError::new_err(e.to_string()))
}

#[pymethods]
impl Recording {
    /// A table of named columns: arrays of float64 without gaps, or lists of texts.
    #[staticmethod]
    fn from_table(
        py: Python<'_>,
        name: &str,
        names: Vec<String>,
        columns: Vec<Bound<'_, PyAny>>,
        options: Options<'_>,
    ) -> PyResult<Self> {
        let (read, _) = options.read(false)?;
        let held = held(&columns)?;
        let columns = table(&held)?;
        let made = py.detach(|| recording::Recording::from_table(name, &names, &columns, &read));
        Ok(made.or_raise(py)?.into())
    }

    /// The channels of such a table, each with its column from 0.
    #[staticmethod]
    fn table_fields(
        py: Python<'_>,
        name: &str,
        names: Vec<String>,
        columns: Vec<Bound<'_, PyAny>>,
        options: Options<'_>,
    ) -> PyResult<HashMap<&'static str, usize>> {
        let (read, _) = options.read(false)?;
        let held = held(&columns)?;
        let fields = recording::Recording::table_fields(name, &names, &table(&held)?, &read);
        Ok(fields.or_raise(py)?.into_iter().collect())
    }

    #[staticmethod]
    fn from_bytes(bytes: &[u8]) -> PyResult<Self> {
        let made = rmp_serde::from_slice::<recording::Recording>(bytes);
        made.map(Into::into)
            .map_err(|e| PyRuntimeError::new_err(format!("not a pickled recording: {e}")))
    }

    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = py.detach(|| rmp_serde::to_vec_named(&*self.shared));
        let bytes = bytes.map_err(|e| PyRuntimeError::new_err(e.to_string()))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// The same columns under another name.
    fn named(&self, name: String) -> Self {
        let mut other = (*self.shared).clone();
        for finding in &mut other.findings {
            finding.file = Some(name.clone());
        }
        other.name = name;
        other.into()
    }

    #[getter]
    fn name(&self) -> &str {
        &self.shared.name
    }

    #[getter]
    fn description(&self) -> &str {
        &self.shared.description
    }

    #[getter]
    fn rows(&self) -> usize {
        self.shared.rows()
    }

    #[getter]
    fn column_names(&self) -> Vec<String> {
        self.shared.column_names.clone()
    }

    #[getter]
    fn accel_unit(&self) -> &'static str {
        self.shared.accel_scale.unit.name()
    }

    #[getter]
    fn gyro_unit(&self) -> Option<&'static str> {
        self.shared.gyro_scale.map(|scale| scale.unit.name())
    }

    #[getter]
    fn zero_offset(&self) -> f64 {
        self.shared.zero_offset
    }

    #[getter]
    fn breaks(&self) -> Vec<usize> {
        self.shared.breaks.clone()
    }

    #[getter]
    fn rate_hz(&self) -> Option<f64> {
        self.shared.timing.rate_hz()
    }

    #[getter]
    fn recorded(&self) -> Option<String> {
        self.shared.recorded_at().map(|time| time.to_string())
    }

    fn findings_json(&self) -> PyResult<String> {
        json(&self.shared.findings)
    }

    /// Names of the channels that there are.
    fn channels(&self) -> Vec<&'static str> {
        let r = &*self.shared;
        let time = r.time_s.iter().map(|_| "t");
        let gyro = r.gyro.iter().flat_map(|_| ["gx", "gy", "gz"]);
        let temperature = r.temperature_c.iter().map(|_| "temperature");
        let all = time.chain(["ax", "ay", "az"]).chain(gyro);
        all.chain(temperature).collect()
    }

    /// A read-only view of a channel.
    fn channel<'py>(this: &Bound<'py, Self>, name: &str) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let r = &this.get().shared;
        let gyro = |i: usize| r.gyro.as_ref().map(|g| &g[i][..]);
        let values = match name {
            "t" => r.time_s.as_deref(),
            "ax" => Some(&r.accel[0][..]),
            "ay" => Some(&r.accel[1][..]),
            "az" => Some(&r.accel[2][..]),
            "gx" => gyro(0),
            "gy" => gyro(1),
            "gz" => gyro(2),
            "temperature" => r.temperature_c.as_deref(),
            _ => None,
        };
        match values {
            Some(values) => Ok(view(values, this.clone().into_any())),
            None => Err(PyKeyError::new_err(name.to_owned())),
        }
    }

    /// Different labels, and for every row the index of its own.
    fn labels(&self) -> Option<(Vec<String>, Vec<u32>)> {
        let labels = self.shared.labels.as_ref()?;
        Some((labels.names.clone(), labels.of_row.clone()))
    }
}

/// Reads a file.
#[pyfunction]
pub fn read(
    py: Python<'_>,
    path: PathBuf,
    gyro: Option<PathBuf>,
    options: Options<'_>,
) -> PyResult<Recording> {
    let (read, meter) = options.read(true)?;
    let done = task::run(py, &meter, move || match gyro {
        None => recording::read(&path, &read),
        Some(gyro) => {
            let mut recording = recording::read(&path, &read.beside_gyroscope_file())?;
            join_gyroscope(&mut recording, &gyro, &read)?;
            Ok(recording)
        }
    });
    done.map(Into::into)
}

/// Reads the content of a file.
#[pyfunction]
pub fn read_bytes(
    py: Python<'_>,
    bytes: Vec<u8>,
    name: String,
    options: Options<'_>,
) -> PyResult<Recording> {
    let (read, meter) = options.read(true)?;
    let done = task::run(py, &meter, move || {
        recording::read_bytes(&bytes, &name, &read)
    });
    done.map(Into::into)
}

/// Writes a text, atomically; nothing is overwritten without `force`.
#[pyfunction]
pub fn write_text(py: Python<'_>, path: PathBuf, text: &str, force: bool) -> PyResult<()> {
    py.detach(|| output::write_text(&path, force, text))
        .or_raise(py)
}
