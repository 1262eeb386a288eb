//! A robot and its localizer on one machine: publishers and subscribers of our own, over the loopback network.

use std::{
    sync::atomic::{AtomicU16, Ordering},
    thread,
    time::{Duration, SystemTime, UNIX_EPOCH},
};

use visloc_core::{
    Host, Source, Timestamp,
    geom::{Camera, PlanarPose, nao::HeadAngles},
};

use crate::{
    bag::{
        BagTopics, camera_info_message,
        messages::{
            Empty, Header, Image, JointState, JointTrajectory, Odometry, Pose, StringMessage, TfMessage,
            TransformStamped, Twist,
        },
    },
    ros2::{
        DrivePublisher, DriveTopics, LiveFrames, LivePictures, LiveSettings, Network, Node, NodeSettings,
        Order, PublishSettings, ResultPublisher, TeamLink, node::Delivery,
    },
};

/// How long two nodes may take to find each other; far above what they need.
const NUM_TRIES: i64 = 600;
const TRY_EVERY: Duration = Duration::from_millis(25);

#[allow(clippy::disallowed_methods)]
fn now() -> Timestamp {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap();
    Timestamp::from_nanos(i64::try_from(since.as_nanos()).unwrap())
}

/// A domain that no other test uses, and hardly any other program.
fn settings(name: &str) -> NodeSettings {
    static NEXT: AtomicU16 = AtomicU16::new(0);
    let process = u16::try_from(std::process::id() % 40).unwrap();
    let domain_id = 100 + process * 3 + NEXT.fetch_add(1, Ordering::Relaxed);
    NodeSettings { domain_id, name: name.into() }
}

/// A node, or nothing where there is no network.
fn join(settings: &NodeSettings) -> Option<Node> {
    Node::join(settings).map_err(|error| println!("skipped: {error}")).ok()
}

/// How a robot says where its camera is.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kinematics {
    Transforms,
    Joints,
}

/// A camera that a joint lifts, in as many bytes as a description with all its meshes has.
fn description() -> StringMessage {
    let padding = "<!-- mesh -->".repeat(20_000);
    let joint = "<joint name=\"lift\" type=\"prismatic\"><parent link=\"base_footprint\"/><child link=\"eye\"/><axis xyz=\"0 0 1\"/></joint>";
    StringMessage { data: format!("<robot name=\"r\">{padding}{joint}</robot>") }
}

/// Publishes one moment of a robot after the other until somebody has seen enough.
fn robot(node: &mut Node, kinematics: Kinematics, mut until: impl FnMut() -> bool) {
    let topics = BagTopics::default();
    let sensors = Delivery::Reliable;
    let images = node.advertise("/eye", "sensor_msgs/msg/Image", sensors).unwrap();
    let infos = node.advertise(&topics.camera_info, "sensor_msgs/msg/CameraInfo", sensors).unwrap();
    let odometry = node.advertise(&topics.odometry, "nav_msgs/msg/Odometry", sensors).unwrap();
    let tf = node.advertise(&topics.tf_static, "tf2_msgs/msg/TFMessage", Delivery::Latched).unwrap();
    let camera = Camera::pinhole((4, 2), (5.0, 5.0), (1.5, 0.5)).unwrap();
    let mut transform = TransformStamped {
        header: Header::new(Timestamp::default(), "base_footprint"),
        child_frame_id: "eye".into(),
        transform: Pose::planar(&PlanarPose::new(0.1, 0.0, 0.0), 0.5),
    };
    transform.transform.orientation.w = 1.0;
    let (described, states) = ("std_msgs/msg/String", "sensor_msgs/msg/JointState");
    let described = node.advertise(&topics.robot_description, described, Delivery::Kept).unwrap();
    let states = node.advertise(&topics.joint_states, states, sensors).unwrap();
    match kinematics {
        Kinematics::Transforms => tf.publish(TfMessage { transforms: vec![transform] }).unwrap(),
        Kinematics::Joints => described.publish(description()).unwrap(),
    }
    for i in 0..NUM_TRIES {
        let at = Timestamp::from_nanos(1_700_000_000_000_000_000 + i * 50_000_000);
        infos.publish(camera_info_message(at, &camera, "eye")).unwrap();
        if kinematics == Kinematics::Joints {
            let (header, name, position) = (Header::new(at, ""), vec!["lift".into()], vec![0.5]);
            states.publish(JointState { header, name, position, ..JointState::default() }).unwrap();
        }
        let x_m = 0.01 * i as f64;
        let mut moved = Odometry { header: Header::new(at, "odom"), ..Odometry::default() };
        moved.pose.pose = Pose::planar(&PlanarPose::new(x_m, 0.0, 0.0), 0.0);
        odometry.publish(moved).unwrap();
        let (height, width, step, data) = (2, 4, 4, vec![u8::try_from(i % 256).unwrap(); 8]);
        let (header, encoding) = (Header::new(at, "eye"), "mono8".into());
        images.publish(Image { header, height, width, encoding, is_bigendian: 0, step, data }).unwrap();
        thread::sleep(TRY_EVERY);
        if until() {
            return;
        }
    }
    panic!("nobody saw anything");
}

