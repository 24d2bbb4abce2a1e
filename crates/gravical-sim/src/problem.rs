//! What is refused of a simulation, and its sentences.

const HELP: &str = "`gravical simulate --help` explains the options";

gravical_judge::errors! {
    "simulate-option" usage:
        OutOfRange { name: &'static str, value: f64, unit: &'static str, low: f64, high: f64 } =>
            "{name} is {value} {unit}; it has to be between {low} and {high}" => "{HELP}";
        OtherRange { range_g: u32 } => "range {range_g} g: the part has 2, 4, 8, 16 g" => "{HELP}";
        RawWithHeader => "raw counts have no header of units" => "{HELP}";
        TooManyRows { rows: usize, max: usize } => "{rows} rows; {max} at most: lower the rate or the duration" => "{HELP}";
        NoDirection => "a direction needs three numbers that are not all 0" => "{HELP}";
}
