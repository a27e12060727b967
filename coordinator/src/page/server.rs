//! HTTP on loopback: the page of a run, its state by server-sent events, its frames on request.
//!
//! | request | answer |
//! |---|---|
//! | `GET /` | the page |
//! | `GET /api/run` | the message of [`super::run`], without frames |
//! | `GET /api/frames/K` | one frame that stands alone |
//! | `GET /api/events` | server-sent events: how far the run is, and whether there is anything new to ask for |
//! | `POST /api/checkpoint`, `POST /api/stop` | an order to the run; needs `Authorization: Bearer TOKEN` |
//!
//! The server has a thread of its own and reads what the run has written to its folder, and only while a browser is
//! connected. It holds the run up nowhere: a browser gets the newest state that it has room for, and what it does not ask
//! for is never made. The number of connections, the size of requests and the time for which a browser may take nothing
//! are bounded. Only pages of this machine's loopback name get answers, and no other origin may read them.

mod answer;
mod connection;
mod show;

use std::net::{Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use proto::hex::hex;
use tokio::net::TcpListener;
use tokio::sync::{Semaphore, oneshot, watch};
use tokio::time::Instant;

use self::answer::Site;
use self::show::Show;
use super::live::Live;
use crate::failure::Failure;

/// Connections at a time; more are closed at once.
const CONNECTIONS: usize = 32;
/// Time between looks at the folder while a browser is connected.
const LOOK: Duration = Duration::from_millis(500);
/// A look takes at most this part of the time of this thread: large tables are read less often.
const LARGEST_PART: u32 = 100;
/// How long browsers may ask for the last state of a run that has ended.
const FAREWELL: Duration = Duration::from_millis(700);

/// What a page may ask a run for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// A checkpoint at the next step boundary.
    Checkpoint,
    /// A stop at the next step boundary, with a checkpoint.
    Stop,
}

/// Takes orders of a page; answers whether the run will follow.
pub type TakeOrder = Box<dyn Fn(Order) -> bool + Send + Sync>;

/// What is shown.
pub struct Exhibit {
    /// Folder of the run.
    pub folder: PathBuf,
    /// State of a run of this process.
    pub live: Option<Arc<Live>>,
    /// Who takes orders, if anyone.
    pub orders: Option<TakeOrder>,
}

/// A server on a thread of its own.
#[derive(Debug)]
pub struct Server {
    address: SocketAddr,
    token: Option<String>,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl Server {
    /// Starts it at a port of 127.0.0.1 that the system chooses.
    ///
    /// # Errors
    /// When there is no port, no random number for the token or no thread to be had.
    pub fn start(exhibit: Exhibit) -> Result<Self, Failure> {
        let failed = |e: std::io::Error| Failure::internal(format!("cannot serve the page: {e}"));
        let listener = std::net::TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).map_err(failed)?;
        listener.set_nonblocking(true).map_err(failed)?;
        let address = listener.local_addr().map_err(failed)?;
        let token = exhibit.orders.is_some().then(new_token).transpose()?;
        let (stop, stopped) = oneshot::channel();
        let runtime = tokio::runtime::Builder::new_current_thread()
            .thread_name("page")
            .enable_all()
            .build()
            .map_err(failed)?;
        let secret = token.clone();
        let work = move || {
            lower_priority();
            runtime.block_on(serve(listener, exhibit, secret, stopped));
            runtime.shutdown_background();
        };
        let thread = std::thread::Builder::new().name("page".into()).spawn(work).map_err(failed)?;
        Ok(Self { address, token, stop: Some(stop), thread: Some(thread) })
    }

    /// Where the page is; with the token, which a browser keeps to itself, where there are orders to give.
    pub fn link(&self) -> String {
        let token = self.token.as_ref().map_or(String::new(), |token| format!("#token={token}"));
        format!("http://{}/{token}", self.address)
    }

    /// Ends it: browsers that are connected may ask for the last state first, for a moment.
    pub fn end(mut self) {
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            // Only a fault ends it otherwise, and then there is nothing to end.
            drop(thread.join());
        }
    }
}

/// A secret that cannot be guessed.
fn new_token() -> Result<String, Failure> {
    let mut bytes = [0; 32];
    getrandom::fill(&mut bytes)
        .map_err(|e| Failure::internal(format!("no random numbers for a token: {e}")))?;
    Ok(hex(&bytes))
}

/// The thread that serves a page gives way to those that compute.
fn lower_priority() {
    // Without it the page competes with the solvers, no more.
    let _ = rustix::process::nice(5);
}

async fn serve(
    listener: std::net::TcpListener,
    exhibit: Exhibit,
    token: Option<String>,
    mut stopped: oneshot::Receiver<()>,
) {
    let Ok(listener) = TcpListener::from_std(listener) else { return };
    let Exhibit { folder, live, orders } = exhibit;
    let show = Arc::new(Show::new(&folder, live));
    let (news, _) = watch::channel(String::new());
    let site = Arc::new(Site { show: show.clone(), news: news.clone(), token, orders });
    let room = Arc::new(Semaphore::new(CONNECTIONS));
    let mut next = Instant::now();
    loop {
        tokio::select! {
            _ = &mut stopped => break,
            accepted = listener.accept() => {
                let Ok((stream, _)) = accepted else {
                    // Such as too many open files: later there may be room again.
                    tokio::time::sleep(LOOK).await;
                    continue;
                };
                if let Ok(permit) = room.clone().try_acquire_owned() {
                    let site = site.clone();
                    tokio::spawn(async move {
                        connection::serve(stream, site).await;
                        drop(permit);
                    });
                }
            }
            () = tokio::time::sleep_until(next) => {
                let began = Instant::now();
                if news.receiver_count() > 0 {
                    look(&show, &news, false).await;
                }
                next = Instant::now() + LOOK.max(began.elapsed() * LARGEST_PART);
            }
        }
    }
    if news.receiver_count() > 0 {
        look(&show, &news, true).await;
        let farewell = Instant::now() + FAREWELL;
        while let Ok(Ok((stream, _))) = tokio::time::timeout_at(farewell, listener.accept()).await {
            let site = site.clone();
            tokio::spawn(async move { connection::serve(stream, site).await });
        }
    }
}

/// Looks for news in the folder and tells them.
async fn look(show: &Arc<Show>, news: &watch::Sender<String>, ended: bool) {
    let reader = show.clone();
    // A fault of the reader leaves the page as it is.
    if let Ok(message) = tokio::task::spawn_blocking(move || reader.look(ended)).await {
        news.send_if_modified(|before| {
            let changed = *before != message;
            *before = message;
            changed
        });
    }
}

/// Shows the folder of a run until `stop` has come.
///
/// # Errors
/// When it is no folder of a run, or as [`Server::start`].
pub fn of_folder(folder: &Path) -> Result<Server, Failure> {
    super::folder::CaseFacts::read(folder)
        .map_err(|why| Failure::input(format!("`{}` is no folder of a run: {why}", folder.display())))?;
    Server::start(Exhibit { folder: folder.to_owned(), live: None, orders: None })
}

#[cfg(test)]
mod tests;
