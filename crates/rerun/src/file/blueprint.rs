//! The layout as what the viewer calls a blueprint.
//!
//! Rerun's own blueprint types cannot say where the eye of a view begins or which entities show their past, so views and containers
//! are written here as the entities that a blueprint is made of: `viewport`, `container/ID`, `view/ID` and properties below them.

use re_sdk::{
    AsComponents, EntityPath, RecordingStream, RecordingStreamBuilder, RecordingStreamError,
    external::re_log_types::BlueprintActivationCommand,
};
use re_sdk_types::{
    Archetype as _,
    blueprint::{
        archetypes::{
            Background, ContainerBlueprint, EyeControls3D, LineGrid3D, PanelBlueprint, PlotLegend,
            ScalarAxis, TimePanelBlueprint, ViewBlueprint, ViewContents, ViewportBlueprint,
            VisibleTimeRanges, VisualBounds2D,
        },
        components::{
            AutoLayout, AutoViews, BackgroundKind, ColumnShare, ContainerKind, Corner2D, Eye3DKind,
            IncludedContent, PanelState, QueryExpression, RootContainer, RowShare, TimelineName, ViewClass,
        },
    },
    components::{Color as Rgba, Name, Position3D, Range1D, Visible},
    datatypes::{Bool, Float32, Range2D, TimeInt, TimeRange, TimeRangeBoundary, Utf8, VisibleTimeRange},
    external::uuid::Uuid,
};

use super::writer::{FRAME, TIME};
use crate::{Color, Layout, ViewKind, layout::View};

type Done = Result<(), RecordingStreamError>;

/// Sends a layout along with a recording. It is active at once, and stays the one of the application.
pub(super) fn send(recording: &RecordingStream, application: &'static str, layout: &Layout) -> Done {
    let (stream, storage) =
        RecordingStreamBuilder::new(application).recording_id("layout").blueprint().memory()?;
    stream.set_log_time_enabled(false);
    stream.set_time_sequence("blueprint", 0);
    let mut writer = Writer { stream, num_ids: 0 };
    let (root, _) = writer.part(layout)?;
    writer.panels(root)?;
    let messages = storage.take();
    if let Some(blueprint_id) = messages.first().map(|message| message.store_id().clone()) {
        let activate = BlueprintActivationCommand { blueprint_id, make_active: true, make_default: true };
        recording.send_blueprint(messages, activate);
    }
    Ok(())
}

/// Writes parts of a layout, and numbers them.
struct Writer {
    stream: RecordingStream,
    num_ids: u128,
}

impl Writer {
    fn next_id(&mut self) -> Uuid {
        self.num_ids += 1;
        Uuid::from_u128(self.num_ids)
    }

    fn write(&self, path: &str, thing: &dyn AsComponents) -> Done {
        self.stream.log(path, thing)
    }

    /// Writes a part and all in it; its id and its path.
    fn part(&mut self, layout: &Layout) -> Result<(Uuid, String), RecordingStreamError> {
        match layout {
            Layout::Row(parts) => self.container(ContainerKind::Horizontal, parts),
            Layout::Column(parts) => self.container(ContainerKind::Vertical, parts),
            Layout::View(view) => self.view(view),
        }
    }

    fn container(
        &mut self,
        kind: ContainerKind,
        parts: &[(f32, Layout)],
    ) -> Result<(Uuid, String), RecordingStreamError> {
        let mut contents = Vec::new();
        for (_, part) in parts {
            let (_, path) = self.part(part)?;
            contents.push(IncludedContent(path.into()));
        }
        let shares = parts.iter().map(|(share, _)| Float32(*share));
        let container = ContainerBlueprint::new(kind).with_contents(contents);
        let container = match kind {
            ContainerKind::Horizontal => container.with_col_shares(shares.map(ColumnShare)),
            _ => container.with_row_shares(shares.map(RowShare)),
        };
        let id = self.next_id();
        let path = format!("container/{id}");
        self.write(&path, &container)?;
        Ok((id, path))
    }

    fn view(&mut self, view: &View) -> Result<(Uuid, String), RecordingStreamError> {
        let id = self.next_id();
        let path = format!("view/{id}");
        let class = match view.kind {
            ViewKind::Space => "3D",
            ViewKind::Picture => "2D",
            ViewKind::Plot => "TimeSeries",
            ViewKind::Events => "TextLog",
            ViewKind::Text => "TextDocument",
        };
        let blueprint = ViewBlueprint::new(ViewClass(class.into()))
            .with_display_name(Name(view.name.as_str().into()))
            .with_space_origin(format!("/{}", view.origin));
        self.write(&path, &blueprint)?;
        let contents = ViewContents::new([QueryExpression("$origin/**".into())]);
        self.write(&format!("{path}/{}", ViewContents::name().short_name()), &contents)?;
        if let Some([place, target]) = view.eye {
            let eye = EyeControls3D::new()
                .with_kind(Eye3DKind::Orbital)
                .with_position(position(place))
                .with_look_target(position(target));
            self.write(&format!("{path}/EyeControls3D"), &eye)?;
            // Our colors are those for the dark, whatever theme the viewer has.
            let [red, green, blue, _] = Color::BACKGROUND.0;
            let background =
                Background::new(BackgroundKind::SolidColor).with_color(Rgba::from_rgb(red, green, blue));
            self.write(&format!("{path}/Background"), &background)?;
            let grid = LineGrid3D::new().with_visible(Visible(Bool(false)));
            self.write(&format!("{path}/LineGrid3D"), &grid)?;
        }
        if let Some([width, height]) = view.image_size {
            let range = Range2D { x_range: [0.0, width].into(), y_range: [0.0, height].into() };
            self.write(&format!("{path}/VisualBounds2D"), &VisualBounds2D::new(range))?;
        }
        if let Some(range) = view.range {
            self.write(&format!("{path}/ScalarAxis"), &ScalarAxis::new().with_range(Range1D::from(range)))?;
        }
        if view.kind == ViewKind::Plot {
            self.write(&format!("{path}/PlotLegend"), &PlotLegend::new().with_corner(Corner2D::LeftTop))?;
        }
        for entity in &view.histories {
            let path =
                ViewContents::blueprint_base_visualizer_path_for_entity(id, &EntityPath::from(&**entity));
            self.stream.log(path, &until_now())?;
        }
        Ok((id, path))
    }

    fn panels(&self, root: Uuid) -> Done {
        let viewport = ViewportBlueprint::new()
            .with_root_container(RootContainer(root.into()))
            .with_auto_layout(AutoLayout(Bool(false)))
            .with_auto_views(AutoViews(Bool(false)));
        self.write("viewport", &viewport)?;
        self.write("blueprint_panel", &PanelBlueprint::new().with_state(PanelState::Collapsed))?;
        self.write("selection_panel", &PanelBlueprint::new().with_state(PanelState::Collapsed))?;
        let time = TimePanelBlueprint::new()
            .with_state(PanelState::Collapsed)
            .with_timeline(TimelineName(TIME.into()));
        self.write("time_panel", &time)
    }
}

/// Everything from the begin to the cursor, on both time lines.
fn until_now() -> VisibleTimeRanges {
    let range =
        TimeRange { start: TimeRangeBoundary::Infinite, end: TimeRangeBoundary::CursorRelative(TimeInt(0)) };
    let on = |timeline: &str| VisibleTimeRange { timeline: Utf8::from(timeline), range: range.clone() };
    VisibleTimeRanges::new([TIME, FRAME].map(on))
}

fn position([x, y, z]: [f64; 3]) -> Position3D {
    Position3D::new(x as f32, y as f32, z as f32)
}
