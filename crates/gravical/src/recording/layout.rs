//! Which column is which channel: by `--columns`, by the names of the header,
//! or, without a header, by what the numbers look like.

use crate::{Error, Result};

use super::dialect::Dialect;
use super::finding::Finding;
use super::names::{ColumnName, Quantity, understand};
use super::row::{ACCEL, GYRO, RowScanner, TEMPERATURE, TIME};
use super::timing::{TimeUnit, median};
use super::units::{AccelUnit, Evidence, GyroUnit, accel_evidence};

/// `--columns`: which column holds what.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ColumnsSpec {
    /// `t=Timestamp,ax=…`: channel and name of the column.
    Named(Vec<(Quantity, String)>),
    /// `ax,ay,az,_,gx`: channels in the order of the columns; none skips one.
    Ordered(Vec<Option<Quantity>>),
}

impl std::str::FromStr for ColumnsSpec {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let channel = |name: &str| -> Result<Quantity> {
            Ok(match name.trim() {
                "t" | "time" => Quantity::Time,
                "ax" => Quantity::Accel(0),
                "ay" => Quantity::Accel(1),
                "az" => Quantity::Accel(2),
                "gx" => Quantity::Gyro(0),
                "gy" => Quantity::Gyro(1),
                "gz" => Quantity::Gyro(2),
                "temp" | "temperature" => Quantity::Temperature,
                "label" | "part" => Quantity::Label,
                other => {
                    return Err(Error::usage(
                        "columns-syntax",
                        format!("--columns: there is no channel \"{other}\""),
                    )
                    .with_hint(
                        "channels are t, ax, ay, az, gx, gy, gz, temp and label; _ skips a column",
                    ));
                }
            })
        };
        if text.contains('=') {
            let pairs = text.split(',').map(|pair| {
                let (name, column) = pair.split_once('=').ok_or_else(|| {
                    Error::usage("columns-syntax", format!("--columns: \"{pair}\" has no ="))
                })?;
                Ok((channel(name)?, column.trim().to_owned()))
            });
            return Ok(ColumnsSpec::Named(pairs.collect::<Result<_>>()?));
        }
        let ordered = text.split(',').map(|name| match name.trim() {
            "_" | "" => Ok(None),
            name => channel(name).map(Some),
        });
        Ok(ColumnsSpec::Ordered(ordered.collect::<Result<_>>()?))
    }
}

/// Columns that were chosen, with what their names claim.
#[derive(Debug, Clone)]
pub struct Layout {
    /// Quantity and field (from 0) of each channel that is read.
    pub fields: Vec<(Quantity, usize)>,
    /// Unit that the accelerometer's header claims, if it is one.
    pub accel_claim: Option<AccelUnit>,
    /// Unit that the gyroscope's header claims.
    pub gyro_claim: Option<GyroUnit>,
    /// Unit that the time's header claims.
    pub time_claim: Option<TimeUnit>,
}

impl Layout {
    /// Field of a channel, from 0.
    #[must_use]
    pub fn field(&self, quantity: Quantity) -> Option<usize> {
        self.fields
            .iter()
            .find(|(q, _)| *q == quantity)
            .map(|(_, f)| *f)
    }

    /// True when all three axes of the gyroscope are there.
    #[must_use]
    pub fn has_gyro(&self) -> bool {
        (0..3).all(|i| self.field(Quantity::Gyro(i)).is_some())
    }

    /// A scanner that reads these columns.
    #[must_use]
    pub fn scanner(&self, dialect: &Dialect) -> RowScanner {
        let mut scanner = RowScanner::new(dialect.delimiter, dialect.decimal_comma, dialect.fields);
        for &(quantity, field) in &self.fields {
            match quantity {
                Quantity::Time => scanner.assign(field, TIME),
                Quantity::Accel(i) => scanner.assign(field, ACCEL + i),
                Quantity::Gyro(i) => scanner.assign(field, GYRO + i),
                Quantity::Temperature => scanner.assign(field, TEMPERATURE),
                Quantity::Label => scanner.assign_label(field),
                Quantity::Index => {}
            }
        }
        scanner
    }
}

/// Finds the columns.
///
/// # Errors
///
/// `no-accelerometer` or `columns-unknown` (input) when they cannot be found,
/// with the names that are there; `columns-missing` (usage) when `--columns`
/// names one that is not.
pub fn find(
    dialect: &Dialect,
    spec: Option<&ColumnsSpec>,
    findings: &mut Vec<Finding>,
) -> Result<Layout> {
    match (spec, &dialect.header) {
        (Some(spec), _) => by_spec(dialect, spec),
        (None, Some(header)) => by_names(&header.names, findings),
        (None, None) => by_content(dialect, findings),
    }
}

