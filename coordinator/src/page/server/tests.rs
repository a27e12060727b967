//! Requests to a page, of browsers and of others.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::sync::atomic::{AtomicUsize, Ordering};

use sph::coupling::solver::{Field, ParticleFields, Role};
use tempfile::TempDir;

use super::*;
use crate::results::names;
use crate::results::vtk::Series;

/// A folder of a run of 40 particles with two snapshots.
fn folder() -> TempDir {
    let root = tempfile::tempdir().unwrap();
    let case = "name = \"tank\"\n[domain]\nlower_m = [0.0, 0.0]\n[time]\nstart_time_s = 0.0\nend_time_s = 1.0\n\
                [fluid]\nparticle_spacing_m = 0.1\n[[wall]]\nname = \"floor\"\n";
    std::fs::write(root.path().join(names::CASE), case).unwrap();
    std::fs::write(root.path().join(names::PROBES), "t_s,p_pressure_pa\n0.0,1.0\n0.5,7.0\n").unwrap();
    let folder = root.path().join(names::SNAPSHOTS);
    std::fs::create_dir(&folder).unwrap();
    let mut series = Series::new(&folder, Role::Fluid);
    for step in 0..2u32 {
        let field = |name: &str, components, values| Field {
            name: name.into(),
            unit: "1".into(),
            components,
            values,
        };
        let particles = ParticleFields {
            step: u64::from(step),
            time: 0.5 * f64::from(step),
            id: (0..40).collect(),
            group: (0..40).map(|id| u32::from(id < 10)).collect(),
            group_names: vec!["water".into(), "floor".into()],
            fields: vec![
                field("position", 2, (0..80).map(|k| f64::from(k) + f64::from(step)).collect()),
                field("pressure", 1, (0..40).map(f64::from).collect()),
            ],
        };
        series.write(&particles).unwrap();
    }
    root
}

fn open(server: &Server) -> TcpStream {
    let stream = TcpStream::connect(server.address).unwrap();
    // Far above any answer here.
    stream.set_read_timeout(Some(Duration::from_secs(30))).unwrap();
    stream
}

/// Status and content of the answer to a request with these lines.
fn ask(server: &Server, line: &str, headers: &str) -> (u16, String) {
    let mut stream = open(server);
    write!(stream, "{line} HTTP/1.1\r\n{headers}Connection: close\r\n\r\n").unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    let status =
        answer.split(' ').nth(1).and_then(|status| status.parse().ok()).unwrap_or_else(|| panic!("{answer}"));
    (status, answer)
}

const HERE: &str = "Host: 127.0.0.1\r\n";

fn with_orders(folder: &TempDir) -> (Server, Arc<AtomicUsize>) {
    let count = Arc::new(AtomicUsize::new(0));
    let counted = count.clone();
    let orders: TakeOrder = Box::new(move |_| {
        counted.fetch_add(1, Ordering::SeqCst);
        true
    });
    let live = Some(Arc::new(Live::default()));
    let exhibit = Exhibit { folder: folder.path().to_owned(), live, orders: Some(orders) };
    (Server::start(exhibit).unwrap(), count)
}

#[test]
fn a_folder_is_shown_with_all_its_frames() {
    let folder = folder();
    let server = of_folder(folder.path()).unwrap();
    assert!(!server.link().contains("token"), "there is nothing to order");
    let (status, page) = ask(&server, "GET /", HERE);
    assert_eq!((status, page.matches("class=\"frame\"").count()), (200, 2));
    assert!(page.contains("content-security-policy"), "{}", &page[..600]);
    assert_eq!(ask(&server, "GET /api/frames/9", HERE).0, 404);
    assert_eq!(ask(&server, "GET /etc/passwd", HERE).0, 404);
    assert_eq!(ask(&server, "DELETE /", HERE).0, 405);
    assert_eq!(ask(&server, "POST /api/stop", HERE).0, 409);
    server.end();
    assert!(of_folder(&folder.path().join("nothing")).is_err());
}

#[test]
fn orders_need_the_token_of_the_link() {
    let folder = folder();
    let (server, count) = with_orders(&folder);
    let token = server.link().split("#token=").nth(1).unwrap().to_owned();
    assert_eq!(token.len(), 64);
    assert_eq!(ask(&server, "POST /api/stop", HERE).0, 401);
    let wrong =
        format!("{HERE}Authorization: Bearer {}\r\n", token.replace(|c: char| c.is_ascii_digit(), "x"));
    assert_eq!(ask(&server, "POST /api/stop", &wrong).0, 403);
    let short = format!("{HERE}Authorization: Bearer {}\r\n", &token[..63]);
    assert_eq!(ask(&server, "POST /api/checkpoint", &short).0, 403);
    assert_eq!(count.load(Ordering::SeqCst), 0);
    let right = format!("{HERE}Authorization: Bearer {token}\r\n");
    assert_eq!(ask(&server, "POST /api/checkpoint", &right).0, 202);
    assert_eq!(ask(&server, "GET /api/stop", &right).0, 404, "an order is no link");
    assert_eq!(count.load(Ordering::SeqCst), 1);
    server.end();
}

