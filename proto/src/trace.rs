//! Where the time of a run goes: spans of the solvers and of the coordinator, for a picture over time or for sums.
//!
//! Spans have the target [`sph::coupling::driver::TRACE`]. A trace is a JSON array of events in Chrome's trace format, which
//! <https://ui.perfetto.dev> and `chrome://tracing` open. Each process writes a part of its own, one event a line; its
//! times are those of the machine's monotonic clock, so that the parts of one machine share an axis when
//! [`join`] makes one file of them.

use std::cell::Cell;
use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, BufWriter, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use rustix::time::{ClockId, clock_gettime};
use tracing::field::{Field, Visit};
use tracing::level_filters::LevelFilter;
use tracing::span::{Attributes, Id};
use tracing::{Subscriber, subscriber};
use tracing_subscriber::filter::Targets;
use tracing_subscriber::layer::{Context, Layer, SubscriberExt};
use tracing_subscriber::registry::LookupSpan;
use tracing_subscriber::{Registry, fmt};

/// What takes the spans of a process.
pub trait Sink: Send + Sync + 'static {
    /// Clock by which spans are timed, such as [`now`].
    fn clock(&self) -> Duration;

    /// Takes a span that has ended, inner ones before those around them.
    fn ended(&self, span: &Ended<'_>);
}

/// A span that has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ended<'a> {
    /// Its name.
    pub name: &'a str,
    /// Clock of the sink at its start.
    pub start: Duration,
    /// And at its end.
    pub end: Duration,
    /// Its fields as the inside of a JSON object; often empty.
    pub fields: &'a str,
}

/// Time of the clock that all processes of a machine share.
pub fn now() -> Duration {
    of_clock(ClockId::Monotonic)
}

/// CPU time that this thread has used.
pub fn thread_cpu() -> Duration {
    of_clock(ClockId::ThreadCPUTime)
}

/// CPU time that this process has used, all threads together.
pub fn process_cpu() -> Duration {
    of_clock(ClockId::ProcessCPUTime)
}

fn of_clock(clock: ClockId) -> Duration {
    // None of these clocks is ever negative.
    Duration::try_from(clock_gettime(clock)).unwrap_or_default()
}

/// Gives the spans of this process to `sink` from here on.
///
/// # Errors
/// When this process records already: it does so once.
pub fn record(sink: impl Sink) -> Result<(), AlreadyRecording> {
    let subscriber = Registry::default().with(only_spans(sink));
    subscriber::set_global_default(subscriber).map_err(|_| AlreadyRecording)
}

/// As [`record`], with a log to stderr beside.
///
/// # Errors
/// As [`record`].
pub fn record_with_log(sink: impl Sink, filter: Targets) -> Result<(), AlreadyRecording> {
    let subscriber = Registry::default().with(only_spans(sink)).with(to_stderr(filter));
    subscriber::set_global_default(subscriber).map_err(|_| AlreadyRecording)
}

/// Writes a log to stderr, unless something is set up that takes it.
pub fn log(filter: Targets) {
    let subscriber = Registry::default().with(to_stderr(filter));
    // What is set up keeps its place.
    let _ = subscriber::set_global_default(subscriber);
}

fn to_stderr<S: Subscriber + for<'a> LookupSpan<'a>>(filter: Targets) -> impl Layer<S> {
    // A log that cannot be written must not end the server: it would be reported by a macro that panics.
    fmt::layer()
        .with_writer(io::stderr)
        .with_ansi(io::stderr().is_terminal())
        .log_internal_errors(false)
        .with_filter(filter)
}

/// Spans of this process are recorded, or its log is set up, already.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("this process records its spans already, or has a log without them")]
pub struct AlreadyRecording;

fn only_spans<S, K>(sink: K) -> impl Layer<S>
where
    S: Subscriber + for<'a> LookupSpan<'a>,
    K: Sink,
{
    let ours = Targets::new().with_target(sph::coupling::driver::TRACE, LevelFilter::TRACE);
    Spans { sink }.with_filter(ours)
}

/// Times spans.
struct Spans<K> {
    sink: K,
}

/// Fields of a span, kept with it.
struct Fields(String);

/// When a span was entered.
struct Entered(Duration);

impl Visit for Fields {
    fn record_debug(&mut self, field: &Field, value: &dyn std::fmt::Debug) {
        let value = serde_json::Value::from(format!("{value:?}"));
        let comma = if self.0.is_empty() { "" } else { "," };
        let _ = write!(self.0, "{comma}\"{}\":{value}", field.name());
    }
}

impl<S, K> Layer<S> for Spans<K>
where
    S: Subscriber + for<'a> LookupSpan<'a>,
    K: Sink,
{
    fn on_new_span(&self, attributes: &Attributes<'_>, id: &Id, context: Context<'_, S>) {
        let mut fields = Fields(String::new());
        attributes.record(&mut fields);
        if let Some(span) = context.span(id) {
            span.extensions_mut().insert(fields);
        }
    }

    fn on_enter(&self, id: &Id, context: Context<'_, S>) {
        if let Some(span) = context.span(id) {
            span.extensions_mut().replace(Entered(self.sink.clock()));
        }
    }

    fn on_exit(&self, id: &Id, context: Context<'_, S>) {
        let end = self.sink.clock();
        let Some(span) = context.span(id) else { return };
        let extensions = span.extensions();
        let Some(Entered(start)) = extensions.get::<Entered>() else { return };
        let fields = extensions.get::<Fields>().map_or("", |fields| fields.0.as_str());
        self.sink.ended(&Ended { name: span.name(), start: *start, end, fields });
    }
}

