//! Correspondence of a header further down, as in two concatenated recordings, to the first
//! header: columns and units.

use gravical_core::unit::STANDARD_GRAVITY_MPS2;

use super::header::understand_all;
use super::{Layout, Named, with_claims};
use crate::recording::ReadOptions;
use crate::recording::board;
use crate::recording::dialect::{Dialect, Header};
use crate::recording::metadata::range_g;
use crate::recording::names::{Quantity, Role};
use crate::recording::timing::TimeUnit;
use crate::recording::units::{AccelUnit, GyroUnit};

/// What the rows under the first header are read with.
pub(in crate::recording) struct First<'a> {
    pub dialect: &'a Dialect,
    pub layout: &'a Layout,
    pub role: Role,
    pub options: &'a ReadOptions,
    /// Name of the file.
    pub file: &'a str,
}

/// Conversion of rows under a later header to rows under the first one.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::recording) struct Correspondence {
    /// Fields of a row under the later header.
    pub fields: usize,
    /// For each field of a row under the first header: the source field, and the factor for its
    /// number.
    pub columns: Vec<(Option<usize>, f64)>,
    /// Names of columns that the first header does not have.
    pub surplus: Vec<String>,
    /// Description of the differences.
    pub changes: String,
}

impl Correspondence {
    /// Rows under both headers are read equally.
    pub fn is_identity(&self) -> bool {
        let same = |(i, c): (usize, &(Option<usize>, f64))| *c == (Some(i), 1.0);
        self.fields == self.columns.len() && self.columns.iter().enumerate().all(same)
    }
}

/// Size of a unit, as far as the header gives it.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Size {
    /// Not given.
    Unnamed,
    /// Counts of a converter with unknown range.
    Counts,
    /// Size relative to a common unit.
    Of(f64),
}

impl Size {
    fn accel(layout: &Layout, given: Option<AccelUnit>) -> Self {
        let claim = layout.accel_claim;
        match claim.unit.or(given) {
            Some(AccelUnit::MetrePerSecondSquared) => Size::Of(1.0 / STANDARD_GRAVITY_MPS2),
            Some(AccelUnit::StandardGravity) => Size::Of(1.0),
            Some(AccelUnit::MilliGravity) => Size::Of(1e-3),
            Some(AccelUnit::Counts) => claim.lsb_per_g.map_or(Size::Counts, |n| Size::Of(1.0 / n)),
            Some(AccelUnit::Unknown) | None => Size::Unnamed,
        }
    }

    fn gyro(layout: &Layout, given: Option<GyroUnit>) -> Self {
        match layout.gyro_claim.or(given) {
            Some(GyroUnit::RadianPerSecond) => Size::Of(1f64.to_degrees()),
            Some(GyroUnit::DegreePerSecond) => Size::Of(1.0),
            Some(GyroUnit::Counts) => layout
                .gyro_lsb_per_deg_s
                .map_or(Size::Counts, |n| Size::Of(1.0 / n)),
            Some(GyroUnit::Unknown) | None => Size::Unnamed,
        }
    }

    fn time(layout: &Layout, given: Option<TimeUnit>) -> Self {
        let unit = layout.time_claim.or(given);
        unit.map_or(Size::Unnamed, |u| Size::Of(u.seconds()))
    }

    /// Factor from this unit to that of `first`; `None` if unknown.
    fn over(self, first: Size) -> Option<f64> {
        match (self, first) {
            (a, b) if a == b => Some(1.0),
            (Size::Of(own), Size::Of(first)) => Some(own / first),
            _ => None,
        }
    }
}

/// True for a header of the sensor that is read, with any other columns.
pub(in crate::recording) fn names_sensor(header: &Header, first: &First<'_>) -> bool {
    let columns = understand_all(header, first.file, first.role);
    let axis: fn(usize) -> Quantity = match first.role {
        Role::Recording => Quantity::Accel,
        Role::Gyroscope => Quantity::Gyro,
    };
    let named = (0..3).all(|i| columns.iter().any(|(_, c)| c.quantity == axis(i)));
    let known = first.dialect.header.as_ref().is_some_and(|known| {
        let shared = |n: &&String| !n.is_empty() && known.names.contains(*n);
        2 * header.names.iter().filter(shared).count() > header.names.len()
    });
    named || known
}

