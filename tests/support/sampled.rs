//! Tests over a sample of their cases, and over all of them among the slow tests.

/// Of each function that takes a number of cases: the test of so many, and the slow one of all.
macro_rules! sampled {
    ($($name:ident($some:expr, $all:expr);)*) => {
        mod sample {
            $(#[test] fn $name() { super::$name($some); })*
        }
        mod all {
            $(#[test] #[ignore = "slow: all cases"] fn $name() { super::$name($all); })*
        }
    };
}
