//! The program `gravical`.
fn main() {}
