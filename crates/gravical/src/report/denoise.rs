//! What filters did, as text.

use crate::denoise::{DenoiseSummary, FilterOutcome, Sigmas};

use super::text::{decimals_of, findings_text, paragraph};

/// σ of one sensor's axes.
type SigmaOf = fn(&Sigmas) -> Option<[f64; 3]>;

/// What is said of every result.
const NO_DRIFT: &str = "Smoothing does not reduce drift. The noise it takes away averages out in an integral as well, and an offset passes a low-pass unchanged.";

/// The filters, what each does to white noise and did to this recording at rest, and
/// the findings.
#[must_use]
pub fn denoise_text(summary: &DenoiseSummary) -> String {
    let mut out = format!("  read as   {}\n", summary.description);
    let rate = match summary.rate_hz {
        Some(rate) => format!("{rate:.2} Hz"),
        None => "rate unknown".to_owned(),
    };
    out.push_str(&format!(
        "  sampling  {rate}, {}; edge: {}\n",
        count(summary.stretches, "stretch", "stretches"),
        summary.edge.name()
    ));
    if summary.still_spans > 0 {
        out.push_str(&format!(
            "  at rest   {}, {} rows\n",
            count(summary.still_spans, "span", "spans"),
            summary.still_rows
        ));
    }
    let sensors: [(&str, &str, SigmaOf); 2] = [
        ("accelerometer", summary.accel_unit, |s| s.accelerometer),
        ("gyroscope", summary.gyro_unit, |s| s.gyroscope),
    ];
    let mut any = false;
    for (name, unit, of) in sensors {
        if of(&summary.recorded).is_some() {
            out.push_str(&table(summary, !any, &title(name, unit), of));
            any = true;
        }
    }
    if !any {
        out.push_str(&table(summary, true, "", |_| None));
    }
    out.push('\n');
    let units: Vec<String> = summary.filters.iter().filter_map(derived).collect();
    if !units.is_empty() {
        out.push_str(&paragraph("  ", &units.join("; ")));
    }
    out.push_str(&paragraph("  ", NO_DRIFT));
    out.push_str(&findings_text(&summary.findings, false));
    out
}

fn title(name: &str, unit: &str) -> String {
    let unit = if unit == "unknown" {
        "unit unknown"
    } else {
        unit
    };
    format!("σ of {name}, {unit}")
}

fn count(n: usize, one: &str, many: &str) -> String {
    match n {
        1 => format!("1 {one}"),
        n => format!("{n} {many}"),
    }
}

/// One line a filter; the columns of what it does anyhow only `with_response`.
fn table(
    summary: &DenoiseSummary,
    with_response: bool,
    title: &str,
    of: fn(&Sigmas) -> Option<[f64; 3]>,
) -> String {
    let width = summary
        .filters
        .iter()
        .map(|f| f.filter.chars().count())
        .chain([11])
        .max()
        .unwrap_or(11)
        .min(24);
    let rows = summary.filters.iter().map(|f| of(&f.sigma));
    let all: Vec<Option<[f64; 3]>> = [of(&summary.recorded)].into_iter().chain(rows).collect();
    let numbers = |s: &Option<[f64; 3]>| match s {
        Some(values) => values.iter().map(|v| sigma(*v)).collect::<String>(),
        None => String::new(),
    };
    let response = |gain: &str, frequency: &str| match with_response {
        true => format!("{gain:>8}{frequency:>12}"),
        false => " ".repeat(20),
    };
    let mut lines = vec![
        format!("  {:width$}{}{title:>33}", "", response("white", "−3 dB")),
        format!(
            "  {:width$}{}{}",
            "",
            response("noise", "Hz"),
            match title {
                "" => String::new(),
                _ => ["x", "y", "z"].map(|axis| format!("{axis:>11}")).concat(),
            }
        ),
        format!(
            "  {:width$}{}{}",
            "as recorded",
            response("1", ""),
            numbers(&all[0])
        ),
    ];
    for (filter, sigmas) in summary.filters.iter().zip(&all[1..]) {
        let replaced = match filter.replaced {
            Some(n) if with_response => format!("  {n} replaced"),
            _ => String::new(),
        };
        lines.push(format!(
            "  {:width$}{}{}{}",
            filter.filter,
            response(&gain(filter), &frequencies(filter)),
            numbers(sigmas),
            // The numbers fill the line.
            if sigmas.is_none() {
                replaced.as_str()
            } else {
                ""
            }
        ));
        if sigmas.is_some() && !replaced.is_empty() {
            lines.push(format!("  {:width$}{replaced}", ""));
        }
    }
    let mut out = "\n".to_owned();
    for line in lines {
        out.push_str(line.trim_end());
        out.push('\n');
    }
    out
}

/// Three digits, whatever the unit.
fn sigma(value: f64) -> String {
    if value != 0.0 && value.abs() < 1e-4 {
        return format!("{value:>11.1e}");
    }
    format!("{value:>11.*}", decimals_of(value, 3))
}

fn gain(filter: &FilterOutcome) -> String {
    let gain = filter.response.noise_gain;
    format!("{gain:.*}", decimals_of(gain, 3).min(4))
}

fn frequencies(filter: &FilterOutcome) -> String {
    match &filter.response.minus_3db_hz {
        Some(edges) if !edges.is_empty() => {
            let texts: Vec<String> = edges
                .iter()
                .map(|f| format!("{f:.*}", decimals_of(*f, 3)))
                .collect();
            texts.join("–")
        }
        Some(_) => "–".to_owned(),
        // A share of a rate that nobody knows.
        None => match filter.response.minus_3db_of_rate.first() {
            Some(share) => format!("{share:.3} f_s"),
            None => "–".to_owned(),
        },
    }
}

fn derived(filter: &FilterOutcome) -> Option<String> {
    let power = match filter.derivative {
        0 => return None,
        1 => "s".to_owned(),
        n => format!("s^{n}"),
    };
    Some(format!(
        "behind {}: per {power}, and white noise in 1/{power}",
        filter.filter
    ))
}

#[cfg(test)]
mod tests {
    use crate::denoise::{DenoiseOptions, denoise};
    use crate::recording::{ReadOptions, read_bytes};

    use super::denoise_text;

    #[test]
    fn eighty_columns_whatever_the_filter() {
        let mut csv = "t_ms,ax,ay,az,gx (deg/s),gy (deg/s),gz (deg/s)\n".to_owned();
        for i in 0..600 {
            let noise = f64::from(i * 7919 % 101) / 1000.0 - 0.05;
            csv += &format!(
                "{},{noise},{noise},{},{noise},0,{noise}\n",
                10 * i,
                9.8 + noise
            );
        }
        let filters = [
            "hampel:7,3",
            "butter1:8,10.125-20.375Hz",
            "savgol:21,4,2",
            "mean:1",
        ];
        let recording = read_bytes(csv.as_bytes(), "desk.csv", &ReadOptions::default()).unwrap();
        let options = DenoiseOptions::new(filters.map(|f| f.parse().unwrap()));
        let text = denoise_text(&denoise(recording, &options).unwrap().summary);
        println!("{text}");
        for line in text.lines() {
            assert!(line.chars().count() <= 80, "{line}");
        }
        for filter in filters {
            assert!(text.contains(filter), "{filter}");
        }
    }
}
