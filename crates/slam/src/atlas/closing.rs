//! Closing a loop: its drift is spread over the way.

use super::{PoseGraph, PoseGraphEdge, Similarity, certainty, sighting::Sighting};
use crate::{
    map::{Correction, Crossing, KeyframeId, Map, MapId, Standing},
    recognize::Refusal,
};

/// Fewest landmarks that two keyframes share for an edge. Source: Mur-Artal, Montiel and Tardos, "ORB-SLAM", 2015, section VII-D,
/// takes 100 of some thousand; keyframes here have a tenth of that.
const EDGE_SHARED: u32 = 25;
/// Most edges of a keyframe to earlier ones.
const MOST_EDGES: usize = 8;
/// Steps of the solver.
const MOST_STEPS: usize = 20;
/// Most that a way can have drifted, share of its length. Odometry by a camera is better by far; places that look alike are
/// mostly nearer to each other than a tenth of the way between.
const MOST_DRIFT: f64 = 0.1;
/// Most that a way can have turned, degrees.
const MOST_TURN_DEG: f64 = 45.0;
/// Most by which the scale can have drifted, factor.
const MOST_SCALE: f64 = 2.0;

/// Squared error up to which frames at a loss are believed where it ties the way together: that of the six numbers of a pose is larger in one
/// of a thousand cases.
const MOST_TORN: f64 = 22.5;

/// By how much a loop bends the way.
#[derive(Debug, Clone, Copy)]
pub struct Bend {
    /// Distance between where the keyframe is in the map and where it should be, share of the way since.
    pub drift: f64,
    /// Factor on its lengths.
    pub scale: f64,
}

/// By how much a loop would bend the way.
///
/// # Errors
/// If that is more than can have drifted.
pub fn bend(map: &Map, sighting: &Sighting) -> Result<Bend, Refusal> {
    let own = map.keyframe(sighting.keyframe).camera_from_world();
    let there = sighting.pose_there;
    let shift = (own.inverse().translation() - there.inverse().translation()).norm();
    let way = way_between(map, map.active(), (sighting.around, sighting.keyframe)).max(1e-9);
    let turn_deg = (*own * there.inverse()).rotation_angle_rad().to_degrees();
    let (drift, scale) = (shift / way, sighting.old_from_new.scale);
    let is_plausible =
        drift < MOST_DRIFT && turn_deg < MOST_TURN_DEG && (1.0 / MOST_SCALE..MOST_SCALE).contains(&scale);
    if is_plausible {
        Ok(Bend { drift, scale })
    } else {
        Err(Refusal::Implausible { drift, turn_deg, scale })
    }
}

/// Whether two maps still meet where the camera was lost between them if a sighting joins them. That closes a loop over the frames that both
/// know, and may bend it no farther than a loop within one map, beside what such a frame does not tell of its place. Doors and walls that look the
/// same from both ends of a corridor are told apart by that.
///
/// # Errors
/// If all of these frames say that they would not.
pub fn meet_where_lost(map: &Map, sighting: &Sighting) -> Result<(), Refusal> {
    let other = map.keyframe(sighting.around).map;
    let mut apart = Ok(());
    for sides in map.crossings_to(other).filter(|_| other != map.active()) {
        apart = meet_across(map, sighting, &sides);
        if apart.is_ok() {
            break;
        }
    }
    apart
}

