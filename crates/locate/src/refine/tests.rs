//! Filters and tracks on a world of which everything is known.

use visloc_core::{
    Rng, RngTree, Timestamp, gaussian,
    geom::{PlanarPose, angle, nao},
};

use super::{
    Refined, RefinementConfig,
    filter::PoseFilter,
    known::Known,
    mount::Mount,
    search::{Candidate, PlaceSearch},
    tracks::Tracks,
    view::View,
};
use crate::{
    Estimate, Hypothesis, Individual, Localizer, ObservationModel, Region, StartPrior, StepInput,
    observation::features::{CameraState, CameraVector, FeatureMatch, FeatureModel, Residual},
    odometer::{Odometer, Odometry},
    vision::Percept,
};

/// Features that tell x, y and heading, each many times. Seen from `places` (all of them alike) they are all explained,
/// from elsewhere none is. The percept's quality carries the index of the true world, so that a kidnap can be played.
#[derive(Clone)]
struct Alike {
    places: Vec<PlanarPose>,
    noise: Vec<f64>,
    is_symmetric: bool,
    has_landmarks: bool,
    /// Tilt of the camera that each place needs, radians; empty if the images do not tell.
    tilts_rad: Vec<f64>,
}

/// Pixels per meter and per radian.
const SCALE: [f64; 3] = [100.0, 100.0, 300.0];
const NUM_FEATURES: usize = 60;

impl Alike {
    fn new(places: &[PlanarPose]) -> Self {
        let noise = vec![0.0; NUM_FEATURES];
        Self {
            places: places.to_vec(),
            noise,
            is_symmetric: false,
            has_landmarks: true,
            tilts_rad: Vec::new(),
        }
    }

    fn with_noise(mut self, rng: &mut Rng) -> Self {
        self.noise.iter_mut().for_each(|noise| *noise = gaussian(rng, 0.5));
        self
    }

    fn offset(&self, pose: &PlanarPose) -> [f64; 3] {
        let offsets = self.places.iter().map(|place| {
            [pose.x_m - place.x_m, pose.y_m - place.y_m, angle::difference(pose.yaw_rad, place.yaw_rad)]
        });
        let size = |o: &[f64; 3]| o[0].hypot(o[1]) + o[2].abs();
        offsets.min_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or([9.0; 3])
    }
}

impl FeatureModel for Alike {
    fn condition_on(&mut self, _: &Percept) {}

    fn num_features(&self) -> usize {
        NUM_FEATURES
    }

    fn visit_matches(
        &self,
        state: &CameraState,
        gate_px: f64,
        _: usize,
        visit: &mut dyn FnMut(FeatureMatch),
    ) {
        let offset = self.offset(&state.world_from_robot);
        for (i, noise) in self.noise.iter().enumerate() {
            let axis = i % 3;
            let error_px = SCALE[axis] * offset[axis] + noise;
            let mut jacobian = CameraVector::zeros();
            jacobian[axis] = SCALE[axis];
            let is_near = offset.iter().zip(SCALE).all(|(o, scale)| (o * scale).abs() < gate_px);
            let residual = (is_near && error_px.abs() < gate_px).then_some(Residual { error_px, jacobian });
            visit(FeatureMatch {
                group: usize::from(i % 2 == 0),
                residual,
                unmatched_agreement: 0.0,
                on_bar: None,
            });
        }
        let here = self
            .places
            .iter()
            .zip(&self.tilts_rad)
            .filter(|(place, _)| place.distance_m(&state.world_from_robot) < 1.0);
        for (_, needed_rad) in here {
            let mut jacobian = CameraVector::zeros();
            jacobian[3] = SCALE[2];
            let error_px = SCALE[2] * (state.tilt_rad.x - needed_rad);
            let residual = (error_px.abs() < gate_px).then_some(Residual { error_px, jacobian });
            (0..NUM_FEATURES / 3).for_each(|_| {
                visit(FeatureMatch { group: 0, residual, unmatched_agreement: 0.0, on_bar: None })
            });
        }
    }

    fn has_landmarks(&self) -> bool {
        self.has_landmarks
    }

    fn mirrored(&self, pose: &PlanarPose) -> Option<PlanarPose> {
        self.is_symmetric.then(|| PlanarPose::new(-pose.x_m, -pose.y_m, pose.yaw_rad + std::f64::consts::PI))
    }
}

