//! What can be asked for.

use std::sync::{
    Arc,
    atomic::{AtomicU64, Ordering},
};

use axum::{
    Extension, Router,
    body::Body,
    extract::{DefaultBodyLimit, State, WebSocketUpgrade},
    http::{HeaderMap, HeaderValue, StatusCode, Uri, header},
    response::{IntoResponse, Response},
    routing::{get, post},
};
use tokio::sync::Semaphore;

use super::{
    access::{Access, Refusal},
    assets, building,
    files::take_file,
    guests::Peer,
    hub::Hub,
    seat::Visitor,
    socket::attend,
};

/// Longest message of a page, bytes.
const MAX_MESSAGE_BYTES: usize = 64 * 1024;
/// Nothing from elsewhere, nothing inline, in no frame.
const CONTENT_SECURITY_POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; \
                                       img-src 'self' blob: data:; base-uri 'none'; form-action 'none'; \
                                       frame-ancestors 'none'";

#[derive(Clone)]
struct Shared {
    hub: Arc<Hub>,
    access: Arc<Access>,
    /// Places for pages at their sockets.
    places: Arc<Semaphore>,
    /// How many pages have come so far.
    num_visitors: Arc<AtomicU64>,
}

/// The page, its parts and the socket.
pub(super) fn router(hub: Arc<Hub>, access: Access, num_pages: usize) -> Router {
    let (access, places) = (Arc::new(access), Arc::new(Semaphore::new(num_pages)));
    Router::new()
        .route("/socket", get(open_socket))
        .route("/access", get(may_open))
        .route("/files", get(takes_files).post(open_file).layer(DefaultBodyLimit::disable()))
        .route("/building", post(check_building).layer(DefaultBodyLimit::max(building::MAX_BYTES)))
        .fallback(get(page))
        .with_state(Shared { hub, access, places, num_visitors: Arc::default() })
}

/// Serves a part of the page; everything is in the program, so no path leads anywhere else.
async fn page(uri: Uri) -> Response {
    let Some(asset) = assets::find(uri.path()) else {
        return with_headers((StatusCode::NOT_FOUND, "not found").into_response());
    };
    let kind = [(header::CONTENT_TYPE, asset.kind)];
    with_headers((kind, asset.bytes).into_response())
}

fn with_headers(mut response: Response) -> Response {
    let headers = response.headers_mut();
    for (name, value) in [
        (header::CONTENT_SECURITY_POLICY, CONTENT_SECURITY_POLICY),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::CACHE_CONTROL, "no-store"),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    response
}

/// Tells a page why its socket does not open; a browser does not.
async fn may_open(State(shared): State<Shared>, uri: Uri, headers: HeaderMap) -> Response {
    with_headers(match check(&shared, &uri, &headers) {
        Ok(()) => StatusCode::NO_CONTENT.into_response(),
        Err(refused) => refused,
    })
}

/// Tells a page whether it may hand over files.
async fn takes_files(State(shared): State<Shared>) -> Response {
    let is_so = shared.access.token().is_none() && shared.hub.files_folder().is_some();
    with_headers(if is_so { "yes" } else { "no" }.into_response())
}

async fn open_file(State(shared): State<Shared>, uri: Uri, headers: HeaderMap, body: Body) -> Response {
    with_headers(match check(&shared, &uri, &headers) {
        Ok(()) => take_file(&shared.hub, shared.access.token().is_none(), &uri, body).await,
        Err(refused) => refused,
    })
}

/// Tells whether a building that a page has drawn can be one.
async fn check_building(
    State(shared): State<Shared>,
    uri: Uri,
    headers: HeaderMap,
    body: String,
) -> Response {
    with_headers(match check(&shared, &uri, &headers) {
        Ok(()) => building::check_building(body).await,
        Err(refused) => refused,
    })
}

async fn open_socket(
    State(shared): State<Shared>,
    Extension(Peer(address)): Extension<Peer>,
    uri: Uri,
    headers: HeaderMap,
    upgrade: WebSocketUpgrade,
) -> Response {
    if let Err(refused) = check(&shared, &uri, &headers) {
        return refused;
    }
    let Ok(place) = shared.places.try_acquire_owned() else {
        return (StatusCode::SERVICE_UNAVAILABLE, "too many pages are open; close one").into_response();
    };
    let visitor = Visitor { id: shared.num_visitors.fetch_add(1, Ordering::Relaxed), address };
    upgrade.max_message_size(MAX_MESSAGE_BYTES).max_frame_size(MAX_MESSAGE_BYTES).on_upgrade(
        |socket| async move {
            attend(socket, shared.hub, visitor).await;
            drop(place);
        },
    )
}

#[allow(clippy::result_large_err)]
fn check(shared: &Shared, uri: &Uri, headers: &HeaderMap) -> Result<(), Response> {
    let text = |name: header::HeaderName| headers.get(name).and_then(|value| value.to_str().ok());
    let mut pairs = uri.query().unwrap_or_default().split('&');
    let token = pairs.find_map(|pair| pair.strip_prefix("token="));
    let checked = shared.access.check(text(header::HOST), text(header::ORIGIN), token);
    checked.map_err(|refusal| {
        let reason = match refusal {
            Refusal::Origin => "pages of other origins may not open this socket",
            Refusal::Token => "the token is missing or wrong; it is in the address that visloc printed",
        };
        shared.hub.count_refused(reason);
        (StatusCode::FORBIDDEN, reason).into_response()
    })
}
