//! Files that a page hands over, on this computer only: they are written below a folder of the program's under names of the program's.

use std::{fs::File, io::Write as _, sync::Arc};

use axum::{
    body::Body,
    http::{StatusCode, Uri},
    response::{IntoResponse, Response},
};
use futures_util::StreamExt as _;

use super::hub::Hub;
use crate::{Command, new_file::open_new_file};

/// Folder below that of recordings.
const FOLDER: &str = "opened";
/// A longer file is refused, bytes.
const MAX_BYTES: u64 = 16 << 30;
const MAX_NAME: usize = 60;
/// What is opened, by the ends of names.
const EXTENSIONS: [&str; 16] = [
    "mcap", "bag", "db3", "mp4", "mkv", "webm", "mov", "avi", "png", "jpg", "toml", "yaml", "yml", "svg",
    "dxf", "json",
];

/// Takes a file and has the engine open it; `isolated` tells that nobody but this computer can be here.
pub(super) async fn take_file(hub: &Arc<Hub>, isolated: bool, uri: &Uri, body: Body) -> Response {
    let refused = |status: StatusCode, reason: &str| (status, reason.to_owned()).into_response();
    let Some(folder) = hub.files_folder().filter(|_| isolated) else {
        return refused(
            StatusCode::FORBIDDEN,
            "this studio opens no files of pages; name them where it is started",
        );
    };
    let query = uri.query().unwrap_or_default();
    let name = query.split('&').find_map(|pair| pair.strip_prefix("name=")).unwrap_or_default();
    let Some((stem, extension)) = safe_name(name) else {
        let known = EXTENSIONS.join(", ");
        return refused(
            StatusCode::UNSUPPORTED_MEDIA_TYPE,
            &format!("{name}: expected a file that ends in {known}"),
        );
    };
    let (path, file) = match open_new_file(&folder.join(FOLDER), &stem, extension) {
        Ok(new) => new,
        Err(error) => return refused(StatusCode::INTERNAL_SERVER_ERROR, &error.to_string()),
    };
    let is_place = query.split('&').any(|pair| pair == "as=place");
    match save(body, file).await {
        Ok(()) => {
            hub.take(Command::OpenFile { path, is_place });
            StatusCode::ACCEPTED.into_response()
        }
        Err(reason) => {
            let _ = std::fs::remove_file(&path);
            refused(StatusCode::BAD_REQUEST, &reason)
        }
    }
}

async fn save(body: Body, mut file: File) -> Result<(), String> {
    let mut chunks = body.into_data_stream();
    let mut num_bytes = 0;
    while let Some(chunk) = chunks.next().await {
        let chunk = chunk.map_err(|error| error.to_string())?;
        num_bytes += chunk.len() as u64;
        if num_bytes > MAX_BYTES {
            return Err(format!("expected at most {MAX_BYTES} bytes"));
        }
        file.write_all(&chunk).map_err(|error| error.to_string())?;
    }
    Ok(())
}

/// The letters, digits, hyphens and underscores of a name, and the known ending of it.
fn safe_name(name: &str) -> Option<(String, &'static str)> {
    let (stem, extension) = name.rsplit_once('.')?;
    let extension = extension.to_ascii_lowercase();
    let extension = EXTENSIONS.into_iter().find(|known| *known == extension)?;
    let is_safe = |letter: &char| letter.is_ascii_alphanumeric() || matches!(letter, '-' | '_');
    let stem: String = stem.chars().filter(is_safe).take(MAX_NAME).collect();
    Some((if stem.is_empty() { "file".to_owned() } else { stem }, extension))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_nowhere_else() {
        let safe = |name| safe_name(name).map(|(stem, extension)| format!("{stem}.{extension}"));
        assert_eq!(safe("run-1_b.MCAP").as_deref(), Some("run-1_b.mcap"));
        assert_eq!(safe("../../etc/a b.toml").as_deref(), Some("etcab.toml"));
        assert_eq!(safe("..%2F..%2Fx.svg").as_deref(), Some("2F2Fx.svg"));
        assert_eq!(safe("/.toml").as_deref(), Some("file.toml"));
        for wrong in ["", "toml", "run.exe", "run.mcap.sh", "run.", "a.to/ml"] {
            assert_eq!(safe(wrong), None, "{wrong}");
        }
    }
}
