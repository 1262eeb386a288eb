//! The server over real connections on this computer.

use std::{
    io::{Read as _, Write as _},
    net::{SocketAddr, TcpStream},
    sync::{Arc, mpsc::Receiver},
    thread,
    time::Duration,
};

use serde_json::{Map, Value};
use tokio_tungstenite::tungstenite::{
    self, Message as Frame, WebSocket, client::IntoClientRequest as _, http::HeaderValue,
};
use visloc_core::Clock;
use visloc_studio::{Command, Hub, Message, Scenes, Update, recording::Tape, run_engine, server::Server};

use crate::support::playground;

/// Waits at most so long for anything, in steps.
const PATIENCE: usize = 400;

pub fn hub() -> (Arc<Hub>, Receiver<Command>) {
    Hub::new(Clock::still(), |_| {})
}

pub fn serve(hub: &Arc<Hub>, address: &str, token: Option<&str>) -> Server {
    let address: SocketAddr = address.parse().unwrap();
    Server::start(address, token.map(str::to_owned), Arc::clone(hub)).unwrap()
}

/// A page at its socket.
pub type Page = WebSocket<TcpStream>;

/// Opens a socket; `origin` is that of the page.
pub fn open(
    server: &Server,
    origin: Option<&str>,
    token: &str,
) -> Result<WebSocket<TcpStream>, Box<tungstenite::Error>> {
    let port = server.address().port();
    let mut request = format!("ws://127.0.0.1:{port}/socket{token}").into_client_request().unwrap();
    if let Some(origin) = origin {
        request.headers_mut().insert("origin", HeaderValue::from_str(origin).unwrap());
    }
    let stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    match tungstenite::client(request, stream) {
        Ok((socket, _)) => Ok(socket),
        Err(tungstenite::HandshakeError::Failure(error)) => Err(Box::new(error)),
        Err(error) => panic!("{error}"),
    }
}

fn is_forbidden(result: Result<WebSocket<TcpStream>, Box<tungstenite::Error>>) -> bool {
    matches!(result.map_err(|error| *error), Err(tungstenite::Error::Http(answer)) if answer.status() == 403)
}

pub fn wait_for(what: &str, is_so: impl Fn() -> bool) {
    for _ in 0..PATIENCE {
        if is_so() {
            return;
        }
        thread::sleep(Duration::from_millis(25));
    }
    panic!("not within ten seconds: {what}");
}

/// An update whose state tells its number.
pub fn update(number: u32) -> Update {
    let bytes = |kind: u8, rest: &[u8]| -> Arc<[u8]> { [&[kind], rest].concat().into() };
    Update {
        scene: bytes(1, b"scene"),
        state: bytes(2, &number.to_le_bytes()),
        image: Some(bytes(3, &[0; 20_000])),
    }
}

fn get(server: &Server, path: &str) -> String {
    let mut stream = TcpStream::connect(server.address()).unwrap();
    write!(stream, "GET {path} HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n").unwrap();
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).unwrap();
    String::from_utf8_lossy(&answer).into_owned()
}

#[test]
fn only_the_page_is_served_and_it_may_load_nothing_from_elsewhere() {
    let (hub, _commands) = hub();
    let server = serve(&hub, "127.0.0.1:0", None);
    for path in ["/", "/style.css", "/js/main.js"] {
        let answer = get(&server, path).to_lowercase();
        assert!(answer.starts_with("http/1.1 200"), "{path}");
        assert!(answer.contains("content-security-policy: default-src 'none'; script-src 'self'"), "{path}");
        assert!(!answer.contains("http://") && !answer.contains("src=\"//"), "{path} loads from elsewhere");
    }
    for path in
        ["/../Cargo.toml", "/js/../../Cargo.toml", "/%2e%2e/%2e%2e/etc/passwd", "//etc/passwd", "/js/", "/js"]
    {
        assert!(get(&server, path).starts_with("HTTP/1.1 404"), "{path}");
    }
}

#[test]
fn other_origins_cannot_open_the_socket() {
    let (hub, _commands) = hub();
    let server = serve(&hub, "127.0.0.1:0", None);
    let own = format!("http://127.0.0.1:{}", server.address().port());
    assert!(open(&server, Some(&own), "").is_ok());
    assert!(open(&server, None, "").is_ok(), "a program that is no page");
    assert!(is_forbidden(open(&server, Some("http://example.org"), "")));
    assert!(is_forbidden(open(&server, Some("null"), "")));
}

