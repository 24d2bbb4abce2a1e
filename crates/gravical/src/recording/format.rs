//! Format of a file and purpose of reading it.

use super::dialect::Dialect;
use super::layout::Layout;
use super::names::Role;

/// Everything needed to parse the rows of a file.
#[derive(Debug, Clone)]
pub(crate) struct Format {
    /// In words.
    pub description: String,
    pub dialect: Dialect,
    pub layout: Layout,
    /// What it is read for.
    pub role: Role,
}
