//! Keyword arguments as options of the library, through serde: their names and defaults are those
//! of its structs.
//!
//! Several structs share the keywords of one call: each takes the names of its fields, and what is
//! left is unknown. An option that is written as a text, such as `y,-x,z`, is also taken as a list,
//! and a single value where a list is meant.

use std::fmt;

use gravical::gravity::{Gravity, GravityOptions};
use gravical::recording::{Meter, ReadOptions};
use gravical::{Error, Result};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use serde::de::value::{SeqDeserializer, StrDeserializer};
use serde::de::{self, DeserializeOwned, DeserializeSeed, IntoDeserializer, MapAccess, Visitor};
use serde::forward_to_deserialize_any;
use serde_json::{Map, Value};

use crate::error::OrRaise;

/// Keyword arguments that no options have taken yet.
pub struct Keywords {
    given: Map<String, Value>,
    accepted: Vec<&'static str>,
}

impl FromPyObject<'_, '_> for Keywords {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        let given = serde_json::from_str(&object.extract::<String>()?);
        Ok(Keywords {
            given: given.map_err(|e| PyValueError::new_err(e.to_string()))?,
            accepted: Vec::new(),
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
        match self.given.keys().next() {
            None => Ok(options),
            Some(name) => Err(PyTypeError::new_err(format!(
                "unexpected keyword argument '{name}'; accepted: {}",
                self.accepted.join(", ")
            ))),
        }
    }

    /// The options whose names are the fields of `T`.
    pub fn take<T: DeserializeOwned>(&mut self) -> Result<T> {
        T::deserialize(self).map_err(|Wrong(what)| Error::usage("usage", what))
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

    /// Gravity, if it is given.
    pub fn gravity(&mut self) -> Result<Option<Gravity>> {
        self.take::<GravityOptions>()?.given()
    }
}

/// What is wrong with a value.
#[derive(Debug)]
pub struct Wrong(String);

impl fmt::Display for Wrong {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Wrong {}

impl de::Error for Wrong {
    fn custom<T: fmt::Display>(what: T) -> Self {
        Wrong(what.to_string())
    }
}

impl<'de> de::Deserializer<'de> for &mut Keywords {
    type Error = Wrong;

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Wrong> {
        self.accepted.extend(fields);
        let given = fields.iter().filter_map(|field| {
            let (name, value) = self.given.remove_entry(*field)?;
            Some((name, Leaf(value)))
        });
        let given = given.collect::<Vec<_>>().into_iter();
        visitor.visit_map(Fields { given, last: None })
    }

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Wrong> {
        Err(Wrong("options are a struct".to_owned()))
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 u8 u16 u32 u64 f32 f64 char str string bytes byte_buf option unit
        unit_struct newtype_struct seq tuple tuple_struct map enum identifier ignored_any
    }
}

/// The fields of a struct that are given.
struct Fields {
    given: std::vec::IntoIter<(String, Leaf)>,
    last: Option<(String, Leaf)>,
}

impl<'de> MapAccess<'de> for Fields {
    type Error = Wrong;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, Wrong> {
        self.last = self.given.next();
        let key = self.last.as_ref();
        key.map(|(name, _)| seed.deserialize(StrDeserializer::new(name)))
            .transpose()
    }

    fn next_value_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<S::Value, Wrong> {
        let (name, value) = self.last.take().ok_or_else(|| Wrong(String::new()))?;
        seed.deserialize(value)
            .map_err(|Wrong(what)| Wrong(format!("{name}=: {}", in_words(&what))))
    }
}

/// Names of types in words.
fn in_words(what: &str) -> String {
    let what = what.replace("expected f64", "expected a number");
    let what = what.replace("expected a string", "expected a text");
    ["usize", "u64", "u32", "u8"]
        .iter()
        .fold(what, |what, kind| {
            what.replace(
                &format!("expected {kind}"),
                "expected a whole number in its range",
            )
        })
}

/// A value.
struct Leaf(Value);

impl<'de> IntoDeserializer<'de, Wrong> for Leaf {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
    }
}

/// The text that the program would be given: parts of a list with commas, `start-end` of a pair,
/// `name=value` of a mapping.
fn text(value: &Value, separator: &str) -> Result<String, Wrong> {
    Ok(match value {
        Value::String(text) => text.clone(),
        Value::Number(number) => number.to_string(),
        Value::Bool(on) => if *on { "on" } else { "off" }.to_owned(),
        Value::Null => String::new(),
        Value::Array(parts) => {
            let parts = parts.iter().map(|part| text(part, "-"));
            parts.collect::<Result<Vec<_>, _>>()?.join(separator)
        }
        Value::Object(named) => {
            let pair = |(name, value): (&String, &Value)| match value {
                Value::Null => Ok(format!("{name}=-")),
                _ => match text(value, "-")? {
                    value if value.contains([',', '=']) => Err(Wrong(format!(
                        "{value:?} has a comma or an equals sign in it; rename it first"
                    ))),
                    value => Ok(format!("{name}={value}")),
                },
            };
            let pairs = named.iter().map(pair);
            pairs.collect::<Result<Vec<_>, _>>()?.join(separator)
        }
    })
}

impl<'de> de::Deserializer<'de> for Leaf {
    type Error = Wrong;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Wrong> {
        self.0
            .deserialize_any(visitor)
            .map_err(|e| Wrong(e.to_string()))
    }

    fn deserialize_string<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Wrong> {
        visitor.visit_string(text(&self.0, ",")?)
    }

    fn deserialize_str<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Wrong> {
        self.deserialize_string(visitor)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Wrong> {
        visitor.visit_some(self)
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Wrong> {
        let parts = match self.0 {
            Value::Array(parts) => parts,
            one => vec![one],
        };
        visitor.visit_seq(SeqDeserializer::new(parts.into_iter().map(Leaf)))
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Wrong> {
        visitor.visit_enum(text(&self.0, ",")?.into_deserializer())
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Wrong> {
        visitor.visit_newtype_struct(self)
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 u8 u16 u32 u64 f32 f64 char bytes byte_buf unit unit_struct tuple
        tuple_struct map struct identifier ignored_any
    }
}