/// The same for one frame that both maps know: where it is in the other one, and in the active one.
fn meet_across(map: &Map, sighting: &Sighting, (there, here): &(Standing, Standing)) -> Result<(), Refusal> {
    let old_from_new = &sighting.old_from_new;
    let pose = |side: &Standing| side.camera_from_keyframe * map.pose_of(side.keyframe);
    let (old, new) = (pose(there), old_from_new.pose(&pose(here)));
    let shift = (old.inverse().translation() - new.inverse().translation()).norm();
    let turn_deg = (old * new.inverse()).rotation_angle_rad().to_degrees();
    let way_there = way_between(map, map.keyframe(sighting.around).map, (sighting.around, there.keyframe));
    let way_here = way_between(map, map.active(), (here.keyframe, sighting.keyframe));
    // A way that has just begun is as long as its landmarks are far, as for sightings that agree.
    let way = way_there + way_here * old_from_new.scale + sighting.depth;
    let variance = |side: &Standing| side.covariance.diagonal().xyz().sum();
    let sigma = (variance(there) + variance(here) * old_from_new.scale.powi(2)).sqrt();
    if shift < MOST_DRIFT * way + 2.0 * sigma && turn_deg < MOST_TURN_DEG {
        Ok(())
    } else {
        Err(Refusal::Torn { drift: shift / way, turn_deg })
    }
}

/// Length of the way from one keyframe of a map to another, map units.
fn way_between(map: &Map, of_map: MapId, (first, last): (KeyframeId, KeyframeId)) -> f64 {
    let (first, last) = (first.min(last), first.max(last));
    let centers: Vec<_> = map
        .all_keyframes()
        .filter(|(id, keyframe)| keyframe.map == of_map && (first..=last).contains(id))
        .map(|(_, keyframe)| *keyframe.center_in_world())
        .collect();
    centers.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
}

/// Moves all keyframes of the map so that the sightings of an earlier place agree with it. Where parts of it were maps of their own that know
/// the same frame, that is weighed against the rest.
pub fn spread(map: &mut Map, sightings: &[Sighting]) {
    let crossings: Vec<Crossing> = map.crossings().collect();
    let ids: Vec<KeyframeId> = map.keyframes().map(|(id, _)| id).collect();
    let index_of = |id: KeyframeId| ids.binary_search(&id).ok();
    let nodes = ids.iter().map(|id| Similarity::of_pose(map.keyframe(*id).camera_from_world())).collect();
    let num_fixed = ids.iter().filter(|id| map.is_fixed(**id)).count().max(1);
    let mut graph = PoseGraph { nodes, num_fixed, edges: Vec::new(), length: 1.0 };
    for (second, id) in ids.iter().enumerate().skip(num_fixed) {
        for first in neighbors(map, *id).into_iter().filter_map(index_of) {
            let first_from_second = graph.nodes[first].after(&graph.nodes[second].inverse());
            let mut edge = PoseGraphEdge::new(first, second, first_from_second);
            if !crossings.is_empty() {
                edge.weight = certainty::of_shared(&first_from_second);
            }
            graph.edges.push(edge);
        }
    }
    let mut depths = Vec::new();
    for sighting in sightings {
        let (Some(first), Some(second)) = (index_of(sighting.around), index_of(sighting.keyframe)) else {
            continue;
        };
        let there = Similarity::of_pose(&sighting.pose_there).enlarged(1.0 / sighting.old_from_new.scale);
        let first_from_second = graph.nodes[first].after(&there.inverse());
        let mut edge = PoseGraphEdge::new(first, second, first_from_second);
        if !crossings.is_empty() {
            edge.weight = certainty::of_sighting();
        }
        graph.edges.push(edge);
        depths.push(sighting.depth);
    }
    graph.length = depths.iter().sum::<f64>() / depths.len().max(1) as f64;
    let edge_across = |crossing: &Crossing| {
        let nodes = index_of(crossing.before.keyframe).zip(index_of(crossing.after.keyframe))?;
        certainty::edge_across(crossing, nodes, graph.length)
    };
    let across: Vec<PoseGraphEdge> = crossings.iter().filter_map(edge_across).collect();
    let has_length = graph.length.is_finite() && graph.length > 0.0;
    let Some(graph) = Some(graph).filter(|_| has_length).and_then(|graph| solved(graph, &across)) else {
        return;
    };
    let corrections: Vec<Correction> = ids
        .iter()
        .zip(&graph.nodes)
        .filter(|(id, _)| !map.is_fixed(**id))
        .map(|(id, node)| Correction {
            keyframe: *id,
            camera_from_world: node.to_pose(),
            scale: 1.0 / node.scale,
        })
        .collect();
    map.correct(&corrections);
}

