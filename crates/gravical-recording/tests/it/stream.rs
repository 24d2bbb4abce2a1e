//! Rows behind those by which a recording was judged are read as the first ones.

use gravical_recording::bytes::from_reader;
use gravical_recording::{Error, Piece, ReadOptions, Recording, Stream};

use crate::support::*;

/// The pieces of a text that is judged by its first rows, and the account of its lines.
fn stream(text: &str, head_rows: usize) -> Result<(Vec<Piece>, Recording), Error> {
    let input = from_reader(Box::new(std::io::Cursor::new(text.to_owned())), false).unwrap();
    let options = ReadOptions::default();
    let mut stream = Stream::open(input, "log.csv", &options, head_rows, |_| vec![(0, 0)])?;
    let mut pieces = Vec::new();
    while let Some(piece) = stream.next_piece()? {
        pieces.push(piece);
    }
    Ok((pieces, stream.finish()))
}

/// A channel of all measurements.
fn measured(pieces: &[Piece], channel: impl Fn(&Piece) -> &[f64]) -> Vec<f64> {
    let of_piece = |piece: &Piece| {
        let cells = channel(piece).iter().zip(&piece.is_measured);
        let cells: Vec<f64> = cells.filter(|(_, m)| **m).map(|(v, _)| *v).collect();
        cells
    };
    pieces.iter().flat_map(of_piece).collect()
}

/// The text is read alike whole and behind its first rows; the blocks of a stream are long, so that
/// these are repeated until there are several.
fn assert_reads_alike(header: &str, rows: &[String]) {
    let rows = rows.join("\n") + "\n";
    let text = format!("{header}\n{}", rows.repeat(600_000 / rows.len() + 1));
    let whole = read(&text, "log.csv");
    let (pieces, account) = stream(&text, 200).unwrap();
    assert!(pieces.len() > 2, "{header}");
    for axis in 0..3 {
        let same = measured(&pieces, |piece| &piece.accel[axis]) == whole.accel[axis];
        assert!(same, "{header}: {axis}");
        if let Some(gyro) = &whole.gyro {
            let same = measured(&pieces, |piece| &piece.gyro.as_ref().unwrap()[axis]) == gyro[axis];
            assert!(same, "{header}: rates {axis}");
        }
    }
    let lines = pieces.iter().flat_map(|piece| &piece.lines).count();
    assert_eq!(lines + account.ledger.total(), text.lines().count());
    assert_eq!(account.ledger.lines, text.lines().count());
}

/// Counts of a sensor on its six faces, at 16384 per g.
fn counts(of: impl Fn(usize, [i32; 6]) -> String) -> Vec<String> {
    let rows = six_faces(3).into_iter().enumerate();
    rows.map(|(i, row)| {
        let accel = row.accel_g.map(|v| (16_384.0 * v).round() as i32);
        let gyro = row.gyro_deg_s.map(|v| (131.0 * v).round() as i32);
        of(i, [accel[0], accel[1], accel[2], gyro[0], gyro[1], gyro[2]])
    })
    .collect()
}

fn joined<const N: usize>(cells: &[i32; N]) -> String {
    cells.map(|cell| cell.to_string()).join(",")
}

#[test]
fn rows_behind_the_first_are_read_alike() {
    let header = "flag,ax,ay,az,gx,gy,gz";
    let unsigned = counts(|_, v| format!("7,{}", joined(&v.map(|v| v & 0xffff))));
    assert_reads_alike(header, &unsigned);
    let offset = counts(|_, v| {
        let accel = [v[0] / 4 + 32_768, v[1] / 4 + 32_768, v[2] / 4 + 32_768];
        format!("7,{}", joined(&accel))
    });
    assert_reads_alike("flag,ax,ay,az", &offset);
    let two_sensors = counts(|i, v| format!("{},0,{}\n{},1,5,6,7,1,2,3", i, joined(&v), i));
    assert_reads_alike("flag,I,ax,ay,az,gx,gy,gz", &two_sensors);
    // A value holds until the next one: this recording is read whole.
    let sparse = counts(|i, [x, y, z, ..]| match i % 3 {
        0 => format!("7,{x},{y},{z}"),
        _ => format!("7,{x},{y},"),
    });
    let text = format!("flag,ax,ay,az\n{}\n", sparse.join("\n"));
    let (pieces, _) = stream(&text, 200).unwrap();
    let z = measured(&pieces, |p| &p.accel[2]);
    assert_eq!(z, read(&text, "log.csv").accel[2]);
    let zeros = counts(|i, v| match i {
        120..130 | 250.. => "7,0,0,0,0,0,0".to_owned(),
        _ => format!("7,{}", joined(&v)),
    });
    assert_reads_alike(header, &zeros);
}

#[test]
fn another_header_in_the_middle_ends_the_reading_with_its_line() {
    let rows = counts(|i, v| format!("{},{}\n", 40 * i, joined(&v))).concat();
    let many = rows.repeat(60);
    let text = format!("ms,ax,ay,az,gx,gy,gz\n{many}ms,temp,ax,ay,az,gx,gy\n{rows}");
    let line = 2 + 60 * 300;
    let error = stream(&text, 200).map(|_| ()).unwrap_err();
    assert_eq!(error.code(), "header-differs");
    assert_eq!(error.location().unwrap().line, Some(line));
    let cut = format!("tail -n +{line} FILE > after.csv");
    assert!(error.hint().unwrap().contains(&cut), "{error}");
}