/// Weighs poses by their distance to the places, and proposes them.
impl ObservationModel for Alike {
    fn condition_on(&mut self, _: &Percept) {}
    fn has_evidence(&self) -> bool {
        true
    }
    fn likelihood(&self, pose: &PlanarPose) -> f64 {
        let [x, y, turn] = self.offset(pose);
        (-(x * x + y * y + turn * turn)).exp()
    }
    fn region(&self) -> Region {
        Region { min_x_m: -5.0, max_x_m: 5.0, min_y_m: -4.0, max_y_m: 4.0 }
    }
    fn max_jump_m(&self) -> f64 {
        2.0
    }
    fn propose(&self, rng: &mut Rng) -> PlanarPose {
        let sampled = self.region().sample(rng);
        PlanarPose::new(sampled.x_m, sampled.y_m, self.propose_heading(0.0, 0.0, rng))
    }
    fn propose_heading(&self, _: f64, _: f64, _: &mut Rng) -> f64 {
        self.places.first().map_or(0.0, |place| place.yaw_rad)
    }
}

/// A search that always answers with the same places.
struct Fixed(Estimate);

impl Fixed {
    fn new(places: &[PlanarPose]) -> Self {
        let mut estimate = Estimate::unknown();
        estimate.hypotheses.extend(places.iter().map(|place| Hypothesis {
            world_from_robot: *place,
            covariance: nalgebra::Matrix3::identity(),
            probability: 1.0,
        }));
        estimate.normalize_hypotheses();
        Self(estimate)
    }
}

impl Localizer for Fixed {
    fn reset(&mut self) {}
    fn step(&mut self, _: &StepInput<'_>, _: &mut Rng) -> &Estimate {
        &self.0
    }
    fn estimate(&self) -> &Estimate {
        &self.0
    }
    fn individuals(&self, _: &mut Vec<Individual>) {}
}

fn refined(world: &Alike, searched: &[PlanarPose]) -> Refined {
    let search = Box::new(Fixed::new(searched));
    let (features, pixels) = (Box::new(world.clone()), Box::new(world.clone()));
    Refined::new(RefinementConfig::default(), search, features, pixels).unwrap()
}

/// Steps through images that show landmarks. The head turns, so that every image is a new view.
fn step(localizer: &mut Refined, steps: std::ops::Range<u32>, is_lifted: bool) -> Estimate {
    look(localizer, steps, is_lifted, 0.3)
}

/// The same; the head turns by so much from image to image, radians.
fn look(localizer: &mut Refined, steps: std::ops::Range<u32>, is_lifted: bool, turn_rad: f64) -> Estimate {
    let mut rng = RngTree::new(1).stream("refined", u64::from(steps.start));
    for i in steps {
        let head = nao::HeadAngles { yaw_rad: turn_rad * f64::from(i % 20), pitch_rad: 0.1 };
        let percept = Percept {
            at: Timestamp::from_secs(f64::from(i) / 30.0),
            robot_from_camera: nao::robot_from_camera(&nao::Torso::upright(), &head, nao::NaoCamera::TopV3),
            quality: 1.0,
            is_informative: true,
            ..Percept::default()
        };
        let odometry = Some(PlanarPose::default());
        localizer.step(&StepInput { percept: &percept, odometry, is_lifted }, &mut rng);
    }
    localizer.estimate().clone()
}

fn is_at(estimate: &Estimate, place: &PlanarPose) -> bool {
    estimate.world_from_robot.distance_m(place) < 0.02
        && estimate.world_from_robot.heading_difference_rad(place) < 0.01
}

#[test]
fn a_rough_place_becomes_an_exact_pose() {
    let place = PlanarPose::new(1.0, -0.5, 0.7);
    let mut localizer = refined(&Alike::new(&[place]), &[PlanarPose::new(1.15, -0.4, 0.75)]);
    let estimate = step(&mut localizer, 0..30, false);
    assert!(is_at(&estimate, &place) && estimate.is_localized(), "{estimate:?}");
    let sigma_m = estimate.covariance[(0, 0)].sqrt();
    assert!((0.0003..0.02).contains(&sigma_m), "{sigma_m}");
}

