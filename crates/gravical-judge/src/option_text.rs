//! Options that are written as a text, such as `y,-x,z`, for serde.

use std::str::FromStr;

use serde::{Deserialize, Deserializer, de};

use crate::error::Error;

/// The value of a text, or the error with its hint.
fn parse<T: FromStr<Err = Error>, E: de::Error>(text: &str) -> Result<T, E> {
    text.parse().map_err(|error: Error| match error.hint() {
        Some(hint) => E::custom(format_args!("{error}; {hint}")),
        None => E::custom(error),
    })
}

/// A value.
pub fn one<'de, D: Deserializer<'de>, T: FromStr<Err = Error>>(from: D) -> Result<T, D::Error> {
    parse(&String::deserialize(from)?)
}

/// A value that may be missing.
pub fn optional<'de, D: Deserializer<'de>, T: FromStr<Err = Error>>(
    from: D,
) -> Result<Option<T>, D::Error> {
    let text = Option::<String>::deserialize(from)?;
    text.map(|text| parse(&text)).transpose()
}

/// A list.
pub fn list<'de, D: Deserializer<'de>, T: FromStr<Err = Error>>(
    from: D,
) -> Result<Vec<T>, D::Error> {
    let texts = Vec::<String>::deserialize(from)?;
    texts.iter().map(|text| parse(text)).collect()
}
