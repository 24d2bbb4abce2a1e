//! Keyword arguments as options of the library, through serde: their names and defaults are those
//! of its structs.
//!
//! Several structs share the keywords of one call: each takes the names of its fields, and what is
//! left is unknown.

use std::collections::BTreeSet;
use std::path::PathBuf;

use gravical::gravity::{Gravity, GravityOptions};
use gravical::recording::{Meter, ReadOptions};
use gravical::{Error, Result};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use serde::de::{self, DeserializeOwned, Deserializer, Error as _, Visitor};
use serde::forward_to_deserialize_any;
use serde_json::{Map, Value};

use crate::error::OrRaise;

/// Keyword arguments that no options have taken yet.
pub struct Keywords {
    given: Map<String, Value>,
    accepted: BTreeSet<&'static str>,
}

impl FromPyObject<'_, '_> for Keywords {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        let given = serde_json::from_str(&object.extract::<String>()?);
        Ok(Keywords {
            given: given.map_err(|e| PyValueError::new_err(e.to_string()))?,
            accepted: BTreeSet::new(),
        })
    }
}

impl Keywords {
    /// The options of one call; `TypeError` for keywords that `read` does not take.
    pub fn read<T>(
        mut self,
        py: Python<'_>,
        read: impl FnOnce(&mut Self) -> Result<T>,
    ) -> PyResult<T> {
        let options = read(&mut self).or_raise(py)?;
        let Some(name) = self.given.keys().next() else {
            return Ok(options);
        };
        let accepted: Vec<&str> = self.accepted.into_iter().collect();
        Err(PyTypeError::new_err(format!(
            "unexpected keyword argument '{name}'; accepted: {}",
            accepted.join(", ")
        )))
    }

    /// The options whose names are the fields of `T`.
    pub fn take<T: DeserializeOwned>(&mut self) -> Result<T> {
        let names = fields::<T>();
        self.accepted.extend(names);
        let given = names
            .iter()
            .filter_map(|name| self.given.remove_entry(*name));
        let given: Map<String, Value> = given.collect();
        // Each alone at first: its error names it.
        for (name, value) in &given {
            let alone = Map::from_iter([(name.clone(), value.clone())]);
            options::<T>(alone)
                .map_err(|what| Error::usage("usage", format!("{name}=: {what}")))?;
        }
        options(given).map_err(|what| Error::usage("usage", what))
    }

    /// How a recording is read; the meter stops it.
    pub fn reading(&mut self, meter: &Meter) -> Result<ReadOptions> {
        let options = ReadOptions {
            hash: true,
            meter: Some(meter.clone()),
            ..self.take()?
        };
        options.validate()?;
        Ok(options)
    }

    /// A file beside the recordings.
    pub fn path(&mut self, name: &'static str) -> Result<Option<PathBuf>> {
        self.accepted.insert(name);
        match self.given.remove(name) {
            None => Ok(None),
            Some(Value::String(path)) => Ok(Some(path.into())),
            Some(_) => Err(Error::usage("usage", format!("{name}=: expected a path"))),
        }
    }

    /// Gravity, if it is given.
    pub fn gravity(&mut self) -> Result<Option<Gravity>> {
        self.take::<GravityOptions>()?.given()
    }
}

/// The options, or what is wrong, with names of types in words.
fn options<T: DeserializeOwned>(given: Map<String, Value>) -> Result<T, String> {
    const WORDS: [(&str, &str); 7] = [
        ("f64", "a number"),
        ("a string", "a text"),
        ("string or map", "a text"),
        ("usize", "a whole number in its range"),
        ("u64", "a whole number in its range"),
        ("u32", "a whole number in its range"),
        ("u8", "a whole number in its range"),
    ];
    serde_json::from_value(Value::Object(given)).map_err(|error| {
        WORDS.iter().fold(error.to_string(), |what, (kind, words)| {
            what.replace(&format!("expected {kind}"), &format!("expected {words}"))
        })
    })
}

/// The names of the fields of `T`.
pub fn fields<T: DeserializeOwned>() -> &'static [&'static str] {
    let mut names: &'static [&'static str] = &[];
    // It fails: the names alone are wanted.
    let _ = T::deserialize(Fields(&mut names));
    names
}

/// Takes down the names of the fields of a struct.
struct Fields<'a>(&'a mut &'static [&'static str]);

impl<'de> Deserializer<'de> for Fields<'_> {
    type Error = de::value::Error;

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Self::Error> {
        *self.0 = fields;
        self.deserialize_any(visitor)
    }

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Self::Error> {
        Err(Self::Error::custom("no values"))
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 u8 u16 u32 u64 f32 f64 char str string bytes byte_buf option unit
        unit_struct newtype_struct seq tuple tuple_struct map enum identifier ignored_any
    }
}