#[test]
fn only_the_names_of_this_machine_are_answered_and_no_origin_is_let_in() {
    let folder = folder();
    let (server, _) = with_orders(&folder);
    for host in ["evil.example", "127.0.0.1.evil.example", "localhost.evil.example:80", "", "[fe80::1]"] {
        assert_eq!(ask(&server, "GET /api/run", &format!("Host: {host}\r\n")).0, 403, "{host}");
    }
    for host in ["localhost:1234", "127.0.0.1", "[::1]:80"] {
        assert_eq!(ask(&server, "GET /", &format!("Host: {host}\r\n")).0, 200, "{host}");
    }
    let foreign = format!("{HERE}Origin: http://evil.example\r\nAccess-Control-Request-Method: POST\r\n");
    let (status, answer) = ask(&server, "OPTIONS /api/stop", &foreign);
    assert_eq!(status, 405);
    assert!(!answer.to_lowercase().contains("access-control-allow"), "{answer}");
    server.end();
}

#[test]
fn a_running_run_is_followed_by_events_and_frames_that_stand_alone() {
    let folder = folder();
    let (server, _) = with_orders(&folder);
    let mut stream = open(&server);
    write!(stream, "GET /api/events HTTP/1.1\r\n{HERE}\r\n").unwrap();
    let mut heard = String::new();
    let mut some = [0; 4096];
    while !heard.contains("\"frames\":2") {
        let n = stream.read(&mut some).unwrap();
        assert!(n > 0, "{heard}");
        heard.push_str(&String::from_utf8_lossy(&some[..n]));
    }
    assert!(heard.contains("event: status") && heard.contains("starting the solvers"), "{heard}");
    let (status, run) = ask(&server, "GET /api/run", HERE);
    assert!(status == 200 && run.contains("\"verdict\":\"running\"") && run.contains("\"every\":1"), "{run}");
    let (status, frame) = ask(&server, "GET /api/frames/1", HERE);
    assert!(status == 200 && frame.contains("\"count\":40") && frame.contains("\"time\":0.5"), "{frame}");
    // Those who listen learn of the end.
    let end = std::thread::spawn(move || server.end());
    while !heard.contains("\"ended\":true") {
        let n = stream.read(&mut some).unwrap();
        assert!(n > 0, "{heard}");
        heard.push_str(&String::from_utf8_lossy(&some[..n]));
    }
    end.join().unwrap();
}

#[test]
fn browsers_that_take_nothing_or_are_too_many_do_not_delay_the_run() {
    let folder = folder();
    let (server, _) = with_orders(&folder);
    // Some read nothing, some say nothing.
    let deaf: Vec<TcpStream> = (0..100)
        .map(|k| {
            let mut stream = open(&server);
            if k % 2 == 0 {
                // One that was turned away fails here.
                let _ = write!(stream, "GET /api/events HTTP/1.1\r\n{HERE}\r\n");
            }
            stream
        })
        .collect();
    let live = Live::default();
    let began = std::time::Instant::now();
    for step in 0..100_000 {
        live.step(step, 1e-5 * step as f64, 0);
    }
    // A step costs far less than a microsecond; a machine that is busy with other things gets its time.
    assert!(began.elapsed() < Duration::from_secs(5));
    drop(deaf);
    // When they are gone there is room again.
    let until = std::time::Instant::now() + Duration::from_secs(20);
    loop {
        let mut stream = open(&server);
        let mut answer = String::new();
        let asked = write!(stream, "GET /api/frames/x HTTP/1.1\r\n{HERE}Connection: close\r\n\r\n");
        if asked.is_ok() && stream.read_to_string(&mut answer).is_ok() && answer.starts_with("HTTP/1.1 404") {
            break;
        }
        assert!(std::time::Instant::now() < until, "no room after the others have gone");
        std::thread::sleep(Duration::from_millis(50));
    }
    let began = std::time::Instant::now();
    server.end();
    assert!(began.elapsed() < Duration::from_secs(10), "the end does not wait for browsers");
}
