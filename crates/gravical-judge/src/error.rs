//! The error type of gravical.
//!
//! An error gives what happened, where, why and what to do next. `code` is stable and intended
//! for scripts; the text is intended for people and contains the numbers.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use crate::advice::{Advice, with_options};
use crate::escape::one_line;

/// Shorthand for results of this library.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Cause of an error; determines the exit code of the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Category {
    /// Wrong usage: an option that does not fit (exit 2).
    Usage,
    /// The recording or file does not contain what is needed (exit 3).
    Input,
    /// The machine: disk, permissions (exit 1).
    System,
    /// The board, its port or the cable to it (exit 5).
    Device,
}

/// A place in a file, as far as known.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Location {
    /// Path of the file as given, `-` for standard input.
    pub path: PathBuf,
    /// Line, from 1.
    pub line: Option<u64>,
    /// Column of that line, from 1.
    pub column: Option<u64>,
}

/// An error with cause, place and hint; `Debug` writes what a `main` that returns it should show.
#[must_use = "an error is returned"]
pub struct Error(Box<Inner>);

struct Inner {
    category: Category,
    code: &'static str,
    message: String,
    /// Option with the value that is not possible.
    option: Option<&'static str>,
    hint: Option<String>,
    options: Vec<Advice>,
    location: Option<Location>,
    source: Option<io::Error>,
}

impl Error {
    fn new(category: Category, code: &'static str, message: impl Into<String>) -> Self {
        Error(Box::new(Inner {
            category,
            code,
            message: message.into(),
            option: None,
            hint: None,
            options: Vec::new(),
            location: None,
            source: None,
        }))
    }

    /// What [`errors!`](crate::errors) makes of a case.
    #[doc(hidden)]
    pub fn of_row(
        category: Category,
        code: &'static str,
        said: fmt::Arguments<'_>,
        hint: Option<&fmt::Arguments<'_>>,
    ) -> Self {
        let mut error = Self::new(category, code, fmt::format(said));
        error.0.hint = hint.map(|hint| fmt::format(*hint));
        error
    }

    /// The recording or file does not contain what is needed.
    pub fn input(code: &'static str, message: impl Into<String>) -> Self {
        Self::new(Category::Input, code, message)
    }

    /// An invalid option or combination of options.
    pub fn usage(code: &'static str, message: impl Into<String>) -> Self {
        Self::new(Category::Usage, code, message)
    }

    /// A value of an option that is not possible: `option-range`. As [`Error::option`].
    pub fn range(option: &'static str, message: impl Into<String>) -> Self {
        Self::usage("option-range", message).of_option(option)
    }

    /// Sets the [option](Error::option) that is the cause.
    pub fn of_option(mut self, option: &'static str) -> Self {
        self.0.option = Some(option);
        self
    }

    /// The board, its port or the cable to it fails.
    pub fn device(code: &'static str, message: impl Into<String>) -> Self {
        Self::new(Category::Device, code, message)
    }

    /// A failed read or write of `path`, or the error of this type that its reader passes on.
    pub fn io(path: &Path, source: io::Error) -> Self {
        Self::from(source).in_file(path)
    }

    /// Adds a hint, in place of one with its options that is there.
    pub fn with_hint(mut self, hint: impl Into<String>) -> Self {
        self.0.hint = Some(hint.into());
        self.0.options.clear();
        self
    }

    /// Adds an option that helps, or that is better left out; the value as of [`Advice`].
    pub fn advise(mut self, option: impl Into<String>, value: impl Into<String>) -> Self {
        self.0.options.push(Advice::new(option, value));
        self
    }

    /// Adds the place.
    pub fn at(mut self, path: &Path, line: Option<u64>) -> Self {
        self.0.location = Some(Location {
            path: path.to_path_buf(),
            line,
            column: None,
        });
        self
    }

    /// Adds the line, from 1, of a file that whoever opened it [adds](Error::in_file).
    pub fn at_line(self, line: usize) -> Self {
        self.at(Path::new(""), Some(line as u64))
    }

    /// Adds the column to a place with a line.
    pub fn at_column(mut self, column: u64) -> Self {
        if let Some(place) = &mut self.0.location {
            place.column = Some(column);
        }
        self
    }

    /// Sets the file of a place, whose line and column remain.
    pub fn in_file(mut self, path: &Path) -> Self {
        match &mut self.0.location {
            Some(place) => place.path = path.to_path_buf(),
            None => self = self.at(path, None),
        }
        self
    }

    /// Adds to the message.
    pub fn with_detail(mut self, text: &str) -> Self {
        self.0.message += text;
        self
    }

