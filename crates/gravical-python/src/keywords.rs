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
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use serde::de::{self, DeserializeOwned, Deserializer, Error as _, Visitor};
use serde::forward_to_deserialize_any;
use serde_json::{Map, Value};

use crate::error::UNEXPECTED;

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
    /// Refuses keywords that nothing has taken.
    pub fn end(&self) -> Result<()> {
        let Some(name) = self.given.keys().next() else {
            return Ok(());
        };
        let accepted: Vec<&str> = self.accepted.iter().copied().collect();
        let accepted = accepted.join(", ");
        let what = format!("unexpected keyword argument '{name}'; accepted: {accepted}");
        Err(Error::usage(UNEXPECTED, what))
    }

    /// The last options of a call: [`take`](Self::take), and nothing may be left.
    pub fn last<T: DeserializeOwned>(&mut self) -> Result<T> {
        let options = self.take()?;
        self.end()?;
        Ok(options)
    }

    /// The options whose names are the fields of `T`.
    pub fn take<T: DeserializeOwned>(&mut self) -> Result<T> {
        let names = fields::<T>();
        self.accepted.extend(names);
        let mut taken = Map::new();
        for name in names {
            if let Some((name, value)) = self.given.remove_entry(*name) {
                let value = fitting::<T>(&name, value)
                    // An array of samples in place of an option is not shown in full.
                    .map_err(|what| Error::usage("usage", format!("{name}=: {what:.500}")))?;
                taken.insert(name, value);
            }
        }
        options(taken).map_err(|what| Error::usage("usage", what))
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

/// The value in the form that the option `name` of `T` takes: as it is, as the only one of a list, or
/// as the text that the program takes. Else the error of the first form of the right type.
fn fitting<T: DeserializeOwned>(name: &str, value: Value) -> Result<Value, String> {
    let forms = [
        Some(value.clone()),
        Some(Value::Array(vec![value.clone()])),
        text(&value, ",").map(Value::String),
    ];
    let mut errors = Vec::new();
    for form in forms.into_iter().flatten() {
        match options::<T>(Map::from_iter([(name.to_owned(), form.clone())])) {
            Ok(_) => return Ok(form),
            Err(what) => errors.push(what),
        }
    }
    let is_of_type = |what: &String| !what.starts_with("invalid type");
    let at = errors.iter().position(is_of_type).unwrap_or(0);
    Err(errors.swap_remove(at))
}

/// `y,-x,z`, `0-5,7.2-`, `t=time,gx=-`; none if a part of a mapping cannot be told from the next.
fn text(value: &Value, separator: &str) -> Option<String> {
    Some(match value {
        Value::Null => String::new(),
        Value::Bool(on) => if *on { "on" } else { "off" }.to_owned(),
        Value::Number(number) => number.to_string(),
        Value::String(text) => text.clone(),
        Value::Array(parts) => {
            let parts: Option<Vec<String>> = parts.iter().map(|part| text(part, "-")).collect();
            parts?.join(separator)
        }
        Value::Object(pairs) => {
            let pair = |(key, part): (&String, &Value)| {
                let part = if part.is_null() {
                    "-".to_owned()
                } else {
                    text(part, "-")?
                };
                (!part.contains([',', '='])).then(|| format!("{key}={part}"))
            };
            let pairs: Option<Vec<String>> = pairs.iter().map(pair).collect();
            pairs?.join(",")
        }
    })
}

/// The options, or what is wrong, with names of types in words.
fn options<T: DeserializeOwned>(given: Map<String, Value>) -> Result<T, String> {
    let whole = ["usize", "u64", "u32", "u8"].map(|kind| (kind, "a whole number in its range"));
    let texts = ["a string", "string or map"].map(|kind| (kind, "a text"));
    serde_json::from_value(Value::Object(given)).map_err(|error| {
        let words = [("f64", "a number")].into_iter().chain(texts).chain(whole);
        words.fold(error.to_string(), |what, (kind, words)| {
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
