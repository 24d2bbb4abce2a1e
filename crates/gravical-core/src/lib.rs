//! The part of gravical that a microcontroller runs.
#![no_std]
