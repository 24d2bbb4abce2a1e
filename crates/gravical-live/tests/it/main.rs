//! Acceptance tests of the guided session: simulated sensors that a hand moves, recordings, replays.
// The exemption of tests in clippy.toml does not reach helpers outside #[test].
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[path = "../../examples/live_sessions/hand.rs"]
#[allow(dead_code, reason = "the example uses more of it")]
mod hand;
mod live;
#[path = "../../../../tests/support/library.rs"]
mod support;
