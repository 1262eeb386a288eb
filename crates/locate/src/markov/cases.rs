//! The published observations: two tables with nine cases each for every state.

use std::fmt::Write as _;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::{ViewLikelihoods, table_text};
use crate::vision::{FeatureKind, Percept};

/// Cases of each of the two observations.
pub const NUM_CASES: usize = 9;

/// Width of the images whose pixels the limits of the size count: the Nao of the source took 160 x 120 pixels.
const SIZE_IMAGE_WIDTH_PX: f64 = 160.0;

/// A goal as one blob.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlobView {
    /// Pixels of its color, as if the image were 160 pixels wide.
    pub area_px: f64,
    /// Bearing of its centroid in the robot's frame, radians, positive to the left.
    pub bearing_rad: f64,
}

impl BlobView {
    /// The goal of one color in a percept: all its valid blobs together. The bearing is that of the ray through the
    /// centroid, turned into the robot's frame, so it also holds for a turned head.
    pub fn of(percept: &Percept, kind: FeatureKind) -> Option<Self> {
        let scale = (SIZE_IMAGE_WIDTH_PX / f64::from(percept.camera.size_px().0)).powi(2);
        let (mut area_px, mut sine, mut cosine) = (0.0, 0.0, 0.0);
        for blob in percept.blobs.iter().filter(|blob| blob.kind == kind) {
            let ray = percept.robot_from_camera.rotate(&percept.camera.bearing(&blob.centroid_px));
            let length = ray.x.hypot(ray.y).max(1e-9);
            area_px += blob.area_px;
            sine += blob.area_px * ray.y / length;
            cosine += blob.area_px * ray.x / length;
        }
        (area_px > 0.0).then(|| Self { area_px: area_px * scale, bearing_rad: sine.atan2(cosine) })
    }
}

visloc_core::with_defaults! {
    /// Where one case ends and the next begins.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct CaseLimits {
        /// Limits between the nine cases of the size, pixels of an image 160 pixels wide. Source: table 4.
        pub sizes_px: [f64; NUM_CASES - 1] = [200.0, 400.0, 700.0, 1000.0, 1300.0, 1500.0, 1700.0, 2000.0],
        /// Width of the eight sectors of the centroid, degrees. Source: section 4.2.2, about 8.
        pub sector_deg: f64 = 8.0,
    }
}

impl CaseLimits {
    /// Case of the size, 0 (small or not seen) to 8.
    pub fn size_case(&self, view: Option<&BlobView>) -> usize {
        view.map_or(0, |view| self.sizes_px.partition_point(|limit| *limit <= view.area_px))
    }

    /// Case of the centroid: 0 not seen, 1 the leftmost sector to 8 the rightmost; farther out counts as outermost.
    pub fn centroid_case(&self, view: Option<&BlobView>) -> usize {
        view.map_or(0, |view| {
            let sectors_from_left = 4.0 - view.bearing_rad.to_degrees() / self.sector_deg;
            1 + sectors_from_left.clamp(0.0, 7.0) as usize
        })
    }
}

/// A file of tables that cannot be used.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("observation tables, line {line}: expected {expected}")]
pub struct TableError {
    /// From 1.
    pub line: usize,
    /// What should be there.
    pub expected: String,
}

/// P(case | state) of both observations.
#[derive(Debug, Clone, PartialEq)]
pub struct CaseTables {
    limits: CaseLimits,
    sizes: Vec<[f64; NUM_CASES]>,
    centroids: Vec<[f64; NUM_CASES]>,
}

