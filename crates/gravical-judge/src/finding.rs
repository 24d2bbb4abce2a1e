//! What is wrong, or merely worth knowing, in a recording or a result: its kind, its numbers, its lines and what was
//! done about it.
//!
//! Each crate has one enum of what it finds, made by [`findings!`](crate::findings): the sentences stand there. What was found is told. It decides nothing, but that a gate makes a calibration poor.

mod cases;

use std::fmt::Display;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::advice::{Advice, with_options};
use crate::spans::LineSpans;

pub use cases::{Case, EmptyCells, GyroMismatch, Misfit};
#[doc(hidden)]
pub type Map = serde_json::Map<String, Value>;

/// How much a finding matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Severity {
    /// Worth knowing; the result does not suffer.
    Note,
    /// The result may suffer, or an assumption was made that can be wrong.
    Warning,
}

/// One thing that was found, its lines, and what was done.
#[must_use = "a finding is reported"]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Finding {
    /// Kebab-case name of the case, stable, for scripts: `unit-mismatch`,
    /// `repeated-header`, `torn-line` …; `docs/recording.md` lists all.
    pub kind: String,
    /// How much it matters.
    pub severity: Severity,
    /// True for what makes a calibration poor.
    #[serde(default, skip_serializing_if = "is_false")]
    pub gate: bool,
    /// What was found, with numbers, and what was done.
    pub message: String,
    /// What the message says, by name.
    #[serde(default, skip_serializing_if = "Map::is_empty")]
    pub values: Map,
    /// Options that help, or that are better left out, as the message says.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub options: Vec<Advice>,
    /// The file, as it was given; null when it concerns all inputs together.
    #[serde(default)]
    pub file: Option<String>,
    /// Line ranges of the file, from 1, both ends included; the first
    /// [`LineSpans::KEPT`] of them.
    #[serde(default)]
    pub lines: Vec<[u64; 2]>,
    /// How many lines (or cells, or samples) are concerned in all.
    #[serde(default)]
    pub count: u64,
}

fn is_false(is_it: &bool) -> bool {
    !is_it
}

impl Finding {
    /// What [`findings!`](crate::findings) makes of a case.
    #[doc(hidden)]
    pub fn from_case((kind, weight): (&str, Weight), message: &dyn Display, values: Map) -> Self {
        Finding {
            kind: kind.to_owned(),
            severity: match weight {
                Weight::Note => Severity::Note,
                Weight::Warning | Weight::Loss | Weight::Gate => Severity::Warning,
            },
            gate: weight == Weight::Gate,
            message: message.to_string(),
            values,
            options: Vec::new(),
            file: None,
            lines: Vec::new(),
            count: 0,
        }
    }

    /// Of a case that matters little here.
    pub fn as_note(mut self) -> Self {
        self.severity = Severity::Note;
        self
    }

    /// Adds an option that helps, or that is better left out; the value as of [`Advice`].
    pub fn advise(mut self, option: impl Into<String>, value: impl Into<String>) -> Self {
        self.options.push(Advice::new(option, value));
        self
    }

    /// The message with its options, in the words of a surface.
    pub fn worded(&self, word: impl Fn(&Advice) -> String) -> String {
        with_options(&self.message, &self.options, word)
    }

    /// True if samples were lost or could not be read.
    pub fn is_loss(&self) -> bool {
        let mut losses = Case::KINDS.iter().filter(|k| k.weight == Weight::Loss);
        losses.any(|kind| kind.name == self.kind)
    }

    /// True for what the values show once there are enough: a channel that does not change, the end of the range.
    pub fn is_of_samples(&self) -> bool {
        let kinds = ["clipped", "frozen-axis", "repeated-rows", "sensor-hung"];
        kinds.contains(&&*self.kind)
    }

    /// Adds the lines it concerns.
    pub fn at_lines(mut self, spans: &LineSpans) -> Self {
        self.lines = spans.ranges().to_vec();
        self.count = spans.count();
        self
    }

