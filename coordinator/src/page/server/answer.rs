//! Which request gets which answer.

use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};

use hyper::body::{Body, Bytes, Frame, SizeHint};
use hyper::header::{AUTHORIZATION, CACHE_CONTROL, CONTENT_TYPE, HOST, HeaderValue};
use hyper::{Method, Request, Response, StatusCode};
use tokio::sync::{mpsc, watch};

use super::show::Show;
use super::{Order, TakeOrder};

/// What a browser may do with the page: nothing from elsewhere, nothing to elsewhere.
const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:; \
                      connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// What connections share.
pub(super) struct Site {
    pub show: Arc<Show>,
    pub news: watch::Sender<String>,
    pub token: Option<String>,
    pub orders: Option<TakeOrder>,
}

/// A whole answer, or events as they come.
pub(super) enum Content {
    Whole(Option<Bytes>),
    Events(mpsc::Receiver<Bytes>),
}

impl Body for Content {
    type Data = Bytes;
    type Error = std::convert::Infallible;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, Self::Error>>> {
        match &mut *self {
            Self::Whole(bytes) => Poll::Ready(bytes.take().map(|bytes| Ok(Frame::data(bytes)))),
            Self::Events(events) => {
                events.poll_recv(cx).map(|bytes| bytes.map(|bytes| Ok(Frame::data(bytes))))
            }
        }
    }

    fn is_end_stream(&self) -> bool {
        matches!(self, Self::Whole(None))
    }

    fn size_hint(&self) -> SizeHint {
        match self {
            // A usize fits in 64 bits on every platform that Rust supports.
            Self::Whole(bytes) => SizeHint::with_exact(bytes.as_ref().map_or(0, |bytes| bytes.len() as u64)),
            Self::Events(_) => SizeHint::default(),
        }
    }
}

/// The answer to a request.
pub(super) async fn answer<B>(site: &Arc<Site>, request: &Request<B>) -> Response<Content> {
    if !is_for_loopback(request) {
        return plain(StatusCode::FORBIDDEN, "this page answers to 127.0.0.1 and localhost only");
    }
    let path = request.uri().path();
    match (request.method(), path) {
        (&Method::GET, "/" | "/index.html") => made(site, "text/html; charset=utf-8", Show::page).await,
        (&Method::GET, "/api/run") => made(site, "application/json", |show| show.run()).await,
        (&Method::GET, "/api/events") => events(site),
        (&Method::GET, _) if path.starts_with("/api/frames/") => {
            match path["/api/frames/".len()..].parse::<usize>() {
                Ok(k) => made(site, "application/json", move |show| show.frame(k)).await,
                Err(_) => plain(StatusCode::NOT_FOUND, "no such frame"),
            }
        }
        (&Method::POST, "/api/checkpoint") => order(site, request, Order::Checkpoint),
        (&Method::POST, "/api/stop") => order(site, request, Order::Stop),
        (&Method::GET | &Method::POST, _) => plain(StatusCode::NOT_FOUND, "nothing is here"),
        _ => plain(StatusCode::METHOD_NOT_ALLOWED, "GET and POST only"),
    }
}

/// Whether the request was meant for this machine: a foreign name that leads here is one of a page elsewhere.
fn is_for_loopback<B>(request: &Request<B>) -> bool {
    let host = request.headers().get(HOST).and_then(|host| host.to_str().ok()).unwrap_or("");
    let name = match host.strip_prefix('[') {
        Some(rest) => rest.split(']').next().unwrap_or(""),
        None => host.split(':').next().unwrap_or(""),
    };
    matches!(name, "127.0.0.1" | "localhost" | "::1")
}

/// What `make` gives, on a thread that may wait for files.
async fn made(
    site: &Arc<Site>,
    kind: &'static str,
    make: impl FnOnce(&Show) -> Result<Option<Bytes>, String> + Send + 'static,
) -> Response<Content> {
    let show = site.show.clone();
    match tokio::task::spawn_blocking(move || make(&show)).await {
        Ok(Ok(Some(bytes))) => with(StatusCode::OK, kind, Content::Whole(Some(bytes))),
        Ok(Ok(None)) => plain(StatusCode::NOT_FOUND, "not there yet"),
        Ok(Err(why)) => plain(StatusCode::INTERNAL_SERVER_ERROR, &why),
        Err(_) => plain(StatusCode::INTERNAL_SERVER_ERROR, "a fault of this program"),
    }
}

/// The newest state again and again; what a slow browser has no room for is left out.
fn events(site: &Arc<Site>) -> Response<Content> {
    let mut news = site.news.subscribe();
    let (sender, events) = mpsc::channel(1);
    tokio::spawn(async move {
        let text = |message: &str| Bytes::from(format!("event: status\ndata: {message}\n\n"));
        loop {
            let message = news.borrow_and_update().clone();
            if !message.is_empty() && sender.send(text(&message)).await.is_err() {
                return;
            }
            tokio::select! {
                changed = news.changed() => if changed.is_err() { return },
                () = sender.closed() => return,
            }
        }
    });
    let mut response = with(StatusCode::OK, "text/event-stream", Content::Events(events));
    response.headers_mut().insert(CACHE_CONTROL, HeaderValue::from_static("no-store"));
    response
}

fn order<B>(site: &Site, request: &Request<B>, order: Order) -> Response<Content> {
    let (Some(token), Some(orders)) = (&site.token, &site.orders) else {
        return plain(StatusCode::CONFLICT, "this page only shows a folder");
    };
    let given = request.headers().get(AUTHORIZATION).and_then(|value| value.to_str().ok());
    match given.and_then(|value| value.strip_prefix("Bearer ")) {
        None => plain(StatusCode::UNAUTHORIZED, "the token of the printed link is needed"),
        Some(given) if !same(given, token) => {
            plain(StatusCode::FORBIDDEN, "that is not the token of this run")
        }
        Some(_) if orders(order) => plain(StatusCode::ACCEPTED, "at the next step boundary"),
        Some(_) => plain(StatusCode::CONFLICT, "the run takes no orders any more"),
    }
}

/// Whether two texts are equal, in a time that does not show where they differ.
fn same(a: &str, b: &str) -> bool {
    let (a, b) = (a.as_bytes(), b.as_bytes());
    a.len() == b.len() && a.iter().zip(b).fold(0, |difference, (x, y)| difference | (x ^ y)) == 0
}

fn plain(status: StatusCode, text: &str) -> Response<Content> {
    with(status, "text/plain; charset=utf-8", Content::Whole(Some(Bytes::from(format!("{text}\n")))))
}

fn with(status: StatusCode, kind: &'static str, content: Content) -> Response<Content> {
    let mut response = Response::new(content);
    *response.status_mut() = status;
    let headers = response.headers_mut();
    let lines = [
        (CONTENT_TYPE.as_str(), kind),
        (CACHE_CONTROL.as_str(), "no-store"),
        ("content-security-policy", POLICY),
        ("x-content-type-options", "nosniff"),
        ("referrer-policy", "no-referrer"),
        ("cross-origin-resource-policy", "same-origin"),
        ("cross-origin-opener-policy", "same-origin"),
        ("x-frame-options", "DENY"),
    ];
    for (name, value) in lines {
        headers.insert(name, HeaderValue::from_static(value));
    }
    response
}