/// Two places that explain everything leave nothing to rely on, and both are told.
#[test]
fn of_two_places_that_look_alike_neither_is_relied_upon() {
    let places = [PlanarPose::new(2.0, 0.0, 0.0), PlanarPose::new(-2.0, 1.0, 0.0)];
    let mut localizer = refined(&Alike::new(&places), &places);
    let estimate = step(&mut localizer, 0..60, false);
    assert!(estimate.reliability < 0.1, "{}", estimate.reliability);
    assert_eq!(estimate.hypotheses.len(), 2);
    assert!(estimate.hypotheses.iter().all(|h| (h.probability - 0.5).abs() < 0.1));
}

/// A robot that stands sees one view again and again: if that fits one place only it is relied upon as soon as a search would have found
/// another one; a second place that explains it is disputed for ever.
#[test]
fn one_view_is_relied_upon_if_it_fits_one_place_only() {
    let places = [PlanarPose::new(2.0, 0.0, 0.0), PlanarPose::new(-2.0, 1.0, 0.0)];
    for num in [1, 2] {
        let mut localizer = refined(&Alike::new(&places[..num]), &places[..num]);
        let early = look(&mut localizer, 0..2, false, 0.0);
        assert!(early.reliability < 0.6, "{} after two images", early.reliability);
        let estimate = look(&mut localizer, 2..300, false, 0.0);
        assert_eq!(estimate.is_localized(), num == 1, "{estimate:?}");
    }
}

/// A robot that was carried without noticing, and stands: of two places that explain its images alike the one that is found first has no lead over
/// the other, although it was the only one to explain the image then.
#[test]
fn a_place_that_is_found_first_has_no_lead_over_its_look_alike() {
    let before = PlanarPose::new(0.0, -2.0, 0.0);
    let alike = [PlanarPose::new(2.0, 0.0, 0.0), PlanarPose::new(-2.0, 1.0, 0.0)];
    let mut localizer = refined(&Alike::new(&[before]), &[before]);
    look(&mut localizer, 0..3, false, 0.0);
    localizer.model = Box::new(Alike::new(&alike));
    localizer.search = Box::new(Fixed::new(&alike[..1]));
    look(&mut localizer, 3..5, false, 0.0);
    localizer.search = Box::new(Fixed::new(&alike));
    for i in 5..60 {
        let estimate = look(&mut localizer, i..i + 1, false, 0.0);
        assert!(!estimate.is_localized(), "image {i}: {estimate:?}");
    }
}

#[test]
fn an_established_track_is_not_replaced_by_a_newcomer_that_is_as_good() {
    let places = [PlanarPose::new(2.0, 0.0, 0.0), PlanarPose::new(-2.0, 1.0, 0.0)];
    let mut localizer = refined(&Alike::new(&places[..1]), &places[..1]);
    step(&mut localizer, 0..60, false);
    localizer.search = Box::new(Fixed::new(&places));
    localizer.model = Box::new(Alike::new(&places));
    let estimate = step(&mut localizer, 60..120, false);
    assert!(is_at(&estimate, &places[0]) && estimate.is_localized(), "{estimate:?}");
    assert!(estimate.hypotheses.len() == 2 && estimate.hypotheses[1].probability < 0.01);
}

/// Carried to another place without noticing: the old track explains nothing any more.
#[test]
fn after_a_kidnap_trust_is_lost_at_once_and_the_new_place_found() {
    let places = [PlanarPose::new(2.0, 0.0, 0.0), PlanarPose::new(-2.0, 1.0, 0.0)];
    let mut localizer = refined(&Alike::new(&places[..1]), &places);
    assert!(is_at(&step(&mut localizer, 0..60, false), &places[0]));
    localizer.model = Box::new(Alike::new(&places[1..]));
    localizer.places = PlaceSearch::new(Box::new(Alike::new(&places[1..])));
    for i in 60..75 {
        let estimate = step(&mut localizer, i..i + 1, false);
        let is_wrong = !is_at(&estimate, &places[1]);
        assert!(!(i > 63 && is_wrong && estimate.is_localized()), "image {i}: {estimate:?}");
    }
    let estimate = step(&mut localizer, 75..120, false);
    assert!(is_at(&estimate, &places[1]) && estimate.is_localized(), "{estimate:?}");
}

/// Images that show nothing, and should show borders of this length.
struct Nothing(f64);