/// Hands over a file, as a page of an origin does; the answer's first line.
fn post(server: &Server, name: &str, origin: &str, content: &str) -> String {
    let answer = post_to(server, &format!("/files?name={name}"), origin, content);
    answer.lines().next().unwrap_or_default().to_owned()
}

fn post_to(server: &Server, path: &str, origin: &str, content: &str) -> String {
    let mut stream = TcpStream::connect(server.address()).unwrap();
    let length = content.len();
    write!(
        stream,
        "POST {path} HTTP/1.1\r\nHost: 127.0.0.1\r\nOrigin: {origin}\r\nContent-Length: {length}\r\n\
         Connection: close\r\n\r\n{content}"
    )
    .unwrap();
    let mut answer = Vec::new();
    let _ = stream.read_to_end(&mut answer);
    String::from_utf8_lossy(&answer).into_owned()
}

#[test]
fn only_pages_on_this_computer_hand_over_files() {
    let folder = tempfile::tempdir().unwrap();
    let (hub, commands) = hub();
    let server = serve(&hub, "127.0.0.1:0", None);
    assert!(
        post(&server, "a.toml", "http://127.0.0.1", "x").contains("403"),
        "nobody said that files are taken"
    );
    hub.take_files(folder.path());
    let content = "x".repeat(300_000);
    assert!(post(&server, "../a.toml", "http://127.0.0.1", &content).contains("202"));
    let Ok(Command::OpenFile { path, is_place: false }) = commands.try_recv() else { panic!("it is opened") };
    assert!(path.starts_with(folder.path()) && path.ends_with("opened/a-001.toml"), "{path:?}");
    assert_eq!(std::fs::read_to_string(path).unwrap(), content);
    assert!(post(&server, "a.toml", "http://example.org", "x").contains("403"));
    assert!(post(&server, "a.sh", "http://127.0.0.1", "x").contains("415"));
    let guarded = serve(&hub, "127.0.0.1:0", Some("secret"));
    assert!(
        post(&guarded, "a.toml&token=secret", "http://127.0.0.1", "x").contains("403"),
        "others can be there"
    );
    assert!(commands.try_recv().is_err());
}

#[test]
fn buildings_are_checked_for_whoever_may_watch_and_nothing_is_kept() {
    let (hub, commands) = hub();
    let (server, guarded) = (serve(&hub, "127.0.0.1:0", None), serve(&hub, "127.0.0.1:0", Some("secret")));
    let home = "http://127.0.0.1";
    let ask = |plan: &str| post_to(&server, "/building", home, plan);
    let plan = r#"{"plan":{"kind":"office","name":"hall","walls":[],"corridors":[{"outline":[[0,0],[9,0],[9,2],[0,2]]}]}}"#;
    let answer = ask(plan);
    assert!(answer.starts_with("HTTP/1.1 200") && answer.contains("no doors"), "{answer}");
    assert!(answer.contains("[[corridors]]"), "the text of the map file comes along: {answer}");
    assert!(ask(&plan.replace("9,2", "9,\"two\"")).starts_with("HTTP/1.1 400"));
    assert!(ask(&plan.replace("hall", &"h".repeat(300_000))).contains("413"));
    assert!(post_to(&guarded, "/building", home, plan).contains("403"));
    assert!(post_to(&server, "/building", "http://example.org", plan).contains("403"));
    assert!(commands.try_recv().is_err());
}

#[test]
fn a_map_that_is_handed_over_is_a_place_to_play_in() {
    let folder = tempfile::tempdir().unwrap();
    let (hub, commands) = hub();
    let server = serve(&hub, "127.0.0.1:0", None);
    hub.take_files(folder.path());
    let office = visloc_world::Map::built_in("office").unwrap().to_toml().unwrap();
    assert!(post(&server, "own.toml&as=place", "http://127.0.0.1", &office).contains("202"));
    let Ok(Command::OpenFile { path, is_place: true }) = commands.try_recv() else { panic!("it is opened") };
    let mut scenes = Scenes::new(Clock::still(), Clock::still(), 1);
    let id = scenes.add_place(&path).unwrap();
    let mut own = scenes.open(&id).unwrap();
    let update = own.update(None).unwrap();
    let scene = crate::support::scene(&update);
    assert_eq!((&scene["scene"], &scene["mode"]), (&id.into(), &"playground".into()));
    assert_eq!(scene["world"]["kind"], "office");
    std::fs::write(&path, "kind = \"office\"\n").unwrap();
    assert!(scenes.add_place(&path).unwrap_err().to_string().contains("no map to play on"));
}