/// The graph with its nodes where its edges agree, and with as many of those across each loss as it bears: the last frames before a loss
/// may be anywhere, since what is tracked then slips. `None` if nothing moves.
fn solved(graph: PoseGraph, across: &[PoseGraphEdge]) -> Option<PoseGraph> {
    let start = graph.nodes.clone();
    let mut solved = graph;
    let mut has_moved = solved.solve(MOST_STEPS) > 0;
    // All frames of a loss hang on the first keyframe of the map that was started behind it.
    for loss in across.chunk_by(|a, b| a.second == b.second) {
        let (mut loss, cost) = (loss.to_vec(), solved.cost());
        while !loss.is_empty() {
            let mut tied = PoseGraph { nodes: start.clone(), ..solved.clone() };
            tied.edges.extend_from_slice(&loss);
            let has_tied_moved = tied.solve(MOST_STEPS) > 0;
            if tied.cost() - cost < MOST_TORN {
                (solved, has_moved) = (tied, has_tied_moved);
                break;
            }
            // Those stay that the way without them contradicts least.
            loss.sort_by(|a, b| solved.cost_of_edge(a).total_cmp(&solved.cost_of_edge(b)));
            loss.truncate(loss.len() / 2);
        }
    }
    has_moved.then_some(solved)
}

