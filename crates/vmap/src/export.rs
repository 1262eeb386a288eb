//! Maps for other programs: COLMAP and nerfstudio make dense models of them.

use std::fmt::Write;

use serde::Serialize;
use visloc_core::geom::{Camera, Distortion};
use visloc_slam::map::{Keyframe, KeyframeId, KeyframePicture, MapId, SessionCamera};

use crate::VisualMap;

/// The three text files of a model of COLMAP. The origin of its pixels is the corner of the image, half a pixel beside the center of the first
/// pixel. Source: COLMAP documentation, "Output format".
#[derive(Debug, Clone, Default)]
pub struct ColmapModel {
    /// `cameras.txt`.
    pub cameras: String,
    /// `images.txt`.
    pub images: String,
    /// `points3D.txt`.
    pub points: String,
}

/// Name of the picture of a keyframe in the exported folders.
pub fn picture_name(id: KeyframeId) -> String {
    format!("images/{:06}.jpg", id.index())
}

impl VisualMap {
    fn cameras_of(&self, map: MapId) -> Vec<SessionCamera> {
        let mut cameras: Vec<SessionCamera> = Vec::new();
        for camera in self.keyframes_of(map).filter_map(|(_, k)| k.foreign.as_deref()) {
            if !cameras.contains(camera) {
                cameras.push(*camera);
            }
        }
        cameras
    }

    fn keyframes_of(&self, map: MapId) -> impl Iterator<Item = (KeyframeId, &Keyframe)> {
        self.map.all_keyframes().filter(move |(_, keyframe)| keyframe.map == map)
    }

    /// The pictures of the keyframes of a map as they lie in the file: JPEG.
    pub fn pictures_of(&self, map: MapId) -> impl Iterator<Item = (KeyframeId, &[u8])> {
        self.keyframes_of(map).filter_map(|(id, keyframe)| match &keyframe.picture {
            Some(KeyframePicture::Packed(packed)) => Some((id, packed.bytes())),
            _ => None,
        })
    }

    /// A map as a model of COLMAP.
    pub fn to_colmap(&self, map: MapId) -> ColmapModel {
        let cameras = self.cameras_of(map);
        let mut model = ColmapModel::default();
        for (number, camera) in (1..).zip(&cameras) {
            let (name, values) = colmap_camera(&camera.camera);
            let (width, height) = camera.camera.size_px();
            let values: Vec<String> = values.iter().map(f64::to_string).collect();
            let _ = writeln!(model.cameras, "{number} {name} {width} {height} {}", values.join(" "));
        }
        // Place of each observation in the list of its image.
        let mut num_seen = vec![0_usize; self.map.num_keyframe_ids()];
        let mut seen = vec![String::new(); self.map.num_keyframe_ids()];
        let is_of_map = |id: KeyframeId| self.map.keyframe(id).map == map;
        for (id, landmark) in
            self.map.all_landmarks().filter(|(_, l)| is_of_map(l.observations.keyframe_at(0)))
        {
            let point = landmark.point_in_world;
            let number = id.index() + 1;
            let mut track = String::new();
            for observation in landmark.observations.iter() {
                let index = observation.keyframe.index();
                let _ = write!(track, " {} {}", index + 1, num_seen[index]);
                let (x, y) = (observation.px.x + 0.5, observation.px.y + 0.5);
                let _ = write!(seen[index], "{x:.3} {y:.3} {number} ");
                num_seen[index] += 1;
            }
            let gray = self.gray_of(landmark);
            let _ = writeln!(
                model.points,
                "{number} {} {} {} {gray} {gray} {gray} 1{track}",
                point.x, point.y, point.z
            );
        }
        for (id, keyframe) in self.keyframes_of(map) {
            let pose = keyframe.camera_from_world();
            let [x, y, z, w] = pose.quaternion_xyzw();
            let t = pose.translation();
            let camera =
                cameras.iter().position(|camera| keyframe.foreign.as_deref() == Some(camera)).unwrap_or(0)
                    + 1;
            let (number, name) = (id.index() + 1, picture_name(id));
            let _ =
                writeln!(model.images, "{number} {w} {x} {y} {z} {} {} {} {camera} {name}", t.x, t.y, t.z);
            let _ = writeln!(model.images, "{}", seen[id.index()].trim_end());
        }
        model
    }

