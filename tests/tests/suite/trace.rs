//! The trace of a run: all processes on one axis, and no trace without the option.

use std::collections::BTreeMap;

use crate::bench;
use serde_json::Value;
use tests::bench::{digests, text};

/// Start and end \[µs\] of the spans called `name`, by what they say of their half-step, for each process.
fn spans(events: &[Value], name: &str) -> BTreeMap<String, BTreeMap<String, (f64, f64)>> {
    let titles = events.iter().filter(|event| event["name"] == "process_name");
    let titles: Vec<(&Value, String)> =
        titles.map(|event| (&event["pid"], event["args"]["name"].as_str().unwrap().to_owned())).collect();
    let mut found: BTreeMap<String, BTreeMap<String, (f64, f64)>> = BTreeMap::new();
    for event in events.iter().filter(|event| event["name"] == name) {
        let (_, title) = titles.iter().find(|(process, _)| **process == event["pid"]).unwrap();
        let start = event["ts"].as_f64().unwrap();
        let at = event["args"]["at"].as_str().unwrap_or_default().to_owned();
        let span = (start, start + event["dur"].as_f64().unwrap());
        found.entry(title.clone()).or_default().insert(at, span);
    }
    found
}

#[test]
fn a_trace_holds_both_servers_and_the_coordinator_on_one_axis() {
    let bench = bench();
    let case = bench.coarse(0.002, &[]);
    let trace = bench.path("trace.json");
    let traced = bench.run(&case, "traced", &["--trace", text(&trace)]);
    let events: Vec<Value> = serde_json::from_str(&std::fs::read_to_string(&trace).unwrap()).unwrap();

    let stages = spans(&events, "stage");
    let (fluid, solid) = (&stages["fluid-server"], &stages["solid-server"]);
    assert_eq!(fluid.len() as u64, 2 * traced["steps"].as_u64().unwrap());
    assert!(fluid.keys().eq(solid.keys()));
    // Neither side can end a half-step before the other began it: it needs the other's frame. Clocks that do not
    // belong together would break that.
    for (at, (start, end)) in fluid {
        let (other_start, other_end) = solid[at];
        assert!(
            *start < other_end && other_start < *end,
            "{at}: {start} to {end}, {other_start} to {other_end}"
        );
    }
    for name in ["begin stage", "own sums", "wait for partner", "cross sums", "advance", "checkpoint"] {
        assert!(spans(&events, name).len() == 2, "{name} of both servers");
    }
    for name in ["write step", "write snapshot", "write checkpoint", "report"] {
        assert!(spans(&events, name).contains_key("coordinator"), "{name}");
    }

    let left: Vec<_> = std::fs::read_dir(trace.parent().unwrap()).unwrap().flatten().collect();
    assert!(!left.iter().any(|entry| entry.file_name().to_string_lossy().starts_with("trace-")), "{left:?}");
    assert_eq!(digests(&bench.run(&case, "plain", &[])), digests(&traced));
}
