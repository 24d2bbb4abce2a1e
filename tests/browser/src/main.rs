//! Reports in a real browser: Chromium, driven through chromedriver.
//!
//!     cargo build
//!     cargo run --manifest-path tests/browser/Cargo.toml -- target/debug/gravical [PICTURES]
//!
//! The reports are those of simulated recordings and, where `GRAVICAL_DATA` is set, of
//! real ones. `PICTURES` is a folder for pictures of every page, for people. What does
//! not hold ends the program with a panic that says what.

mod browser;
mod checks;
mod pages;

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::PathBuf;

use browser::Browser;
use pages::Page;

/// One browser for all: starting it takes longer than most of the checks.
fn main() {
    let mut words = std::env::args_os().skip(1).map(PathBuf::from);
    let program = words.next().expect("which program?");
    let program = program.canonicalize().expect("the program is not there");
    let pictures = words.next();
    let folder = tempfile::tempdir().unwrap();
    let pages = pages::write(&program, folder.path());
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .unwrap();
    let browser = runtime.block_on(Browser::start(folder.path(), pictures));
    let looked = catch_unwind(AssertUnwindSafe(|| {
        runtime.block_on(async {
            for page in &pages {
                println!("{}", page.name);
                look(&browser, page).await;
            }
        });
    }));
    // Whatever was found, the browser ends.
    runtime.block_on(browser.stop());
    if let Err(panic) = looked {
        resume_unwind(panic);
    }
}

async fn look(browser: &Browser, page: &Page) {
    browser.size(1280, 900).await;
    browser.open(&page.path).await;
    checks::series_are_all_there(browser).await;
    checks::nothing_overlaps(browser, "1280").await;
    checks::tables_fit(browser).await;
    checks::an_interval_is_zoomed_into(browser).await;
    checks::toggles_hide(browser).await;
    checks::values_are_read(browser).await;
    checks::structure(browser).await;
    browser.shoot(page, "1280-light").await;
    checks::it_prints(browser).await;
    browser.size(800, 900).await;
    checks::nothing_overflows(browser).await;
    checks::nothing_overlaps(browser, "800").await;
    browser.shoot(page, "800-light").await;
    browser.size(400, 900).await;
    checks::nothing_overflows(browser).await;
    checks::nothing_overlaps(browser, "400").await;
    browser.shoot(page, "400-light").await;
    browser.scheme("dark").await;
    checks::dark_is_dark(browser).await;
    browser.shoot(page, "400-dark").await;
    browser.size(1280, 900).await;
    browser.shoot(page, "1280-dark").await;
    browser.scheme("light").await;
    checks::without_script(browser, page).await;
    browser.quiet(page).await;
}