fn by_spec(dialect: &Dialect, spec: &ColumnsSpec) -> Result<Layout> {
    let names: &[String] = dialect.header.as_ref().map_or(&[], |h| &h.names);
    let mut fields = Vec::new();
    match spec {
        ColumnsSpec::Ordered(order) => {
            if order.len() > dialect.fields {
                return Err(Error::usage(
                    "columns-missing",
                    format!(
                        "--columns names {} columns, the file has {}",
                        order.len(),
                        dialect.fields
                    ),
                ));
            }
            fields.extend(
                order
                    .iter()
                    .enumerate()
                    .filter_map(|(i, q)| Some(((*q)?, i))),
            );
        }
        ColumnsSpec::Named(pairs) => {
            for (quantity, name) in pairs {
                let at = names
                    .iter()
                    .position(|n| n == name)
                    .or_else(|| names.iter().position(|n| n.eq_ignore_ascii_case(name)))
                    .ok_or_else(|| {
                        Error::usage("columns-missing", format!("there is no column \"{name}\""))
                            .with_hint(columns_there(names))
                    })?;
                fields.push((*quantity, at));
            }
        }
    }
    let claims: Vec<(Quantity, ColumnName)> = fields
        .iter()
        .filter_map(|(q, f)| Some((*q, understand(names.get(*f)?)?)))
        .collect();
    let layout = with_claims(fields, &claims);
    if (0..3).any(|i| layout.field(Quantity::Accel(i)).is_none()) {
        return Err(Error::usage(
            "columns-missing",
            "--columns has to name ax, ay and az",
        ));
    }
    Ok(layout)
}

fn columns_there(names: &[String]) -> String {
    if names.is_empty() {
        return "the file has no header: give the channels in order, as --columns t,ax,ay,az"
            .to_owned();
    }
    let list: Vec<&str> = names
        .iter()
        .map(String::as_str)
        .filter(|n| !n.is_empty())
        .collect();
    let shown: Vec<&str> = list.iter().copied().take(16).collect();
    let more = if list.len() > shown.len() {
        ", …"
    } else {
        ""
    };
    format!(
        "its columns are: {}{more}; say which is which with --columns ax=…,ay=…,az=…",
        shown.join(", ")
    )
}

fn by_names(names: &[String], findings: &mut Vec<Finding>) -> Result<Layout> {
    let understood: Vec<(usize, ColumnName)> = names
        .iter()
        .enumerate()
        .filter_map(|(i, n)| Some((i, understand(n)?)))
        .collect();
    // One sensor is one choice of (name, unit) with all three axes.
    let sensors = |of: fn(usize) -> Quantity| -> Vec<[usize; 3]> {
        let mut found: Vec<[usize; 3]> = Vec::new();
        for (_, first) in understood.iter().filter(|(_, c)| c.quantity == of(0)) {
            let axis = |i: usize| {
                understood
                    .iter()
                    .find(|(_, c)| {
                        c.quantity == of(i)
                            && c.sensor == first.sensor
                            && c.without_gravity == first.without_gravity
                            && c.unit == first.unit
                    })
                    .map(|(f, _)| *f)
            };
            if let (Some(x), Some(y), Some(z)) = (axis(0), axis(1), axis(2))
                && !found.contains(&[x, y, z])
            {
                found.push([x, y, z]);
            }
        }
        found
    };
    let name_of = |field: usize| understood.iter().find(|(f, _)| *f == field).map(|(_, c)| c);
    let mut accels = sensors(Quantity::Accel);
    accels.sort_by_key(|a| name_of(a[0]).is_some_and(|c| c.without_gravity));
    let Some(&accel) = accels.first() else {
        return Err(Error::input(
            "no-accelerometer",
            "no three columns of this file are named as an accelerometer's x, y and z",
        )
        .with_hint(columns_there(names)));
    };
    let sensor = name_of(accel[0]).map_or("", |c| &c.sensor);
    let gyros = sensors(Quantity::Gyro);
    let gyro = gyros
        .iter()
        .find(|g| name_of(g[0]).is_some_and(|c| c.sensor == sensor))
        .or(gyros.first());
    if accels.len() > 1 {
        let list: Vec<&str> = accels
            .iter()
            .filter_map(|a| names.get(a[0]))
            .map(String::as_str)
            .collect();
        findings.push(Finding::warning(
            "several-sensors",
            format!(
                "{} accelerometers ({}); the first is read, --columns chooses another",
                accels.len(),
                list.join(", ")
            ),
        ));
    }
    let mut fields: Vec<(Quantity, usize)> =
        (0..3).map(|i| (Quantity::Accel(i), accel[i])).collect();
    if let Some(gyro) = gyro {
        fields.extend((0..3).map(|i| (Quantity::Gyro(i), gyro[i])));
    }
    for quantity in [Quantity::Time, Quantity::Temperature, Quantity::Label] {
        let of_sensor =
            |(_, c): &&(usize, ColumnName)| c.quantity == quantity && c.sensor == sensor;
        if let Some((field, _)) = understood
            .iter()
            .find(of_sensor)
            .or_else(|| understood.iter().find(|(_, c)| c.quantity == quantity))
        {
            fields.push((quantity, *field));
        }
    }
    let claims: Vec<(Quantity, ColumnName)> = fields
        .iter()
        .filter_map(|(q, f)| Some((*q, name_of(*f)?.clone())))
        .collect();
    if claims
        .iter()
        .any(|(q, c)| matches!(q, Quantity::Accel(_)) && c.without_gravity)
    {
        findings.push(Finding::warning(
            "without-gravity",
            "the only acceleration here may have gravity taken out by the device; calibration needs the raw specific force",
        ));
    }
    Ok(with_claims(fields, &claims))
}

