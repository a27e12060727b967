//! How a program ends when it panics: with a line that says where, and the exit code of a fault.

use std::any::Any;
use std::backtrace::{Backtrace, BacktraceStatus};
use std::panic::{AssertUnwindSafe, PanicHookInfo, catch_unwind};
use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};

/// Exit code of a program that ends by a fault of its own, as in `sysexits.h`.
pub const FAULT: u8 = 70;

/// Panics of this process, on any thread, that [`contain`] has not caught.
static PANICS: AtomicU64 = AtomicU64::new(0);

/// Runs `main`, which every program passes through.
///
/// A panic on any thread is printed once, with its place. One of `main` itself gives [`FAULT`]; so does a failure of
/// `main` after another thread has panicked, as it may be no more than a consequence.
pub fn run(main: impl FnOnce() -> ExitCode) -> ExitCode {
    std::panic::set_hook(Box::new(report));
    match catch_unwind(AssertUnwindSafe(main)) {
        Ok(code) if code == ExitCode::SUCCESS || PANICS.load(Ordering::Relaxed) == 0 => code,
        _ => ExitCode::from(FAULT),
    }
}

/// Runs `work`, whose panic must not end more than the work itself.
///
/// # Errors
/// The message of its panic, which has been printed with its place.
pub fn contain<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    let before = PANICS.load(Ordering::Relaxed);
    catch_unwind(AssertUnwindSafe(work)).map_err(|payload| {
        PANICS.store(before, Ordering::Relaxed);
        message(&*payload).to_owned()
    })
}

/// Prints where a thread panics.
fn report(panic: &PanicHookInfo<'_>) {
    PANICS.fetch_add(1, Ordering::Relaxed);
    let thread = std::thread::current();
    let name = thread.name().unwrap_or("without name");
    let place = panic.location().map_or_else(|| "an unknown place".to_owned(), ToString::to_string);
    let backtrace = Backtrace::capture();
    let backtrace = match backtrace.status() {
        BacktraceStatus::Captured => format!("\n{backtrace}"),
        _ => String::new(),
    };
    let text = message(panic.payload());
    crate::note(format_args!(
        "error: a fault of this program: thread {name} panicked at {place}: {text}{backtrace}"
    ));
}

fn message(payload: &(dyn Any + Send)) -> &str {
    let text = payload.downcast_ref::<&str>().copied();
    text.or_else(|| payload.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message")
}
