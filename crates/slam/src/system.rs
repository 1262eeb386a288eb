//! The whole system.

use visloc_core::{Clock, GrayImage, Timestamp, geom::Camera};

use crate::{
    config::{ConfigError, SlamConfig},
    front_end::{FrontEnd, Keeping},
    map::{Map, MapId, Packing, SessionCamera},
    odometry::{MetricScale, OdomFromCamera},
    outcome::{FrameError, FrameOutcome, FramePose, Mapped, TrajectoryPose},
    schedule::{BackEnd, Order, Schedule, Worker},
    shutter::Readout,
};

/// Monocular SLAM: takes one frame after the other.
#[derive(Debug)]
pub struct Slam {
    front_end: FrontEnd,
    mapping: Mapping,
}

/// Where mapping is done.
#[derive(Debug)]
enum Mapping {
    /// Nowhere: the maps are fixed.
    Never,
    /// Here, frame by frame.
    Here(Box<BackEnd>),
    /// On a thread of its own. An order that must be done waits here while too many others are under way.
    There { worker: Worker, waiting: Option<Box<Order>>, num_left_out: usize },
}

impl Mapping {
    fn new(back_end: BackEnd, schedule: Schedule) -> Result<Self, ConfigError> {
        match schedule {
            Schedule::Sequential => Ok(Self::Here(Box::new(back_end))),
            Schedule::Threaded => {
                let worker = Worker::start(back_end).map_err(|e| ConfigError::Thread(e.to_string()))?;
                Ok(Self::There { worker, waiting: None, num_left_out: 0 })
            }
        }
    }
}

impl Slam {
    /// A system for one camera that works strictly in sequence: the same frames give the same bits. The seed fixes every random
    /// choice.
    ///
    /// # Errors
    /// If a parameter is out of range.
    pub fn new(camera: &Camera, config: &SlamConfig, seed: u64) -> Result<Self, ConfigError> {
        Self::with_schedule(camera, config, seed, Schedule::Sequential)
    }

    /// A system for one camera.
    ///
    /// # Errors
    /// If a parameter is out of range, or there is no thread for mapping.
    pub fn with_schedule(
        camera: &Camera,
        config: &SlamConfig,
        seed: u64,
        schedule: Schedule,
    ) -> Result<Self, ConfigError> {
        config.check()?;
        let mapping = Mapping::new(BackEnd::new(camera, config, seed), schedule)?;
        Ok(Self { front_end: FrontEnd::new(camera, config, seed), mapping })
    }

    /// A system that goes on in maps of an earlier session: it is lost in them at first. What a camera of the same calibration has
    /// learned of itself then is taken over.
    ///
    /// # Errors
    /// As [`Slam::with_schedule`].
    pub fn resume(
        map: Map,
        camera: &Camera,
        config: &SlamConfig,
        seed: u64,
        schedule: Schedule,
    ) -> Result<Self, ConfigError> {
        Self::in_maps(map, (camera, config), seed, Keeping::Growing, Some(schedule))
    }

    /// A system that only finds the camera in maps of an earlier session and follows it there. The maps stay as they are.
    ///
    /// # Errors
    /// If a parameter is out of range.
    pub fn in_fixed_map(
        map: Map,
        camera: &Camera,
        config: &SlamConfig,
        seed: u64,
    ) -> Result<Self, ConfigError> {
        Self::in_maps(map, (camera, config), seed, Keeping::Fixed, None)
    }

    /// A system that finds the camera in maps of an earlier session and adds what it sees around them, so that it can follow the camera
    /// where they show too little. What they had stays as it is, and no new map is started: a lost camera is looked for.
    ///
    /// # Errors
    /// As [`Slam::with_schedule`].
    pub fn around_fixed_map(
        map: Map,
        camera: &Camera,
        config: &SlamConfig,
        seed: u64,
        schedule: Schedule,
    ) -> Result<Self, ConfigError> {
        Self::in_maps(map, (camera, config), seed, Keeping::Extending, Some(schedule))
    }