    /// A map as `transforms.json` of nerfstudio, whose cameras look along -z with y upwards. Source: nerfstudio documentation, "Data
    /// conventions". Pictures of other cameras than the first one have values of their own.
    pub fn to_nerfstudio(&self, map: MapId) -> NerfstudioModel {
        let own = Camera::default();
        let frames = self.keyframes_of(map).map(|(id, keyframe)| {
            let pose = keyframe.camera_from_world().inverse();
            let (r, t) = (pose.rotation(), pose.translation());
            let row = |i: usize| [r[(i, 0)], -r[(i, 1)], -r[(i, 2)], t[i]];
            NerfstudioFrame {
                file_path: picture_name(id),
                transform_matrix: [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]],
                camera: NerfstudioCamera::new(keyframe.camera(&own)),
            }
        });
        NerfstudioModel { frames: frames.collect() }
    }

    /// Gray of a landmark in the first picture that there is; middle gray if there is none.
    fn gray_of(&self, landmark: &visloc_slam::map::Landmark) -> u8 {
        let seen = landmark.observations.iter().find_map(|observation| {
            let pyramid = self.map.keyframe(observation.keyframe).pyramid()?;
            let image = pyramid.level(0);
            let [column, row] = [observation.px.x, observation.px.y].map(|v| v.round().max(0.0) as usize);
            let is_inside = column < image.width() && row < image.height();
            is_inside.then(|| image.data()[row * image.width() + column])
        });
        seen.unwrap_or(128)
    }
}

/// `transforms.json`.
#[derive(Debug, Clone, Serialize)]
pub struct NerfstudioModel {
    frames: Vec<NerfstudioFrame>,
}

#[derive(Debug, Clone, Serialize)]
struct NerfstudioFrame {
    file_path: String,
    transform_matrix: [[f64; 4]; 4],
    #[serde(flatten)]
    camera: NerfstudioCamera,
}

#[derive(Debug, Clone, Serialize)]
struct NerfstudioCamera {
    camera_model: &'static str,
    w: u32,
    h: u32,
    fl_x: f64,
    fl_y: f64,
    cx: f64,
    cy: f64,
    k1: f64,
    k2: f64,
    k3: f64,
    k4: f64,
    p1: f64,
    p2: f64,
}

impl NerfstudioCamera {
    fn new(camera: &Camera) -> Self {
        let ((w, h), (fl_x, fl_y), (cx, cy)) = (camera.size_px(), camera.focal_px(), camera.center_px());
        let (camera_model, [k1, k2, k3, k4, p1, p2]) = match camera.distortion() {
            Distortion::RadialTangential([k1, k2, p1, p2, k3]) => ("OPENCV", [k1, k2, k3, 0.0, p1, p2]),
            Distortion::KannalaBrandt([k1, k2, k3, k4]) => ("OPENCV_FISHEYE", [k1, k2, k3, k4, 0.0, 0.0]),
            _ => ("OPENCV", [0.0; 6]),
        };
        Self { camera_model, w, h, fl_x, fl_y, cx: cx + 0.5, cy: cy + 0.5, k1, k2, k3, k4, p1, p2 }
    }
}

fn colmap_camera(camera: &Camera) -> (&'static str, Vec<f64>) {
    let ((fx, fy), (cx, cy)) = (camera.focal_px(), camera.center_px());
    let mut values = vec![fx, fy, cx + 0.5, cy + 0.5];
    let name = match camera.distortion() {
        Distortion::RadialTangential([k1, k2, p1, p2, k3]) => {
            values.extend([k1, k2, p1, p2, k3, 0.0, 0.0, 0.0]);
            "FULL_OPENCV"
        }
        Distortion::KannalaBrandt(k) => {
            values.extend(k);
            "OPENCV_FISHEYE"
        }
        _ => "PINHOLE",
    };
    (name, values)
}
