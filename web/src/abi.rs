//! What JavaScript sees: memory for a message, the call, and where its answer is. All that is unsafe is here.
#![allow(unsafe_code)]

use std::cell::RefCell;
use std::panic;
use std::sync::Once;

use crate::app::App;

thread_local! {
    static APP: RefCell<App> = RefCell::default();
    /// The last answer; after a panic its words.
    static ANSWER: RefCell<Vec<u8>> = RefCell::default();
}
static PREPARED: Once = Once::new();

/// Memory for a message of `size` bytes, which [`call`] frees. The last answer is gone.
#[unsafe(no_mangle)]
pub extern "C" fn alloc(size: usize) -> *mut u8 {
    keep(Vec::new());
    Box::into_raw(vec![0_u8; size].into_boxed_slice()).cast()
}

/// Takes the message at `start`, and leaves an answer.
///
/// # Safety
///
/// `start` and `size` are those of an [`alloc`], and nobody uses that memory afterwards.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn call(start: *mut u8, size: usize) {
    PREPARED.call_once(|| {
        // A panic ends the instance; what it says can still be read.
        panic::set_hook(Box::new(|what| keep(what.to_string().into_bytes())));
    });
    // Safety: as above.
    let bytes = unsafe { Box::from_raw(std::ptr::slice_from_raw_parts_mut(start, size)) };
    keep(APP.with_borrow_mut(|app| app.call(&bytes)));
}

fn keep(answer: Vec<u8>) {
    ANSWER.replace(answer);
}

/// Where the answer begins; it stays there until the next message.
#[unsafe(no_mangle)]
pub extern "C" fn answer() -> *const u8 {
    ANSWER.with_borrow(|answer| answer.as_ptr())
}

/// Its length.
#[unsafe(no_mangle)]
pub extern "C" fn answer_size() -> usize {
    ANSWER.with_borrow(Vec::len)
}
