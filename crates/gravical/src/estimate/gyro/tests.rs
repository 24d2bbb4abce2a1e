//! Simulated sensors with known truth.

use super::*;
