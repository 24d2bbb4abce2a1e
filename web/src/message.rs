//! A message: the length of a JSON object (32 bits, little endian), the object, and files one after the other.
//! The object names them: `"files": [{"name": "x.csv", "size": 1234, "role": "calibration"}]`.

use std::path::Path;

use gravical::recording::source::Named;
use gravical::{Error, Result};
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

/// A message from the page.
pub struct Message<'a> {
    head: Value,
    /// The files with their roles: `calibration`, `gyro`, `sections`; else a recording.
    files: Vec<(String, File<'a>)>,
}

/// A file in memory.
#[derive(Clone)]
pub struct File<'a> {
    pub name: String,
    pub bytes: &'a [u8],
}

impl File<'_> {
    pub fn named(&self) -> Named<'_> {
        Named::Bytes(Path::new(&self.name), self.bytes)
    }
}

impl<'a> Message<'a> {
    /// A malformed message is read as an empty one; only the page writes them.
    pub fn parse(bytes: &'a [u8]) -> Self {
        let split = |(size, rest): (&[u8; 4], &'a [u8])| {
            rest.split_at_checked(u32::from_le_bytes(*size) as usize)
        };
        let (head, mut rest) = bytes
            .split_first_chunk()
            .and_then(split)
            .unwrap_or_default();
        let head: Value = serde_json::from_slice(head).unwrap_or_default();
        let take = |file: &Value| {
            let (bytes, others) = rest.split_at_checked(file["size"].as_u64()? as usize)?;
            rest = others;
            let name = file["name"].as_str()?.to_owned();
            let role = file["role"].as_str().unwrap_or_default().to_owned();
            Some((role, File { name, bytes }))
        };
        let files = head["files"].as_array().into_iter().flatten();
        let files = files.map_while(take).collect();
        Message { head, files }
    }

    /// What it asks for.
    pub fn verb(&self) -> &str {
        self.head["do"].as_str().unwrap_or_default()
    }

    /// A number of its head.
    pub fn number(&self, name: &str) -> Option<f64> {
        self.head[name].as_f64()
    }

    /// Its options as far as `T` has them; the names are those of the program's, with _ for -.
    pub fn options<T: DeserializeOwned>(&self) -> Result<T> {
        let options = match &self.head["options"] {
            Value::Null => json!({}),
            options => options.clone(),
        };
        T::deserialize(options).map_err(|e| Error::usage("usage", e.to_string()))
    }

    /// The files of this role.
    pub fn files<'m>(&'m self, role: &'m str) -> impl Iterator<Item = &'m File<'a>> {
        let files = self.files.iter().filter(move |(own, _)| own == role);
        files.map(|(_, file)| file)
    }

    /// The one file of this role.
    pub fn file<'m>(&'m self, role: &'m str) -> Result<&'m File<'a>> {
        let what = if role.is_empty() { "recording" } else { role };
        let missing = || Error::usage("usage", format!("a file is missing: the {what}"));
        self.files(role).next().ok_or_else(missing)
    }
}

/// A message to the page.
pub fn answer(mut head: Value, files: &[(String, Vec<u8>)]) -> Vec<u8> {
    let name = |(name, bytes): &(String, Vec<u8>)| json!({ "name": name, "size": bytes.len() });
    head["files"] = files.iter().map(name).collect();
    let head = head.to_string();
    let mut message = (head.len() as u32).to_le_bytes().to_vec();
    message.extend_from_slice(head.as_bytes());
    for (_, bytes) in files {
        message.extend_from_slice(bytes);
    }
    message
}