    /// Adds how many lines, cells or samples it concerns.
    pub fn counting(mut self, count: u64) -> Self {
        self.count = count;
        self
    }

    /// Adds the file.
    pub fn in_file(mut self, file: &str) -> Self {
        self.file = Some(file.to_owned());
        self
    }
}

/// How much a kind matters.
#[doc(hidden)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Weight {
    Note,
    Warning,
    /// A warning: samples were lost or could not be read.
    Loss,
    /// A warning that makes a calibration poor.
    Gate,
}

/// An item of the lists of `docs/recording.md`, which are made of these.
#[doc(hidden)]
#[derive(Debug, Clone, Copy)]
pub struct Kind {
    pub name: &'static str,
    pub weight: Weight,
    /// That of its cases, where one differs.
    pub of_cases: &'static [Weight],
    /// When it is found, and what follows from it.
    pub meaning: &'static str,
    /// What the user should do; empty if nothing.
    pub remedy: &'static str,
}

/// Adds a value to those of a finding; what JSON cannot say is null. A function, since there are hundreds of values.
#[doc(hidden)]
pub fn add(values: &mut Map, name: &str, value: &impl Serialize) {
    fn insert(values: &mut Map, name: &str, value: serde_json::Result<Value>) {
        values.insert(name.to_owned(), value.unwrap_or_default());
    }
    insert(values, name, serde_json::to_value(value));
}

#[doc(hidden)]
#[macro_export]
macro_rules! own_weight {
    ($kind:ident) => {
        $crate::finding::Weight::$kind
    };
    ($kind:ident $own:ident) => {
        $crate::finding::Weight::$own
    };
}

/// The enum `Case` of what a crate finds, `Case::KINDS` for the lists of the documents, and `Case::finding`.
///
/// ```ignore
/// findings! {
///     "name-of-the-kind" Warning "when it is found" / "What the user should do":
///         // One sentence or more, each with the values that it says.
///         OneCase { count: u64 } => "{count} of them";
///         // That weighs otherwise than its kind.
///         AnotherCase { part: f64 } @ Note => "{:.0} %", 100.0 * part;
/// }
/// ```
#[doc(hidden)]
#[macro_export]
macro_rules! findings {
    ($($name:literal $weight:ident $meaning:literal / $remedy:literal:
        $($case:ident $({ $($field:ident: $of:ty),* $(,)? })? $(@ $own:ident)?
            => $said:literal $(, $part:expr)*;)+
    )*) => {
        /// What is found.
        #[doc(hidden)]
        #[derive(Debug, Clone)]
        pub enum Case {
            $($(#[doc = $said] $case $({ $(#[allow(missing_docs)] $field: $of),* })?,)+)*
        }

        impl Case {
            /// The kinds, in the order of the documents.
            pub const KINDS: &'static [$crate::finding::Kind] = &[$($crate::finding::Kind {
                name: $name,
                weight: $crate::finding::Weight::$weight,
                of_cases: &[$($crate::own_weight!($weight $($own)?)),+],
                meaning: $meaning,
                remedy: $remedy,
            },)*];

            fn row(&self) -> (&'static str, $crate::finding::Weight) {
                match self {
                    $($(Case::$case { .. } => ($name, $crate::own_weight!($weight $($own)?)),)+)*
                }
            }

            /// The finding, to which place and options are added.
            pub fn finding(self) -> $crate::finding::Finding {
                #[allow(unused_mut)]
                let mut values = $crate::finding::Map::new();
                match &self {
                    $($(Case::$case { $($($field),*)? } => {
                        $($($crate::finding::add(&mut values, stringify!($field), $field);)*)?
                    })+)*
                }
                $crate::finding::Finding::from_case(self.row(), &self, values)
            }
        }

        impl std::fmt::Display for Case {
            #[allow(unused_variables)]
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                match self { $($(Case::$case { $($($field),*)? } => write!(f, $said $(, $part)*),)+)* }
            }
        }
    };
}