fn live(node: &NodeSettings) -> LiveSettings {
    let topics = BagTopics { image: "/eye".into(), ..BagTopics::default() };
    let node = NodeSettings { name: "listener".into(), ..node.clone() };
    LiveSettings { topics, patience_secs: Some(60.0), ..LiveSettings::new(node) }
}

#[test]
fn frames_are_joined_from_live_topics() {
    frames_are_joined(Kinematics::Transforms);
}

#[test]
fn frames_are_joined_from_live_joints() {
    frames_are_joined(Kinematics::Joints);
}

fn frames_are_joined(kinematics: Kinematics) {
    let settings = settings("robot");
    let Some(mut node) = join(&settings) else { return };
    let host = Host::new(now, |_| {});
    let listener = thread::spawn(move || {
        let mut frames = LiveFrames::open(&live(&settings), &host).unwrap();
        let with_odometry = |frames: &mut LiveFrames| loop {
            let frame = frames.next_item().unwrap().unwrap().frame;
            if frame.odometry.is_some() {
                return frame;
            }
        };
        let frame = with_odometry(&mut frames);
        let number = (frame.at.nanos() - 1_700_000_000_000_000_000) / 50_000_000;
        assert_eq!(frame.image.get(3, 1), [u8::try_from(number % 256).unwrap(); 3]);
        assert!((frame.odometry.unwrap().x_m - 0.01 * number as f64).abs() < 1e-9);
        assert_eq!(frame.camera.size_px(), (4, 2));
        assert!((frame.robot_from_camera.translation().z - 0.5).abs() < 1e-12);
        assert!(frames.status().received_at.is_some());
        host.stop();
        assert!(frames.next_item().is_none());
    });
    robot(&mut node, kinematics, || listener.is_finished());
    listener.join().unwrap();
}

#[test]
fn pictures_need_no_robot_and_bring_their_calibration() {
    let settings = settings("camera");
    let Some(mut node) = join(&settings) else { return };
    let listener = thread::spawn(move || {
        let host = Host::new(now, |_| {});
        let mut pictures = LivePictures::open(&live(&settings), &host).unwrap();
        let camera = pictures.wait_for_camera().unwrap().unwrap();
        assert_eq!(camera.focal_px(), (5.0, 5.0));
        let (first, second) =
            (pictures.next_item().unwrap().unwrap(), pictures.next_item().unwrap().unwrap());
        assert!(first.at < second.at && first.image.width() == 4);
    });
    robot(&mut node, Kinematics::Transforms, || listener.is_finished());
    listener.join().unwrap();
}

