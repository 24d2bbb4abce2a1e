//! The commands of the program on files in memory: options are those of the library, by the names of the program.

use std::path::Path;
use std::slice::from_ref;

use gravical::apply::{ApplyOptions, apply};
use gravical::calibrate::{CalibrateOptions, calibrate};
use gravical::calibration_file::{Calibration, Grade, InputFile, creation_time};
use gravical::check::{CheckOptions, check};
use gravical::compare::compare;
use gravical::convert::{ConvertOptions, convert_file};
use gravical::denoise::{DenoiseOptions, denoise, denoise_file};
use gravical::export::{ExportOptions, TARGETS, Target, export, export_noise};
use gravical::gravity::{Gravity, GravityOptions};
use gravical::inspect::inspect;
use gravical::motion::{Motion, MotionOptions, OrientationJudgement, motion};
use gravical::noise::{noise_of, read_noise};
use gravical::poses::SegmentOptions;
use gravical::poses::sections::read_sections;
use gravical::recording::source::{self, Named};
use gravical::recording::{ReadOptions, Recording, join_gyroscope, read_named, read_samples};
use gravical::session::read_named_session;
use gravical::{Error, Result, TOOL};
use gravical_report::document::Document;
use gravical_report::figure::{self, Figure};
use gravical_report::report;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::message::{File, Message};

/// The result as JSON, and files: a page, a table.
type Done = (Value, Vec<(String, Vec<u8>)>);

/// Runs the verb of a message.
pub fn run(asked: &Message<'_>) -> Result<Done> {
    match asked.verb() {
        "inspect" => inspect_file(asked),
        "calibrate" => calibrate_files(asked),
        "check" => check_files(asked),
        "compare" => compare_files(asked),
        "apply" => apply_file(asked),
        "convert" => convert_to_table(asked),
        "denoise" => filter_file(asked),
        "noise" => measure_noise(asked),
        "motion" => compute_motion(asked),
        "orient" => compute_orientation(asked),
        "export" => export_file(asked),
        "targets" => Ok((targets(), Vec::new())),
        other => Err(Error::usage(
            "usage",
            format!("nothing here does {other:?}"),
        )),
    }
}

/// A result, its page and its other files. `is_poor`: the program ends with exit code 4.
fn done(
    result: &impl Serialize,
    is_poor: bool,
    page: Option<String>,
    files: Vec<(String, Vec<u8>)>,
) -> Done {
    let page = page.map(|html| ("report.html".to_owned(), html.into_bytes()));
    let head = json!({ "result": result, "is_poor": is_poor });
    (head, page.into_iter().chain(files).collect())
}

/// With program, time and inputs.
fn page(document: Document<'_>, inputs: &[InputFile]) -> Option<String> {
    let document = document.with_provenance(TOOL, None, &creation_time(), inputs);
    Some(document.to_html())
}

/// The name of a file without its endings, with another.
fn renamed(file: &File<'_>, ending: &str) -> String {
    source::stem(&file.name) + ending
}

fn reading(asked: &Message<'_>) -> Result<ReadOptions> {
    let options = ReadOptions {
        hash: true,
        ..asked.options()?
    };
    options.validate()?;
    Ok(options)
}

fn gravity(asked: &Message<'_>) -> Result<Option<Gravity>> {
    asked.options::<GravityOptions>()?.given()
}

