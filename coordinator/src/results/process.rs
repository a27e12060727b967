//! Resources that a process used, as the system reports them.

use std::ops::Add;

use serde::Serialize;

/// Clock ticks per second in `/proc/<pid>/stat`: a constant of Linux's interface to programs.
const TICKS_PER_SECOND: f64 = 100.0;

/// Use of resources by one process; `null` where the system does not report it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Process {
    /// Peak resident memory \[bytes\].
    pub peak_memory_bytes: Option<u64>,
    /// CPU time, user and system \[s\].
    pub cpu_seconds: Option<f64>,
}

impl Process {
    /// Figures of this process so far.
    pub fn own() -> Self {
        Self::of_entry("self")
    }

    /// Figures so far of the process with this id on this machine, and of those that it has started and that run still: a
    /// launcher computes nothing itself. Empty when it has ended.
    pub fn of(id: u32) -> Self {
        let (mut all, mut waiting) = (Self::default(), vec![id]);
        while let Some(id) = waiting.pop() {
            let one = Self::of_entry(&id.to_string());
            all.peak_memory_bytes = sum(all.peak_memory_bytes, one.peak_memory_bytes);
            all.cpu_seconds = sum(all.cpu_seconds, one.cpu_seconds);
            waiting.extend(children(id));
        }
        all
    }

    fn of_entry(entry: &str) -> Self {
        let read = |file: &str| std::fs::read_to_string(format!("/proc/{entry}/{file}")).ok();
        Self {
            peak_memory_bytes: read("status").as_deref().and_then(peak_memory),
            cpu_seconds: read("stat").as_deref().and_then(cpu_time),
        }
    }
}

fn sum<T: Add<Output = T>>(some: Option<T>, more: Option<T>) -> Option<T> {
    match (some, more) {
        (Some(some), Some(more)) => Some(some + more),
        (some, more) => some.or(more),
    }
}

/// The processes that any thread of process `id` has started.
fn children(id: u32) -> Vec<u32> {
    let threads = std::fs::read_dir(format!("/proc/{id}/task")).into_iter().flatten().flatten();
    let lists = threads.filter_map(|thread| std::fs::read_to_string(thread.path().join("children")).ok());
    lists
        .flat_map(|list| list.split_whitespace().filter_map(|id| id.parse().ok()).collect::<Vec<_>>())
        .collect()
}

/// `VmHWM` of `/proc/<pid>/status`, given in units of 1024 bytes.
fn peak_memory(status: &str) -> Option<u64> {
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

/// User and system time of `/proc/<pid>/stat`: 14th and 15th entry; the 2nd may itself hold spaces and brackets.
fn cpu_time(stat: &str) -> Option<f64> {
    let (_, after_name) = stat.rsplit_once(')')?;
    let mut entries = after_name.split_whitespace().skip(11);
    let mut ticks = || entries.next()?.parse::<f64>().ok();
    Some((ticks()? + ticks()?) / TICKS_PER_SECOND)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_files_of_the_system_are_read_right() {
        assert_eq!(peak_memory("Name:\tx\nVmPeak:\t  900 kB\nVmHWM:\t  512 kB\n"), Some(524_288));
        assert_eq!(peak_memory("Name:\tx\n"), None);
        let stat = "77 (a (b) c) S 1 77 77 0 -1 4194560 900 0 0 0 250 50 0 0 20 0 4 0 100 1 1";
        assert_eq!(cpu_time(stat), Some(3.0));
        assert_eq!(cpu_time("77"), None);
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn this_process_uses_memory_and_no_process_has_id_zero() {
        assert!(Process::own().peak_memory_bytes.is_some_and(|bytes| bytes > 100_000));
        assert!(Process::own().cpu_seconds.is_some());
        assert_eq!(Process::of(0), Process::default());
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn processes_that_a_launcher_has_started_count() {
        let mut launcher = std::process::Command::new("sh")
            .args(["-c", "sleep 60 & echo; wait"])
            .stdout(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        let mut line = [0];
        std::io::Read::read_exact(&mut launcher.stdout.take().unwrap(), &mut line).unwrap();
        let (started, id) = (children(launcher.id()), launcher.id());
        assert_eq!(started.len(), 1);
        // The shell has forked, and its copy becomes `sleep` when the system lets it run.
        let is_sleep = || std::fs::read_to_string(format!("/proc/{}/comm", started[0])).unwrap() == "sleep\n";
        let deadline = std::time::Instant::now() + std::time::Duration::from_secs(30);
        while !is_sleep() {
            assert!(std::time::Instant::now() < deadline, "the shell has started no `sleep`");
            std::thread::yield_now();
        }
        let alone = |id: u32| Process::of_entry(&id.to_string()).peak_memory_bytes.unwrap();
        let both = || alone(id) + alone(started[0]);
        // From now on a peak can only grow.
        let (before, found, after) = (both(), Process::of(id).peak_memory_bytes.unwrap(), both());
        assert!((before..=after).contains(&found), "{found} is not from {before} to {after}");
        assert!(found > alone(id));
        std::process::Command::new("kill").args([started[0].to_string(), id.to_string()]).status().unwrap();
        launcher.wait().unwrap();
    }
}
