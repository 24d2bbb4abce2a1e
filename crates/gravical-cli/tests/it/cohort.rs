//! Many runs into one folder, on one machine or on many: together they are one run, and `collect` says
//! what became of every recording.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::each::{ends_with, fleet, results, rows};
use crate::support::*;

/// What `collect` says of the folder `out`.
fn collected(at: &Path, options: &str, code: i32) -> Value {
    let (out, _) = ends_with(at, &format!("collect out --json {options}"), code);
    serde_json::from_str(&out).unwrap()
}

#[test]
fn shards_together_are_one_run() {
    let folder = fleet(4);
    let at = folder.path();
    write(at, "fleet/broken.csv", "t,ax,ay,az\n1,2\n");
    let line = "calibrate --each fleet --gravity 9.81";
    ends_with(at, &format!("{line} -o whole --summary whole.json"), 4);
    for (shard, code) in [("1/3", 4), ("2/3", 0)] {
        ends_with(at, &format!("{line} -o out --shard {shard}"), code);
    }
    // The third has not begun: how many are missing is known, and which shard.
    let cohort = collected(at, "", 4);
    let counts = &cohort["counts"];
    let of = |key: &str| counts[key].as_u64().unwrap();
    assert_eq!(
        [
            of("items"),
            of("done"),
            of("error"),
            of("missing"),
            of("unnamed")
        ],
        [5, 3, 1, 1, 1]
    );
    assert_eq!(cohort["missing_shards"], serde_json::json!(["3/3"]));
    ends_with(at, &format!("{line} -o out --shard 3/3"), 0);
    let cohort = collected(at, "-o all.json --report all.html", 4);
    assert_eq!(cohort["counts"]["missing"], 0);
    assert_eq!(cohort["errors"][0]["code"], "no-rows");
    assert!(
        results(&at.join("out")) == {
            let mut whole = results(&at.join("whole"));
            for (_, bytes) in &mut whole {
                *bytes = String::from_utf8(bytes.clone())
                    .unwrap()
                    .replace("whole/", "out/")
                    .into_bytes();
            }
            whole
        }
    );
    let mut whole = rows(&at.join("whole.json"));
    whole.sort_by_key(|row| row["name"].as_str().unwrap().to_owned());
    for row in &mut whole {
        if let Some(result) = row["result"].as_str() {
            row["result"] = result.replace("whole/", "out/").into();
        }
    }
    assert_eq!(rows(&at.join("all.json")), whole);
    // The distribution is that of the rows.
    let mut biases: Vec<f64> = whole.iter().filter_map(|r| r["bias_x"].as_f64()).collect();
    biases.sort_by(f64::total_cmp);
    let all = cohort["distributions"].as_array().unwrap();
    let bias = all.iter().find(|d| d["name"] == "bias_x").unwrap();
    assert_eq!(bias["values"], 4);
    close(
        bias["median"].as_f64().unwrap(),
        0.5 * (biases[1] + biases[2]),
        1e-15,
    );
    close(bias["max"].as_f64().unwrap(), biases[3], 0.0);
    // A page leads to the results from where it is.
    let page = fs::read_to_string(at.join("all.html")).unwrap();
    assert!(page.contains("href=\"out/unit-1.json\""));
    // Another number of shards continues, and begins nothing again.
    let (_, err) = ends_with(at, &format!("{line} -o out --shard 2/2 --resume"), 0);
    assert!(
        err.contains("2 sessions: 2 done; 2 of them by an earlier run"),
        "{err}"
    );
}

#[test]
fn two_lists_share_a_folder_and_replace_nothing_of_each_other() {
    let folder = fleet(3);
    let at = folder.path();
    ends_with(at, "calibrate --each fleet -o out", 0);
    fs::create_dir(at.join("other")).unwrap();
    for (from, to) in [("2", "unit-1"), ("2", "a"), ("3", "b")] {
        let to = at.join(format!("other/{to}.csv"));
        fs::copy(at.join(format!("fleet/unit-{from}.csv")), to).unwrap();
    }
    let before = results(&at.join("out"));
    // The names in order: a, b, unit-1. Of the second shard is b.
    let line = "calibrate --each other -o out --resume --shard 1/2";
    let (out, _) = ends_with(at, line, 4);
    assert!(
        out.contains("another recording of this name, ") && out.contains("fleet/unit-1.csv"),
        "{out}"
    );
    let after = results(&at.join("out"));
    assert!(before.iter().all(|file| after.contains(file)), "replaced");
    let cohort = collected(at, "", 4);
    assert_eq!(
        (&cohort["counts"]["unnamed"], &cohort["missing_shards"]),
        (&1.into(), &serde_json::json!(["2/2"]))
    );
}

