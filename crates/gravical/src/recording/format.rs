//! How a file is written, and what it is read for.

use super::ReadOptions;
use super::dialect::Dialect;
use super::layout::Layout;
use super::names::Role;

/// How a file is written, as far as its rows need it.
#[derive(Debug, Clone)]
pub(crate) struct Format {
    pub dialect: Dialect,
    pub layout: Layout,
    /// What it is read for.
    pub role: Role,
    /// What the user says of it.
    pub options: ReadOptions,
}
