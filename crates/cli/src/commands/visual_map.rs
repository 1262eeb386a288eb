//! `visloc map info | align | export`, for maps of SLAM.

use std::path::Path;

use anyhow::{Context, Result, anyhow, bail};
use serde::Serialize;
use visloc_core::{CameraTrajectory, files, geom::Camera};
use visloc_io::camera_trajectory::read_camera_trajectory_file;
use visloc_slam::map::{MapId, SessionCamera};
use visloc_vmap::{VisualMap, load, picture_name, save};

use crate::{
    args::{JsonArg, MapAlignArgs},
    in_map::{draw, floor_of, unit},
    report::save_json,
    run::{Saving, expect_new_folder},
    say,
    slam::{damages_in_words, load_map, write_ply},
};

/// What `--json` of `map info` has.
#[derive(Serialize)]
struct Findings {
    keyframes: usize,
    landmarks: usize,
    bytes: u64,
    maps: Vec<MapFindings>,
    cameras: Vec<(u32, u32)>,
    sessions: Vec<SessionFindings>,
    damages: Vec<String>,
}

#[derive(Serialize)]
struct MapFindings {
    keyframes: usize,
    landmarks: usize,
    /// Longest side of the box of its keyframes, map units.
    extent: f64,
    scale: &'static str,
    scale_sigma: f64,
}

#[derive(Serialize)]
struct SessionFindings {
    source: String,
    program: String,
    images: u64,
    seed: u64,
}

/// Says what a map has.
pub fn info(path: &Path, plots: Option<&Path>, json: &JsonArg) -> Result<()> {
    let opened = load(path)?;
    let map = &opened.map;
    let findings = Findings {
        keyframes: map.map.all_keyframes().count(),
        landmarks: map.map.all_landmarks().count(),
        bytes: std::fs::metadata(path).map_or(0, |file| file.len()),
        maps: map.map.maps().into_iter().map(|id| findings_of(map, id)).collect(),
        cameras: cameras_of(map).iter().map(|camera| camera.camera.size_px()).collect(),
        sessions: map
            .sessions
            .iter()
            .map(|session| SessionFindings {
                source: session.source.clone(),
                program: session.program.clone(),
                images: session.num_images,
                seed: session.seed,
            })
            .collect(),
        damages: damages_in_words(&opened.damages),
    };
    print(path, &findings);
    let mut saving = Saving::default();
    saving.save_if(json.json.as_deref(), |path| save_json(path, &findings));
    saving.save_if(plots, |folder| {
        draw(folder, &path.display().to_string(), map, &[])?;
        say::line!("pictures: {}", folder.display());
        Ok(())
    });
    saving.end()
}

fn print(path: &Path, findings: &Findings) {
    let each = findings.bytes as f64 / findings.keyframes.max(1) as f64 / 1e3;
    say::line!(
        "{}: {}, {}, {:.1} MB, {each:.1} kB a keyframe",
        path.display(),
        say::count(findings.keyframes, "keyframe"),
        say::count(findings.landmarks, "landmark"),
        findings.bytes as f64 / 1e6
    );
    for (number, map) in findings.maps.iter().enumerate() {
        let sigma = if map.scale_sigma > 0.0 {
            format!(", to {:.2} %", map.scale_sigma * 100.0)
        } else {
            String::new()
        };
        say::line!(
            "  map {number}        {}, {}, {:.2} wide; scale: {}{sigma}",
            say::count(map.keyframes, "keyframe"),
            say::count(map.landmarks, "landmark"),
            map.extent,
            map.scale
        );
    }
    for (width, height) in &findings.cameras {
        say::line!("  camera       {width} x {height} px");
    }
    for session in &findings.sessions {
        say::line!("  made from    {}, {} images ({})", session.source, session.images, session.program);
    }
    for damage in &findings.damages {
        say::note!("{}: {damage}", path.display());
    }
}

fn findings_of(map: &VisualMap, id: MapId) -> MapFindings {
    let shown = map.map.with_active(id);
    let centers: Vec<_> = shown.keyframes().map(|(_, keyframe)| *keyframe.center_in_world()).collect();
    let extent = (0..3).map(|axis| {
        let along = centers.iter().map(|center| center[axis]);
        along.clone().fold(f64::NEG_INFINITY, f64::max) - along.fold(f64::INFINITY, f64::min)
    });
    let scale = map.scale(id);
    MapFindings {
        keyframes: centers.len(),
        landmarks: shown.landmarks().count(),
        extent: extent.fold(0.0, f64::max),
        scale: scale.source.name(),
        scale_sigma: scale.relative_sigma,
    }
}

fn cameras_of(map: &VisualMap) -> Vec<SessionCamera> {
    let mut cameras: Vec<SessionCamera> = Vec::new();
    for camera in map.map.all_keyframes().filter_map(|(_, keyframe)| keyframe.foreign.as_deref()) {
        if !cameras.contains(camera) {
            cameras.push(*camera);
        }
    }
    cameras
}

/// Whose keyframes have no camera of their own: every keyframe of a map that was read has one.
pub fn nobody() -> SessionCamera {
    SessionCamera::as_calibrated(&Camera::default())
}

/// The map that has most keyframes.
pub fn largest(map: &VisualMap, path: &Path) -> Result<MapId> {
    map.largest().ok_or_else(|| anyhow!("{}: expected a map with keyframes, found none", path.display()))
}

