//! Options that are written as a text, such as `y,-x,z`, for serde.

use std::str::FromStr;

use serde::{Deserialize, Deserializer};

/// The value of a text, or the error with its hint.
pub fn parse<T, E: serde::de::Error>(
    text: &str,
    read: impl Fn(&str) -> crate::Result<T>,
) -> Result<T, E> {
    read(text).map_err(|error| match error.hint() {
        Some(hint) => E::custom(format_args!("{error}; {hint}")),
        None => E::custom(error),
    })
}

/// A value.
pub fn one<'de, D: Deserializer<'de>, T: FromStr<Err = crate::Error>>(
    from: D,
) -> Result<T, D::Error> {
    parse(&String::deserialize(from)?, str::parse)
}

/// A value that may be missing.
pub fn optional<'de, D: Deserializer<'de>, T: FromStr<Err = crate::Error>>(
    from: D,
) -> Result<Option<T>, D::Error> {
    let text = Option::<String>::deserialize(from)?;
    text.map(|text| parse(&text, str::parse)).transpose()
}

/// A list.
pub fn list<'de, D: Deserializer<'de>, T: FromStr<Err = crate::Error>>(
    from: D,
) -> Result<Vec<T>, D::Error> {
    let texts = Vec::<String>::deserialize(from)?;
    texts.iter().map(|text| parse(text, str::parse)).collect()
}