/// The one recording, joined with its gyroscope where that is a second file.
fn recording(
    asked: &Message<'_>,
    read: impl Fn(Named<'_>, &ReadOptions) -> Result<Recording>,
) -> Result<Recording> {
    let (file, options) = (asked.file("")?, reading(asked)?);
    let Some(gyro) = asked.files("gyro").next() else {
        return read(file.named(), &options);
    };
    let mut recording = read(file.named(), &options.beside_gyroscope_file())?;
    join_gyroscope(&mut recording, gyro.named(), &options)?;
    Ok(recording)
}

/// The recordings of a session, what was left out of it.
fn session(asked: &Message<'_>) -> Result<(Vec<Recording>, Vec<gravical::finding::Finding>)> {
    #[derive(Deserialize, Default)]
    #[serde(default)]
    struct Given {
        /// The files were dropped as a folder: nobody said that each is a recording.
        of_folder: bool,
    }
    let Given { of_folder } = asked.options()?;
    let files: Vec<Named<'_>> = asked.files("").map(File::named).collect();
    let gyro = asked.files("gyro").next().map(File::named);
    let found = read_named_session(&files, of_folder, gyro, &reading(asked)?)?;
    if found.0.is_empty() {
        return Err(Error::input(
            "no-recordings",
            "none of these files is a recording",
        ));
    }
    Ok(found)
}

fn calibration(asked: &Message<'_>) -> Result<(Calibration, InputFile)> {
    Calibration::read_with_input(asked.file("calibration")?.named())
}

/// What a file is: a recording, a calibration, the noise of a sensor, a list of sections.
fn inspect_file(asked: &Message<'_>) -> Result<Done> {
    let file = asked.file("")?;
    if read_noise(file.named()).is_ok() {
        return Ok(done(&json!({ "kind": "noise" }), false, None, Vec::new()));
    }
    let no_calibration = match Calibration::read_with_input(file.named()) {
        Ok((calibration, _)) => {
            let verdict = calibration.verdict();
            let found =
                json!({ "kind": "calibration", "calibration": calibration, "verdict": verdict });
            return Ok(done(&found, false, None, Vec::new()));
        }
        Err(error) => error,
    };
    let is_json = file.bytes.trim_ascii_start().starts_with(b"{");
    let recording = match recording(asked, read_named) {
        // A list of sections has columns, too.
        Err(_) if read_sections(file.named()).is_ok() => {
            return Ok(done(
                &json!({ "kind": "sections" }),
                false,
                None,
                Vec::new(),
            ));
        }
        Err(_) if is_json => return Err(no_calibration),
        recording => recording?,
    };
    let options: SegmentOptions = asked.options()?;
    let found = inspect(&recording, &options.axes);
    let figures = figure::inspection::inspection(&found, &recording);
    let document = report::inspection(&found, &figures);
    let html = page(document, &InputFile::of(from_ref(&recording)));
    Ok(done(
        &json!({ "kind": "recording", "inspection": found }),
        false,
        html,
        Vec::new(),
    ))
}

fn calibrate_files(asked: &Message<'_>) -> Result<Done> {
    let mut options = CalibrateOptions {
        segment: asked.options()?,
        gravity: gravity(asked)?.unwrap_or_default(),
        estimate: asked.options()?,
        record: asked.options()?,
        ..CalibrateOptions::default()
    };
    if let Some(file) = asked.files("sections").next() {
        let (sections, list) = read_sections(file.named())?;
        options.segment.sections = Some(sections);
        options.other_inputs.push(list);
    }
    let (recordings, left_out) = session(asked)?;
    let mut made = calibrate(&recordings, &options)?;
    made.calibration.findings.extend(left_out);
    let file = made.calibration;
    let figures = figure::calibration::figures(&file, Some((&recordings, &made.segmentation)));
    let name = "calibration.json";
    let html = report::calibration(&file, Some(Path::new(name)), &figures).to_html();
    let is_poor = file.grade() == Grade::Poor;
    let files = vec![(name.to_owned(), file.to_json()?.into_bytes())];
    Ok(done(&file, is_poor, Some(html), files))
}

fn check_files(asked: &Message<'_>) -> Result<Done> {
    let options = CheckOptions {
        gravity: gravity(asked)?,
        ..asked.options()?
    };
    let (calibration, file) = calibration(asked)?;
    let (recordings, left_out) = session(asked)?;
    let mut result = check(&calibration, &file.path, &recordings, &options)?;
    result.findings.extend(left_out);
    let mut inputs = InputFile::of(&recordings);
    inputs.push(file);
    let figures = figure::check::check(&result);
    let html = page(report::check(&result, &figures), &inputs);
    Ok(done(
        &result,
        result.verdict.judgement.is_change(),
        html,
        Vec::new(),
    ))
}

fn compare_files(asked: &Message<'_>) -> Result<Done> {
    let two: Vec<&File<'_>> = asked.files("calibration").collect();
    let [first, second] = two[..] else {
        return Err(Error::usage("usage", "two calibrations are compared"));
    };
    let (a, first) = Calibration::read_with_input(first.named())?;
    let (b, second) = Calibration::read_with_input(second.named())?;
    let result = compare(&a, &b, [&first.path, &second.path])?;
    let figures = figure::check::comparison(&result);
    let is_change = result.verdict.judgement.is_change();
    let html = page(report::comparison(&result, &figures), &[first, second]);
    Ok(done(&result, is_change, html, Vec::new()))
}

fn apply_file(asked: &Message<'_>) -> Result<Done> {
    let (calibration, _) = calibration(asked)?;
    let file = asked.file("")?;
    let options = ApplyOptions {
        read: reading(asked)?,
        ..asked.options()?
    };
    let mut table = Vec::new();
    let input = source::open(file.named(), &options.read)?;
    let summary = apply(&calibration, input, &file.name, &mut table, &options)?;
    Ok(done(
        &summary,
        false,
        None,
        vec![(renamed(file, "-calibrated.csv"), table)],
    ))
}

fn convert_to_table(asked: &Message<'_>) -> Result<Done> {
    let file = asked.file("")?;
    let options: ConvertOptions = asked.options()?;
    let mut table = Vec::new();
    let summary = convert_file(file.named(), &reading(asked)?, &options, &mut table)?;
    Ok(done(
        &summary,
        false,
        None,
        vec![(renamed(file, "-converted.csv"), table)],
    ))
}

fn filter_file(asked: &Message<'_>) -> Result<Done> {
    let file = asked.file("")?;
    let options: DenoiseOptions = asked.options()?;
    let read = reading(asked)?;
    let mut table = Vec::new();
    let (summary, inputs) = denoise_file(file.named(), &read, &options, &mut table)?;
    let raw = read_samples(file.named(), &read)?;
    let mut filtered = raw.clone();
    denoise(&mut filtered, &options)?;
    let mut figures = figure::denoise::denoise(&summary);
    figures.extend(figure::denoise::before_and_after(&raw, &filtered));
    let html = page(report::denoise(&summary, &figures), &inputs);
    Ok(done(
        &summary,
        false,
        html,
        vec![(renamed(file, "-filtered.csv"), table)],
    ))
}

fn measure_noise(asked: &Message<'_>) -> Result<Done> {
    let result = noise_of(recording(asked, read_named)?)?;
    let figures = figure::noise::figures(&result);
    let html = page(report::noise(&result, &figures), &result.inputs);
    let text = serde_json::to_string_pretty(&result).unwrap_or_default() + "\n";
    Ok(done(
        &result,
        false,
        html,
        vec![("noise.json".to_owned(), text.into_bytes())],
    ))
}

/// The motion of the one recording, with its inputs.
fn motion_of(asked: &Message<'_>) -> Result<(Motion, Recording, Vec<InputFile>)> {
    let options = MotionOptions {
        gravity: gravity(asked)?,
        ..asked.options()?
    };
    options.validate()?;
    let given = asked.files("calibration").next();
    let file = given.map(|file| Calibration::read_with_input(file.named()));
    let file = file.transpose()?;
    let recording = recording(asked, |file, how| read_samples(file, how))?;
    let calibrated = file.as_ref().map(|(file, input)| (file, &*input.path));
    let motion = motion(&recording, calibrated, &options)?;
    let mut inputs = InputFile::of(from_ref(&recording));
    inputs.extend(file.map(|(_, input)| input));
    Ok((motion, recording, inputs))
}

/// A table as the file of this name.
fn written(table: &gravical::motion::MotionTable<'_>, name: String) -> Result<(String, Vec<u8>)> {
    let mut bytes = Vec::new();
    table
        .write(&mut bytes)
        .map_err(|e| Error::io(Path::new(&name), e))?;
    Ok((name, bytes))
}

fn compute_motion(asked: &Message<'_>) -> Result<Done> {
    let (motion, recording, inputs) = motion_of(asked)?;
    let table = written(&motion.table(), renamed(asked.file("")?, "-motion.csv"))?;
    let figures: Vec<Figure> = figure::motion::figures(&motion);
    let html = page(
        report::motion(&motion.result, &recording, &figures),
        &inputs,
    );
    let is_poor = !motion.result.verdict.judgement.is_known();
    Ok(done(&motion.result, is_poor, html, vec![table]))
}

fn compute_orientation(asked: &Message<'_>) -> Result<Done> {
    #[derive(Deserialize, Default)]
    #[serde(default)]
    struct Given {
        acceleration: bool,
    }
    let Given { acceleration } = asked.options()?;
    let (motion, recording, inputs) = motion_of(asked)?;
    let result = motion.orientation()?;
    let name = renamed(asked.file("")?, "-orientation.csv");
    let table = written(&motion.orientation_table(acceleration), name)?;
    let figures = figure::motion::orientation(&motion);
    let html = page(report::orientation(&result, &recording, &figures), &inputs);
    let is_poor = result.verdict.judgement == OrientationJudgement::NotKnown;
    Ok(done(&result, is_poor, html, vec![table]))
}

/// A calibration as code or parameters, or the noise of a sensor for kalibr.
fn export_file(asked: &Message<'_>) -> Result<Done> {
    #[derive(Deserialize)]
    struct To {
        to: String,
    }
    let To { to } = asked.options()?;
    let unknown = || Error::usage("usage", format!("there is no target {to:?}"));
    let target = Target::find(&to).ok_or_else(unknown)?;
    let options: ExportOptions = asked.options()?;
    target.check(&options)?;
    let file = asked.file("calibration")?;
    let made = if target.is_noise() {
        export_noise(&read_noise(file.named())?, target, &options)?
    } else {
        export(
            &Calibration::read_with_input(file.named())?.0,
            target,
            &options,
        )?
    };
    let files = vec![(target.file.to_owned(), made.text.into_bytes())];
    Ok(done(&json!({ "notes": made.notes }), false, None, files))
}

/// What a calibration can be exported to.
fn targets() -> Value {
    let all = TARGETS
        .iter()
        .map(|t| json!({ "name": t.name, "holds": t.holds, "is_noise": t.is_noise() }));
    json!({ "result": all.collect::<Vec<_>>() })
}