#[test]
fn orders_arrive_and_other_types_are_seen() {
    let settings = settings("operator");
    let Some(mut node) = join(&settings) else { return };
    let mut results =
        ResultPublisher::open(&PublishSettings::new(NodeSettings { name: "visloc".into(), ..settings }))
            .unwrap();
    let reset = node.advertise("/visloc/reset", "std_msgs/msg/Empty", Delivery::Reliable).unwrap();
    let is_obeyed = (0..NUM_TRIES).any(|_| {
        reset.publish(Empty::default()).unwrap();
        thread::sleep(TRY_EVERY);
        let mut orders = Vec::new();
        results.obey(|order| {
            orders.push(order);
            Ok(String::new())
        });
        orders.contains(&Order::Reset)
    });
    assert!(is_obeyed);
    let topics = node.topics();
    let pose = topics.iter().find(|live| live.topic == "/visloc/pose").unwrap();
    assert_eq!(pose.type_name, "geometry_msgs/msg/PoseWithCovarianceStamped");
}

/// Speeds and angles of the head arrive as robots of ROS 2 take them.
#[test]
fn a_robot_is_driven_by_topics() {
    let settings = settings("base");
    let Some(mut node) = join(&settings) else { return };
    let newest = Delivery::Newest;
    let speeds = node.subscribe::<Twist>("/cmd_vel", "geometry_msgs/msg/Twist", newest).unwrap();
    let joints = ["neck_yaw".to_owned(), "neck_pitch".to_owned()];
    let topics = DriveTopics { joints, ..DriveTopics::default() };
    let (topic, kind) = ("/head_controller/joint_trajectory", "trajectory_msgs/msg/JointTrajectory");
    let head = node.subscribe::<JointTrajectory>(topic, kind, newest).unwrap();
    let driver = DrivePublisher::open(&NodeSettings { name: "driver".into(), ..settings }, &topics).unwrap();
    let (mut twist, mut trajectory) = (None, None);
    for _ in 0..NUM_TRIES {
        driver.drive([0.2, -0.1, 0.5]);
        driver.look(HeadAngles { yaw_rad: 0.3, pitch_rad: 0.1 });
        thread::sleep(TRY_EVERY);
        twist = twist.or(speeds.take().unwrap());
        trajectory = trajectory.or(head.take().unwrap());
        if twist.is_some() && trajectory.is_some() {
            break;
        }
    }
    let (twist, trajectory) = (twist.expect("speeds").0, trajectory.expect("head").0);
    assert_eq!((twist.linear.x, twist.linear.y, twist.angular.z), (0.2, -0.1, 0.5));
    assert_eq!(trajectory.joint_names, ["neck_yaw", "neck_pitch"]);
    assert_eq!(trajectory.points[0].positions, [0.3, 0.1]);
    assert_eq!(trajectory.points[0].time_from_start.nanosec, 300_000_000);
}

/// Two robots of one team hear each other and each its own detector; one of another team hears none of it.
#[test]
fn robots_of_a_team_hear_each_other() {
    let settings = settings("team");
    let open = |team: &str, number: u8| {
        let network = Network::new(settings.domain_id);
        TeamLink::<Header, Empty>::open(&network, &format!("{team}_{number}"), team, number)
    };
    let Some(mut detector) = join(&settings) else { return };
    let seen = detector
        .advertise("/visloc/team/ours/robot_2/sightings", "visloc_msgs/msg/Sightings", Delivery::Newest)
        .unwrap();
    let (mut one, mut two, mut other) =
        (open("ours", 1).unwrap(), open("ours", 2).unwrap(), open("theirs", 1).unwrap());
    let (mut heard, mut num_seen) = ([0, 0], 0);
    for _ in 0..NUM_TRIES {
        one.publish(Header::new(Timestamp::default(), "one"));
        two.publish(Header::new(Timestamp::default(), "two"));
        seen.publish(Empty::default()).unwrap();
        thread::sleep(TRY_EVERY);
        heard[0] += one.messages().iter().filter(|message| message.frame_id == "two").count();
        heard[1] += two.messages().iter().filter(|message| message.frame_id == "one").count();
        num_seen += two.sightings().len();
        assert!(other.messages().is_empty() && one.sightings().is_empty());
        if heard.iter().all(|count| *count > 3) && num_seen > 3 {
            return;
        }
    }
    panic!("not heard: {heard:?} {num_seen}");
}