/// A part of a trace, being written.
#[derive(Clone)]
pub struct Part {
    file: Arc<Mutex<BufWriter<File>>>,
}

static THREADS: AtomicU32 = AtomicU32::new(1);

thread_local! {
    /// Number of this thread in the trace; 0 before its first event.
    static THREAD: Cell<u32> = const { Cell::new(0) };
}

impl Part {
    /// Begins the part of this process, called `title` in the picture, at `path`.
    ///
    /// # Errors
    /// When the file cannot be made.
    pub fn create(path: &Path, title: &str) -> io::Result<Self> {
        let part = Self { file: Arc::new(Mutex::new(BufWriter::new(File::create(path)?))) };
        part.named("process_name", title);
        Ok(part)
    }

    /// Brings all that was recorded onto the disk.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn flush(&self) -> io::Result<()> {
        self.file.lock().unwrap_or_else(PoisonError::into_inner).flush()
    }

    fn line(&self, text: &str) {
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        // A full disk ends the trace, not the run; the last flush tells.
        let _ = writeln!(file, "{text}");
    }

    fn named(&self, what: &str, name: &str) {
        let name = serde_json::Value::from(name);
        self.line(&format!(
            "{{\"name\":\"{what}\",\"ph\":\"M\",\"pid\":{},\"tid\":{},\"args\":{{\"name\":{name}}}}}",
            std::process::id(),
            THREAD.get()
        ));
    }

    fn thread(&self) -> u32 {
        if THREAD.get() == 0 {
            THREAD.set(THREADS.fetch_add(1, Ordering::Relaxed));
            self.named("thread_name", std::thread::current().name().unwrap_or("unnamed"));
        }
        THREAD.get()
    }
}

impl Sink for Part {
    fn clock(&self) -> Duration {
        now()
    }

    fn ended(&self, span: &Ended<'_>) {
        // Microseconds to the nanosecond: the format's unit.
        let micro = |time: Duration| format!("{}.{:03}", time.as_micros(), time.as_nanos() % 1000);
        self.line(&format!(
            "{{\"name\":\"{}\",\"ph\":\"X\",\"ts\":{},\"dur\":{},\"pid\":{},\"tid\":{},\"args\":{{{}}}}}",
            span.name,
            micro(span.start),
            micro(span.end.saturating_sub(span.start)),
            std::process::id(),
            self.thread(),
            span.fields
        ));
    }
}

/// Makes one trace at `path` of the parts of several processes, in that order; lines that were cut off are left out.
///
/// # Errors
/// When a part cannot be read or the trace not be written.
pub fn join(path: &Path, parts: &[PathBuf]) -> io::Result<()> {
    let mut out = BufWriter::new(File::create(path)?);
    let mut before = "[\n";
    for part in parts {
        let text = std::fs::read_to_string(part)?;
        // A process that was killed leaves a line without its end.
        for line in text.split_inclusive('\n').filter_map(|line| line.strip_suffix('\n')) {
            write!(out, "{before}{line}")?;
            before = ",\n";
        }
    }
    let end = if before == ",\n" { "\n]\n" } else { "[]\n" };
    out.write_all(end.as_bytes())?;
    out.flush()
}

#[cfg(test)]
mod tests {
    use super::*;
    use tracing::trace_span;

    #[test]
    fn a_trace_holds_the_nested_spans_of_all_parts_and_no_others() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str| folder.path().join(name);
        let part = Part::create(&file("a"), "one \"quoted\"").unwrap();
        let subscriber = Registry::default().with(only_spans(part.clone()));
        subscriber::with_default(subscriber, || {
            let _step = trace_span!(target: sph::coupling::driver::TRACE, "step", step = 7).entered();
            trace_span!(target: sph::coupling::driver::TRACE, "own sums").in_scope(|| {
                trace_span!(target: "elsewhere", "foreign").in_scope(|| {});
            });
        });
        part.flush().unwrap();
        std::fs::write(file("b"), "{\"name\":\"whole\",\"ph\":\"X\"}\n{\"name\":\"cut").unwrap();
        join(&file("trace.json"), &[file("a"), file("b")]).unwrap();
        let text = std::fs::read_to_string(file("trace.json")).unwrap();
        let events: Vec<serde_json::Value> = serde_json::from_str(&text).unwrap();
        let names: Vec<&str> = events.iter().map(|e| e["name"].as_str().unwrap()).collect();
        assert_eq!(names, ["process_name", "thread_name", "own sums", "step", "whole"]);
        let (inner, outer) = (&events[2], &events[3]);
        assert_eq!(outer["args"]["step"], "7");
        let span = |event: &serde_json::Value| {
            let start = event["ts"].as_f64().unwrap();
            (start, start + event["dur"].as_f64().unwrap())
        };
        // Sums of numbers of microseconds since the machine started: a double resolves 1e-4 of one.
        assert!(span(outer).0 <= span(inner).0 && span(inner).1 <= span(outer).1 + 1e-3);
    }

    #[test]
    fn a_trace_without_parts_is_an_empty_list() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trace.json");
        join(&path, &[]).unwrap();
        let events: Vec<serde_json::Value> =
            serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        assert!(events.is_empty());
    }
}