#[test]
fn without_the_token_nobody_comes_in() {
    let (hub, commands) = hub();
    let server = serve(&hub, "0.0.0.0:0", None);
    let token = server.token().unwrap().to_owned();
    assert!(server.url().ends_with(&format!("?token={token}")));
    for wrong in ["", "?token=", "?token=0000", &format!("?token={}", &token[1..])] {
        assert!(is_forbidden(open(&server, None, wrong)), "{wrong}");
    }
    assert!(commands.try_recv().is_err(), "no command was taken");
    assert_eq!(hub.num_refused(), 4);
    assert!(open(&server, None, &format!("?token={token}")).is_ok());
    let own = serve(&hub, "127.0.0.1:0", Some("secret"));
    assert!(is_forbidden(open(&own, None, "")), "a token that was asked for is needed at home, too");
}

#[test]
fn malformed_messages_are_counted_and_nothing_else() {
    let (hub, commands) = hub();
    let server = serve(&hub, "127.0.0.1:0", None);
    let mut socket = open(&server, None, "").unwrap();
    for i in 0..20_000_u32 {
        let frame = match i % 4 {
            0 => Frame::text("{\"type\":\"fly\"}"),
            1 => Frame::text("{"),
            2 => Frame::binary(i.to_le_bytes().to_vec()),
            _ => Frame::text("{\"type\":\"kidnap\",\"x_m\":\"far\"}"),
        };
        socket.write(frame).unwrap();
    }
    socket.send(Frame::text("{\"type\":\"pause\"}")).unwrap();
    wait_for("all are counted", || hub.num_malformed() == 20_000);
    let taken: Vec<Command> = commands.iter().take(2).collect();
    assert_eq!(taken, [Command::Hello {}, Command::Pause {}]);
    assert!(commands.try_recv().is_err());
}

#[test]
fn a_message_that_is_too_long_ends_that_page_only() {
    let (hub, _commands) = hub();
    let server = serve(&hub, "127.0.0.1:0", None);
    let (mut greedy, mut polite) = (open(&server, None, "").unwrap(), open(&server, None, "").unwrap());
    let _ = greedy.send(Frame::text("x".repeat(1 << 20)));
    wait_for("it is sent away", || hub.num_viewers() == 1);
    hub.publish(update(7));
    assert_eq!(polite.read().unwrap().into_data()[0], 1, "the other one is served");
}

#[test]
fn a_stalled_page_is_sent_two_updates_and_then_the_latest() {
    let (hub, _commands) = hub();
    let server = serve(&hub, "127.0.0.1:0", None);
    let mut socket = open(&server, None, "").unwrap();
    wait_for("the page is there", || hub.num_viewers() == 1);
    hub.publish(update(0));
    while socket.read().unwrap().into_data()[0] != 2 {}
    // It has drawn once, and does not any more.
    socket.send(Frame::text("drawn")).unwrap();
    let mut kept = Vec::new();
    for number in 1..5000 {
        let update = update(number);
        kept.push(Arc::downgrade(&update.state));
        hub.publish(update);
        if number % 500 == 0 {
            // The server may look now and then, as it would in reality.
            thread::sleep(Duration::from_millis(5));
        }
    }
    wait_for("memory is given back", || kept.iter().filter(|state| state.strong_count() > 0).count() <= 3);
    let mut numbers = Vec::new();
    let mut read_states = |socket: &mut WebSocket<TcpStream>, count: usize| {
        while numbers.len() < count {
            let data = socket.read().unwrap().into_data();
            if data[0] == 2 {
                numbers.push(u32::from_le_bytes([data[1], data[2], data[3], data[4]]));
            }
        }
        numbers.clone()
    };
    let sent = read_states(&mut socket, 2);
    assert!(sent[1] < 5000, "{sent:?}");
    socket.send(Frame::text("drawn")).unwrap();
    assert_eq!(read_states(&mut socket, 3)[2], 4999, "whoever wakes up sees the present");
}

