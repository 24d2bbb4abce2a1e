//! Files that are no recording, recognised by their first bytes, so that the error says what they
//! are instead of asking for their columns.

use std::path::Path;

use gravical_judge::Result;
use gravical_judge::escape::path_word;

use crate::problem::Problem;

/// Files of other tools by their first bytes.
const CONTAINERS: [(&[u8], Problem); 5] = [
    (b"#ROSBAG", Problem::IsRosBag),
    (b"SQLite format 3", Problem::IsDatabase),
    (b"\x89MCAP0", Problem::IsMcap),
    (b"ULog\x01\x12\x35", Problem::IsUlog),
    (b"H Product:Blackbox", Problem::IsBlackbox),
];

/// Refuses the files of other tools by their first bytes, before they are decoded.
///
/// # Errors
///
/// `no-rows` with the command that makes a table of one.
pub(crate) fn refuse_container(magic: &[u8], file: &Path) -> Result<()> {
    let mut containers = CONTAINERS.into_iter();
    match containers.find(|(first, _)| magic.starts_with(first)) {
        Some((_, problem)) => Err(problem.error().at(file, None)),
        None => Ok(()),
    }
}

/// Refuses a calibration file.
///
/// # Errors
///
/// `is-a-calibration` with the commands that take one.
pub(crate) fn refuse_calibration(head: &[u8], file: &Path) -> Result<()> {
    let has = |word: &[u8]| memchr::memmem::find(head, word).is_some();
    let content = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
    let is_one = content.trim_ascii_start().first() == Some(&b'{')
        && (has(b"\"gravical-calibration/") || has(b"\"K_a\"") && has(b"\"b_a\""));
    if !is_one {
        return Ok(());
    }
    let word = path_word(file);
    Err(Problem::IsCalibration { file: word }.error().at(file, None))
}

#[cfg(test)]
mod tests {
    use crate::{ReadOptions, read_bytes};

    #[test]
    fn files_that_are_no_recording_are_named() {
        let words = "Bias and scale of x, y and z are listed below.\n".repeat(30);
        let page = "<p>words of a page</p>\n".repeat(30);
        // A list of numbers in a text is no table.
        let list = format!("{words}| x | 1 | 2 | 3 |\n{words}");
        let page = format!("{page}<line 1, 2, 3, 4, 5 />\n<line 1, 2, 3, 4, 6 />\n{page}");
        let epochs = "Epoch Period (hh:mm:ss) 00:00:15\nAxis1,Axis2,Axis3\n".to_owned()
            + &"3,5,8\n".repeat(300);
        let calibration =
            "{\n  \"format\": \"gravical-calibration/3\",\n  \"bias\": [1, 2, 3]\n}\n";
        let object = "{\n  \"values\": [\n    1.0,\n    2.0\n  ]\n}\n";
        let is_calibration = "this is a calibration file";
        let files: [(&[u8], &str); 12] = [
            (calibration.as_bytes(), is_calibration),
            (
                b"{\"K_a\": [[1, 0, 0]], \"b_a\": [1, 2, 3]}",
                is_calibration,
            ),
            (b"#ROSBAG V2.0\n\x13\xff", "this is a bag of ROS 1"),
            (b"SQLite format 3\0\x10\0\x01\x01", "this is a database"),
            (b"\x89MCAP0\r\n\x01", "this is an MCAP file"),
            (b"ULog\x01\x12\x35\x01", "this is a log of PX4"),
            (
                b"H Product:Blackbox flight data\nH 1\n",
                "this is a log of Betaflight",
            ),
            (object.as_bytes(), "this is JSON"),
            (words.as_bytes(), "no table of samples"),
            (list.as_bytes(), "no table of samples"),
            (page.as_bytes(), "this is HTML"),
            (epochs.as_bytes(), ""),
        ];
        for (bytes, what) in files {
            let error = read_bytes(bytes, "file", &ReadOptions::default()).unwrap_err();
            let code = match what {
                "" => "epochs-of-counts",
                _ if what == is_calibration => "is-a-calibration",
                _ => "no-rows",
            };
            assert_eq!(error.code(), code, "{what}");
            assert!(error.message().starts_with(what), "{error}");
        }
    }

    #[test]
    fn a_log_with_more_messages_than_rows_is_a_recording() {
        let message = "[INFO] sensor connected, waiting for the next sample of it\n".repeat(3);
        let row = |i: usize| format!("{message}{},0.01,0.02,9.8{}\n", 10 * i, i % 3);
        let text = "t_ms,ax,ay,az\n".to_owned() + &(0..200).map(row).collect::<String>();
        let recording = read_bytes(text.as_bytes(), "log", &ReadOptions::default()).unwrap();
        assert_eq!(recording.rows(), 200);
    }
}