impl FeatureModel for Nothing {
    fn condition_on(&mut self, _: &Percept) {}
    fn num_features(&self) -> usize {
        0
    }
    fn visit_matches(&self, _: &CameraState, _: f64, _: usize, _: &mut dyn FnMut(FeatureMatch)) {}
    fn expected_px(&self, _: &CameraState, _: f64) -> f64 {
        self.0
    }
}

/// Images that show nothing soon contradict a place from which lines should be seen, and one from which none are slowly; a single one
/// contradicts none.
#[test]
fn a_place_is_doubted_if_nothing_is_seen_of_what_should_be() {
    let place = PlanarPose::new(1.0, -0.5, 0.7);
    let images = |expected_px: f64| {
        let mut localizer = refined(&Alike::new(&[place]), &[place]);
        step(&mut localizer, 0..60, false);
        localizer.model = Box::new(Nothing(expected_px));
        (60..400).take_while(|i| step(&mut localizer, *i..i + 1, false).is_localized()).count()
    };
    let [nothing, a_little, much, all] = [0.0, 80.0, 320.0, 2000.0].map(images);
    assert!(nothing == 340 && (45..90).contains(&a_little), "{nothing}, {a_little}");
    assert!((2..10).contains(&all) && (all..20).contains(&much), "{much}, {all}");
}

#[test]
fn a_lifted_robot_is_nowhere() {
    let place = PlanarPose::new(1.0, -0.5, 0.7);
    let mut localizer = refined(&Alike::new(&[place]), &[place]);
    step(&mut localizer, 0..30, false);
    let estimate = step(&mut localizer, 30..31, true);
    assert!(estimate.reliability.abs() < 1e-12 && estimate.hypotheses.is_empty());
}

/// Where places look alike, a robot that was put down may be anywhere: the middle of the map is the best guess, not the place
/// from which it was carried away.
#[test]
fn among_look_alikes_a_lifted_robot_is_taken_for_in_the_middle() {
    let place = PlanarPose::new(3.0, 2.0, 0.0);
    let world = Alike::new(&[place]);
    let config = RefinementConfig { has_look_alikes: true, ..RefinementConfig::default() };
    let search = Box::new(Fixed::new(&[place]));
    let mut localizer =
        Refined::new(config, search, Box::new(world.clone()), Box::new(world.clone())).unwrap();
    assert!(is_at(&step(&mut localizer, 0..60, false), &place));
    let estimate = step(&mut localizer, 60..62, true);
    assert!(estimate.world_from_robot.distance_m(&PlanarPose::default()) < 0.7, "{estimate:?}");
    assert!(estimate.reliability == 0.0 && estimate.hypotheses.is_empty());
    assert!(is_at(&step(&mut localizer, 62..90, false), &place));
}

/// Of places that look alike, one that needs another camera than the robot's is less probable; to rely on the other one takes more.
#[test]
fn among_look_alikes_a_place_that_needs_another_camera_is_less_probable() {
    let places = [PlanarPose::new(2.0, 0.0, 0.0), PlanarPose::new(-2.0, 1.0, 0.0)];
    let probability = |tilts_rad: [f64; 2], has_look_alikes: bool| {
        let world = Alike { tilts_rad: tilts_rad.to_vec(), ..Alike::new(&places) };
        // In a building the reported direction of the camera is believed.
        let mount_pitch_rad = if has_look_alikes { 0.0 } else { 0.035 };
        let config = RefinementConfig {
            has_look_alikes,
            mount_pitch_rad,
            mount_roll_rad: 0.0,
            mount_yaw_rad: 0.0,
            ..RefinementConfig::default()
        };
        let search = Box::new(Fixed::new(&places));
        let mut localizer = Refined::new(config, search, Box::new(world.clone()), Box::new(world)).unwrap();
        let estimate = step(&mut localizer, 0..60, false);
        assert!(estimate.reliability < 0.1, "{}", estimate.reliability);
        let first = estimate.hypotheses.iter().find(|h| h.world_from_robot.x_m > 0.0);
        first.map(|h| h.probability).unwrap()
    };
    assert!((probability([0.0, 0.0], true) - 0.5).abs() < 0.1);
    assert!(probability([0.0, 0.015], true) > 0.8);
    assert!(probability([0.015, 0.0], true) < 0.2);
    assert!((probability([0.0, 0.015], false) - 0.5).abs() < 0.1, "on a field nothing but images count");
}

