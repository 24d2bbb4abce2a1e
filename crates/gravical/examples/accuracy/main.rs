//! How accurate the estimators are, over hundreds of simulated parts: the tables
//! of `docs/accuracy.md`.
//!
//! ```console
//! $ cargo run --release --example accuracy -- --write docs/accuracy.md
//! ```
//!
//! Options: `--sensors N` (1000), `--seed S` (1), `--only NAME`, and `--write FILE`
//! to put the tables into a file between their marks. Without it they are printed.

mod each;
#[path = "../../../../tests/support/means.rs"]
#[allow(dead_code, reason = "others use more of it")]
mod means;
mod runs;
mod table;
mod tables;

use tables::Runs;

type Table = fn(Runs) -> String;

const TABLES: [(&str, Table); 6] = [
    ("estimators", tables::estimators),
    ("intervals", tables::intervals),
    ("tilts", tables::tilts),
    ("table-not-level", tables::table_not_level),
    ("roles", tables::roles),
    ("bad-pose", tables::bad_pose),
];

struct Arguments {
    runs: Runs,
    only: Option<String>,
    write: Option<String>,
}

fn arguments() -> Result<Arguments, String> {
    let mut out = Arguments {
        runs: Runs {
            count: 1000,
            seed: 1,
        },
        only: None,
        write: None,
    };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let value = words.next().ok_or(format!("{word} needs a value"))?;
        let number = || {
            value
                .parse()
                .map_err(|_| format!("{word} {value}: a whole number"))
        };
        match word.as_str() {
            "--sensors" => out.runs.count = number()?,
            "--seed" => out.runs.seed = number()? as u64,
            "--only" => out.only = Some(value),
            "--write" => out.write = Some(value),
            _ => return Err(format!("{word}: not an option")),
        }
    }
    Ok(out)
}

/// Replaces what stands between `<!-- NAME -->` and the next empty comment mark.
fn put(text: &str, name: &str, table: &str) -> Option<String> {
    let mark = format!("<!-- {name} -->\n");
    let start = text.find(&mark)? + mark.len();
    let end = start + text[start..].find("<!-- end -->")?;
    Some(format!("{}{table}{}", &text[..start], &text[end..]))
}

fn run() -> Result<(), String> {
    let arguments = arguments()?;
    for (name, table) in TABLES {
        if arguments.only.as_ref().is_some_and(|only| only != name) {
            continue;
        }
        eprintln!("{name}: {} sensors a cell …", arguments.runs.count);
        let made = table(arguments.runs);
        let Some(path) = &arguments.write else {
            println!("{name}\n\n{made}");
            continue;
        };
        let text = std::fs::read_to_string(path).map_err(|e| format!("{path}: {e}"))?;
        let text = put(&text, name, &made).ok_or(format!("{path} has no place for {name}"))?;
        std::fs::write(path, text).map_err(|e| format!("{path}: {e}"))?;
    }
    Ok(())
}

fn main() -> std::process::ExitCode {
    match run() {
        Ok(()) => std::process::ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("{why}");
            std::process::ExitCode::from(2)
        }
    }
}