    /// Stable code for scripts: `missing-face`, `unit-unknown` ….
    pub fn code(&self) -> &'static str {
        self.0.code
    }

    /// The message without option, place and hint.
    pub fn message(&self) -> &str {
        &self.0.message
    }

    /// The option that is the cause, for example `pose_tilt`, if it is one.
    pub fn option(&self) -> Option<&'static str> {
        self.0.option
    }

    /// The options that help, or that are better left out, as the hint or else the message says.
    pub fn options(&self) -> &[Advice] {
        &self.0.options
    }

    /// The whole text without the hint, with options in the words of a surface: flags, keywords.
    pub fn worded(&self, word: impl Fn(&Advice) -> String) -> String {
        let mut text = String::new();
        if let Some(place) = &self.0.location {
            let name = match place.path.to_str() {
                Some("-") => "standard input".into(),
                Some("") => "the recording".into(),
                _ => place.path.to_string_lossy(),
            };
            text += &one_line(&name);
            for number in [place.line, place.column].into_iter().flatten() {
                text += &format!(":{number}");
            }
            text += ": ";
        }
        if let Some(option) = self.0.option {
            text += &format!("{}: ", word(&Advice::new(option, "")));
        }
        text += &one_line(&self.0.message);
        match self.0.hint {
            Some(_) => text,
            None => with_options(&text, &self.0.options, word),
        }
    }

    /// The hint in the words of a surface.
    pub fn worded_hint(&self, word: impl Fn(&Advice) -> String) -> Option<String> {
        let hint = self.0.hint.as_deref()?;
        Some(with_options(hint, &self.0.options, word))
    }

    /// The hint without its options, if any.
    pub fn hint(&self) -> Option<&str> {
        self.0.hint.as_deref()
    }

    /// The place, if known.
    pub fn location(&self) -> Option<&Location> {
        self.0.location.as_ref()
    }

    /// Cause of the error.
    pub fn category(&self) -> Category {
        self.0.category
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.worded(Advice::to_string))
    }
}

impl From<io::Error> for Error {
    fn from(source: io::Error) -> Self {
        let source = match source.downcast::<Error>() {
            Ok(error) => return error,
            Err(source) => source,
        };
        // A missing or invalid file is an input error; a full disk is not.
        let (category, code) = match source.kind() {
            io::ErrorKind::NotFound => (Category::Input, "not-found"),
            io::ErrorKind::PermissionDenied => (Category::Input, "permission-denied"),
            io::ErrorKind::InvalidData
            | io::ErrorKind::InvalidInput
            | io::ErrorKind::UnexpectedEof => (Category::Input, "unreadable"),
            io::ErrorKind::IsADirectory => (Category::Input, "is-a-directory"),
            _ => (Category::System, "io"),
        };
        let mut error = match code {
            "not-found" => Self::new(category, code, "there is no such file")
                .with_hint("check the path; relative ones start at the current folder"),
            _ => Self::new(category, code, source.to_string()),
        };
        error.0.source = Some(source);
        error
    }
}

impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self} ({})", self.0.code)?;
        match self.worded_hint(Advice::to_string) {
            Some(hint) => write!(f, "\n  hint: {}", one_line(&hint)),
            None => Ok(()),
        }
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        self.0.source.as_ref().map(|e| e as _)
    }
}

#[doc(hidden)]
#[macro_export]
macro_rules! category {
    (input) => {
        $crate::Category::Input
    };
    (usage) => {
        $crate::Category::Usage
    };
    (device) => {
        $crate::Category::Device
    };
}

/// The enum `Problem` of what a crate refuses, and `Problem::error`.
///
/// ```ignore
/// errors! {
///     "code-for-scripts" input:
///         // One sentence or more, each with the values that it says; behind `=>` what helps.
///         OneProblem { rows: usize } => "{rows} rows are too few" => "record for longer";
///         OtherProblem => "nothing was written";
/// }
/// ```
#[doc(hidden)]
#[macro_export]
macro_rules! errors {
    ($($code:literal $category:ident:
        $($case:ident $({ $($field:ident: $of:ty),* $(,)? })?
            => $said:literal $(, $part:expr)* $(=> $hint:literal $(, $hint_part:expr)*)?;)+
    )*) => {
        /// What is refused.
        #[derive(Debug, Clone)]
        pub(crate) enum Problem {
            $($(#[doc = $said] $case $({ $($field: $of),* })?,)+)*
        }

        impl Problem {
            /// The error, to which place and options are added.
            #[allow(unused_variables)]
            pub fn error(self) -> $crate::Error {
                match self {
                    $($(Problem::$case { $($($field),*)? } => $crate::Error::of_row(
                        $crate::category!($category),
                        $code,
                        format_args!($said $(, $part)*),
                        [$(format_args!($hint $(, $hint_part)*))?].first(),
                    ),)+)*
                }
            }
        }
    };
}