/// On a map that looks the same from a mirrored pose both are told, with equal probability; knowing the half settles it.
#[test]
fn mirrored_poses_share_the_probability_until_the_half_is_known() {
    let place = PlanarPose::new(1.5, 0.5, 0.3);
    let mirrored = PlanarPose::new(-1.5, -0.5, 0.3 - std::f64::consts::PI);
    let mut world = Alike::new(&[place, mirrored]);
    (world.is_symmetric, world.has_landmarks) = (true, false);
    let mut localizer = refined(&world, &[place, mirrored]);
    let estimate = step(&mut localizer, 0..90, false);
    assert!(estimate.reliability < 0.1 && estimate.reliability_up_to_symmetry > 0.6, "{estimate:?}");
    assert_eq!(estimate.hypotheses.len(), 2);
    assert!(estimate.hypotheses.iter().all(|h| (h.probability - 0.5).abs() < 1e-9));
    for (half, expected) in [
        (Region { max_x_m: 0.0, ..world.region() }, mirrored),
        (Region { min_x_m: 0.0, ..world.region() }, place),
    ] {
        localizer.reset_to(&StartPrior::Region { region: half, heading: None });
        let estimate = step(&mut localizer, 0..90, false);
        assert!(is_at(&estimate, &expected) && estimate.is_localized(), "{estimate:?}");
        assert!(estimate.hypotheses[1].probability < 0.02, "the other is still told");
    }
}

/// A half that was given holds for where the robot was then, not for where it has walked since.
#[test]
fn a_given_half_follows_the_robot_over_the_middle_line() {
    let mut world = Alike::new(&[]);
    world.is_symmetric = true;
    let half = Region { min_x_m: 0.0, ..world.region() };
    let mut known = Known::new(StartPrior::Region { region: half, heading: None });
    let start = PlanarPose::new(0.5, 1.0, 3.0);
    assert!(known.share(&world, &start, 0.1) > 0.9);
    let motion = PlanarPose::new(1.0, 0.0, 0.2);
    known.move_by(&motion);
    let now = start.compose(&motion);
    assert!(now.x_m < 0.0 && known.share(&world, &now, 0.1) > 0.9);
    let mirrored = world.mirrored(&now).unwrap();
    assert!(known.share(&world, &mirrored, 0.1) < 0.1);
}

/// Beside the middle line the first guess may be on its wrong side; as the pose gets better, the half is asked again.
#[test]
fn the_half_is_asked_again_while_the_pose_gets_better() {
    let seen_at = |x_m: f64| {
        let place = PlanarPose::new(x_m, 0.5, 0.3);
        let mut world = Alike::new(&[place]);
        world.is_symmetric = true;
        world.places.extend(world.mirrored(&place));
        world
    };
    let config = RefinementConfig::default();
    let half = Region { min_x_m: 0.0, ..seen_at(0.0).region() };
    let known = Known::new(StartPrior::Region { region: half, heading: None });
    let view = View {
        novelty: 1.0,
        clearness: 1.0,
        has_landmarks: false,
        is_localized: false,
        region: seen_at(0.0).region(),
    };
    let (first, truth) = (seen_at(-0.04), seen_at(0.04));
    let mut tracks = Tracks::default();
    let candidate = Candidate { world_from_robot: first.places[0], tilt_rad: nalgebra::Vector3::zeros() };
    tracks.update(&first, &[candidate], &view, &known, &config);
    let guess = tracks.best().unwrap().filter.pose();
    assert!(guess.distance_m(&first.places[1]) < 0.02, "{guess:?}: the mirrored pose is in the half");
    for _ in 0..30 {
        tracks.predict(&Odometry::Moved(PlanarPose::default()), 1.0 / 30.0, &config);
        tracks.update(&truth, &[], &view, &known, &config);
    }
    let best = tracks.best().unwrap();
    let pose = best.filter.pose();
    assert!(pose.distance_m(&truth.places[0]) < 0.03 && best.own_share > 0.9, "{pose:?}");
    assert!(pose.heading_difference_rad(&truth.places[0]) < 0.1, "{pose:?}");
}

