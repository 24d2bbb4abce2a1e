//! What the page computes is what the program computes: every verb, and every small input that once went wrong.
//! GRAVICAL names the program, GRAVICAL_DATA the real recordings; without them the tests say so.

#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};
use std::process::Command;

use gravical_web::App;
use serde_json::{Value, json};

fn program() -> Option<PathBuf> {
    let program = std::env::var_os("GRAVICAL").map(PathBuf::from);
    if program.is_none() {
        eprintln!("skipped: GRAVICAL names no program");
    }
    program
}

/// The answer to a verb with these files, and the files in it.
fn asked(
    verb: &str,
    options: Value,
    files: &[(&str, &str, Vec<u8>)],
) -> (Value, Vec<(String, Vec<u8>)>) {
    told(
        &mut App::default(),
        json!({ "do": verb, "options": options }),
        files,
    )
}

/// The answer of this instance.
fn told(
    app: &mut App,
    mut head: Value,
    files: &[(&str, &str, Vec<u8>)],
) -> (Value, Vec<(String, Vec<u8>)>) {
    let names = files
        .iter()
        .map(|(role, name, bytes)| json!({ "name": name, "role": role, "size": bytes.len() }));
    let names: Vec<Value> = names.collect();
    head["files"] = names.into();
    let head = head.to_string();
    let mut message = (head.len() as u32).to_le_bytes().to_vec();
    message.extend(head.as_bytes());
    message.extend(files.iter().flat_map(|(_, _, bytes)| bytes));
    let answer = app.call(&message);
    let size = u32::from_le_bytes(answer[..4].try_into().unwrap()) as usize;
    let (head, mut rest) = answer[4..].split_at(size);
    let head: Value = serde_json::from_slice(head).unwrap();
    let written = head["files"].as_array().unwrap().iter().map(|file| {
        let (bytes, others) = rest.split_at(file["size"].as_u64().unwrap() as usize);
        rest = others;
        (file["name"].as_str().unwrap().to_owned(), bytes.to_vec())
    });
    let written = written.collect();
    (head, written)
}

/// What the program prints as JSON, or the code of its error; and whether it ends with 4.
fn printed(program: &Path, folder: &Path, line: &str) -> (Result<Value, String>, bool) {
    let done = Command::new(program)
        .args(line.split(' '))
        .current_dir(folder)
        .output()
        .unwrap();
    let printed: Value = serde_json::from_slice(&done.stdout).unwrap_or_default();
    let value = match done.status.code() {
        Some(0 | 4) => Ok(printed),
        _ => Err(printed["code"].as_str().unwrap_or_default().to_owned()),
    };
    (value, done.status.code() == Some(4))
}

/// Without the time and the command.
fn bare(mut value: Value) -> Value {
    // Which calibration a folder gave is the program's to say.
    for name in ["command", "created", "calibration"] {
        value.as_object_mut().map(|object| object.remove(name));
    }
    value
}

/// Compares an answer with the program's.
fn same(
    what: &str,
    (head, _): &(Value, Vec<(String, Vec<u8>)>),
    (value, is_poor): (Result<Value, String>, bool),
) {
    match value {
        Ok(value) => {
            assert_eq!(head["error"], Value::Null, "{what}");
            let (own, other) = (bare(head["result"].clone()), bare(value));
            let differs = other
                .as_object()
                .into_iter()
                .flatten()
                .find(|(k, v)| own.get(k) != Some(v));
            assert!(
                own == other,
                "{what}: {differs:?} {:?}",
                differs.map(|(k, _)| &own[k])
            );
            assert_eq!(head["is_poor"], json!(is_poor), "{what}");
        }
        Err(code) => assert_eq!(head["error"]["code"], json!(code), "{what}"),
    }
}