    /// In maps of an earlier session; without a schedule nothing is mapped.
    fn in_maps(
        mut map: Map,
        (camera, config): (&Camera, &SlamConfig),
        seed: u64,
        keeping: Keeping,
        schedule: Option<Schedule>,
    ) -> Result<Self, ConfigError> {
        config.check()?;
        let known = map.take_over(camera);
        if keeping != Keeping::Growing {
            map.fix();
        }
        let mapping = match schedule {
            Some(schedule) => Mapping::new(BackEnd::resume(&map, &known, config, seed), schedule)?,
            None => Mapping::Never,
        };
        Ok(Self { front_end: FrontEnd::resume(&map, &known, config, seed, keeping), mapping })
    }

    /// Whether the place in a fixed map is in doubt from the next image on: the camera is looked for in the whole map then, though it is
    /// followed. Without effect where the map grows.
    pub fn set_doubt(&mut self, is_in_doubt: bool) {
        self.front_end.set_doubt(is_in_doubt);
    }

    /// Measures times with a clock.
    pub fn set_clock(&mut self, clock: Clock) {
        self.front_end.clock = clock;
    }

    /// From now on images of keyframes that the camera has not been near for long are packed, beside frames that become no keyframes. Without it
    /// all images stay as they were taken.
    pub fn set_packing(&mut self, packing: Packing) {
        self.front_end.packing = Some(packing);
    }

    /// The camera as it is known now.
    #[must_use]
    pub fn camera(&self) -> &Camera {
        &self.front_end.camera
    }

    /// How far the first radial coefficient of the lens, as the map tells it, is from the calibration; 0 as long as the map agrees
    /// with the calibration.
    #[must_use]
    pub fn lens_change(&self) -> f64 {
        let coefficient =
            |camera: &Camera| camera.distortion().coefficients().first().copied().unwrap_or(0.0);
        coefficient(&self.front_end.camera) - coefficient(&self.front_end.calibrated)
    }

    /// How long the camera takes from the exposure of one border of an image to that of the other, as the map tells it. Images that come in are put right by
    /// it, as long as the camera is followed. All at once as long as the map agrees with that.
    #[must_use]
    pub fn readout(&self) -> Readout {
        self.front_end.readout
    }

    /// The camera as calibrated and as it is known now.
    #[must_use]
    pub fn session_camera(&self) -> SessionCamera {
        let FrontEnd { calibrated, camera, readout, .. } = self.front_end;
        SessionCamera { calibrated, camera, readout }
    }

    /// The map so far, as tracking sees it.
    #[must_use]
    pub fn map(&self) -> &Map {
        &self.front_end.map
    }

    /// All frames so far that are remembered.
    #[must_use]
    pub fn frames(&self) -> &[FramePose] {
        self.front_end.frames.poses()
    }

    /// From now on only the poses of the newest frames are remembered, at least so many of them, so that memory does not
    /// grow with time. All are by default.
    pub fn remember_frames(&mut self, least: usize) {
        self.front_end.frames.remember(least);
    }

    /// Whether there were frames that are no longer remembered.
    #[must_use]
    pub fn has_forgotten_frames(&self) -> bool {
        self.front_end.frames.has_forgotten()
    }

    /// Poses of all frames that have one, with all corrections of the map so far.
    #[must_use]
    pub fn trajectory(&self) -> Vec<TrajectoryPose> {
        self.front_end.trajectory()
    }

    /// Tracked frames that the mapper had no time for; 0 in sequence.
    #[must_use]
    pub fn num_left_out(&self) -> usize {
        match &self.mapping {
            Mapping::Never | Mapping::Here(_) => 0,
            Mapping::There { num_left_out, .. } => *num_left_out,
        }
    }

