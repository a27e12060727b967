//! Keys that tests have read from case files.

use std::cell::RefCell;
use std::collections::BTreeSet;

/// A key of a table with the word on which it depends.
pub type Key = (&'static str, Option<&'static str>, &'static str);

thread_local! {
    static KEYS: RefCell<BTreeSet<Key>> = const { RefCell::new(BTreeSet::new()) };
}

/// Notes that `key` was written and read.
pub fn note(table: &'static str, variant: Option<&'static str>, key: &'static str) {
    KEYS.with_borrow_mut(|keys| keys.insert((table, variant, key)));
}

/// Keys that this thread has read.
pub fn keys() -> BTreeSet<Key> {
    KEYS.with_borrow(Clone::clone)
}
