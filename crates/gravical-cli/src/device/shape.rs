//! What the rows of a board are: how they are written, and which number is what. Learned
//! once, from a header, from the names in the rows or from the first rows.

use gravical::Result;
use gravical::recording::layout::Layout;
use gravical::recording::names::{Quantity, understand};
use gravical::recording::{ColumnsSpec, stream_layout};

use super::form::{Form, header_names};
use super::item::{Reason, Row};

/// The column of arrival times, where the board sends no time.
pub const HOST_TIME: &str = "t_host_ms";

/// Rows of one form that are needed where nothing names the columns.
pub const LEAST_ROWS: usize = 5;

/// The rows of a board.
#[derive(Debug, Clone)]
pub struct RowShape {
    form: Form,
    layout: Layout,
    columns: Vec<u8>,
    notes: Vec<String>,
    /// The board sends no time: the file has a column of arrival times.
    pub host_time: bool,
}

impl RowShape {
    /// By the header of the board; its rows may not have arrived yet.
    ///
    /// # Errors
    ///
    /// `columns-missing` (usage) when `spec` names a column that the header does not have.
    pub fn of_header(header: &[u8], spec: Option<&ColumnsSpec>) -> Result<Option<Self>> {
        let Some((form, names)) = header_names(header) else {
            return Ok(None);
        };
        Self::new(form, Some((names, header)), &[], spec).map(Some)
    }

    /// By rows: the form of most of them, at least [`LEAST_ROWS`]; none where there are
    /// fewer. `header` is used if it has the form of the rows.
    ///
    /// # Errors
    ///
    /// As [`of_header`](Self::of_header).
    pub fn of_rows<'a>(
        rows: impl Iterator<Item = &'a [u8]> + Clone,
        header: Option<&[u8]>,
        spec: Option<&ColumnsSpec>,
    ) -> Result<Option<Self>> {
        let mut forms: Vec<(Form, usize)> = Vec::new();
        for form in rows.clone().filter_map(|row| Form::of(row).ok()) {
            match forms.iter_mut().find(|(known, _)| *known == form) {
                Some((_, n)) => *n += 1,
                None => forms.push((form, 1)),
            }
        }
        // Of equals the first: the last of the reversed.
        let most = forms.into_iter().rev().max_by_key(|(_, n)| *n);
        let Some((form, _)) = most.filter(|(_, n)| *n >= LEAST_ROWS) else {
            return Ok(None);
        };
        let sample: Vec<Vec<f64>> = rows
            .filter_map(|row| Some(form.numbers(row).ok()?.values))
            .collect();
        let named = |header| {
            let (own, names) = header_names(header)?;
            (own == form).then_some((names, header))
        };
        let names = header.and_then(named);
        Self::new(form, names, &sample, spec).map(Some)
    }

    fn new(
        form: Form,
        header: Option<(Vec<String>, &[u8])>,
        sample: &[Vec<f64>],
        spec: Option<&ColumnsSpec>,
    ) -> Result<Self> {
        let fields = form.fields();
        let (names, header) = match (form.names(), header) {
            (Some(names), _) => (Some(names), None),
            (None, Some((names, header))) => (Some(names), Some(header)),
            (None, None) => (None, None),
        };
        let layout = stream_layout(fields, names.as_deref(), sample, spec)?;
        let host_time = layout.field(Quantity::Time).is_none();
        let named = file_names(&layout, fields, names.as_deref(), spec.is_some());
        let mut notes = Vec::new();
        match (&names, header) {
            (None, _) => {
                let how = match spec {
                    Some(_) => "as given with --columns",
                    None => "recognised by the numbers",
                };
                notes.push(format!("# the board names no columns: {how}"));
            }
            (Some(own), Some(_)) if *own != named => {
                notes.push(format!("# the board names its columns {}", own.join(",")));
            }
            (Some(_), None) => {
                notes.push("# the board sends each number with its name".to_owned());
            }
            _ => {}
        }
        let separator = char::from(form.separator()).to_string();
        let unchanged = header.filter(|_| names.as_ref() == Some(&named));
        let mut columns = match unchanged {
            Some(header) => header.to_vec(),
            None => named.join(&separator).into_bytes(),
        };
        if host_time {
            columns = [HOST_TIME.as_bytes(), separator.as_bytes(), &columns[..]].concat();
            notes.push(format!(
                "# {HOST_TIME}: the board sends no time; this is the time of arrival at the computer, ms since the first row"
            ));
        }
        Ok(RowShape {
            columns,
            form,
            layout,
            notes,
            host_time,
        })
    }

    /// The header of the file.
    pub fn columns(&self) -> &[u8] {
        &self.columns
    }

    /// Lines that begin with `#`, for the head of the file.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Whether an accelerometer is recognised.
    #[cfg(test)]
    pub fn has_accel(&self) -> bool {
        self.layout.field(Quantity::Accel(0)).is_some()
    }

    /// Whether a header is written as the rows are, with a name for each number.
    pub fn fits(&self, header: &[u8]) -> bool {
        header_names(header).is_some_and(|(form, _)| form == self.form)
    }

    /// A row, and the line of it for the file.
    ///
    /// # Errors
    ///
    /// Why the line is none.
    pub fn row(&self, text: &[u8]) -> std::result::Result<(Vec<u8>, Row), Reason> {
        let numbers = self.form.numbers(text)?;
        let value = |quantity| {
            let field = self.layout.field(quantity)?;
            numbers.values.get(field).copied()
        };
        let axes = [0, 1, 2].map(|axis| value(Quantity::Accel(axis)));
        // Differences and parts of a stamp are no clock by themselves.
        let is_clock = !self.layout.sums_time && self.layout.fraction.is_none();
        let row = Row {
            stamp: value(Quantity::Time).filter(|_| is_clock),
            accel: match axes {
                [Some(x), Some(y), Some(z)] => Some([x, y, z]),
                _ => None,
            },
            temperature: value(Quantity::Temperature),
            sequence: None,
        };
        Ok((numbers.line, row))
    }

    /// A line of the file with its arrival time in front, where the board sends none.
    pub fn with_host_time(&self, line: Vec<u8>, time_s: f64) -> Vec<u8> {
        if !self.host_time {
            return line;
        }
        let mut stamped = format!("{:.1}", time_s * 1e3).into_bytes();
        stamped.push(self.form.separator());
        stamped.extend(line);
        stamped
    }
}