/// An odometry that tells 10 % too much forward motion is corrected: after a blind stretch the pose is right.
#[test]
fn the_scale_of_the_odometry_is_learned() {
    let config = RefinementConfig::default();
    let mut rng = RngTree::new(5).stream("noise", 0);
    let mut truth = PlanarPose::new(-4.0, 0.0, 0.0);
    let mut filter = PoseFilter::new(&truth, &Mount::default(), &config);
    let told = |step_m: f64| Odometry::Moved(PlanarPose::new(step_m * 1.1, 0.0, 0.0));
    for _ in 0..600 {
        truth.x_m += 0.007;
        filter.predict(&told(0.007), 1.0 / 30.0, &config);
        filter.update(&Alike::new(&[truth]).with_noise(&mut rng), &[12.0, 8.0], &config);
    }
    let start_m = filter.pose().distance_m(&truth);
    for _ in 0..200 {
        truth.x_m += 0.01;
        filter.predict(&told(0.01), 1.0 / 30.0, &config);
    }
    let error_m = filter.pose().distance_m(&truth);
    assert!(start_m < 0.01 && error_m < 0.05, "{start_m} {error_m}: uncorrected it would be 0.2 m");
}

/// Errors of a filter, image by image, meters, and the scale of the odometry that it had learned at the gap and at the end.
struct Walk {
    errors_m: Vec<f64>,
    scales: [f64; 2],
}

impl Walk {
    fn worst_m(&self, images: std::ops::Range<usize>) -> f64 {
        self.errors_m[images].iter().copied().fold(0.0, f64::max)
    }
}

/// First image without odometry of a second without, and the first one after it; and last image at all.
const GAP: std::ops::Range<usize> = 700..730;
const LAST_SEEN: usize = 850;

/// A robot walks 0.3 m/s, and in the gap it turns all at once, which only images tell. Its odometry has 10 % too much; the filter is given
/// what `sample` makes of it. The last 150 images show nothing.
fn walk(sample: impl Fn(usize, PlanarPose) -> Option<PlanarPose>) -> Walk {
    let config = RefinementConfig::default();
    let mut rng = RngTree::new(6).stream("noise", 0);
    let mut truth = PlanarPose::new(-4.0, -2.0, 0.0);
    let mut filter = PoseFilter::new(&truth, &Mount::default(), &config);
    let mut odometer = Odometer::new(config.max_motion_m);
    let mut told = PlanarPose::default();
    let mut walk = Walk { errors_m: Vec::new(), scales: [0.0; 2] };
    for i in 0..LAST_SEEN + 150 {
        let turn_rad = if GAP.contains(&i) { 0.5 / 30.0 } else { 0.0 };
        truth = truth.compose(&PlanarPose::new(0.01, 0.0, turn_rad));
        told = told.compose(&PlanarPose::new(0.011, 0.0, turn_rad));
        let odometry = odometer.update(Timestamp::from_secs(i as f64 / 30.0), sample(i, told));
        filter.predict(&odometry, 1.0 / 30.0, &config);
        if i < LAST_SEEN {
            filter.update(&Alike::new(&[truth]).with_noise(&mut rng), &[12.0, 8.0], &config);
            walk.scales[usize::from(i >= GAP.start)] = filter.odometry_errors()[0];
        }
        walk.errors_m.push(filter.pose().distance_m(&truth));
    }
    walk
}

/// The odometry is missing for a second, jumps by 5 m, and is not a number once. What was learned of it stays: a walk without images is as
/// right as without all that, and in the gap the filter is no worse than one that never had odometry.
#[test]
fn gaps_and_jumps_of_the_odometry_do_not_erase_what_was_learned() {
    let away = PlanarPose::new(-5.0, 0.0, 1.0);
    let whole = walk(|_, told| Some(told));
    let never = walk(|_, _| None);
    let disturbed = walk(|i, told| match i {
        800 => Some(PlanarPose { x_m: f64::NAN, ..told }),
        i if GAP.contains(&i) => None,
        i if i >= 760 => Some(away.compose(&told)),
        _ => Some(told),
    });
    let gap = GAP.start..GAP.end + 30;
    let (found_m, never_m) = (disturbed.worst_m(gap.clone()), never.worst_m(gap.clone()));
    assert!(found_m <= never_m, "{found_m} m in the gap, {never_m} m without odometry");
    let rest = gap.end..LAST_SEEN;
    let (found_m, whole_m) = (disturbed.worst_m(rest.clone()), whole.worst_m(rest));
    assert!(found_m < 2.0 * whole_m, "{found_m} m after the gap, {whole_m} m if nothing is missing");
    let [before, after] = disturbed.scales;
    assert!((after - before).abs() < 0.01 && (after + 0.1 / 1.1).abs() < 0.02, "{before} became {after}");
    let error_m = disturbed.errors_m[LAST_SEEN + 149];
    assert!(error_m < 0.06, "{error_m} m after 1.5 m without images: uncorrected it would be 0.15 m");
}