fn why_not_aligned(
    map: &VisualMap,
    id: MapId,
    truth: &CameraTrajectory,
    args: &MapAlignArgs,
    path: &Path,
) -> String {
    match map.num_known_places(id, truth) {
        num @ 0..4 => format!(
            "{}: expected the places of at least four keyframes of {}, found {num}; are the times those of its images?",
            path.display(),
            args.map.display()
        ),
        num => format!(
            "{}: {num} keyframes of {} have a known place, but these do not tell how the map is turned, or how large it is: they lie too near \
             each other or on a line, or do not fit the map; a way with turns tells more (for the length alone: --between, --camera-height)",
            path.display(),
            args.map.display()
        ),
    }
}

/// Gives a map the frame and the meters of known places.
pub fn align(args: &MapAlignArgs) -> Result<()> {
    let mut map = load_map(&args.map)?;
    let id = largest(&map, &args.map)?;
    if let Some(path) = &args.to {
        let file = read_camera_trajectory_file(path)?;
        if file.is_in_map_units {
            bail!(
                "{}: expected places in meters, found map units, of which nobody knows how long they are; --distance or \
                 --camera-height says it",
                path.display()
            );
        }
        let truth = file.timed(path)?;
        let Some(aligned) = map.align(id, &truth) else {
            bail!(why_not_aligned(&map, id, &truth, args, path))
        };
        say::line!(
            "{} keyframes with known places: a map unit is {:.5} m, to {:.2} %, turned to {:.2} degrees; {:.4} m are left (RMSE)",
            aligned.num_pairs,
            aligned.scale,
            aligned.relative_sigma * 100.0,
            aligned.turn_sigma_rad.to_degrees(),
            aligned.rmse_m
        );
    }
    if let (Some(meters), Some([first, second])) = (args.distance, args.between.as_deref()) {
        check_length("--distance", meters)?;
        let scaled = map.scale_by_distance(id, [*first, *second], meters).context("--between")?;
        say::line!(
            "{meters} m between the camera's places {:.2} and {:.2} s after the first keyframe: a map unit is {:.5} m, to {:.1} %",
            scaled.secs[0],
            scaled.secs[1],
            scaled.scale,
            scaled.relative_sigma * 100.0
        );
    }
    if let Some(meters) = args.camera_height {
        check_length("--camera-height", meters)?;
        let Some((scale, ground)) = map.scale_by_height(id, meters) else {
            bail!(
                "{}: expected landmarks on the ground below the camera's way, found too few",
                args.map.display()
            );
        };
        say::line!(
            "a ground of {} landmarks below {} pieces of the way: a map unit is {scale:.5} m, to {:.1} %",
            ground.num_points,
            ground.num_pieces,
            ground.relative_sigma * 100.0
        );
    }
    save(&args.out, &map, &nobody())?;
    say::line!("map: {}", args.out.display());
    Ok(())
}

fn check_length(option: &str, meters: f64) -> Result<()> {
    if !(meters.is_finite() && meters > 0.0) {
        bail!("{option}: expected more than 0 m, found {meters}");
    }
    Ok(())
}

/// Where an export goes.
pub struct Wanted<'a> {
    /// PLY.
    pub points: Option<&'a Path>,
    /// Folder of a model of COLMAP.
    pub colmap: Option<&'a Path>,
    /// Folder of nerfstudio.
    pub nerfstudio: Option<&'a Path>,
    /// Folder of a floor picture.
    pub floor: Option<&'a Path>,
}

/// Writes a map for other programs.
pub fn export(path: &Path, wanted: &Wanted<'_>) -> Result<()> {
    let all = [wanted.points, wanted.colmap, wanted.nerfstudio, wanted.floor];
    if all.iter().all(Option::is_none) {
        bail!("expected --points, --colmap, --nerfstudio or --floor");
    }
    let map = load_map(path)?;
    let id = largest(&map, path)?;
    let mut saving = Saving::default();
    saving.save_if(wanted.points, |out| {
        write_ply(out, &map.map.with_active(id), &Camera::default(), unit(&map))?;
        say::line!("landmarks: {}", out.display());
        Ok(())
    });
    saving.save_if(wanted.colmap, |folder| {
        expect_new_folder(folder)?;
        let model = map.to_colmap(id);
        write(&folder.join("cameras.txt"), model.cameras)?;
        write(&folder.join("images.txt"), model.images)?;
        write(&folder.join("points3D.txt"), model.points)?;
        write_pictures(&map, id, folder)
    });
    saving.save_if(wanted.nerfstudio, |folder| {
        expect_new_folder(folder)?;
        save_json(&folder.join("transforms.json"), &map.to_nerfstudio(id))?;
        write_pictures(&map, id, folder)
    });
    saving.save_if(wanted.floor, |folder| write_floor(path, &map, folder));
    saving.end()
}

fn write_floor(path: &Path, map: &VisualMap, folder: &Path) -> Result<()> {
    let floor = floor_of(path, map).context("--floor")?;
    write(&folder.join("floor.pgm"), floor.to_pgm())?;
    write(&folder.join("floor.yaml"), floor.to_yaml("floor.pgm"))?;
    say::line!(
        "floor: {}, {} x {} cells of {} m",
        folder.display(),
        floor.size.0,
        floor.size.1,
        floor.cell_m
    );
    Ok(())
}

fn write_pictures(map: &VisualMap, id: MapId, folder: &Path) -> Result<()> {
    for (keyframe, bytes) in map.pictures_of(id) {
        write(&folder.join(picture_name(keyframe)), bytes)?;
    }
    say::line!("model: {}", folder.display());
    Ok(())
}

fn write(path: &Path, bytes: impl AsRef<[u8]>) -> Result<()> {
    files::write(path, bytes).with_context(|| path.display().to_string())
}