/// Whether a header can be used before the first row: it names an accelerometer, and not
/// just with the words of a sentence.
pub fn is_certain(header: &[u8]) -> bool {
    let names = header_names(header).filter(|(form, _)| form.separator() != b' ');
    names.is_some_and(|(form, names)| {
        let layout = stream_layout(form.fields(), Some(&names), &[], None);
        layout.is_ok_and(|layout| layout.field(Quantity::Accel(0)).is_some())
    })
}

/// The names of the columns in the file: those of the board, unless `--columns` says
/// otherwise; a channel's own name where there is none, and `c5` for an unknown column.
fn file_names(
    layout: &Layout,
    fields: usize,
    names: Option<&[String]>,
    is_given: bool,
) -> Vec<String> {
    let of_field = |field: usize| {
        let channel = layout.fields.iter().find(|(_, f)| *f == field);
        let channel = channel.map(|(quantity, _)| *quantity);
        let own = names.and_then(|names| names.get(field));
        let understood = own.and_then(|name| understand(name)).map(|c| c.quantity);
        match own {
            Some(own) if !is_given || understood == channel => return own.clone(),
            _ => {}
        }
        channel
            .and_then(|quantity| channel_name(quantity, layout.sums_time))
            .unwrap_or_else(|| format!("c{}", field + 1))
    };
    (0..fields).map(of_field).collect()
}