/// How rows under `later` are converted to rows under the first header; `metadata`: the lines
/// between the last row and `later`.
///
/// # Errors
///
/// The reason why they cannot be converted, as a sentence whose subject is the later header.
pub(in crate::recording) fn corresponding(
    first: &First<'_>,
    later: &Header,
    metadata: Vec<String>,
) -> Result<Correspondence, String> {
    let known = first.dialect.header.as_ref();
    if let Some(board) = board::last(&metadata)
        && board.is_calibrated() != first.layout.calibrated_by_board
    {
        let [now, before] = match board.is_calibrated() {
            true => ["calibrated", "raw"],
            false => ["raw", "calibrated"],
        };
        return Err(format!(
            "follows a line of the board that announces {now} values, and those before are {before}"
        ));
    }
    let mut later = later.clone();
    if let Some(known) = known
        && later.units.is_empty()
        && later.names == known.names
    {
        later.units = known.units.clone();
    }
    let layout = first.layout;
    let before = known.map_or_else(Vec::new, |h| understand_all(h, first.file, first.role));
    let after = understand_all(&later, first.file, first.role);
    let mut columns: Vec<(Option<usize>, f64)> = (0..first.dialect.fields)
        .map(|field| {
            let same_name = known.and_then(|h| same_name(&h.names, field, &later.names));
            let by_meaning = || same_meaning(layout, &before, field, &after);
            (same_name.or_else(by_meaning), 1.0)
        })
        .collect();
    let mut fields = Vec::new();
    let rest = [layout.fraction.map(|f| f.0), layout.instance.map(|i| i.0)];
    for field in rest.into_iter().flatten() {
        if columns.get(field).is_none_or(|c| c.0.is_none()) {
            return Err(format!("names no column for {}", name_of(known, field)));
        }
    }
    for &(quantity, field) in &layout.fields {
        match columns.get(field) {
            Some((Some(at), _)) => fields.push((quantity, *at)),
            _ => {
                return Err(format!(
                    "names no column for {}, which is read under the first header",
                    name_of(known, field)
                ));
            }
        }
    }
    let dialect = Dialect {
        header: Some(later),
        metadata: match board::of_counts(&metadata).is_some() || range_g(&metadata).is_some() {
            true => metadata,
            false => first.dialect.metadata.clone(),
        },
        ..first.dialect.clone()
    };
    let later = dialect.header.as_ref().map_or(&[][..], |h| &h.names);
    let same_text = |of: Quantity| {
        let at = |l: &Layout| l.field(of);
        let name = |names: &[String], f: Option<usize>| names.get(f?).cloned();
        let known = known.map_or(&[][..], |h| &h.names);
        let moved = fields.iter().find(|(q, _)| *q == of).map(|(_, f)| *f);
        name(known, at(layout)).is_some_and(|n| name(later, moved) == Some(n))
    };
    let time_is_same = same_text(Quantity::Time);
    let mut claims = with_claims(fields.clone(), &dialect, &after);
    claims.apply_board_settings(&dialect.metadata);
    let given = first.options;
    let mut changes = Vec::new();
    let of_accel = |l: &Layout| Size::accel(l, given.accel_unit);
    let of_gyro = |l: &Layout| Size::gyro(l, given.gyro_unit);
    let of_time = |l: &Layout| Size::time(l, given.time_unit);
    let of = |of: &dyn Fn(&Layout) -> Size| (of(&claims), of(layout));
    let time = match time_is_same {
        true => (Size::Unnamed, Size::Unnamed),
        false => of(&of_time),
    };
    type Is = fn(Quantity) -> bool;
    let channels: [(&str, Is, (Size, Size)); 3] = [
        (
            "accelerometer",
            |q| matches!(q, Quantity::Accel(_)),
            of(&of_accel),
        ),
        (
            "gyroscope",
            |q| matches!(q, Quantity::Gyro(_)),
            of(&of_gyro),
        ),
        ("time", |q| q == Quantity::Time, time),
    ];
    for (what, is, (own, was)) in channels {
        if !layout.fields.iter().any(|(q, _)| is(*q)) {
            continue;
        }
        let Some(factor) = own.over(was) else {
            return Err(format!(
                "and the first one do not both give the unit of the {what}, or the range of its counts"
            ));
        };
        if factor != 1.0 {
            changes.push(format!("the {what} in another unit, times {factor}"));
        }
        for (_, field) in layout.fields.iter().filter(|(q, _)| is(*q)) {
            if let Some(column) = columns.get_mut(*field) {
                column.1 = factor;
            }
        }
    }
    let taken = |at: usize| columns.iter().any(|c| c.0 == Some(at));
    let surplus = later.iter().enumerate();
    let surplus = surplus.filter(|(at, name)| !taken(*at) && !name.is_empty());
    let surplus: Vec<String> = surplus.map(|(_, name)| name.clone()).collect();
    let moved = columns.iter().enumerate();
    if moved
        .filter(|(i, c)| c.0.is_some_and(|at| at != *i))
        .count()
        > 0
    {
        changes.insert(0, "other columns or another order".to_owned());
    }
    Ok(Correspondence {
        fields: later.len(),
        columns,
        surplus,
        changes: changes.join(", "),
    })
}

fn name_of(header: Option<&Header>, field: usize) -> String {
    let name = header.and_then(|h| h.names.get(field));
    name.filter(|n| !n.is_empty()).map_or_else(
        || format!("column {}", field + 1),
        |name| format!("\"{name}\""),
    )
}

/// The column of the same name; of several, the one at the same position among them.
fn same_name(known: &[String], field: usize, later: &[String]) -> Option<usize> {
    let name = known.get(field).filter(|n| !n.is_empty())?;
    let place = known.iter().take(field).filter(|n| *n == name).count();
    let mut alike = later.iter().enumerate().filter(|(_, n)| *n == name);
    alike.nth(place).map(|(at, _)| at)
}

/// The column of the same quantity and sensor; of any sensor if there is only one.
fn same_meaning(layout: &Layout, before: &[Named], field: usize, after: &[Named]) -> Option<usize> {
    let named = before.iter().find(|(f, _)| *f == field).map(|(_, c)| c);
    let read = layout.fields.iter().find(|(_, f)| *f == field);
    let quantity = match read.map(|(q, _)| *q) {
        Some(Quantity::Time) if layout.sums_time => Quantity::TimeStep,
        Some(quantity) => quantity,
        None => named?.quantity,
    };
    let alike: Vec<&Named> = after.iter().filter(|c| c.1.quantity == quantity).collect();
    let sensor = |c: &Named| (c.1.sensor.clone(), c.1.without_gravity);
    let own = named.map(|c| (c.sensor.clone(), c.without_gravity));
    let same = alike.iter().find(|c| own == Some(sensor(c)));
    match (same, &alike[..]) {
        (Some(found), _) | (None, [found]) => Some(found.0),
        _ => None,
    }
}
