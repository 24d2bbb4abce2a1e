//! What is refused of a session and of a recording, and its sentences.

gravical_judge::errors! {
    "already-calibrated" input:
        AlreadyCalibrated => "the board sends calibrated values, as the line with its settings says: a calibration needs raw ones" =>
            "let the sketch send raw values";
    "no-rows" input:
        NoRows => "no row was received yet";
    "sections-empty" input:
        NoPose => "no pose was accepted in this session" => "go on with the session in live";
    "recording-changed" input:
        OtherRows { lines: [u32; 2], pose: u32, journal: &'static str } =>
            "lines {} to {} are not those of pose {pose} in {journal}: the recording was changed", lines[0], lines[1] =>
            "to find the poses anew, give the recording instead of the folder";
    "journal-syntax" input:
        NotAnEvent { why: String } => "not an event: {why}" => "a journal has one event a line";
    "command-unknown" usage:
        NoCommand { text: String } => "\"{text}\" is no command" =>
            "port NAME; simulate; undo; redo +x; take; latitude 48.1; gravity 9.81; stop; cancel; with a simulated sensor also +x, -z, 0.6 0.6 0.5, free, shake";
    "board-silent" device:
        BoardSilent { port: String } => "{port} is open, but nothing arrives: does the board have a sketch?" =>
            "check that it is the right port, and that its sketch prints rows, as firmware/mpu6050_logger does";
    "board-not-text" device:
        NoText { port: String } => "what {port} sends is not text: the board uses another baud rate, or it has no sketch" =>
            "give the baud rate of the sketch, for example 9600 or 57600";
    "no-samples-from-board" device:
        NoSensor { port: String, line: String } => "{port} sends text that is no row of a sensor: {line:?}" =>
            "a row has at least three numbers, as firmware/mpu6050_logger prints them; say what its columns are";
    "settings-refused" device:
        NoSettings => "the board does not report the settings that were sent to it" =>
            "upload firmware/mpu6050_logger to the board, or leave the settings out";
    "columns-changed" device:
        OtherColumns { line: String } => "the board sends rows of other columns or units than before ({line:?}): the recording ends" =>
            "the rows up to here are in the file; record the rest into another one, or set the board as it was";
    "unreadable-rows" device:
        Unreadable { why: String } => "the rows cannot be read any more ({why}): the recording ends" =>
            "the rows up to here are in the file; record the rest into another one";
}
