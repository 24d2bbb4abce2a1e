//! What is refused of a session, and its sentences.

gravical_recording::errors! {
    "already-calibrated" input:
        AlreadyCalibrated => "the board sends calibrated values, as the line with its settings says: a calibration needs raw ones" =>
            "gravical live --format si: with it the sketch sends raw values";
    "no-rows" input:
        NoRows => "no row was received yet";
    "sections-empty" input:
        NoPose => "no pose was accepted in this session" => "`gravical live --resume` goes on with it";
    "recording-changed" input:
        OtherRows { lines: [u32; 2], pose: u32, journal: &'static str } =>
            "lines {} to {} are not those of pose {pose} in {journal}: the recording was changed", lines[0], lines[1] =>
            "to find the poses anew, give the recording instead of the folder";
    "journal-syntax" input:
        NotAnEvent { why: String } => "not an event: {why}" => "an event a line, as `gravical live` writes them";
    "command-unknown" usage:
        NoCommand { text: String } => "\"{text}\" is no command" =>
            "port NAME; simulate; undo; redo +x; take; latitude 48.1; gravity 9.81; stop; cancel; with a simulated sensor also +x, -z, 0.6 0.6 0.5, free, shake";
}
