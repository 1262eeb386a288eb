//! The server on its thread.

use std::{
    net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener},
    sync::Arc,
    thread::{self, JoinHandle},
};

use thiserror::Error;
use tokio::{runtime::Builder, sync::oneshot};

use super::{
    access::{Access, random_token},
    guests::{Limits, receive},
    hub::Hub,
    routes::router,
};

/// Why a server cannot be started.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ServerError {
    /// The address is taken or not of this computer.
    #[error(
        "{address}: cannot listen there: {source}; choose an address of this computer and a free port (--port of the studio, or behind the colon of --publish)"
    )]
    Listen {
        /// The address.
        address: SocketAddr,
        /// What the system says.
        source: std::io::Error,
    },
    /// There is no thread or no event loop.
    #[error("cannot start the server: {0}")]
    System(#[from] std::io::Error),
    /// There are no random numbers for a token.
    #[error("cannot make a token: {0}")]
    Random(#[from] getrandom::Error),
}

/// A running server; it ends when it is dropped.
#[derive(Debug)]
pub struct Server {
    address: SocketAddr,
    token: Option<String>,
    end: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    /// Starts to serve. Port 0 is any free one. Without a `token`, one is made if other computers can reach the address.
    ///
    /// # Errors
    /// If nobody can listen at this address.
    pub fn start(address: SocketAddr, token: Option<String>, hub: Arc<Hub>) -> Result<Self, ServerError> {
        Self::start_with(address, token, hub, Limits::default())
    }

    /// As [`Server::start`], but whoever comes needs a token, also on this computer.
    ///
    /// # Errors
    /// If nobody can listen at this address.
    pub fn start_guarded(
        address: SocketAddr,
        token: Option<String>,
        hub: Arc<Hub>,
    ) -> Result<Self, ServerError> {
        let token = token.map_or_else(random_token, Ok)?;
        Self::start(address, Some(token), hub)
    }

    pub(super) fn start_with(
        address: SocketAddr,
        token: Option<String>,
        hub: Arc<Hub>,
        limits: Limits,
    ) -> Result<Self, ServerError> {
        let listener =
            TcpListener::bind(address).map_err(|source| ServerError::Listen { address, source })?;
        listener.set_nonblocking(true)?;
        let address = listener.local_addr()?;
        let access = Access::new(&address, token)?;
        let token = access.token().map(str::to_owned);
        let runtime = Builder::new_current_thread().enable_io().enable_time().build()?;
        let (end, ended) = oneshot::channel::<()>();
        let router = router(Arc::clone(&hub), access, limits.num_pages);
        let serve = async move {
            let Ok(listener) = tokio::net::TcpListener::from_std(listener) else { return };
            tokio::select! {
                () = receive(listener, router, hub, limits) => {}
                _ = ended => {}
            }
        };
        let thread =
            thread::Builder::new().name("studio-server".to_owned()).spawn(move || runtime.block_on(serve))?;
        Ok(Self { address, token, end: Some(end), thread: Some(thread) })
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// What must be known to get in from outside.
    pub fn token(&self) -> Option<&str> {
        self.token.as_deref()
    }

    /// The address for a browser, with the token.
    pub fn url(&self) -> String {
        let mut address = self.address;
        if address.ip().is_unspecified() {
            address.set_ip(IpAddr::V4(Ipv4Addr::LOCALHOST));
        }
        let token = self.token.as_ref().map(|token| format!("?token={token}")).unwrap_or_default();
        format!("http://{address}/{token}")
    }

    /// Waits until the server ends, which it does not by itself.
    pub fn wait(mut self) {
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        if let Some(end) = self.end.take() {
            let _ = end.send(());
        }
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
