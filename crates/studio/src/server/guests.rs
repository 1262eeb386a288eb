//! The connections of a server: how many there may be, and who has to go.

use std::{
    io,
    net::SocketAddr,
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicU64, Ordering},
    },
    time::Duration,
};

use axum::{Router, http::Request};
use hyper::{
    body::Incoming,
    server::conn::http1,
    service::{Service as _, service_fn},
};
use hyper_util::{
    rt::{TokioIo, TokioTimer},
    service::TowerToHyperService,
};
use tokio::{
    net::{TcpListener, TcpStream},
    task::AbortHandle,
    time::sleep,
};

use super::hub::Hub;

visloc_core::with_defaults! {
    /// What one server bears.
    #[derive(Debug, Clone, Copy)]
    pub(super) struct Limits {
        /// Connections that are not sockets of pages. The next one takes the place of one that asks for nothing.
        pub num_connections: usize = 64,
        /// Pages at their sockets; more are refused.
        pub num_pages: usize = 64,
        /// Time for a whole request, and for the next one on the same connection.
        pub request_time: Duration = Duration::from_secs(5),
    }
}

/// When the system has no connection to give, so many are sent away, and the next attempt comes after this time.
const MAKE_ROOM: usize = 8;
const PAUSE: Duration = Duration::from_millis(50);

/// Where a request comes from, among its extensions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Peer(pub SocketAddr);

/// A connection that may have to go.
struct Guest {
    id: u64,
    /// Whether it has asked for anything so far, and when it came or asked last, as a count.
    use_of: Arc<Use>,
    task: AbortHandle,
}

#[derive(Default)]
struct Use {
    num_requests: AtomicU64,
    last: AtomicU64,
}

/// All connections of a server.
#[derive(Default)]
struct Guests {
    all: Mutex<Vec<Guest>>,
    count: AtomicU64,
}

impl Guests {
    fn all(&self) -> MutexGuard<'_, Vec<Guest>> {
        self.all.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn next(&self) -> u64 {
        self.count.fetch_add(1, Ordering::Relaxed)
    }

    /// Sends away the connection that is least in use: of those that have never asked for anything the oldest, then the one whose last
    /// request is the longest ago. Whether there was one.
    fn send_one_away(&self) -> bool {
        let mut all = self.all();
        let rank = |guest: &Guest| {
            let has_asked = guest.use_of.num_requests.load(Ordering::Relaxed) > 0;
            (has_asked, guest.use_of.last.load(Ordering::Relaxed))
        };
        let Some(i) = (0..all.len()).min_by_key(|i| rank(&all[*i])) else { return false };
        all.swap_remove(i).task.abort();
        true
    }

    fn forget(&self, id: u64) {
        self.all().retain(|guest| guest.id != id);
    }
}

/// Serves whoever connects, until it is dropped. Errors of the system, as when there are no more open files, do not end it.
pub(super) async fn receive(listener: TcpListener, router: Router, hub: Arc<Hub>, limits: Limits) {
    let guests = Arc::new(Guests::default());
    loop {
        match listener.accept().await {
            Ok((stream, address)) => welcome(stream, Peer(address), &router, &guests, limits),
            Err(error) if is_of_one_connection(&error) => {}
            Err(error) => {
                hub.complain(&format!("cannot take a connection: {error}"));
                for _ in 0..MAKE_ROOM {
                    guests.send_one_away();
                }
                sleep(PAUSE).await;
            }
        }
    }
}

fn is_of_one_connection(error: &io::Error) -> bool {
    use io::ErrorKind::{ConnectionAborted, ConnectionRefused, ConnectionReset};
    matches!(error.kind(), ConnectionAborted | ConnectionRefused | ConnectionReset)
}

