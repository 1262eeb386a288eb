//! A picture of what the image analysis keeps and drops.

use visloc_core::{Frame, RgbImage, geom::Horizon};
use visloc_locate::{
    ImageAnalyzer, Pipeline,
    vision::{
        DropReason, FeatureKind, ObjectKind, Percept,
        field::{FieldAnalyzer, GoalBlob},
        office::OfficeAnalyzer,
    },
};
use visloc_plot::{Color, ImageBoxes, ImageDots, ImageLine, ImagePicture, Picture, image_picture};

use crate::run::{FrameView, Spectator};

/// How much the image is enlarged.
const ENLARGEMENT: u32 = 3;

/// The analysis of one image, as it is drawn.
pub struct AnalysisSnapshot {
    picture: ImagePicture,
    secs: f64,
}

/// Waits for the image that somebody asked for, or else for the one that shows most of what the analysis can do.
#[derive(Default)]
pub struct SnapshotTaker {
    at_secs: Option<f64>,
    best: Option<(f64, AnalysisSnapshot)>,
}

impl SnapshotTaker {
    /// Takes the image nearest to this time, seconds after the first, if it is given.
    pub fn new(at_secs: Option<f64>) -> Self {
        Self { at_secs, best: None }
    }

    /// The best image so far.
    pub fn snapshot(&self) -> Option<&AnalysisSnapshot> {
        self.best.as_ref().map(|(_, snapshot)| snapshot)
    }
}

impl Spectator for SnapshotTaker {
    fn after_frame(&mut self, view: &FrameView<'_>) {
        let Some(runner) = view.runners.first() else { return };
        let score = match self.at_secs {
            Some(at_secs) => -(view.secs - at_secs).abs(),
            None => score(view.frame, runner.pipeline()),
        };
        if self.best.as_ref().is_none_or(|(best, _)| score > *best) {
            self.best = Some((score, AnalysisSnapshot::new(view, runner.pipeline())));
        }
    }
}

/// Good pixels, many different reasons to drop others but few of them, a goal and an obstacle, and the horizon in the
/// upper part of the image, so that both the room and the field are seen.
fn score(frame: &Frame, pipeline: &Pipeline) -> f64 {
    let analyzer = pipeline.analyzer();
    let percept = analyzer.percept();
    let is_seen = |reason: &&DropReason| percept.num_dropped(**reason) > 0;
    let (num_reasons, num_dropped) =
        (DropReason::ALL.iter().filter(is_seen).count() as f64, percept.dropped.len() as f64);
    let height_px = f64::from(frame.image.height());
    let horizon = Horizon::new(&frame.camera, &frame.robot_from_camera);
    let horizon_row = horizon.row_px(0.5 * f64::from(frame.image.width())).unwrap_or(-1.0);
    let bonus = |is_there: bool| if is_there { 0.5 } else { 0.0 };
    let of_world = match analyzer {
        ImageAnalyzer::Field(field) => {
            bonus(percept.num_dropped(DropReason::InObstacle) >= 5) + bonus(sees_large_goal(field, height_px))
        }
        ImageAnalyzer::Office(office) => 0.05 * office.lines().len() as f64,
        _ => 0.0,
    };
    percept.quality + 0.1 * num_reasons - 0.001 * num_dropped
        + of_world
        + bonus((0.1 * height_px..0.45 * height_px).contains(&horizon_row))
}

fn sees_large_goal(analyzer: &FieldAnalyzer, height_px: f64) -> bool {
    let is_large = |blob: &GoalBlob| f64::from(blob.bounds_px[3] - blob.bounds_px[1]) > 0.2 * height_px;
    analyzer.goal_blobs().iter().any(|blob| blob.is_valid && is_large(blob))
}

impl AnalysisSnapshot {
    fn new(view: &FrameView<'_>, pipeline: &Pipeline) -> Self {
        let analyzer = pipeline.analyzer();
        let mut dots = dropped(analyzer.percept());
        dots.extend(kept(analyzer.percept()));
        let picture = ImagePicture {
            title: "What the image analysis sees".to_owned(),
            subtitle: String::new(),
            image: washed(&view.frame.image),
            enlargement: ENLARGEMENT,
            boxes: match analyzer {
                ImageAnalyzer::Field(field) => boxes(field),
                _ => Vec::new(),
            },
            lines: lines(view.frame, analyzer),
            dots,
        };
        Self { picture, secs: view.secs }
    }

    /// The picture.
    pub fn draw(&self) -> Picture {
        let num_of = |is_meant: &dyn Fn(&str) -> bool| -> usize {
            let meant = self.picture.dots.iter().filter(|dots| is_meant(&dots.label));
            meant.map(|dots| dots.points_px.len()).sum()
        };
        let num_kept = num_of(&|label| label.starts_with("kept"));
        let num_discarded = num_of(&|label| label == DropReason::RandomDiscard.name());
        let subtitle = format!(
            "image at {:.1} s; {} border pixels passed all filters; large: those of --features pixels",
            self.secs,
            num_kept + num_discarded
        );
        image_picture(&ImagePicture { subtitle, ..self.picture.clone() })
    }
}

/// A little paler than it is, so that colored marks stand out.
fn washed(image: &RgbImage) -> RgbImage {
    let mut pale = image.clone();
    for value in pale.data_mut() {
        *value = 60 + (u16::from(*value) * 3 / 4) as u8;
    }
    pale
}