#[test]
fn verbs_are_those_of_the_program() {
    let Some(program) = program() else { return };
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/demo");
    let work = std::env::temp_dir().join(format!("gravical-web-{}", std::process::id()));
    std::fs::create_dir_all(&work).unwrap();
    for name in ["poses/poses.csv", "line/line.csv"] {
        std::fs::copy(
            folder.join(name),
            work.join(Path::new(name).file_name().unwrap()),
        )
        .unwrap();
    }
    let file = |role: &'static str, name: &'static str| {
        (role, name, std::fs::read(work.join(name)).unwrap())
    };
    let g = json!({ "gravity": 9.80665 });
    let made = asked("calibrate", g.clone(), &[file("", "poses.csv")]);
    let line = "calibrate poses.csv --gravity 9.80665 -o cal.json --report r.html --json";
    same("calibrate", &made, printed(&program, &work, line));
    // The report is that of the program, but for command and time.
    let page = |bytes: &[u8]| {
        let text = String::from_utf8_lossy(bytes).into_owned();
        let text = text.replace("cal.json", "calibration.json");
        let is_own = |line: &&str| !line.contains("computed 2") && !line.contains("<footer>");
        text.lines().filter(is_own).collect::<Vec<_>>().join("\n")
    };
    let report = std::fs::read(work.join("r.html")).unwrap();
    assert!(page(&made.1[0].1) == page(&report));
    let cal = || {
        (
            "calibration",
            "cal.json",
            std::fs::read(work.join("cal.json")).unwrap(),
        )
    };
    let move_ = || file("", "line.csv");
    let calls = [
        (
            "motion",
            json!({}),
            vec![move_(), cal()],
            "motion line.csv -c cal.json -o t.csv --json",
        ),
        (
            "orient",
            json!({}),
            vec![move_(), cal()],
            "orient line.csv -c cal.json -o t.csv --json",
        ),
        (
            "check",
            g.clone(),
            vec![cal(), move_()],
            "check cal.json line.csv --gravity 9.80665 --json",
        ),
        (
            "compare",
            json!({}),
            vec![cal(), cal()],
            "compare cal.json cal.json --json",
        ),
        (
            "apply",
            json!({}),
            vec![cal(), move_()],
            "apply cal.json line.csv -o t.csv --json",
        ),
        (
            "convert",
            json!({}),
            vec![move_()],
            "convert line.csv -o t.csv --json",
        ),
        (
            "denoise",
            json!({ "filter": ["butter:4,5Hz"] }),
            vec![move_()],
            "denoise line.csv -f butter:4,5Hz -o t.csv --json",
        ),
        (
            "noise",
            json!({}),
            vec![file("", "poses.csv")],
            "noise poses.csv --json",
        ),
    ];
    for (verb, options, files, line) in calls {
        let done = asked(verb, options, &files);
        same(
            verb,
            &done,
            printed(
                &program,
                &work,
                &format!("{line} --force")
                    .replace("noise poses.csv --json --force", "noise poses.csv --json"),
            ),
        );
        // The table is the program's, too.
        if line.contains("t.csv") {
            let table = std::fs::read(work.join("t.csv")).unwrap();
            assert!(done.1.iter().any(|(_, bytes)| *bytes == table), "{verb}");
        }
    }
    for target in [
        "c", "arduino", "rust", "python", "ros2", "imucal", "gravical",
    ] {
        let (_, files) = asked("export", json!({ "to": target }), &[cal()]);
        let done = Command::new(&program)
            .args(["export", "cal.json", "--to", target])
            .current_dir(&work)
            .output()
            .unwrap();
        assert!(files[0].1 == done.stdout, "{target}");
    }
    std::fs::remove_dir_all(&work).unwrap();
}

#[test]
fn every_case_is_read_as_the_program_reads_it() {
    let (Some(program), Some(data)) = (program(), std::env::var_os("GRAVICAL_DATA")) else {
        return eprintln!("skipped: GRAVICAL_DATA is not set");
    };
    let mut count = 0;
    let cases = std::fs::read_dir(Path::new(&data).join("../cases"))
        .unwrap()
        .flatten();
    for case in cases.filter(|case| case.path().is_dir()) {
        for file in std::fs::read_dir(case.path()).unwrap().flatten() {
            let name = file.file_name().into_string().unwrap();
            if name.ends_with(".md") || name.contains(' ') || file.path().is_dir() {
                continue;
            }
            let bytes = std::fs::read(file.path()).unwrap();
            let done = asked("calibrate", json!({}), &[("", &name, bytes)]);
            same(
                &name,
                &done,
                printed(&program, &case.path(), &format!("calibrate {name} --json")),
            );
            count += 1;
        }
    }
    assert!(count > 40, "{count}");
}