fn welcome(stream: TcpStream, peer: Peer, router: &Router, guests: &Arc<Guests>, limits: Limits) {
    while guests.all().len() >= limits.num_connections && guests.send_one_away() {}
    // An update goes out at once: otherwise its end waits until the page has confirmed its beginning.
    let _ = stream.set_nodelay(true);
    let (id, use_of) = (guests.next(), Arc::new(Use::default()));
    use_of.last.store(id, Ordering::Relaxed);
    let router = TowerToHyperService::new(router.clone());
    let (theirs, mine) = (Arc::clone(guests), Arc::clone(&use_of));
    let task = tokio::spawn(async move {
        let answer = service_fn(|mut request: Request<Incoming>| {
            request.extensions_mut().insert(peer);
            mine.num_requests.fetch_add(1, Ordering::Relaxed);
            mine.last.store(theirs.next(), Ordering::Relaxed);
            router.call(request)
        });
        let connection = http1::Builder::new()
            .timer(TokioTimer::new())
            .header_read_timeout(limits.request_time)
            .serve_connection(TokioIo::new(stream), answer)
            .with_upgrades();
        // What a browser does to its connection is nobody's fault.
        let _ = connection.await;
        theirs.forget(id);
    });
    // The task does not run before this function has returned: there is one thread.
    guests.all().push(Guest { id, use_of, task: task.abort_handle() });
}

#[cfg(test)]
mod tests {
    use std::{
        io::{Read as _, Write as _},
        net::TcpStream,
    };

    use visloc_core::Clock;

    use super::*;
    use crate::{Hub, server::listen::Server};

    fn server(limits: Limits) -> Server {
        let (hub, _) = Hub::new(Clock::still(), |_| {});
        Server::start_with("127.0.0.1:0".parse().unwrap(), None, hub, limits).unwrap()
    }

    /// A connection that has sent so much.
    fn connect(server: &Server, request: &str) -> TcpStream {
        let mut stream = TcpStream::connect(server.address()).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        stream.write_all(request.as_bytes()).unwrap();
        stream
    }

    fn is_closed(stream: &mut TcpStream) -> bool {
        // Closed with or without what was sent to it having been read.
        !matches!(stream.read(&mut [0; 64]), Ok(1..))
    }

    fn page(server: &Server) -> String {
        let mut answer = String::new();
        let mut stream = connect(server, "GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n");
        stream.read_to_string(&mut answer).unwrap();
        answer
    }

    const HALF: &str = "GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n";

    #[test]
    fn who_does_not_finish_a_request_has_to_go() {
        let server = server(Limits { request_time: Duration::from_millis(100), ..Limits::default() });
        let mut silent = connect(&server, "");
        let mut half = connect(&server, HALF);
        let mut idle = connect(&server, "GET /none HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
        assert!(is_closed(&mut silent) && is_closed(&mut half));
        let mut answer = Vec::new();
        let _ = idle.read_to_end(&mut answer);
        assert!(answer.starts_with(b"HTTP/1.1 404"), "it was answered before it was closed");
    }

    /// Four hundred half-open connections keep nobody out, and those that a page has used stay.
    #[test]
    fn the_oldest_half_open_connection_makes_room() {
        let limits =
            Limits { num_connections: 20, request_time: Duration::from_secs(600), ..Limits::default() };
        let server = server(limits);
        let mut used = connect(&server, "GET /none HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
        assert!(used.read(&mut [0; 2000]).unwrap() > 0);
        let mut half_open: Vec<_> = (0..400).map(|_| connect(&server, HALF)).collect();
        assert!(page(&server).starts_with("HTTP/1.1 200"));
        assert!(half_open[..300].iter_mut().all(is_closed), "the oldest are gone");
        used.write_all(b"GET /none HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n").unwrap();
        assert!(used.read(&mut [0; 2000]).unwrap() > 0, "this one is still there");
    }

    #[test]
    fn pages_beyond_the_limit_are_refused() {
        let server = server(Limits { num_pages: 2, ..Limits::default() });
        let open = || {
            let mut stream = connect(
                &server,
                "GET /socket HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
                 Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n",
            );
            let mut start = [0; 12];
            stream.read_exact(&mut start).unwrap();
            (stream, String::from_utf8_lossy(&start).into_owned())
        };
        let pages = [open(), open()];
        assert!(pages.iter().all(|(_, answer)| answer == "HTTP/1.1 101"));
        assert_eq!(open().1, "HTTP/1.1 503");
        drop(pages);
        let is_let_in = (0..400).any(|_| {
            std::thread::sleep(Duration::from_millis(5));
            open().1 == "HTTP/1.1 101"
        });
        assert!(is_let_in, "their places are free again");
    }
}