/// While the odometry is missing nobody knows the motion, and the filter says so; a short gap is made good by the next sample.
#[test]
fn the_covariance_grows_over_a_gap_of_the_odometry() {
    let config = RefinementConfig::default();
    let walk = |missing: std::ops::Range<u32>| {
        let mut filter = PoseFilter::new(&PlanarPose::default(), &Mount::default(), &config);
        filter.update(&Alike::new(&[PlanarPose::default()]), &[12.0, 8.0], &config);
        let mut odometer = Odometer::new(config.max_motion_m);
        for i in 0..60_u32 {
            let sample = PlanarPose::new(0.01 * f64::from(i), 0.0, 0.0);
            let at = Timestamp::from_secs(f64::from(i) / 30.0);
            let odometry = odometer.update(at, (!missing.contains(&i)).then_some(sample));
            filter.predict(&odometry, 1.0 / 30.0, &config);
        }
        (filter.x_m(), filter.spread_m())
    };
    let (whole, bridged, gap) = (walk(0..0), walk(20..30), walk(20..50));
    assert!((whole.0 - 0.59).abs() < 1e-9 && (bridged.0 - whole.0).abs() < 1e-6, "{whole:?} {bridged:?}");
    assert!(bridged.1 < 1.5 * whole.1, "{whole:?} {bridged:?}");
    assert!((gap.0 - whole.0).abs() < 0.15 && gap.1 > 2.0 * whole.1, "{whole:?} {gap:?}");
}

/// Without odometry the speed is learned from the images.
#[test]
fn without_odometry_the_filter_goes_on_moving() {
    let config = RefinementConfig::default();
    let mut truth = PlanarPose::new(-1.0, 0.0, 0.4);
    let mut filter = PoseFilter::new(&truth, &Mount::default(), &config);
    let motion = PlanarPose::new(0.2 / 30.0, 0.0, 0.3 / 30.0);
    for _ in 0..90 {
        truth = truth.compose(&motion);
        filter.predict(&Odometry::Without, 1.0 / 30.0, &config);
        filter.update(&Alike::new(&[truth]), &[12.0, 8.0], &config);
    }
    let (before_m, spread_m) = (filter.pose().distance_m(&truth), filter.spread_m());
    for _ in 0..15 {
        truth = truth.compose(&motion);
        filter.predict(&Odometry::Without, 1.0 / 30.0, &config);
    }
    let error_m = filter.pose().distance_m(&truth);
    assert!(before_m < 0.01 && error_m < 0.05, "{before_m} {error_m}: standing still it would be 0.1 m");
    assert!(filter.spread_m() > 2.0 * spread_m, "and it knows that it knows less");
}

/// Covariances are honest: over many runs with independent noise of the assumed size the normalized error has its mean,
/// three for three dimensions. Margin: 0.3, three standard errors of 600 runs.
#[test]
fn the_covariance_of_one_update_is_honest() {
    let config = RefinementConfig {
        pixel_noise_px: 0.5,
        max_independent_pixels: 1000.0,
        gate_px: 50.0,
        // The camera of these images is where it is reported.
        eye_noise_m: 1e-9,
        ..RefinementConfig::default()
    };
    let mut rng = RngTree::new(8).stream("noise", 0);
    let truth = PlanarPose::new(0.3, 0.2, 0.1);
    let mut sum = 0.0;
    for _ in 0..600 {
        let mut filter = PoseFilter::new(&truth, &Mount::default(), &config);
        filter.update(&Alike::new(&[truth]).with_noise(&mut rng), &[50.0; 3], &config);
        let pose = filter.pose();
        let error = nalgebra::Vector3::new(
            pose.x_m - truth.x_m,
            pose.y_m - truth.y_m,
            angle::difference(pose.yaw_rad, truth.yaw_rad),
        );
        sum += error.dot(&(filter.pose_covariance().try_inverse().unwrap() * error));
    }
    let mean = sum / 600.0;
    assert!((mean - 3.0).abs() < 0.3, "{mean}");
}