fn channel_name(quantity: Quantity, sums_time: bool) -> Option<String> {
    let axis = |i: usize| ["x", "y", "z"].get(i).copied().unwrap_or_default();
    Some(match quantity {
        Quantity::Time if sums_time => "dt".to_owned(),
        Quantity::Time => "Timestamp".to_owned(),
        Quantity::Accel(i) => format!("a{}", axis(i)),
        Quantity::Gyro(i) => format!("g{}", axis(i)),
        Quantity::Temperature => "temp".to_owned(),
        Quantity::Label => "label".to_owned(),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(shape: &RowShape) -> &str {
        std::str::from_utf8(shape.columns()).unwrap()
    }

    fn of_rows(rows: &[&str], header: Option<&str>, spec: Option<&str>) -> RowShape {
        let rows: Vec<&[u8]> = rows.iter().map(|row| row.as_bytes()).collect();
        let spec = spec.map(|spec| spec.parse::<ColumnsSpec>().unwrap());
        let header = header.map(str::as_bytes);
        let shape = RowShape::of_rows(rows.iter().copied(), header, spec.as_ref());
        shape.unwrap().unwrap()
    }

    #[test]
    fn a_header_says_what_the_numbers_are() {
        let of = |header: &str| {
            RowShape::of_header(header.as_bytes(), None)
                .unwrap()
                .unwrap()
        };
        let shape = of("t,ax,ay,az,temp,mx,my,mz");
        assert!(!shape.host_time && shape.has_accel() && shape.notes().is_empty());
        let (line, row) = shape.row(b"5,1,2,3,25,4,5,6").unwrap();
        let expected = Row {
            stamp: Some(5.0),
            accel: Some([1.0, 2.0, 3.0]),
            temperature: Some(25.0),
            sequence: None,
        };
        assert_eq!((&line[..], row), (&b"5,1,2,3,25,4,5,6"[..], expected));
        assert_eq!(shape.row(b"1,2,3"), Err(Reason::FieldCount));
        let shape = of("aX (g);aY (g);aZ (g)");
        assert_eq!(text(&shape), "t_host_ms;aX (g);aY (g);aZ (g)");
        let (line, row) = shape.row(b"1;2;3").unwrap();
        assert_eq!((row.stamp, row.accel), (None, Some([1.0, 2.0, 3.0])));
        assert_eq!(shape.with_host_time(line, 1.25), b"1250.0;1;2;3");
        assert_eq!(shape.notes().len(), 1);
        for (header, certain) in [
            ("ax,ay,az", true),
            ("x,y,z", true),
            ("Reading x y z", false),
            ("Hello, world, again", false),
            ("t,foo,bar", false),
        ] {
            assert_eq!(is_certain(header.as_bytes()), certain, "{header}");
        }
    }

    #[test]
    fn rows_say_it_where_no_header_does() {
        // Gravity shows which three are the accelerometer.
        let shape = of_rows(&["0.1 0.2 0.1 1.2 0.3 9.7"; 6], None, None);
        assert_eq!(text(&shape), "t_host_ms gx gy gz ax ay az");
        let rows: Vec<String> = (0..20).map(|i| format!("{},0.1,0.2,9.8", 10 * i)).collect();
        let mut rows: Vec<&str> = rows.iter().map(String::as_str).collect();
        rows.insert(0, "1,2,3");
        let shape = of_rows(&rows, None, None);
        assert_eq!(text(&shape), "Timestamp,ax,ay,az");
        let shape = of_rows(&["X: 0.1 Y: 0.2 Z: 9.8 m/s^2"; 5], None, None);
        assert_eq!(text(&shape), "t_host_ms,X (m/s^2),Y (m/s^2),Z (m/s^2)");
        // A header that says nothing by itself names the columns of rows that fit.
        let shape = of_rows(&["1;2;3;4"; 5], Some("p;q;r;u"), None);
        assert_eq!(
            (text(&shape), shape.has_accel()),
            ("t_host_ms;p;q;r;u", false)
        );
        let shape = of_rows(&["1;2;3;4;5"; 5], Some("p;q;r;u"), None);
        assert_eq!(text(&shape), "t_host_ms;c1;c2;c3;c4;c5");
        let few = [&b"1,2,3"[..]; 4];
        assert!(
            RowShape::of_rows(few.into_iter(), None, None)
                .unwrap()
                .is_none()
        );
    }

    #[test]
    fn the_option_names_columns_in_the_file() {
        let rows = ["7,1,2,3,4,5,6,7,8,9,10"; 5];
        let shape = of_rows(&rows, None, Some("t,gx,gy,gz,-,ax,ay,az"));
        assert_eq!(text(&shape), "Timestamp,gx,gy,gz,c5,ax,ay,az,c9,c10,c11");
        let spec: ColumnsSpec = "t=n,ax=u,ay=v,az=w".parse().unwrap();
        let shape = RowShape::of_header(b"n,u,v,w,ax", Some(&spec))
            .unwrap()
            .unwrap();
        assert_eq!(text(&shape), "Timestamp,ax,ay,az,c5");
        assert_eq!(shape.notes(), ["# the board names its columns n,u,v,w,ax"]);
        let error = RowShape::of_header(b"a,b,c", Some(&spec)).unwrap_err();
        assert_eq!(error.code(), "columns-missing");
    }
}
