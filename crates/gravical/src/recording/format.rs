//! Format of a file.

use super::dialect::Dialect;
use super::layout::Layout;

/// Everything needed to parse the rows of a file.
#[derive(Debug, Clone)]
pub(crate) struct Format {
    /// In words.
    pub description: String,
    pub dialect: Dialect,
    pub layout: Layout,
}
