//! How the viewer arranges what it shows.

/// What a view shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ViewKind {
    /// The world.
    Space,
    /// The image.
    Picture,
    /// Curves over time.
    Plot,
    /// What happened.
    Events,
    /// A text.
    Text,
}

/// Views, side by side or one above the other.
#[derive(Debug, Clone, PartialEq)]
pub enum Layout {
    /// From left to right, with the share of each.
    Row(Vec<(f32, Layout)>),
    /// From top to bottom, with the share of each.
    Column(Vec<(f32, Layout)>),
    /// One view.
    View(View),
}

/// A view.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// Its title.
    pub name: String,
    /// What it shows.
    pub kind: ViewKind,
    /// The entity that it shows, with everything below.
    pub origin: String,
    /// Entities of which not only the latest state is shown but everything until now.
    pub histories: Vec<String>,
    /// Where the eye begins and what it looks at, meters.
    pub eye: Option<[[f64; 3]; 2]>,
    /// Width and height of the image, pixels: what lies beyond is not shown at first.
    pub image_size: Option<[f64; 2]>,
    /// Least and largest value that are shown, for plots with a fixed scale.
    pub range: Option<[f64; 2]>,
}

impl View {
    fn new(name: &str, kind: ViewKind, origin: &str) -> Self {
        let (name, origin) = (name.to_owned(), origin.to_owned());
        Self { name, kind, origin, histories: Vec::new(), eye: None, image_size: None, range: None }
    }
}

/// A plot: its title and the entity with its curves.
#[derive(Debug, Clone, PartialEq)]
pub struct PlotPlace {
    /// Its title, with the unit.
    pub title: String,
    /// The entity.
    pub path: String,
    /// The scale, if it is fixed.
    pub range: Option<[f64; 2]>,
}

impl Layout {
    /// The world at the left with events and numbers below it, the image and the plots at the right.
    ///
    /// `bounds_m` are the least x and y and the largest x and y of the world, `image_size` the width and height of the image, pixels.
    pub fn new(
        title: &str,
        bounds_m: [f64; 4],
        image_size: Option<[f64; 2]>,
        histories: Vec<String>,
        plots: &[PlotPlace],
    ) -> Self {
        let space =
            View { histories, eye: Some(eye(bounds_m)), ..View::new(title, ViewKind::Space, "world") };
        let view = |name, kind, origin| Self::View(View::new(name, kind, origin));
        let plot = |plot: &PlotPlace| {
            let range = plot.range;
            (1.0, Self::View(View { range, ..View::new(&plot.title, ViewKind::Plot, &plot.path) }))
        };
        let plots = plots.chunks(2).map(|pair| (1.0, Self::Row(pair.iter().map(plot).collect())));
        let below = Self::Row(vec![
            (3.0, view("Events", ViewKind::Events, "events")),
            (2.0, view("Numbers", ViewKind::Text, "numbers")),
        ]);
        let left = Self::Column(vec![(5.0, Self::View(space)), (2.0, below)]);
        let camera = View { image_size, ..View::new("Camera", ViewKind::Picture, "camera/image") };
        let right = Self::Column(vec![(4.0, Self::View(camera)), (3.0, Self::Column(plots.collect()))]);
        Self::Row(vec![(4.0, left), (3.0, right)])
    }
}

/// An eye from which the whole world is seen, from the side of negative y, and what it looks at.
fn eye([x0, y0, x1, y1]: [f64; 4]) -> [[f64; 3]; 2] {
    let (x, y) = ((x0 + x1) / 2.0, (y0 + y1) / 2.0);
    let far = (0.5 * (x1 - x0)).max(0.75 * (y1 - y0)).max(1.0);
    [[x, y - 1.1 * far, 1.25 * far], [x, y - 0.1 * far, 0.0]]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn views<'a>(layout: &'a Layout, found: &mut Vec<&'a View>) {
        match layout {
            Layout::View(view) => found.push(view),
            Layout::Row(parts) | Layout::Column(parts) => {
                parts.iter().for_each(|(_, part)| views(part, found));
            }
        }
    }

    #[test]
    fn everything_has_its_place() {
        let plots: Vec<PlotPlace> = (0..3)
            .map(|i| PlotPlace { title: format!("{i}"), path: format!("plots/{i}"), range: None })
            .collect();
        let layout =
            Layout::new("Field", [-3.0, -2.0, 3.0, 2.0], None, vec!["world/truth/way".to_owned()], &plots);
        let mut found = Vec::new();
        views(&layout, &mut found);
        let origins: Vec<&str> = found.iter().map(|view| view.origin.as_str()).collect();
        assert_eq!(origins, ["world", "events", "numbers", "camera/image", "plots/0", "plots/1", "plots/2"]);
        let [place, target] = found[0].eye.unwrap();
        assert!(place[2] > 1.0 && place[1] < target[1] && target[2] == 0.0);
    }
}