#[test]
#[cfg(unix)]
fn what_an_interrupted_run_leaves_is_missing_by_name() {
    let folder = fleet(3);
    let at = folder.path();
    // One after the other, so that the last row is that of the last one.
    ends_with(at, "calibrate --each fleet -o out --threads 1", 0);
    let journal = at.join("out/calibrate.journal.ndjson");
    let text = fs::read_to_string(&journal).unwrap();
    // As after a power cut: the last row is torn, and the result of the second is gone.
    fs::write(&journal, &text[..text.len() - 20]).unwrap();
    fs::remove_file(at.join("out/unit-2.json")).unwrap();
    let cohort = collected(at, "-o all.csv", 4);
    assert_eq!(
        (&cohort["counts"]["done"], &cohort["counts"]["missing"]),
        (&1.into(), &2.into())
    );
    assert_eq!(
        cohort["errors"][0]["examples"],
        serde_json::json!(["unit-2", "unit-3"])
    );
    let table = fs::read_to_string(at.join("all.csv")).unwrap();
    assert!(table.contains("unit-3,fleet/unit-3.csv,error,,"), "{table}");
    ends_with(at, "calibrate --each fleet -o out --resume", 0);
    assert_eq!(collected(at, "", 0)["counts"]["done"], 3);
}

#[test]
fn sensors_that_changed_and_mixed_options_are_said() {
    let folder = fleet(3);
    let at = folder.path();
    // Two recordings of one sensor that is not the same any more, and two of one that is.
    for (name, from, id) in [
        ("a-1", 1, "A-1"),
        ("a-2", 2, "A-1"),
        ("b-1", 3, "B-1"),
        ("b-2", 3, "B-1"),
    ] {
        let text = fs::read_to_string(at.join(format!("fleet/unit-{from}.csv"))).unwrap();
        fs::create_dir_all(at.join("more")).unwrap();
        write(
            at,
            &format!("more/{name}.csv"),
            &format!("# Serial Number: {id}\n# {name}\n{text}"),
        );
    }
    ends_with(at, "calibrate --each more -o out", 0);
    let cohort = collected(at, "", 0);
    assert_eq!(cohort["repeated_sensors"], 2);
    let changed = cohort["changed_sensors"].as_array().unwrap();
    assert_eq!(changed.len(), 1, "{changed:?}");
    assert_eq!(changed[0]["items"], serde_json::json!(["a-1", "a-2"]));
    ends_with(
        at,
        "calibrate --each fleet -o out --gravity 9.7 --resume",
        0,
    );
    let (out, _) = ends_with(at, "collect out", 0);
    assert!(
        out.contains("2 different versions or options") && out.contains("--gravity=9.7"),
        "{out}"
    );
}

#[test]
fn commands_are_collected_one_at_a_time() {
    let folder = fleet(1);
    let at = folder.path();
    fs::create_dir(at.join("out")).unwrap();
    let refused = |options: &str| run_in(at, words(&format!("collect out --json {options}")));
    assert_eq!(
        (refused("").code, refused("").error_code().as_str()),
        (3, "no-journal")
    );
    ends_with(at, "calibrate --each fleet -o out", 0);
    ends_with(
        at,
        "noise --each fleet --summary out/noise.csv --rate 25",
        4,
    );
    assert_eq!(
        (refused("").code, refused("").error_code().as_str()),
        (2, "collect-command")
    );
    let noise = collected(at, "--command noise", 4);
    assert_eq!(noise["errors"][0]["code"], "not-at-rest");
    assert_eq!(collected(at, "--command calibrate", 0)["counts"]["done"], 1);
    assert_eq!(refused("--command apply").error_code(), "no-journal");
    fs::write(at.join("out/x.journal.ndjson"), "{}\n").unwrap();
    assert_eq!(refused("").error_code(), "journal-syntax");
}

/// A script of the queues in `examples/cohort`.
#[cfg(unix)]
fn script(name: &str) -> std::path::PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    root.join("examples/cohort").join(name)
}

/// A shell with the program in its path, in a folder with the list of `fleet`.
#[cfg(unix)]
fn shell(at: &Path, name: &str) -> std::process::Command {
    let mut list = String::new();
    for entry in fs::read_dir(at.join("fleet")).unwrap() {
        list.push_str(&format!("{}\n", entry.unwrap().path().display()));
    }
    write(at, "list.txt", &list);
    let own = program().parent().unwrap().to_owned();
    let path = std::env::var("PATH").unwrap();
    let mut command = std::process::Command::new(name);
    command
        .current_dir(at)
        .env("PATH", format!("{}:{}:{path}", at.display(), own.display()));
    command
}

