use super::*;

fn scanner(delimiter: Delimiter, slots: &[Option<usize>]) -> RowScanner {
    let mut scanner = RowScanner::new(delimiter, true, slots.len());
    for (field, slot) in slots.iter().enumerate() {
        if let Some(slot) = slot {
            scanner.assign(field, *slot);
        }
    }
    scanner
}

fn values(scanner: &RowScanner, line: &str) -> Result<Values, RowDefect> {
    let mut values = [0.0; SLOTS];
    scanner.scan(line.as_bytes(), &mut values, &mut (0, 0))?;
    Ok(values)
}

#[test]
fn fields_are_parsed_with_every_delimiter() {
    let comma = scanner(Delimiter::Byte(b','), &[Some(TIME), None, Some(1), Some(2)]);
    let v = values(&comma, "12,\"a,b\", -1.5 ,2e1").unwrap();
    assert_eq!((v[0], v[1], v[2]), (12.0, -1.5, 20.0));
    let semi = scanner(Delimiter::Byte(b';'), &[Some(1), Some(2)]);
    let v = values(&semi, "\"1,25\";-0,5").unwrap();
    assert_eq!((v[1], v[2]), (1.25, -0.5));
    let space = scanner(Delimiter::Whitespace, &[Some(1), Some(2)]);
    let v = values(&space, "   1.0\t  2.0  ").unwrap();
    assert_eq!((v[1], v[2]), (1.0, 2.0));
}

#[test]
fn defects_are_distinguished() {
    let s = scanner(Delimiter::Byte(b','), &[Some(1), Some(2), Some(3)]);
    assert_eq!(values(&s, "1,2"), Err(RowDefect::TooFewFields));
    assert_eq!(values(&s, "1,2,3,4"), Err(RowDefect::TooManyFields));
    assert_eq!(values(&s, "1,x2,3"), Err(RowDefect::NotANumber(1)));
    for blank in ["", ",,", ",,,,,", "  ", ",nan,"] {
        let got = values(&s, blank);
        assert!(
            matches!(got, Err(RowDefect::Blank | RowDefect::TooFewFields)),
            "{blank}: {got:?}"
        );
    }
    let some = values(&s, "1,,NaN").unwrap();
    assert!(some[1] == 1.0 && some[2].is_nan() && some[3].is_nan());
    let some = values(&s, "1,1e999, -1e100").unwrap();
    assert!(some[1] == 1.0 && some[2].is_nan() && some[3].is_nan());
}

#[test]
fn dates_count_as_time_stamps() {
    let s = scanner(Delimiter::Byte(b','), &[Some(TIME), Some(1)]);
    let a = values(&s, "2025-03-01 12:00:00.010,1").unwrap()[0];
    let b = values(&s, "2025-03-01T12:00:00.035Z,1").unwrap()[0];
    assert!((b - a - 0.025).abs() < 1e-6);
    assert_eq!(values(&s, "12:00:01.5,1").unwrap()[0], 43201.5);
}

#[test]
fn spans_cover_the_fields() {
    let s = scanner(Delimiter::Byte(b','), &[Some(1), None, Some(2)]);
    let (mut values, mut spans) = ([0.0; SLOTS], Vec::new());
    s.scan_spans(b"1.5,abc,2", &mut values, &mut spans).unwrap();
    assert_eq!(spans, [(0, 3), (4, 7), (8, 9)]);
}