/// Learns both tables: the share of the captures of a state in which each case was seen. A state without captures expects
/// everything alike. Captures of states that do not exist are left out.
pub fn learn_tables(
    limits: CaseLimits,
    num_states: usize,
    captures: impl Iterator<Item = (usize, Option<BlobView>)>,
) -> CaseTables {
    let mut sizes = vec![[0.0; NUM_CASES]; num_states];
    let mut centroids = sizes.clone();
    for (state, view) in captures.filter(|(state, _)| *state < num_states) {
        sizes[state][limits.size_case(view.as_ref())] += 1.0;
        centroids[state][limits.centroid_case(view.as_ref())] += 1.0;
    }
    for row in sizes.iter_mut().chain(&mut centroids) {
        let total: f64 = row.iter().sum();
        *row = if total > 0.0 { row.map(|count| count / total) } else { [1.0 / NUM_CASES as f64; NUM_CASES] };
    }
    CaseTables { limits, sizes, centroids }
}

impl CaseTables {
    /// The limits of the cases.
    pub fn limits(&self) -> &CaseLimits {
        &self.limits
    }

    /// P(size case | state).
    pub fn size(&self, state: usize) -> &[f64; NUM_CASES] {
        &self.sizes[state]
    }

    /// P(centroid case | state).
    pub fn centroid(&self, state: usize) -> &[f64; NUM_CASES] {
        &self.centroids[state]
    }

    /// The same tables, in which a share of each row goes to all cases alike: what was not seen in a few captures is rare,
    /// not impossible. Deviation: the source uses plain shares, and one observation out of line empties its belief.
    #[must_use]
    pub fn softened(&self, share: f64) -> Self {
        let soften = |row: &[f64; NUM_CASES]| row.map(|p| p * (1.0 - share) + share / NUM_CASES as f64);
        Self {
            limits: self.limits,
            sizes: self.sizes.iter().map(soften).collect(),
            centroids: self.centroids.iter().map(soften).collect(),
        }
    }

    /// Likelihood of a size and a centroid in every state: both observations in turn, which is their product. Cases that
    /// do not exist are impossible.
    pub fn likelihoods_of_cases(&self, size: usize, centroid: usize, out: &mut Vec<f64>) {
        out.clear();
        let share = |row: &[f64; NUM_CASES], case: usize| row.get(case).copied().unwrap_or(0.0);
        let rows = self.sizes.iter().zip(&self.centroids);
        out.extend(rows.map(|(s, c)| share(s, size) * share(c, centroid)));
    }

    /// As text: one line for each state, its number, nine shares of the size and nine of the centroid, with 4 decimals.
    pub fn to_csv(&self) -> String {
        let mut text = String::from("state");
        for name in ["size", "centroid"] {
            for case in 0..NUM_CASES {
                let _ = write!(text, ",{name}{case}");
            }
        }
        text.push('\n');
        for (state, (sizes, centroids)) in self.sizes.iter().zip(&self.centroids).enumerate() {
            let _ = write!(text, "{state}");
            for share in sizes.iter().chain(centroids) {
                let _ = write!(text, ",{}", (share * 1e4).round() / 1e4);
            }
            text.push('\n');
        }
        text
    }

    /// Reads what [`CaseTables::to_csv`] wrote.
    ///
    /// # Errors
    /// If a line has not 19 numbers, states do not follow each other, or a share is not one.
    pub fn from_csv(limits: CaseLimits, text: &str) -> Result<Self, TableError> {
        let rows = table_text::rows(text, 2 * NUM_CASES, "shares from 0 to 1")?;
        if let Some(i) = rows.iter().position(|row| !row.iter().all(|share| (0.0..=1.0).contains(share))) {
            return Err(TableError { line: i + 2, expected: "shares from 0 to 1".to_owned() });
        }
        let part = |first: usize| -> Vec<[f64; NUM_CASES]> {
            rows.iter().map(|row| std::array::from_fn(|case| row[first + case])).collect()
        };
        Ok(Self { limits, sizes: part(0), centroids: part(NUM_CASES) })
    }
}

impl ViewLikelihoods for CaseTables {
    fn likelihoods(&self, view: Option<&BlobView>, out: &mut Vec<f64>) {
        self.likelihoods_of_cases(self.limits.size_case(view), self.limits.centroid_case(view), out);
    }
}
