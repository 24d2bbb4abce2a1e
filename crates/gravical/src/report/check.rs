//! A check of a calibration as text.

use gravical_core::unit::STANDARD_GRAVITY_MPS2;

use crate::calibration_file::GravitySource;
use crate::check::{CheckReport, GyroscopeCheck, Judgement, StillCheck};

use super::text::{findings_text, paragraph, short_name};

/// Stills that are listed one by one; the worst is always among them.
const LISTED: usize = 24;

/// The whole report.
#[must_use]
pub fn check_text(report: &CheckReport) -> String {
    let mut out = head(report);
    out.push_str(&stills(report));
    out.push_str(&summary(report));
    if let Some(gyroscope) = &report.gyroscope {
        out.push_str(&gyro(gyroscope));
    }
    if !report.findings.is_empty() {
        out.push_str("\nFindings\n");
        out.push_str(&findings_text(
            &report.findings,
            report.recordings.len() > 1,
        ));
    }
    out.push_str(&paragraph("\nVerdict: ", report.verdict.judgement.name()));
    for reason in &report.verdict.reasons {
        out.push_str(&paragraph("  - ", reason));
    }
    out
}

fn head(report: &CheckReport) -> String {
    let recordings = match &report.recordings[..] {
        [one] => short_name(one),
        several => format!("{} recordings", several.len()),
    };
    let gravity = match (report.gravity_of_calibration, report.gravity_source) {
        (true, GravitySource::Standard) => "that of the calibration, assumed there",
        (true, _) => "that of the calibration",
        (false, GravitySource::Given) => "given",
        (false, GravitySource::Latitude) => "from latitude",
        (false, GravitySource::Standard) => "assumed",
    };
    let stills = match report.stills.len() {
        1 => "1 still".to_owned(),
        n => format!("{n} stills"),
    };
    let mut out = paragraph(
        "",
        &format!(
            "{} against {recordings}: {stills}",
            short_name(&report.calibration)
        ),
    );
    out.push_str(&paragraph(
        "",
        &format!("g = {:.5} m/s² ({gravity})", report.gravity_mps2),
    ));
    out
}

fn stills(report: &CheckReport) -> String {
    let mut out = format!(
        "\n  {:<22}{:>6}  {:<10}{:>17}{:>12}{:>7}\n",
        "still", "rows", "up", "error, mm/s² (mg)", "± 1σ", "z"
    );
    let all = report.stills.iter().enumerate();
    let listed = |i: &usize| *i < LISTED - 1 || *i == report.worst || report.stills.len() <= LISTED;
    let mut left_out = 0;
    for (i, still) in all {
        if listed(&i) {
            let mark = if i == report.worst && report.stills.len() > 1 {
                "←"
            } else if !still.counts {
                "clipped"
            } else {
                ""
            };
            out.push_str(line(report, still, mark).trim_end());
            out.push('\n');
        } else {
            left_out += 1;
        }
    }
    if left_out > 0 {
        out.push_str(&format!("  … and {left_out} more; --json has all\n"));
    }
    out
}

fn line(report: &CheckReport, still: &StillCheck, mark: &str) -> String {
    let at = still.start_s.map_or_else(
        || format!("line {}", still.lines[0]),
        |s| format!("{s:.2} s"),
    );
    let name = match (&still.label, report.recordings.len()) {
        (Some(label), _) => label.clone(),
        (None, 1) => format!("at {at}"),
        (None, _) => format!("{} {at}", short_name(&still.file)),
    };
    let name: String = if name.chars().count() > 21 {
        let tail: Vec<char> = name.chars().rev().take(20).collect();
        std::iter::once('…').chain(tail.into_iter().rev()).collect()
    } else {
        name
    };
    format!(
        "  {name:<22}{:>6}  {:<10}{:>9}{:>8}{:>12}{:>7} {mark}",
        still.rows,
        format!("{} {:.1}°", still.nearest, still.nearest_deg),
        format!("{:+.1}", 1000.0 * still.error_mps2),
        format!("({:+.2})", still.error_mg),
        still
            .sigma_mps2
            .map_or(String::new(), |s| format!("± {:.1}", 1000.0 * s)),
        still.z.map_or(String::new(), |z| format!("{z:+.1}")),
    )
}

fn summary(report: &CheckReport) -> String {
    let mg = |v: f64| 1000.0 * v / STANDARD_GRAVITY_MPS2;
    let predicted = report.predicted_rms_mps2.map_or(String::new(), |p| {
        format!(", {:.1} mm/s² ({:.2} mg) predicted", 1000.0 * p, mg(p))
    });
    format!(
        "\n  RMS {:.1} mm/s² ({:.2} mg){predicted}{}\n",
        1000.0 * report.rms_mps2,
        mg(report.rms_mps2),
        if report.stills.len() > 1 {
            "; ← the worst"
        } else {
            ""
        }
    )
}

fn gyro(g: &GyroscopeCheck) -> String {
    let rates: Vec<String> = (0..3)
        .map(|i| {
            let error = g
                .standard_error_deg_s
                .map_or(String::new(), |e| format!(" ± {:.3}", e[i]));
            format!("{} {:+.3}{error}", ["x", "y", "z"][i], g.rate_deg_s[i])
        })
        .collect();
    let judgement = match g.judgement {
        Judgement::Fits => format!("within {} °/s: its bias fits", g.limit_deg_s),
        Judgement::DoesNotFit => format!(
            "more than {} °/s: its bias has moved (as it does with every start and with temperature); take it anew at rest: {} {}",
            g.limit_deg_s,
            g.bias_now.map(|b| format!("{b:.5}")).join(", "),
            g.input_unit.name()
        ),
        Judgement::CannotSay => format!(
            "too short or unsteady to tell whether that is within {} °/s",
            g.limit_deg_s
        ),
    };
    let mut out = String::from("\nGyroscope at rest, calibrated, °/s\n");
    out.push_str(&paragraph("  ", &rates.join(", ")));
    out.push_str(&paragraph("  ", &judgement));
    out
}
