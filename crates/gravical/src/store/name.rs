//! Names of folders and files in a store.
//!
//! The id of a sensor is the user's text. Its folder has a name that every file system takes; the
//! id itself is in the calibration, and only that counts.

use crate::hash::sha256;
use crate::utc::UtcTime;

/// Longest name of a folder, without its hash.
const LONGEST: usize = 60;
/// Hexadecimal digits of a hash in a name.
const DIGITS: usize = 8;

/// Names that Windows keeps for devices, with any ending.
const RESERVED: [&str; 4] = ["con", "prn", "aux", "nul"];
/// The same with a digit behind.
const NUMBERED: [&str; 2] = ["com", "lpt"];

/// The folder of a sensor: its id, if that is a name for every file system; else with `_` in place
/// of other characters and the beginning of its SHA-256 behind, so that two ids have two folders.
pub(super) fn folder_name(id: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    let mut name: String = id
        .chars()
        .take(LONGEST)
        .map(|c| if plain(c) { c } else { '_' })
        .collect();
    // A dot in front hides a folder, or leads out of the store; Windows drops one at the end.
    if name.starts_with('.') {
        name.replace_range(..1, "_");
    }
    if name.ends_with('.') {
        name.pop();
        name.push('_');
    }
    if is_reserved(&name) {
        name.insert(0, '_');
    }
    if name == id {
        return name;
    }
    format!("{name}-{}", short(&sha256(id.as_bytes())))
}

fn is_reserved(name: &str) -> bool {
    let stem = name.split('.').next().unwrap_or("").to_ascii_lowercase();
    let numbered = || {
        let device = NUMBERED.iter().find_map(|d| stem.strip_prefix(d));
        device.is_some_and(|n| n.len() == 1 && n.bytes().all(|b| b.is_ascii_digit()))
    };
    RESERVED.contains(&stem.as_str()) || numbered()
}

/// The file of a calibration: its time, and the beginning of the hash of its contents, so that two
/// of the same second are two files.
pub(super) fn file_name(time: UtcTime, fingerprint: &str) -> String {
    format!("{}-{}.json", time.in_file_name(), short(fingerprint))
}

/// The end of the names of all files with these contents.
pub(super) fn file_ending(fingerprint: &str) -> String {
    format!("-{}.json", short(fingerprint))
}

fn short(hash: &str) -> &str {
    hash.get(..DIGITS).unwrap_or(hash)
}

/// Sensor and time in the name of a file of imucal: `ID_2026-03-09_10-15.json`.
pub(super) fn imucal_name(name: &str) -> Option<(&str, UtcTime)> {
    const TIME: usize = "2026-03-09_10-15".len();
    let stem = name.strip_suffix(".json")?;
    let at = stem.len().checked_sub(TIME)?;
    let id = stem.get(..at)?.strip_suffix('_')?;
    let (date, clock) = stem.get(at..)?.split_once('_')?;
    let time = format!("{date}T{}:00Z", clock.replace('-', ":"));
    (!id.is_empty()).then_some((id, time.parse().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn plain_ids_are_their_folders() {
        for id in ["left-foot", "MOS2D12345678", "00B4.1234", "a"] {
            assert_eq!(folder_name(id), id);
        }
    }

    #[test]
    fn others_cannot_leave_the_store_or_meet() {
        for (id, begins) in [
            ("..", "__-"),
            ("../../etc", "_._.._etc-"),
            ("/root", "_root-"),
            ("C:\\x", "C__x-"),
            ("a b", "a_b-"),
            ("a/b", "a_b-"),
            ("nul", "_nul-"),
            ("COM7.txt", "_COM7.txt-"),
            ("left.", "left_-"),
            ("ß", "_-"),
            ("a\nb\0", "a_b_-"),
        ] {
            let name = folder_name(id);
            assert!(name.starts_with(begins), "{id:?}: {name}");
            assert_eq!(name.len(), begins.len() + DIGITS, "{id:?}: {name}");
        }
        assert_ne!(folder_name("a b"), folder_name("a/b"));
        assert!(folder_name(&"x".repeat(5000)).len() < 80);
    }

    proptest! {
        #[test]
        fn every_folder_is_one_plain_name(id in ".+") {
            let name = folder_name(&id);
            let plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
            prop_assert!(name.chars().all(plain) && !name.starts_with('.') && !name.ends_with('.'));
            prop_assert!(!is_reserved(&name) && (1..80).contains(&name.len()));
        }
    }

    #[test]
    fn names_of_imucal() {
        let (id, time) = imucal_name("a45f_2020-08-12_13-21.json").unwrap();
        assert_eq!(
            (id, time.to_string().as_str()),
            ("a45f", "2020-08-12T13:21:00Z")
        );
        for other in [
            "2020-08-12_13-21.json",
            "a_2020-13-12_13-21.json",
            "cal.json",
            "ä.json",
            "a_.json",
        ] {
            assert!(imucal_name(other).is_none(), "{other}");
        }
    }
}
