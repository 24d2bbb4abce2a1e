//! Work on many items at a time, and results in their order.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError, mpsc};
use std::thread;
use std::time::Duration;

/// How far work may be ahead of the first item that is not done: so many results wait at most.
const AHEAD: usize = 256;
/// How often a waiting thread looks whether it has to stop.
const LOOK: Duration = Duration::from_millis(100);

/// Where the work is.
struct Place {
    /// The next item to begin.
    next: usize,
    /// Items whose results were taken.
    taken: usize,
}

/// Calls `work` for 0 to `count` − 1 on `threads` threads, and `take` with the results, on this
/// thread and in order. Once `stop` is set no further item is begun; those that were are taken.
/// Returns how many were taken: the first ones.
///
/// # Errors
///
/// The first error of `take`, after which nothing is begun or taken.
pub fn in_order<T: Send, E>(
    count: usize,
    threads: usize,
    stop: &AtomicBool,
    work: impl Fn(usize) -> T + Sync,
    mut take: impl FnMut(usize, T) -> Result<(), E>,
) -> Result<usize, E> {
    let place = Mutex::new(Place { next: 0, taken: 0 });
    let (moved, over) = (Condvar::new(), AtomicBool::new(false));
    let begin = || {
        let mut at = lock(&place);
        loop {
            let ends = stop.load(Ordering::SeqCst) || over.load(Ordering::SeqCst);
            if ends || at.next >= count {
                return None;
            }
            if at.next < at.taken + AHEAD {
                at.next += 1;
                return Some(at.next - 1);
            }
            let waited = moved.wait_timeout(at, LOOK);
            at = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    };
    thread::scope(|scope| {
        let (sender, results) = mpsc::channel();
        for _ in 0..threads.clamp(1, count.max(1)) {
            let sender = sender.clone();
            let (begin, work) = (&begin, &work);
            scope.spawn(move || {
                while let Some(i) = begin() {
                    if sender.send((i, work(i))).is_err() {
                        return;
                    }
                }
            });
        }
        drop(sender);
        let mut waiting = BTreeMap::new();
        let mut taken = 0;
        for (i, result) in results {
            waiting.insert(i, result);
            while let Some(result) = waiting.remove(&taken) {
                if let Err(error) = take(taken, result) {
                    over.store(true, Ordering::SeqCst);
                    return Err(error);
                }
                taken += 1;
            }
            lock(&place).taken = taken;
            moved.notify_all();
        }
        Ok(taken)
    })
}

fn lock(place: &Mutex<Place>) -> MutexGuard<'_, Place> {
    place.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicUsize;

    use super::*;

    #[test]
    fn results_come_in_order_whatever_the_threads() {
        for threads in [1, 2, 7] {
            let (stop, mut seen) = (AtomicBool::new(false), Vec::new());
            // The first one is last: the others wait for it.
            let work = |i: usize| {
                if i == 0 {
                    thread::sleep(Duration::from_millis(20));
                }
                2 * i
            };
            let taken = in_order(1000, threads, &stop, work, |i, twice| {
                seen.push((i, twice));
                Ok::<(), ()>(())
            });
            assert_eq!(taken, Ok(1000));
            assert!(seen.iter().enumerate().all(|(i, s)| *s == (i, 2 * i)));
        }
        let none = in_order(
            0,
            4,
            &AtomicBool::new(false),
            |i| i,
            |_, _| Ok::<(), ()>(()),
        );
        assert_eq!(none, Ok(0));
    }

    #[test]
    fn what_was_begun_is_taken_after_a_stop() {
        let (stop, begun) = (AtomicBool::new(false), AtomicUsize::new(0));
        let work = |i: usize| {
            begun.fetch_add(1, Ordering::SeqCst);
            stop.fetch_or(i == 40, Ordering::SeqCst);
        };
        let taken = in_order(10_000, 3, &stop, work, |_, ()| Ok::<(), ()>(())).unwrap();
        assert!((41..100).contains(&taken), "{taken}");
        assert_eq!(taken, begun.load(Ordering::SeqCst));
    }

    #[test]
    fn an_error_of_the_taker_ends_the_work() {
        let stop = AtomicBool::new(false);
        let mut last = 0;
        let failed = in_order(
            100_000,
            2,
            &stop,
            |i| i,
            |i, _| {
                last = i;
                if i == 5 { Err("full") } else { Ok(()) }
            },
        );
        assert_eq!((failed, last), (Err("full"), 5));
    }
}