#[test]
#[cfg(unix)]
fn scripts_of_the_queues_do_all_shards() {
    let folder = fleet(4);
    let at = folder.path();
    write(at, "fleet/broken.csv", "t,ax,ay,az\n1,2\n");
    let yaml = fs::read_to_string(script("kubernetes.yaml")).unwrap();
    // The block of the command, as YAML reads it.
    let (_, block) = yaml.split_once("            - |\n").unwrap();
    let (block, _) = block.split_once("          resources:").unwrap();
    let block = block
        .replace("@/data/list.txt", "@list.txt")
        .replace("/data/out", "out-kubernetes");
    for task in 0..3 {
        let number = (task + 1).to_string();
        let ended = shell(at, "/bin/sh")
            .args(["-c", &block])
            .env("JOB_COMPLETION_INDEX", task.to_string())
            .env("SHARDS", "3")
            .status();
        assert!(ended.unwrap().success());
        for (name, variables) in [
            (
                "slurm",
                [
                    ("SLURM_ARRAY_TASK_ID", &*number),
                    ("SLURM_ARRAY_TASK_COUNT", "3"),
                ],
            ),
            ("sge", [("SGE_TASK_ID", &*number), ("SGE_TASK_LAST", "3")]),
        ] {
            let mut job = shell(at, "bash");
            job.arg(script(&format!("{name}.sh"))).envs(variables);
            let ended = job.args(["list.txt", &format!("out-{name}")]).status();
            assert!(ended.unwrap().success(), "{name} {number}");
        }
    }
    for name in ["slurm", "sge", "kubernetes"] {
        let (out, _) = ends_with(at, &format!("collect out-{name}"), 4);
        assert!(
            out.contains("5 recordings: 4 done, 1 failed"),
            "{name}: {out}"
        );
    }
}

#[test]
#[cfg(unix)]
fn the_demonstration_ends_in_a_report() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for _ in 0..2 {
        let mut demo = std::process::Command::new(script("demo.sh"));
        let demo = demo.arg(at).arg("3").env("GRAVICAL", program());
        let done = demo.output().unwrap();
        assert!(done.status.success(), "{done:?}");
    }
    assert_eq!(collected(at, "", 0)["counts"]["items"], 3);
    assert!(at.join("cohort.html").exists() && at.join("cohort.csv").exists());
}

#[test]
#[cfg(unix)]
fn a_job_whose_time_is_up_is_queued_again_and_continues() {
    let folder = fleet(1);
    let at = folder.path();
    for i in 0..300 {
        let copy = at.join(format!("fleet/copy-{i}.csv"));
        fs::copy(at.join("fleet/unit-1.csv"), copy).unwrap();
    }
    // The program of Slurm that queues a job again.
    write(at, "scontrol", "#!/bin/sh\necho \"$@\" > queued\n");
    let mode = std::os::unix::fs::PermissionsExt::from_mode(0o755);
    fs::set_permissions(at.join("scontrol"), mode).unwrap();
    let out = |name: &str| at.join(format!("out-{name}"));
    let job = |name: &str| {
        let mut job = shell(at, "bash");
        job.arg(script(&format!("{name}.sh")))
            .args(["list.txt".as_ref(), out(name).as_os_str()]);
        job.env("SLURM_ARRAY_TASK_ID", "1")
            .env("SLURM_ARRAY_TASK_COUNT", "1")
            .env("SLURM_ARRAY_JOB_ID", "77")
            .env("SGE_TASK_ID", "1")
            .env("SGE_TASK_LAST", "1");
        // A queue signals the shell, or all processes of the job.
        std::os::unix::process::CommandExt::process_group(&mut job, 0);
        job
    };
    for (name, signal, whom, code) in [("slurm", "TERM", "", 0), ("sge", "USR2", "-", 99)] {
        let mut run = job(name).spawn().unwrap();
        while fs::read_dir(out(name)).map_or(0, Iterator::count) < 5 {
            std::thread::sleep(std::time::Duration::from_millis(2));
            assert!(run.try_wait().unwrap().is_none());
        }
        let target = format!("{whom}{}", run.id());
        let kill = std::process::Command::new("kill")
            .args(["-s", signal, "--", &target])
            .status();
        assert!(kill.unwrap().success());
        assert_eq!(run.wait().unwrap().code(), Some(code), "{name}");
        let collect = |code| {
            let line = format!("collect out-{name} --json");
            let (out, _) = ends_with(at, &line, code);
            serde_json::from_str::<Value>(&out).unwrap()["counts"].clone()
        };
        let counts = collect(4);
        assert!(counts["missing"].as_u64().unwrap() > 0, "{name}: {counts}");
        assert!(counts["done"].as_u64().unwrap() > 3, "{name}: {counts}");
        assert!(job(name).status().unwrap().success());
        let counts = collect(0);
        let whole = (&counts["done"], &counts["missing"]);
        assert_eq!(whole, (&301.into(), &0.into()), "{name}");
    }
    let queued = fs::read_to_string(at.join("queued")).unwrap();
    assert_eq!(queued, "requeue 77_1\n");
}
