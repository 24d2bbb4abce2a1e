//! `--report`: where it goes, and what it leaves alone. What is in it is held against the
//! JSON by the library's tests and by `tests/browser`.

use gravical::calibration_file::{InputFile, InputRole};

use crate::support::*;

/// Each row of the table of files: path, what it was used as, SHA-256.
fn files(page: &str) -> Vec<[String; 3]> {
    let table = page.split("id=\"provenance\"").nth(1).unwrap();
    let body = table.split("<tbody>").nth(1).unwrap();
    let cells = |row: &str| -> [String; 3] {
        let text: Vec<String> = row
            .split(['<', '>'])
            .skip(1)
            .step_by(2)
            .filter(|t| !t.is_empty())
            .map(str::to_owned)
            .collect();
        text.try_into().unwrap()
    };
    let body = body.split("</tbody>").next().unwrap();
    body.split("<tr>")
        .skip(1)
        .map(|r| cells(&format!("p>{r}")))
        .collect()
}

fn sha256(path: &std::path::Path) -> String {
    let bytes = std::fs::read(path).unwrap();
    InputFile::read(path, InputRole::Other, |b| {
        assert_eq!(b, bytes);
        Ok(())
    })
    .unwrap()
    .1
    .sha256
    .unwrap()
}

#[test]
fn a_motion_names_and_sums_everything_that_went_in() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    crate::motion::line(path);
    // The gyroscope in a file of its own, and poses of its own moves.
    let all = std::fs::read_to_string(path.join("line/line.csv")).unwrap();
    let pick = |columns: &[usize]| -> String {
        let rows = all.lines().filter(|l| !l.starts_with('#'));
        rows.map(|l| {
            let cells: Vec<&str> = l.split(',').collect();
            let own: Vec<&str> = columns.iter().map(|c| cells[*c]).collect();
            own.join(",") + "\n"
        })
        .collect()
    };
    write(path, "accel.csv", &pick(&[0, 1, 2, 3]));
    write(path, "gyro.csv", &pick(&[0, 5, 6, 7]));
    let rows = (0..2000).map(|i| {
        let t = 0.01 * f64::from(i);
        format!(
            "{t:.2},0,{:.4},0\n",
            0.7 * ((t - 6.0) / 2.0).clamp(0.0, 1.0)
        )
    });
    write(
        path,
        "truth.csv",
        &format!("t_s,px_m,py_m,pz_m\n{}", rows.collect::<String>()),
    );
    let run = run_in(
        path,
        words(
            "motion accel.csv --gyro gyro.csv -c cal.json --truth truth.csv --report r.html --json",
        ),
    );
    assert_eq!(run.code, 0, "{}", run.err);
    let page = std::fs::read_to_string(path.join("r.html")).unwrap();
    let wanted = [
        ("accel.csv", "recording"),
        ("gyro.csv", "gyroscope"),
        ("cal.json", "calibration"),
        ("truth.csv", "reference"),
    ]
    .map(|(name, role)| [name.to_owned(), role.to_owned(), sha256(&path.join(name))]);
    assert_eq!(files(&page), wanted);
    // The reference may stand in the recording itself.
    let both = pick(&[0, 1, 2, 3, 1, 2, 3]).replacen(
        "aX (m/s^2),aY (m/s^2),aZ (m/s^2)\n",
        "px_m,py_m,pz_m\n",
        1,
    );
    write(path, "both.csv", &both);
    let run = run_in(
        path,
        words("motion both.csv --truth both.csv --report b.html --json"),
    );
    assert!(run.code == 0 || run.code == 4, "{}{}", run.out, run.err);
    let page = std::fs::read_to_string(path.join("b.html")).unwrap();
    let sum = sha256(&path.join("both.csv"));
    let row = |role: &str| ["both.csv".to_owned(), role.to_owned(), sum.clone()];
    assert_eq!(files(&page), [row("recording"), row("reference")]);
}

