//! What happens when the program has a defect: it ends, except inside the work on one of many
//! items, where the others go on.

use std::cell::{Cell, RefCell};
use std::panic::{self, AssertUnwindSafe, catch_unwind};
use std::process;

thread_local! {
    static IS_GUARDED: Cell<bool> = const { Cell::new(false) };
    static MESSAGE: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// A panic of any thread ends the program, so that none waits for another that is gone; a panic
/// inside of [`guarded`] does not.
pub fn watch() {
    let print = panic::take_hook();
    panic::set_hook(Box::new(move |panic| {
        if IS_GUARDED.get() {
            MESSAGE.set(Some(panic.to_string()));
            return;
        }
        print(panic);
        process::exit(1);
    }));
}

/// Runs `work`; its panic is an error with the message and the place.
pub fn guarded<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    let before = IS_GUARDED.replace(true);
    // What `work` shared with others is not used after a panic: each item has its own.
    let done = catch_unwind(AssertUnwindSafe(work));
    IS_GUARDED.set(before);
    done.map_err(|_| MESSAGE.take().unwrap_or_else(|| "panicked".to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_an_error_of_its_own_item() {
        assert_eq!(guarded(|| 1), Ok(1));
        let failed = guarded(|| -> u8 { panic!("unlikely") });
        assert!(failed.is_err());
        assert!(!IS_GUARDED.get());
    }
}
