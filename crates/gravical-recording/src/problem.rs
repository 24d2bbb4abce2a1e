//! What is refused in reading and writing, and its sentences.

use gravical_judge::Error;
use gravical_judge::finding::Misfit;

/// Names of columns that a hint lists.
const MAX_LISTED: usize = 16;
const A_RECORDING: &str = "a recording is a table of text: one sample a line, x, y and z of an accelerometer at least, separated by comma, semicolon, tab or spaces";

gravical_judge::errors! {
    "empty-file" input:
        EmptyFile => "the file is empty, or holds nothing but blanks and NUL bytes" => "record again: nothing was written to this file";
    "is-a-directory" input:
        IsDirectory => "this is a folder, not a recording" => "give its files, or the folder to `gravical calibrate`";
    "is-an-archive" input:
        IsArchive => "this is a ZIP archive, not a recording" => "unpack it and give the recording in it";
    "is-a-calibration" input:
        IsCalibration { file: String } => "this is a calibration file, not a recording" =>
            "`gravical check {file} RECORDING` tests it with a recording at rest, `gravical apply {file} RECORDING` applies it";
    "epochs-of-counts" input:
        EpochsOfCounts => "the file holds activity counts per epoch, not acceleration" => "export the raw acceleration (in ActiLife: a RAW CSV file)";
    "no-rows" input:
        NoRowRead { sum: String } => "no row could be read: {sum}" => "{A_RECORDING}";
        NoTable => "no table of samples was found: no rows of at least three numbers" => "{A_RECORDING}";
        FewRows => "no table of samples was found: only a few lines of numbers among others" => "{A_RECORDING}";
        LongRow => "no table of samples was found: a row of more than a megabyte" => "{A_RECORDING}";
        OneNumberALine => "no table of samples was found: one number a line" =>
            "`grep . FILE | paste -d, - - - > rows.csv` joins three lines to a row; give as many - as a row has numbers";
        IsMarkup => "this is HTML or XML; no table of samples was found in it" => "{A_RECORDING}";
        IsJson => "this is JSON; no table of samples was found in it" =>
            "one sample a line is read: `jq -c '.[]' FILE > rows.json` writes a list so, `jq -c '.NAME[]'` one that has a name, and `jq -r '[.t, .ax, .ay, .az] | transpose[] | @csv'` a list for each quantity";
        IsRosBag => "this is a bag of ROS 1, not a table" =>
            "`rostopic echo -b FILE.bag -p /TOPIC > imu.csv` writes the messages of sensor_msgs/Imu: %time, field.angular_velocity.x … and field.linear_acceleration.x … are read";
        IsDatabase => "this is a database (.db3 is a bag of ROS 2), not a table" =>
            "`ros2 topic echo --csv /TOPIC > imu.csv` beside `ros2 bag play FOLDER` writes the messages of sensor_msgs/Imu: stamp, angular velocity and linear acceleration are read";
        IsMcap => "this is an MCAP file (a bag of ROS 2), not a table" =>
            "`ros2 topic echo --csv /TOPIC > imu.csv` beside `ros2 bag play FILE` writes the messages of sensor_msgs/Imu; PlotJuggler exports CSV with __time, angular_velocity/x … and linear_acceleration/x …: both are read";
        IsUlog => "this is a log of PX4 (ULog), not a table" =>
            "`ulog2csv FILE.ulg` (pyulog) writes FILE_sensor_combined_0.csv: timestamp, gyro_rad[0] … and accelerometer_m_s2[0] … are read";
        IsBlackbox => "this is a log of Betaflight or INAV (Blackbox), not a table" =>
            "`blackbox_decode FILE.bbl` writes FILE.01.csv: time (us), gyroADC[0] … and accSmooth[0] … are read";
    "no-values" input:
        NoValues { channel: &'static str, rows: usize } => "{channel} has no value in any of the {rows} rows (empty or NaN)" => "choose other columns, as ax=…,ay=…,az=…";
        TextColumn { column: usize } => "column {column} holds texts, not numbers" => "convert it to numbers, or name other columns, as t=…,ax=…";
    "all-zero" input:
        AllZero { axes: Vec<String>, rows: usize } => "{} read zero or nothing in all {rows} rows: the sensor did not answer", axes.join(", ") =>
            "check the wiring (SDA, SCL, power) and that the sketch wakes the sensor";
    "columns-unknown" input:
        ColumnsUnknown { columns: usize } => "the file has no header and {columns} columns whose meaning the numbers do not show" =>
            "name them in order, as t,ax,ay,az,gx,gy,gz; - skips one";
        NamesMisfit { misfit: Misfit } => "{misfit}, and the numbers do not show their meaning" => "name them in order, as t,ax,ay,az,gx,gy,gz; - skips one";
    "no-accelerometer" input:
        TooFewAxes { axes: usize } => "{axes} of the columns may be axes, but an accelerometer has three" => "record x, y and z of the accelerometer";
        NoAccelerometer { names: Vec<String>, header_line: usize } => "no three columns are named as an accelerometer's x, y and z" => "{}", list_columns(&names);
    "gyroscope-alone" input:
        GyroscopeAlone => "this file holds a gyroscope and no accelerometer" => "give the accelerometer's recording as the input, and this file beside it";
    "no-gyroscope" input:
        NoGyroscope { names: Vec<String> } => "no three columns of this file are a gyroscope's x, y and z" =>
            "{}; give the file with the gyroscope, or name its columns, as gx=…,gy=…,gz=…", list_columns(&names).split(';').next().unwrap_or_default();
    "sensor-unknown" usage:
        SensorUnknown { wanted: String, sensors: Vec<String> } => "there is no sensor {wanted}" => "{}", match sensors.len() {
            0 | 1 => "this file has one sensor: leave the option out".to_owned(),
            _ => format!("give one of: {}", sensors.join(", ")),
        };
    "columns-missing" usage:
        TooManyNamed { named: usize, columns: usize } => "{named} columns are named, the file has {columns}" => "leave the last ones out";
        NoColumn { name: String, names: Vec<String> } => "there is no column \"{name}\"" => "{}", list_columns(&names);
    "header-differs" input:
        OtherHeader { line: usize } => "the header in line {line} has other columns, or another delimiter, than the first" => "{}", cut(0, line);
        OtherSettings { line: usize } => "the header in line {line} follows a line of the board with another range or format" => "{}", cut(0, line);
    "unit-changed" input:
        UnitChanged { norms: [f64; 2], line: usize, head: usize } =>
            "the magnitude at rest is {:.4} before line {line} and {:.4} from there on: the unit or range changed without a new header", norms[0], norms[1] =>
            "{}", cut(head, line);
    "shifted-columns" input:
        ShiftedColumns { norms: [f64; 2], line: usize, head: usize } =>
            "the magnitude at rest is {:.4} before line {line} and {:.4} from there on: the values stand in the columns of others: the bus lost a byte", norms[0], norms[1] =>
            "{}", cut(head, line);
    "too-many-labels" input:
        TooManyLabels => "the label column holds more than 254 words" => "leave the column out, or cut the file";
    "too-large" input:
        TooLarge { bytes: u64, lines: u64, head: usize } =>
            "the recording takes more than {:.1} GiB of memory, the share of this machine that it may take; {lines} lines fit", bytes as f64 / (1_u64 << 30) as f64 =>
            "{}", cut(head, lines as usize);
    "averaged" usage:
        Averaged => "the rows of this recording are means of neighbouring samples";
    "samples-length" usage:
        SamplesLength { columns: usize, lengths: Vec<usize>, names: usize } => "{columns} columns of {lengths:?} rows, and {names} names" =>
            "give every column one value for each row, NaN where there is none, and one name";
    "gyro-twice" usage:
        GyroTwice => "this recording has a gyroscope of its own, and a second one is given" => "leave the second one out, or ignore the recording's own";
    "gyro-restart" input:
        GyroRestart => "the time stamps restart in the middle: the files cannot be joined by them" =>
            "split both files where the board was reset, and read the parts separately";
    "gyro-length" input:
        GyroRows { gyro: usize, accel: usize } => "{gyro} rows of the gyroscope, {accel} of the accelerometer, without time stamps in both files to join them by" =>
            "give files with time stamps, or with the same rows";
        GyroLines { line: u64 } => "rows were set aside before line {line} in one of the files, and there are no time stamps in both to join them by" =>
            "give files with time stamps, or with the same rows";
    "gyro-overlap" input:
        GyroOverlap { name: String, spans_s: [[f64; 2]; 2] } =>
            "the two files have no time in common: {name} runs from {:.3} to {:.3} s, this one from {:.3} to {:.3} s", spans_s[0][0], spans_s[0][1], spans_s[1][0], spans_s[1][1] =>
            "give the two files of one recording, stamped by one clock, or the time unit of both";
    "stdout-target" usage:
        FileToStdout => "a file is written here, which standard output is not" => "name a file, or have the result printed";
        FolderToStdout => "several files are written into a folder, which standard output is not" => "name a folder (one that is called - is ./-)";
    "is-folder" usage:
        IsFolder => "a file name is needed; this is a folder" => "name a file in it";
    "exists" usage:
        Exists => "the file exists already; nothing was written" => "name another file, or replace it";
    "no-folder" usage:
        NoFolder { folder: String } => "there is no folder \"{folder}\"" => "create it first, or name a file elsewhere";
        FolderNotMade { why: String } => "the folder cannot be created: {why}" => "name a folder with write permission";
}

/// With the place and the options of those that are passed on before they are an error.
impl From<Problem> for Error {
    fn from(problem: Problem) -> Self {
        use Problem::*;
        let error = problem.clone().error();
        match problem {
            NoAccelerometer { header_line, .. } if header_line > 0 => {
                error.advise("columns", "").at_line(header_line)
            }
            ColumnsUnknown { .. }
            | NamesMisfit { .. }
            | NoAccelerometer { .. }
            | NoValues { .. }
            | TextColumn { .. } => error.advise("columns", ""),
            TooManyLabels => error.advise("columns", "label=-"),
            NoGyroscope { .. } => error.advise("gyro", "").advise("columns", ""),
            GyroscopeAlone => error.advise("gyro", ""),
            SensorUnknown { .. } => error.of_option("sensor"),
            TooManyNamed { .. } | NoColumn { .. } => error.of_option("columns"),
            _ => error,
        }
    }
}

/// A hint that lists the columns of a file.
fn list_columns(names: &[String]) -> String {
    if names.is_empty() {
        return "the file has no header: give the channels in order, as t,ax,ay,az".to_owned();
    }
    let names = names.iter().map(String::as_str);
    let list: Vec<&str> = names.filter(|n| !n.is_empty()).collect();
    let more = if list.len() > MAX_LISTED { ", …" } else { "" };
    let shown = list[..list.len().min(MAX_LISTED)].join(", ");
    format!("its columns are: {shown}{more}; assign them, as ax=…,ay=…,az=…")
}

/// How to read a file whose rows from a line on cannot be read with those before them; the first
/// `head_lines` belong to both parts.
fn cut(head_lines: usize, line: usize) -> String {
    let after = match head_lines {
        0 => format!("tail -n +{line} FILE"),
        _ => format!("sed '{},{}d' FILE", head_lines + 1, line - 1),
    };
    format!(
        "cut the file and read the parts: `sed '{line},$d' FILE > before.csv`, `{after} > after.csv`"
    )
}
