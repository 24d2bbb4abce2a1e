//! Every file of the folder with real recordings goes through `inspect`: no
//! crash, every line accounted for, and findings that are true.

use std::path::{Path, PathBuf};

use crate::support::*;

const ENDINGS: [&str; 6] = ["csv", "tsv", "log", "txt", "gz", "cwa"];

/// Every file under `folder` that may be a recording.
pub fn files(folder: &Path) -> Vec<PathBuf> {
    let mut all = below(folder);
    all.retain(|path| {
        let ending = path.extension().and_then(|e| e.to_str());
        ending.is_some_and(|ending| ENDINGS.contains(&ending))
    });
    all
}

#[test]
#[ignore = "slow: all recordings"]
fn no_file_of_the_folder_crashes_and_every_account_balances() {
    let Some(data) = data() else { return };
    let mut read = 0;
    for path in &files(&data) {
        let run = run(["inspect".as_ref(), path.as_os_str(), "--json".as_ref()]);
        let name = path.display();
        assert!([0, 3].contains(&run.code), "{name}: {}", run.code);
        assert!(run.err.is_empty(), "{name}: {}", run.err);
        let value = run.json();
        let recordings = value["recordings"].as_array().unwrap();
        let errors = value["errors"].as_array().unwrap();
        assert_eq!(recordings.len() + errors.len(), 1, "{name}");
        assert_eq!(run.code == 0, errors.is_empty(), "{name}");
        for error in errors {
            assert!(error["hint"].is_string(), "{name}: {error}");
        }
        for recording in recordings {
            read += 1;
            let account = &recording["row_counts"];
            let aside = account["aside"].as_array().unwrap().iter();
            let aside: u64 = aside.map(|a| a[1].as_u64().unwrap()).sum();
            let [lines, rows] = ["lines", "rows"].map(|key| account[key].as_u64().unwrap());
            assert_eq!(lines, rows + aside, "{name}");
            let own = gravical::recording::read(path, &Default::default()).unwrap();
            assert!(own.is_averaged() || own.rows() as u64 == rows, "{name}");
            assert!(rows > 0, "{name}");
        }
    }
    assert_eq!(read, 34, "recordings");
}
