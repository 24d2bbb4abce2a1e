//! Tables: copied columns byte for byte, new ones with the decimal sign and delimiter of the input.

use gravical_recording::write::{Table, Writer};
use gravical_recording::{Format, ReadOptions, Rows, sniff};

fn write(
    text: &str,
    format: &Format,
    table: Table,
    values: impl Fn(&Rows) -> Vec<Vec<f64>>,
) -> String {
    let mut out = Vec::new();
    let parsed = format.parse_with_text(text.as_bytes(), table.copied(), |_| Ok(()));
    let parsed = parsed.unwrap();
    let mut writer = Writer::new(&mut out, table);
    let values = values(&parsed);
    let values: Vec<&[f64]> = values.iter().map(Vec::as_slice).collect();
    let breaks: Vec<usize> = parsed.blanks.iter().map(|b| b.0).collect();
    let done = writer.write_rows(0..parsed.rows(), &parsed.text, &values, &breaks);
    done.unwrap();
    writer.finish().unwrap();
    String::from_utf8(out).unwrap()
}

/// The axes of the accelerometer with three decimals under new names.
fn rewritten(text: &str, keep_replaced: bool) -> (String, Table) {
    let format = sniff(text, "", &ReadOptions::default()).unwrap();
    let new = [0, 1, 2].map(|i| {
        let name = ["new_x", "new_y", "new_z"][i];
        (name.to_owned(), Some(format.accel[i]))
    });
    let table = Table::with_new(&format, &new, 3, keep_replaced);
    let axes = |b: &Rows| format.accel.map(|c| b.columns[c].clone()).to_vec();
    (write(text, &format, table.clone(), axes), table)
}

#[test]
fn other_columns_are_copied_byte_for_byte() {
    let text = "\"note, of mine\",aX (g),t, aZ (g),aY (g),flag\n\
        \"a,b\",0.1, 007,9.80,0.1,+1e0\n\
        \"c\"\"d\",0.1,8 ,9.81,0.2, x\r\n\
        \n\
        \u{0}e,,9,9.8,\"0.2\",\"\"\n\
        f,0.1,9,9.8,0.2,\n";
    let (out, table) = rewritten(text, false);
    assert_eq!(
        out,
        "\"note, of mine\",new_x,t,new_z,new_y,flag\n\
         \"a,b\",0.100, 007,9.800,0.100,+1e0\n\
         \"c\"\"d\",0.100,8 ,9.810,0.200, x\n\
         \n\
         e,,9,9.800,0.200,\"\"\n\
         f,0.100,9,9.800,0.200,\n"
    );
    assert_eq!(table.names[0], "note, of mine");
}

#[test]
fn delimiters_and_decimal_commas_are_kept() {
    let plain = "t,new_x,new_y,new_z,T\n0.5,0.100,0.200,9.800,25.5\n0.6,0.100,-0.200,9.700,25.5\n";
    let commas = "t,ax,ay,az,T\n0.5,0.1,0.2,9.8,25.5\n0.6,0.1,-0.2,9.7,25.5\n";
    let semicolons = "t;ax;ay;az;T\n0,5;0,1;0,2;9,8;25,5\n0,6;0,1;-0,2;9,7;25,5\n";
    let padded = " t  ax ay az   T\n 0.5 0.1   0.2 9.8 25.5 \n0.6\t0.1 -0.2 9.7  25.5\n";
    let spaces = "t ax ay az T\n0,5 0,1 0,2 9,8 25,5\n0,6 0,1 -0,2 9,7 25,5\n";
    for (text, delimiter, comma) in [
        (commas, ",", "."),
        (semicolons, ";", ","),
        (padded, "\t", "."),
        (spaces, "\t", ","),
    ] {
        let (out, _) = rewritten(text, false);
        let expected = plain.replace('.', "point").replace(',', delimiter);
        assert_eq!(out, expected.replace("point", comma), "{text}");
    }
}

#[test]
fn replaced_columns_can_be_kept_under_names_of_their_own() {
    let text = "t,new_x,ay,az,input_new_x\n0,0.1,0.2,9.80,1\n1,0.1,0.2,9.81,2\n";
    let text = text
        .replace("new_x,ay", "ax,new_x")
        .replace("new_x,az", "ay,az");
    let (out, _) = rewritten(&text, true);
    assert!(
        out.starts_with("t,ax,ay,az,input_new_x,new_x,new_y,new_z\n0,0.1,0.2,9.80,1,0.100,"),
        "{out}"
    );
    let text = "t,ax,ay,az,new_x,input_new_x\n0,0.1,0.2,9.80,1,5\n1,0.1,0.2,9.81,2,5\n";
    let (out, _) = rewritten(text, false);
    let header = "t,new_x,new_y,new_z,input_input_new_x,input_new_x";
    assert_eq!(out.lines().next(), Some(header));
}
