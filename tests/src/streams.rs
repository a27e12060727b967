//! Programs whose output and error streams are closed, full or left by their reader.

use std::fs::File;
use std::io::{Read, pipe};
use std::os::fd::OwnedFd;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc;
use std::thread::JoinHandle;

use crate::bench::soon;
use rustix::pty::{OpenptFlags, grantpt, ioctl_tiocgptpeer, openpt, unlockpt};

/// A stream that cannot be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Broken {
    /// Closed before the program starts, as by `2>&-`.
    Closed,
    /// On a disk without room.
    Full,
    /// A pipe whose reader has left.
    Left,
}

impl Broken {
    /// All of them.
    pub const ALL: [Broken; 3] = [Broken::Closed, Broken::Full, Broken::Left];
}

/// Which streams of a program are broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Which {
    /// Standard output.
    Output,
    /// Standard error.
    Errors,
    /// Both; where they are closed, standard input too.
    Both,
}

impl Which {
    /// All of them.
    pub const ALL: [Which; 3] = [Which::Output, Which::Errors, Which::Both];
}

/// `program` with `arguments`; the streams `which` are `broken`, the other one is thrown away.
pub fn command(program: &Path, arguments: &[&str], which: Which, broken: Broken) -> Command {
    let redirection = match (broken, which) {
        (Broken::Closed, Which::Output) => ">&-",
        (Broken::Closed, Which::Errors) => "2>&-",
        (Broken::Closed, Which::Both) => "<&- >&- 2>&-",
        _ => "",
    };
    // A shell alone can start a program without a stream.
    let mut command = Command::new("sh");
    command.args(["-c", &format!("exec \"$0\" \"$@\" {redirection}")]).arg(program).args(arguments);
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    if which != Which::Errors {
        command.stdout(stream(broken));
    }
    if which != Which::Output {
        command.stderr(stream(broken));
    }
    command
}

fn stream(broken: Broken) -> Stdio {
    match broken {
        Broken::Closed => Stdio::null(),
        Broken::Full => File::options().write(true).open("/dev/full").unwrap().into(),
        Broken::Left => pipe().unwrap().1.into(),
    }
}

/// A program that ends with this value.
#[derive(Debug)]
pub struct Program(Child);

impl Program {
    /// Starts `command`.
    pub fn start(command: &mut Command) -> Self {
        Self(command.spawn().unwrap())
    }

    /// Process id.
    pub fn id(&self) -> u32 {
        self.0.id()
    }

    /// The running program.
    pub fn child(&mut self) -> &mut Child {
        &mut self.0
    }

    /// Sends a signal such as `INT`.
    pub fn signal(&self, name: &str) {
        let process = self.0.id().to_string();
        assert!(Command::new("kill").args([&format!("-{name}"), &process]).status().unwrap().success());
    }

    /// Waits for its end; the exit code.
    pub fn end(&mut self) -> Option<i32> {
        let mut status = None;
        soon("the end of the program", || {
            status = self.0.try_wait().unwrap();
            status.is_some()
        });
        status.and_then(|status| status.code())
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        // Ended already in a test that passes.
        drop(self.0.kill());
        drop(self.0.wait());
    }
}

/// A terminal on which a program writes its errors.
#[derive(Debug)]
pub struct Terminal {
    reader: JoinHandle<()>,
    leave: mpsc::Sender<()>,
    shown: mpsc::Receiver<String>,
}

impl Terminal {
    /// Starts `command` with standard error on a new terminal.
    pub fn start(command: &mut Command) -> (Self, Program) {
        // The program must not hold the terminal open by itself.
        let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC;
        let control = openpt(flags).unwrap();
        grantpt(&control).unwrap();
        unlockpt(&control).unwrap();
        let side: OwnedFd = ioctl_tiocgptpeer(&control, flags).unwrap();
        let program = Program::start(command.stderr(side));
        // The command keeps its end otherwise, and the terminal with it.
        command.stderr(Stdio::null());
        let (leave, left) = mpsc::channel();
        let (show, shown) = mpsc::channel();
        let reader = std::thread::spawn(move || {
            let (mut control, mut bytes) = (File::from(control), [0; 4096]);
            while left.try_recv().is_err() {
                let Ok(count) = control.read(&mut bytes) else { return };
                drop(show.send(String::from_utf8_lossy(&bytes[..count]).into_owned()));
            }
        });
        (Self { reader, leave, shown }, program)
    }

    /// Waits until the program has shown `words`; everything until then.
    pub fn wait_for(&self, words: &str) -> String {
        let mut all = String::new();
        while !all.contains(words) {
            match self.shown.recv_timeout(std::time::Duration::from_secs(30)) {
                Ok(text) => all.push_str(&text),
                Err(e) => panic!("no {words:?} on the terminal ({e}):\n{all}"),
            }
        }
        all
    }

    /// Closes the terminal under the program.
    pub fn close(self) {
        // The reader has ended already when the program closed its end.
        let _ = self.leave.send(());
        // It reads once more, then the terminal is gone.
        self.reader.join().unwrap();
    }
}