fn with_claims(fields: Vec<(Quantity, usize)>, claims: &[(Quantity, ColumnName)]) -> Layout {
    let unit = |of: Quantity| {
        claims
            .iter()
            .find(|(q, _)| *q == of)
            .and_then(|(_, c)| c.unit.as_deref())
    };
    Layout {
        accel_claim: unit(Quantity::Accel(0)).and_then(AccelUnit::parse),
        gyro_claim: unit(Quantity::Gyro(0)).and_then(GyroUnit::parse),
        time_claim: unit(Quantity::Time).and_then(TimeUnit::parse),
        fields,
    }
}

/// Without names: a first column that rises steadily is time (or a counter);
/// of the triples that follow the accelerometer is the one whose magnitude
/// hardly changes, since gravity never leaves it.
fn by_content(dialect: &Dialect, findings: &mut Vec<Finding>) -> Result<Layout> {
    let sample = &dialect.sample;
    let column =
        |i: usize| -> Vec<f64> { sample.iter().filter_map(|r| r.get(i).copied()).collect() };
    let first = column(0);
    let rises = first.len() > 3 && first.windows(2).all(|w| w[1] > w[0]);
    let counter = rises && first.windows(2).all(|w| w[1] - w[0] == 1.0);
    let from = usize::from(rises);
    let rest = dialect.fields - from;
    let triple = |at: usize| [from + at, from + at + 1, from + at + 2];
    let unknown = || {
        Error::input(
            "columns-unknown",
            format!(
                "the file has no header and {} columns whose meaning the numbers do not show",
                dialect.fields
            ),
        )
        .with_hint("name them in order, as --columns t,ax,ay,az,gx,gy,gz (_ skips one)")
    };
    let steady = |t: [usize; 3]| -> Option<(f64, f64)> {
        let mut norms: Vec<f64> = sample
            .iter()
            .map(|r| t.iter().map(|i| r[*i] * r[*i]).sum::<f64>().sqrt())
            .filter(|n| n.is_finite())
            .collect();
        let middle = median(&mut norms)?;
        let mut off: Vec<f64> = norms.iter().map(|n| (n - middle).abs()).collect();
        Some((middle, median(&mut off)? / middle.max(f64::MIN_POSITIVE)))
    };
    let (accel, gyro, temperature) = match rest {
        3 => (triple(0), None, None),
        4 => (triple(0), None, Some(from + 3)),
        6 | 9 => {
            let (a, b) = (
                steady(triple(0)).ok_or_else(unknown)?,
                steady(triple(3)).ok_or_else(unknown)?,
            );
            let gravity = |norm: f64| !matches!(accel_evidence(norm, true), Evidence::None);
            match (gravity(a.0), gravity(b.0)) {
                (true, false) => (triple(0), Some(triple(3)), None),
                (false, true) => (triple(3), Some(triple(0)), None),
                _ if a.1 < b.1 => (triple(0), Some(triple(3)), None),
                _ => (triple(3), Some(triple(0)), None),
            }
        }
        7 => {
            // The order of the sensor's registers, and of the report: the
            // temperature stands in the middle; else it stands last.
            let spread = |i: usize| {
                let c = column(from + i);
                let mean = c.iter().sum::<f64>() / c.len().max(1) as f64;
                let most = c.iter().fold(0.0_f64, |m, v| m.max((v - mean).abs()));
                if mean.abs() > 1.0 {
                    most / mean.abs()
                } else {
                    f64::INFINITY
                }
            };
            if spread(3) <= spread(6) {
                (triple(0), Some(triple(4)), Some(from + 3))
            } else {
                (triple(0), Some(triple(3)), Some(from + 6))
            }
        }
        _ => return Err(unknown()),
    };
    let mut fields: Vec<(Quantity, usize)> =
        (0..3).map(|i| (Quantity::Accel(i), accel[i])).collect();
    if let Some(gyro) = gyro {
        fields.extend((0..3).map(|i| (Quantity::Gyro(i), gyro[i])));
    }
    if let Some(field) = temperature {
        fields.push((Quantity::Temperature, field));
    }
    if rises && !counter {
        fields.push((Quantity::Time, 0));
    }
    fields.sort_by_key(|(_, field)| *field);
    let shown: Vec<String> = (0..dialect.fields)
        .map(|i| match fields.iter().find(|(_, f)| *f == i) {
            Some((Quantity::Time, _)) => "t".to_owned(),
            Some((Quantity::Accel(a), _)) => format!("a{}", ["x", "y", "z"][*a]),
            Some((Quantity::Gyro(a), _)) => format!("g{}", ["x", "y", "z"][*a]),
            Some((Quantity::Temperature, _)) => "temp".to_owned(),
            _ => "_".to_owned(),
        })
        .collect();
    findings.push(Finding::warning(
        "columns-guessed",
        format!(
            "no header; taken by the numbers as --columns {} (give that option to be sure)",
            shown.join(",")
        ),
    ));
    Ok(with_claims(fields, &[]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::dialect::sniff;

    fn layout(text: &str, spec: Option<&str>) -> Result<Layout> {
        let spec = spec.map(|s| s.parse().unwrap());
        find(
            &sniff(text.as_bytes(), true, 3).unwrap(),
            spec.as_ref(),
            &mut Vec::new(),
        )
    }

    #[test]
    fn the_reports_header() {
        let l = layout(
            "Timestamp,aX (g),aY (g),aZ (g),Temp (C),gX (°/s),gY (°/s),gZ (°/s)\n1,2,3,4,5,6,7,8\n",
            None,
        )
        .unwrap();
        assert_eq!(l.field(Quantity::Gyro(2)), Some(7));
        assert_eq!(l.accel_claim, Some(AccelUnit::StandardGravity));
        assert_eq!(l.gyro_claim, Some(GyroUnit::DegreePerSecond));
    }

    #[test]
    fn the_first_of_two_sensors_unless_told() {
        let text = "l_acc_x,r_acc_x,l_acc_y,r_acc_y,l_acc_z,r_acc_z\n1,2,3,4,5,6\n";
        assert_eq!(
            layout(text, None).unwrap().field(Quantity::Accel(1)),
            Some(2)
        );
        let told = layout(text, Some("ax=r_acc_x,ay=r_acc_y,az=r_acc_z")).unwrap();
        assert_eq!(told.field(Quantity::Accel(1)), Some(3));
    }

    #[test]
    fn without_names_the_numbers_decide() {
        let gyro_first: String = (0..50)
            .map(|i| {
                format!(
                    "{} 0.01 0.02 0.1 {} 9.8\n",
                    0.03 * f64::from(i % 7),
                    0.01 * f64::from(i % 3)
                )
            })
            .collect();
        let l = layout(&gyro_first, None).unwrap();
        assert_eq!(
            (l.field(Quantity::Accel(0)), l.field(Quantity::Gyro(0))),
            (Some(3), Some(0))
        );
        let timed = layout(
            "0.01 33000 33100 36400\n0.02 33000 33100 36400\n0.035 33000 33101 36400\n0.04 1 2 3\n",
            None,
        )
        .unwrap();
        assert_eq!(
            (timed.field(Quantity::Time), timed.field(Quantity::Accel(2))),
            (Some(0), Some(3))
        );
    }

    #[test]
    fn what_is_not_there_is_said() {
        assert_eq!(
            layout("a,b,c\n1,2,3\n", None).unwrap_err().code(),
            "no-accelerometer"
        );
        assert_eq!(
            layout("1,2,3,4,5\n1,2,3,4,5\n", None).unwrap_err().code(),
            "columns-unknown"
        );
        assert_eq!(
            layout("p,q,r\n1,2,3\n", Some("ax=p,ay=q,az=x"))
                .unwrap_err()
                .code(),
            "columns-missing"
        );
        assert!("ax,by".parse::<ColumnsSpec>().is_err());
    }
}
