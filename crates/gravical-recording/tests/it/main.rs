//! What a user sees of a reader: files in, columns and notes out.

mod defects;
mod loggers;
mod properties;
mod real;
mod support;
mod writings;