#[test]
fn a_calibration_names_and_sums_everything_that_went_in() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let made = run_in(
        path,
        words("simulate static -o soak --soak 45,5 --duration 300 --rate 50 --quiet"),
    );
    assert_eq!(made.code, 0, "{}", made.err);
    let mut session = String::from("t_ms,ax,ay,az\n");
    let mut list = String::from("label,start,end\n");
    let sensor = Sensor::default();
    for (i, (name, up)) in FACES.iter().enumerate() {
        let text = sensor.file(*up, 300, 100 + i as u64);
        let rows: Vec<&str> = text
            .lines()
            .filter(|l| l.starts_with(|c: char| c.is_ascii_digit()))
            .collect();
        list.push_str(&format!("{name},{},{}\n", 300 * i, 300 * (i + 1)));
        for (k, row) in rows.iter().enumerate() {
            let cells: Vec<&str> = row.split(',').collect();
            session.push_str(&format!(
                "{},{}\n",
                10 * (300 * i + k),
                cells[1..4].join(",")
            ));
        }
    }
    write(path, "session.csv", &session);
    write(path, "list.csv", &list);
    let run = run_in(
        path,
        words(
            "calibrate session.csv --sections list.csv --thermal soak/static.csv --report r.html -o cal.json --json",
        ),
    );
    assert!(run.code == 0 || run.code == 4, "{}{}", run.out, run.err);
    let file = run.calibration();
    let wanted = [
        ("session.csv", "recording"),
        ("list.csv", "sections"),
        ("soak/static.csv", "soak"),
    ];
    for (input, (name, role)) in file["inputs"].as_array().unwrap().iter().zip(wanted) {
        assert_eq!(
            (&input["path"], &input["role"]),
            (&name.into(), &role.into())
        );
        assert_eq!(input["sha256"], sha256(&path.join(name)));
    }
    assert_eq!(file["inputs"].as_array().unwrap().len(), 3);
    assert_eq!(file["temperature_model"]["inputs"][0]["role"], "soak");
    let page = std::fs::read_to_string(path.join("r.html")).unwrap();
    let shown =
        wanted.map(|(name, role)| [name.to_owned(), role.to_owned(), sha256(&path.join(name))]);
    assert_eq!(files(&page), shown);
    // A list and a soak are no recordings of the session.
    assert!(page.contains("<title>Calibration of session.csv"));

    // The same list beside another recording: nothing of the data is shared.
    write(path, "other.csv", &session.replacen("t_ms", "time_ms", 1));
    let run = run_in(
        path,
        words("calibrate other.csv --sections list.csv --prior off -o other.json --json"),
    );
    assert!(run.code == 0 || run.code == 4, "{}{}", run.out, run.err);
    let run = run_in(path, words("compare cal.json other.json --json"));
    assert!(!run.out.contains("same-recordings"), "{}", run.out);
}

/// Every verb that has a document writes it in both forms.
#[test]
fn every_verb_reports() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    crate::motion::line(path);
    let lines = [
        "check cal.json line/line.csv",
        "compare cal.json cal.json",
        "inspect line/line.csv",
        "denoise line/line.csv --filter mean:5 -o smooth.csv",
        "calibrate poses/poses.csv",
        "motion line/line.csv -c cal.json -o moved.csv",
    ];
    for (i, line) in lines.iter().enumerate() {
        for ending in ["html", "md"] {
            let name = format!("report{i}.{ending}");
            let line = format!("{line} --report {name} --force --json");
            let run = run_in(path, words(&line));
            assert!(
                run.code == 0 || run.code == 4,
                "{line}{}{}",
                run.out,
                run.err
            );
            let text = std::fs::read_to_string(path.join(&name)).unwrap();
            assert!(
                text.contains("line.csv")
                    || text.contains("cal.json")
                    || text.contains("poses.csv")
            );
            assert!(text.contains(&format!("report{i}")), "its command: {line}");
            // Every figure that Markdown links to is there.
            for link in text.split("](<").skip(1).filter(|_| ending == "md") {
                let link = link.split(">)").next().unwrap();
                assert!(link.starts_with(&format!("report{i}_figures/")), "{link}");
                assert!(path.join(link).is_file(), "{link}");
            }
            let figures = path.join(format!("report{i}_figures")).is_dir();
            assert_eq!(figures, ending == "md" && i > 3, "{line}");
        }
    }
    // Figures of an earlier report are not left beside one without figures.
    let line = "check cal.json line/line.csv --report report4.md --force";
    assert!([0, 4].contains(&run_in(path, words(line)).code));
    assert!(!path.join("report4_figures").exists());
    let two = run_in(
        path,
        words("inspect line/line.csv poses/poses.csv --report two.md --json"),
    );
    assert_eq!((two.code, two.error_code().as_str()), (2, "report-of-one"));
    // Other files of the folder stay.
    std::fs::write(path.join("report5_figures/notes.txt"), "mine").unwrap();
    let line = "motion line/line.csv -o n.csv --report report5.md --force --json";
    assert!([0, 4].contains(&run_in(path, words(line)).code));
    assert!(path.join("report5_figures/notes.txt").exists());
}