/// A program whose engine hangs says so, while one that waits for its source does not: nothing new comes from either.
#[test]
fn an_engine_that_hangs_is_told_from_one_that_waits() {
    let secs = Arc::new(std::sync::atomic::AtomicU32::new(0));
    let now = Arc::clone(&secs);
    let clock = Clock::new(move || f64::from(now.load(std::sync::atomic::Ordering::Relaxed)));
    let (hub, _commands) = Hub::new(clock, |_| {});
    let server = serve(&hub, "127.0.0.1:0", None);
    let mut socket = open(&server, None, "").unwrap();
    wait_for("the page is there", || hub.num_viewers() == 1);
    hub.publish(update(1));
    hub.work();
    secs.store(7, std::sync::atomic::Ordering::Relaxed);
    let mut next_pulse = || loop {
        if let Frame::Text(text) = socket.read().unwrap() {
            return text.to_string();
        }
    };
    assert_eq!(next_pulse(), "{\"type\":\"pulse\",\"busy_secs\":7.0}");
    hub.rest();
    let rests = (0..40).any(|_| next_pulse() == "{\"type\":\"pulse\",\"busy_secs\":0.0}");
    assert!(rests);
}

#[test]
fn pages_drive_the_engine_and_it_rests_without_them() {
    let (hub, commands) = hub();
    let server = serve(&hub, "127.0.0.1:0", None);
    let engine_hub = Arc::clone(&hub);
    let engine = thread::spawn(move || {
        // The clock stands still until commands move it, so nothing runs by itself.
        run_engine(
            Scenes::new(Clock::still(), Clock::still(), 1),
            Box::new(playground("robocup-2010", 1)),
            Tape::new(&std::env::temp_dir()),
            &engine_hub,
            &commands,
            &Clock::still(),
        );
    });
    let mut socket = open(&server, None, "").unwrap();
    let scene = socket.read().unwrap().into_data();
    assert_eq!(scene[0], 1);
    socket.send(Frame::text("{\"type\":\"open\",\"scene\":\"office\"}")).unwrap();
    let mut office = false;
    for _ in 0..40 {
        let data = socket.read().unwrap().into_data();
        if data[0] == 1 {
            office = Message::read(&data).unwrap().header["world"]["kind"] == "office";
        }
        if data[0] == 2 {
            socket.send(Frame::text("drawn")).unwrap();
        }
        if office {
            break;
        }
    }
    assert!(office, "the office was opened");
    drop(socket);
    wait_for("the page has left", || hub.num_viewers() == 0);
    hub.close();
    engine.join().unwrap();
}

#[test]
fn pages_cut_links_of_a_team_and_make_liars_and_read_what_is_refused() {
    let (hub, commands) = hub();
    let server = serve(&hub, "127.0.0.1:0", None);
    let engine_hub = Arc::clone(&hub);
    let engine = thread::spawn(move || {
        let mut scenes = Scenes::new(Clock::still(), Clock::still(), 1);
        let session = scenes.open("sim:team").unwrap();
        let tape = Tape::new(&std::env::temp_dir());
        run_engine(scenes, session, tape, &engine_hub, &commands, &Clock::still());
    });
    let mut socket = open(&server, None, "").unwrap();
    socket.send(Frame::text("{\"type\":\"pause\"}")).unwrap();
    let mut shown_after = |command: &str, is_so: &dyn Fn(&Map<String, Value>) -> bool| {
        socket.send(Frame::text(command.to_owned())).unwrap();
        let mut is_shown = false;
        for _ in 0..PATIENCE {
            let data = socket.read().unwrap().into_data();
            if data.first() != Some(&2) {
                continue;
            }
            socket.send(Frame::text("drawn")).unwrap();
            is_shown = is_so(&Message::read(&data).unwrap().header);
            if is_shown {
                break;
            }
        }
        assert!(is_shown, "{command}");
    };
    shown_after("{\"type\":\"link\",\"robot\":2,\"is_on\":false}", &|state| {
        state["team"]["robots"][1]["is_linked"] == false
    });
    shown_after("{\"type\":\"lie\",\"robot\":3,\"how\":\"wrong_half\"}", &|state| {
        state["team"]["robots"][2]["lie"] == "wrong_half"
    });
    shown_after("{\"type\":\"link\",\"robot\":7,\"is_on\":false}", &|state| {
        state["notice"] == "robot: expected 1 to 4, found 7"
    });
    drop(socket);
    wait_for("the page has left", || hub.num_viewers() == 0);
    hub.close();
    engine.join().unwrap();
}