fn kept(percept: &Percept) -> Vec<ImageDots> {
    let is_line = |kind: FeatureKind| kind == FeatureKind::FieldLine;
    let is_floor = |kind: FeatureKind| matches!(kind, FeatureKind::WallFoot | FeatureKind::DoorFoot);
    let dots = |label: &str, color, is_meant: &dyn Fn(FeatureKind) -> bool| ImageDots {
        label: label.to_owned(),
        color,
        diameter_px: 4.4,
        points_px: {
            let pixels = percept.pixels.iter().filter(|pixel| is_meant(pixel.kind));
            pixels.map(|pixel| (pixel.px.x, pixel.px.y)).collect()
        },
    };
    let all = vec![
        dots("kept, line", Color::WHITE, &is_line),
        dots("kept, goal", GOLD, &FeatureKind::is_goal),
        dots("kept, floor", Color::WHITE, &is_floor),
        dots("kept, door", GOLD, &FeatureKind::is_door_edge),
    ];
    all.into_iter().filter(|dots| !dots.points_px.is_empty()).collect()
}

const GOLD: Color = Color::rgb(0xff, 0xd4, 0x00);

fn dropped(percept: &Percept) -> Vec<ImageDots> {
    let dots = |reason: &DropReason| ImageDots {
        label: reason.name().to_owned(),
        color: color(*reason),
        diameter_px: 1.7,
        points_px: {
            let pixels = percept.dropped.iter().filter(|pixel| pixel.reason == *reason);
            pixels.map(|pixel| (pixel.px.x, pixel.px.y)).collect()
        },
    };
    DropReason::ALL.iter().map(dots).collect()
}

/// One color for each reason, in the order of the filters.
fn color(reason: DropReason) -> Color {
    const COLORS: [Color; 14] = [
        Color::rgb(0xe4, 0x1a, 0x1c),
        Color::rgb(0xff, 0x7f, 0x00),
        Color::rgb(0xf7, 0x81, 0xbf),
        Color::rgb(0x98, 0x4e, 0xa3),
        Color::rgb(0x37, 0x7e, 0xb8),
        Color::rgb(0xa6, 0x56, 0x28),
        Color::rgb(0x00, 0xc8, 0xc8),
        Color::rgb(0x5a, 0x3c, 0xd2),
        Color::rgb(0x70, 0x10, 0x30),
        Color::rgb(0x4d, 0xaf, 0x4a),
        Color::rgb(0x8c, 0x6d, 0x31),
        Color::rgb(0xb8, 0xd8, 0x30),
        Color::rgb(0x1f, 0x78, 0x8a),
        Color::rgb(0x9a, 0x9a, 0x9a),
    ];
    if reason == DropReason::RandomDiscard {
        return COLORS[13];
    }
    let index = DropReason::ALL.iter().position(|known| *known == reason).unwrap_or(0);
    COLORS[index % 13]
}

fn lines(frame: &Frame, analyzer: &ImageAnalyzer) -> Vec<ImageLine> {
    let horizon = Horizon::new(&frame.camera, &frame.robot_from_camera);
    let last_column = f64::from(frame.image.width()) - 1.0;
    let ends = [0.0, last_column].map(|x| horizon.row_px(x).map(|y| (x, y)));
    let mut lines = vec![line("horizon", Color::SKY_BLUE, ends.into_iter().flatten().collect())];
    match analyzer {
        ImageAnalyzer::Field(field) => {
            lines.push(line("end of the field", Color::VERMILION, field.field_end().hull().to_vec()));
        }
        ImageAnalyzer::Office(office) => lines.extend(office_lines(office)),
        _ => {}
    }
    lines
}

fn line(label: &str, color: Color, points_px: Vec<(f64, f64)>) -> ImageLine {
    ImageLine { label: label.to_owned(), color, points_px }
}

/// Every line that the analysis kept; the legend names each kind once.
fn office_lines(analyzer: &OfficeAnalyzer) -> Vec<ImageLine> {
    let mut named = Vec::new();
    let lines = analyzer.lines().iter().filter_map(|found| Some((found.kind?, found.segment)));
    let mut draw = |(kind, segment): (FeatureKind, visloc_locate::vision::office::EdgeSegment)| {
        let (label, color) = match kind {
            FeatureKind::DoorEdge { .. } => ("edge of a door", Color::PURPLE),
            FeatureKind::DoorFoot => ("foot of a door", Color::VERMILION),
            _ => ("foot of a wall", Color::BLUE),
        };
        let is_new = !named.contains(&label);
        named.push(label);
        let ends = [segment.start, segment.end].map(|end| (end.x, end.y));
        line(if is_new { label } else { "" }, color, ends.to_vec())
    };
    lines.map(&mut draw).collect()
}

fn boxes(analyzer: &FieldAnalyzer) -> Vec<ImageBoxes> {
    let goals = |is_valid: bool| {
        let blobs = analyzer.goal_blobs().iter().filter(|blob| blob.is_valid == is_valid);
        blobs.map(|blob| blob.bounds_px).collect()
    };
    // Inside of the image: what is judged of a robot ends with it.
    let objects = |kind: ObjectKind| {
        let found = analyzer.percept().objects.iter().filter(|object| object.kind == kind);
        found.map(|object| object.bounds_px.map(|px| px.max(0.0) as u32)).collect()
    };
    let boxes = |label: &str, color, bounds_px| ImageBoxes { label: label.to_owned(), color, bounds_px };
    vec![
        boxes("blob that is no goal", Color::GRAY, goals(false)),
        boxes("goal", GOLD, goals(true)),
        boxes(
            "obstacle",
            Color::PURPLE,
            analyzer.obstacles().iter().map(|obstacle| obstacle.bounds_px).collect(),
        ),
        boxes("robot", Color::BLUE, objects(ObjectKind::Robot)),
        boxes("ball", Color::VERMILION, objects(ObjectKind::Ball)),
    ]
}
