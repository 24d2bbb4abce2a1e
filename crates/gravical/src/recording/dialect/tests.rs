use super::*;

fn of(text: &str) -> Dialect {
    sniff(text.as_bytes(), true, 3).expect("a dialect")
}

#[test]
fn delimiters_and_decimal_commas() {
    assert_eq!(of("1,2,3\n4,5,6\n").delimiter, Delimiter::Byte(b','));
    assert_eq!(of("1;2;3\n4;5;6\n").delimiter, Delimiter::Byte(b';'));
    assert_eq!(of("1\t2\t3\n").delimiter, Delimiter::Byte(b'\t'));
    assert_eq!(of("  1.0   2  3\n").delimiter, Delimiter::Whitespace);
    assert_eq!(of("1, 2, 3\n4, 5, 6\n").delimiter, Delimiter::Byte(b','));
    let d = of("t;x;y\n0,5;1,25;-3,0\n0,6;1,25;-3,0\n");
    assert!(d.delimiter == Delimiter::Byte(b';') && d.decimal_comma);
    assert_eq!(d.sample[0], [0.5, 1.25, -3.0]);
}

#[test]
fn quoted_fields() {
    let texts = |line: &str, delimiter| -> Vec<String> {
        let fields = split(line.as_bytes(), Delimiter::Byte(delimiter));
        fields.iter().map(|f| decode(f)).collect()
    };
    assert_eq!(
        texts(r#" "a, ""b""" ,"c", d "e, "" ,"f,g"#, b','),
        ["a, \"b\"", "c", "d \"e", "", "\"f", "g"]
    );
    assert_eq!(texts("\"1\"\t\t\"2\"", b'\t'), ["1", "", "2"]);
}

#[test]
fn header_after_metadata() {
    let d = of("Fs,100\nWaiting time,3\nax,ay,az,gx,gy,gz\n-12,-8,15,1,2,3\n");
    let header = d.header.unwrap();
    assert_eq!(header.names, ["ax", "ay", "az", "gx", "gy", "gz"]);
    assert_eq!((header.lines, d.first_data_line), ([3, 3], 4));
    assert_eq!(d.metadata, ["Fs,100", "Waiting time,3"]);
}

#[test]
fn two_header_rows_and_commented_headers() {
    let d = of("sensor,left,right,left,right\naxis,acc_x,acc_x,acc_y,acc_y\n0,1,2,3,4\n");
    assert_eq!(d.header.unwrap().names[1], "left.acc_x");
    let d = of("# t ax ay az\n0 1 2 3\n");
    assert_eq!(d.header.unwrap().names, ["t", "ax", "ay", "az"]);
}

#[test]
fn sparse_rows_are_rows() {
    let d = of("t,lin,AccX,AccY,AccZ\n0,,,,11.2\n1,,-0.6,,\n2,,,4.2,\n");
    assert_eq!((d.fields, d.first_data_line), (5, 2));
}

#[test]
fn text_is_not_a_recording() {
    assert!(sniff(b"Permission is hereby granted,\nfree of charge\n", true, 3).is_none());
    assert!(sniff(b"", true, 3).is_none());
}