/// Earlier keyframes that share most with one, at least one of them, and the one before, unless the camera was lost between both.
fn neighbors(map: &Map, id: KeyframeId) -> Vec<KeyframeId> {
    let mut connected = map.connected(id, 1);
    connected.retain(|(other, _)| *other < id && map.keyframe(*other).map == map.active());
    let num = connected.iter().filter(|(_, shared)| *shared >= EDGE_SHARED).count().clamp(1, MOST_EDGES);
    let mut neighbors: Vec<KeyframeId> = connected.into_iter().take(num).map(|(other, _)| other).collect();
    let before = map.keyframes().map(|(other, _)| other).take_while(|other| *other < id).last();
    let follows = |before: &KeyframeId| !map.begins_between(*before, id) && !neighbors.contains(before);
    let before = before.filter(follows);
    neighbors.extend(before);
    neighbors
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use nalgebra::{Matrix6, Rotation3, Vector3, Vector6};
    use visloc_core::{GrayImage, Timestamp, geom::Rigid3};

    use super::*;
    use crate::{
        image::Pyramid,
        lie::{CameraFromWorld, exp},
        map::{NewKeyframe, Standing},
    };

    fn at(x: f64) -> CameraFromWorld {
        CameraFromWorld::new(Rotation3::identity(), Vector3::new(-x, 0.0, 0.0))
    }

    /// A corridor: a keyframe every half meter.
    fn corridor() -> Map {
        way(&(0..20).map(|i| at(0.5 * f64::from(i))).collect::<Vec<_>>())
    }

    fn way(poses: &[CameraFromWorld]) -> Map {
        let mut map = Map::new();
        let pyramid = Arc::new(Pyramid::new(GrayImage::new(40, 30), 1));
        for (i, pose) in poses.iter().enumerate() {
            map.add_keyframe(NewKeyframe {
                frame: i,
                at: Timestamp::default(),
                pyramid: Arc::clone(&pyramid),
                camera_from_world: *pose,
                turned_from: None,
                odometry: None,
            });
        }
        map
    }

    fn sighting(map: &Map, pose_there: CameraFromWorld) -> Sighting {
        let (keyframe, _) = map.keyframes().next_back().unwrap();
        let own = map.keyframe(keyframe).camera_from_world();
        Sighting {
            keyframe,
            around: KeyframeId(0),
            pose_there,
            old_from_new: Similarity::between(own, &pose_there, 1.0),
            found: (0, 0),
            features: Vec::new(),
            same: Vec::new(),
            depth: 2.0,
        }
    }

    #[test]
    fn a_door_that_looks_like_the_last_one_is_no_loop() {
        let map = corridor();
        // The next door is 1.9 m away; to take one for the other would bend a way of 9.5 m by a fifth.
        let reason = bend(&map, &sighting(&map, at(9.5 - 1.9))).unwrap_err();
        assert!(
            matches!(reason, Refusal::Implausible { drift, .. } if (drift - 0.2).abs() < 1e-9),
            "{reason}"
        );
        assert!(reason.to_string().contains("20 %"), "{reason}");
        assert!(bend(&map, &sighting(&map, at(9.5 - 0.4))).is_ok());
    }

    #[test]
    fn what_looks_alike_the_other_way_round_does_not_join_maps_that_the_camera_was_lost_between() {
        // The second part of the corridor is a map of its own, in units of 2 m.
        let truth: Vec<CameraFromWorld> = (0..20).map(|i| at(0.5 * f64::from(i))).collect();
        let halved =
            |pose: &CameraFromWorld| CameraFromWorld::new(Rotation3::identity(), 0.5 * pose.translation());
        let mut map = Map::new();
        map.append(&way(&truth[..12]));
        map.append(&way(&truth[12..].iter().map(halved).collect::<Vec<_>>()));
        let found = |map: &Map, pose_there: CameraFromWorld| {
            let own = map.keyframe(KeyframeId(19)).camera_from_world();
            let old_from_new = Similarity::between(own, &pose_there, 2.0);
            Sighting { old_from_new, ..sighting(map, pose_there) }
        };
        let turned = Rotation3::from_axis_angle(&Vector3::y_axis(), std::f64::consts::PI);
        let turned = CameraFromWorld::new(turned, -(turned * Vector3::new(9.5, 0.0, 0.0)));
        assert!(meet_where_lost(&map, &found(&map, turned)).is_ok(), "nothing is known of the loss");

        let between = at(5.75);
        let standing = |map: &Map, id: u32, pose: &CameraFromWorld| Standing {
            keyframe: KeyframeId(id),
            camera_from_keyframe: *pose * map.pose_of(KeyframeId(id)).inverse(),
            scale: 1.0,
            // 2 cm and half a degree.
            covariance: Matrix6::from_diagonal(&Vector6::new(4e-4, 4e-4, 4e-4, 8e-5, 8e-5, 8e-5)),
        };
        let (before, after) = (standing(&map, 11, &between), standing(&map, 12, &halved(&between)));
        map.add_crossing(Crossing { before, after });
        assert!(meet_where_lost(&map, &found(&map, at(9.5 - 0.4))).is_ok());
        let reason = meet_where_lost(&map, &found(&map, turned)).unwrap_err();
        assert!(reason.to_string().contains("180 degrees"), "{reason}");
        // The next door, 1.9 m of 11: the way, and how far off its landmarks are.
        let reason = meet_where_lost(&map, &found(&map, at(9.5 - 1.9))).unwrap_err();
        assert!(
            matches!(reason, Refusal::Torn { drift, .. } if (drift - 1.9 / 11.0).abs() < 1e-9),
            "{reason}"
        );

        // Whichever of the maps is tracked.
        map.activate(MapId(0));
        let back = Sighting { keyframe: KeyframeId(0), around: KeyframeId(19), ..found(&map, at(0.0)) };
        let joined_at = |pose_there: CameraFromWorld| Sighting {
            old_from_new: Similarity::between(&at(0.0), &pose_there, 0.5),
            pose_there,
            ..back.clone()
        };
        assert!(meet_where_lost(&map, &joined_at(at(0.0))).is_ok());
        assert!(matches!(meet_where_lost(&map, &joined_at(turned)), Err(Refusal::Torn { .. })));
    }

    #[test]
    fn the_drift_is_spread_over_the_way() {
        let mut map = corridor();
        let found = sighting(&map, at(9.5 - 0.4));
        spread(&mut map, &[found]);
        let x = |i: u32| map.keyframe(KeyframeId(i)).center_in_world().x;
        assert!((x(19) - 9.1).abs() < 0.1 && x(0).abs() < 1e-12, "{}", x(19));
        assert!((1..20).all(|i| (0.4..0.6).contains(&(x(i) - x(i - 1)))));
    }

    /// A round of 63 m in forty steps. Its second half was a map of its own, whose end was recognized at the beginning of the first one; back
    /// from there it drifts in turn and scale.
    fn round_with_a_gap() -> (Vec<CameraFromWorld>, Map) {
        let pose = |i: usize| {
            let angle = std::f64::consts::TAU * i as f64 / 40.0;
            let rotation = Rotation3::from_scaled_axis(Vector3::y() * angle);
            CameraFromWorld::new(
                rotation,
                -(rotation * Vector3::new(10.0 * angle.cos(), 0.0, 10.0 * angle.sin())),
            )
        };
        let truth: Vec<CameraFromWorld> = (0..40).map(pose).collect();
        let mut estimated = truth.clone();
        for i in (20..39).rev() {
            let motion = truth[i] * truth[i + 1].inverse();
            let drift = Rotation3::from_scaled_axis(Vector3::new(0.0, 0.002, 0.001)) * motion.rotation();
            let grown = 1.004_f64.powi(39 - i as i32);
            let motion = Rigid3::new(Rotation3::from_matrix_unchecked(drift), motion.translation() * grown);
            estimated[i] = motion * estimated[i + 1];
        }
        let map = way(&estimated);
        (truth, map)
    }

    #[test]
    fn a_frame_that_two_maps_know_holds_their_loose_ends_together() {
        held_together_by_frames_of_which_slipped(0);
    }

    #[test]
    fn frames_that_slipped_before_the_loss_do_not_bend_the_way() {
        held_together_by_frames_of_which_slipped(7);
    }

    /// A frame that both maps know, and others of which the first map has the pose wrong by 11 degrees and 18 cm.
    fn held_together_by_frames_of_which_slipped(num: usize) {
        let (truth, mut map) = round_with_a_gap();
        let standing = |keyframe: usize| Standing {
            keyframe: KeyframeId(keyframe as u32),
            camera_from_keyframe: truth[20] * truth[keyframe].inverse(),
            scale: 1.0,
            // 2 cm and half a degree.
            covariance: Matrix6::from_diagonal(&Vector6::new(4e-4, 4e-4, 4e-4, 8e-5, 8e-5, 8e-5)),
        };
        map.add_crossing(Crossing { before: standing(19), after: standing(20) });
        let slipped = exp(&Vector6::new(0.18, 0.0, 0.0, 0.0, 0.19, 0.0)) * standing(19).camera_from_keyframe;
        for _ in 0..num {
            let before = Standing { camera_from_keyframe: slipped, ..standing(19) };
            map.add_crossing(Crossing { before, after: standing(20) });
        }
        let off = |map: &Map, i: usize| {
            let pose = map.keyframe(KeyframeId(i as u32)).camera_from_world();
            (pose.inverse().translation() - truth[i].inverse().translation()).norm()
        };
        let most = |map: &Map| (0..40).map(|i| off(map, i)).fold(0.0, f64::max);
        let gap = |map: &Map| {
            let motion = map.pose_of(KeyframeId(20)) * map.pose_of(KeyframeId(19)).inverse();
            (motion.translation() - (truth[20] * truth[19].inverse()).translation()).norm()
        };
        let (gap_before, most_before) = (gap(&map), most(&map));
        assert!(gap_before > 1.0, "{gap_before}");
        let found = sighting(&map, truth[39]);
        spread(&mut map, &[found]);
        assert!(gap(&map) < 0.1, "{} of {gap_before}", gap(&map));
        assert!(most(&map) < 0.4 * most_before, "{} of {most_before}", most(&map));
        assert!(off(&map, 39) < 0.1, "{}", off(&map, 39));
    }
}