#[test]
fn whatever_arrives_has_an_answer() {
    for bytes in [
        &b""[..],
        b"\xff\xff\xff\xff",
        b"\x02\0\0\0{}",
        b"\x04\0\0\0null",
        b"\x10\0\0\0{\"do\":\"inspect\"}",
    ] {
        let answer = App::default().call(bytes);
        assert!(answer.len() > 4, "{bytes:?}");
    }
    let (head, _) = asked(
        "calibrate",
        json!({ "gravity": "<b>" }),
        &[("", "<b>.csv", b"\0\xff<script>".to_vec())],
    );
    assert_eq!(head["error"]["code"], json!("usage"));
}

/// A guided session in memory, with a hand that does what is asked for, and the files that it leaves.
fn guided(app: &mut App) -> [Vec<u8>; 4] {
    let options = json!({ "source": "simulate", "name": "simulated MPU6050, seed 4", "seed": 4, "speed": 1.0 });
    let mut files: [Vec<u8>; 4] = Default::default();
    let mut now_s = 0.0;
    let mut tell = |now_s: f64, mut head: Value| {
        head["now_s"] = now_s.into();
        let (head, written) = told(app, head, &[]);
        assert_eq!(head["error"], Value::Null);
        for (name, bytes) in written {
            let names = [
                "recording.csv",
                "session.ndjson",
                "calibration.json",
                "calibration.html",
            ];
            files[names.iter().position(|n| *n == name).unwrap()].extend(bytes);
        }
        head["events"].as_array().unwrap().clone()
    };
    let mut events = tell(now_s, json!({ "do": "open", "options": options }));
    let mut wanted = Value::Null;
    let mut is_good = false;
    loop {
        for event in std::mem::take(&mut events) {
            match event["type"].as_str().unwrap() {
                "next_pose" => wanted = event,
                "verdict" => is_good = event["grade"] == "good",
                "end" => {
                    assert_eq!(event["reason"], "finished", "{event}");
                    return files;
                }
                _ => {}
            }
        }
        let command = match (&wanted["up"], &wanted["faces"][0]) {
            _ if is_good => json!({ "command": "finish" }),
            (Value::Null, Value::Null) => Value::Null,
            (Value::Null, face) => json!({ "command": "hand", "put": face }),
            (up, _) => json!({ "command": "hand", "up": up }),
        };
        if !command.is_null() {
            wanted = Value::Null;
            events = tell(
                now_s,
                json!({ "do": "command", "options": { "command": command } }),
            );
        }
        now_s += 0.1;
        events.extend(tell(now_s, json!({ "do": "tick" })));
        assert!(now_s < 600.0, "it never was good");
    }
}

#[test]
fn a_guided_session_is_calibrated_as_by_the_program() {
    let Some(program) = program() else { return };
    let work = std::env::temp_dir().join(format!("gravical-guided-{}", std::process::id()));
    std::fs::create_dir_all(work.join("s")).unwrap();
    let [recording, journal, calibration, page] = guided(&mut App::default());
    assert!(page.starts_with(b"<!"));
    std::fs::write(work.join("s/recording.csv"), recording).unwrap();
    std::fs::write(work.join("s/session.ndjson"), journal).unwrap();
    let (value, _) = printed(&program, &work, "calibrate s --json -o cal.json");
    let own: Value = serde_json::from_slice(&calibration).unwrap();
    let (own, other) = (bare(own), bare(value.unwrap()));
    for name in ["verdict", "accelerometer", "gyroscope", "poses", "findings"] {
        let other = other[name].to_string().replace("s/recording", "recording");
        assert_eq!(own[name].to_string(), other, "{name}");
    }
    std::fs::remove_dir_all(work).unwrap();
}