    /// The unit of length of the map with the given number, as odometry tells it; `None` without odometry, or if the camera has
    /// hardly moved.
    #[must_use]
    pub fn metric_scale(&self, map: MapId) -> Option<MetricScale> {
        MetricScale::of_map(&self.front_end.map, map)
    }

    /// Takes the next frame.
    ///
    /// # Errors
    /// If the frame cannot be used; it is left out.
    pub fn add_frame(&mut self, at: Timestamp, image: GrayImage) -> Result<FrameOutcome, FrameError> {
        self.add_frame_of_robot(at, image, None)
    }

    /// Takes the next frame of a camera on a robot. Its odometry predicts the motion, gives the map its unit of length, and carries the
    /// pose on where the image shows too little. Without odometry, or with one that is not finite, the frame is that of any camera.
    ///
    /// # Errors
    /// If the frame cannot be used; it is left out.
    pub fn add_frame_of_robot(
        &mut self,
        at: Timestamp,
        image: GrayImage,
        odom_from_camera: Option<OdomFromCamera>,
    ) -> Result<FrameOutcome, FrameError> {
        let odom_from_camera = odom_from_camera.filter(OdomFromCamera::is_finite);
        let mut mapped = self.collect();
        let (mut outcome, order) = self.front_end.add_frame(at, image, odom_from_camera)?;
        mapped.extend(order.and_then(|order| self.hand_over(order)));
        outcome.mapped = mapped;
        Ok(outcome)
    }

    /// Waits until the mapper has done all its work. Maps whose unit of length is known by odometry are in meters afterwards.
    pub fn finish(&mut self) -> Vec<Mapped> {
        let mapped = self.wait();
        self.front_end.make_metric();
        mapped
    }

    /// As [`Slam::finish`], once no more images come. In each map of up to 400 keyframes with places that were visited again, keyframes are linked
    /// to all landmarks that they show, and the whole is adjusted, which takes some seconds for the largest. Fixed maps stay as they are.
    pub fn complete(&mut self) -> Vec<Mapped> {
        let mapped = self.wait();
        let order = self.front_end.completion();
        self.hand_over(order);
        self.wait();
        self.front_end.make_metric();
        mapped
    }

    /// Waits for the mapper.
    fn wait(&mut self) -> Vec<Mapped> {
        let mut mapped = self.collect();
        if let Mapping::There { worker, waiting, .. } = &mut self.mapping {
            let mut updates = worker.finish();
            if let Some(order) = waiting.take()
                && worker.submit(*order).is_ok()
            {
                updates.extend(worker.finish());
            }
            mapped.extend(updates.into_iter().filter_map(|update| self.front_end.apply(update)));
        }
        mapped
    }

    /// Takes over what a thread has finished meanwhile.
    fn collect(&mut self) -> Vec<Mapped> {
        let Mapping::There { worker, waiting, .. } = &mut self.mapping else { return Vec::new() };
        let updates = worker.collect();
        *waiting = waiting.take().and_then(|order| worker.submit(*order).err());
        updates.into_iter().filter_map(|update| self.front_end.apply(update)).collect()
    }

    /// Does an order, or leaves it to the thread.
    fn hand_over(&mut self, order: Order) -> Option<Mapped> {
        match &mut self.mapping {
            Mapping::Never => None,
            Mapping::Here(back_end) => {
                self.front_end.release_map();
                let update = back_end.process(order);
                self.front_end.apply(update)
            }
            Mapping::There { worker, waiting, num_left_out } => {
                // A newer start replaces what waits for a map that was given up; else the order is kept.
                let is_blocked = waiting.as_ref().is_some_and(|earlier| earlier.epoch == order.epoch);
                let refused = if is_blocked { Err(Box::new(order)) } else { worker.submit(order) };
                if let Err(order) = refused {
                    if order.must_be_done() {
                        *waiting = Some(order);
                    } else {
                        *num_left_out += 1;
                    }
                }
                None
            }
        }
    }
}
