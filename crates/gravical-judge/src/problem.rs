//! What is refused of options, and its sentences.

crate::errors! {
    "columns-syntax" usage:
        NoChannel { name: String } => "there is no channel \"{name}\"" =>
            "channels are t, dt, ax, ay, az, gx, gy, gz, temp and label; _ leaves a column to recognition, - skips it";
        NoEqualsSign { pair: String } => "\"{pair}\" has no =";
        NamedTwice { channel: String } => "{channel} is named twice";
    "date-syntax" usage:
        NoDate { text: String } => "\"{text}\" is not a date" => "write 2026-03-09 or 2026-03-09T10:15:00Z; without a zone it is UTC";
}
