//! What is worth a line: kidnaps, and who has found itself again.

use visloc_core::{GroundContact, eval::EvaluationOptions};

use crate::run::{FrameView, Runner};

/// Something that happened.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// When it happened, seconds since the first frame.
    pub secs: f64,
    /// What.
    pub text: String,
    /// Which algorithm it is about.
    pub runner: Option<usize>,
}

/// Notices events from frame to frame.
pub struct EventLog {
    options: EvaluationOptions,
    events: Vec<Event>,
    is_carried: bool,
    did_feet_notice: bool,
    /// When the robot was last put down (or the run started), seconds.
    down_secs: f64,
    searches: Vec<Search>,
}

/// How an algorithm looks for the robot after it was put down.
#[derive(Debug, Clone, Copy, Default)]
struct Search {
    right_since_secs: Option<f64>,
    is_over: bool,
}

impl EventLog {
    /// Nothing has happened yet.
    pub fn new(num_runners: usize) -> Self {
        Self {
            options: EvaluationOptions::default(),
            events: Vec::new(),
            is_carried: false,
            did_feet_notice: false,
            down_secs: 0.0,
            searches: vec![Search::default(); num_runners],
        }
    }

    /// Everything that happened, in order.
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// Looks at a frame; returns what is new.
    pub fn update(&mut self, view: &FrameView<'_>) -> &[Event] {
        let num_known = self.events.len();
        let Some(truth) = view.truth else { return &[] };
        let is_carried = truth.height_m > self.options.max_ground_height_m;
        if is_carried && !self.is_carried {
            self.add(view.secs, "lifted and carried away".to_owned(), None);
            self.did_feet_notice = false;
        }
        if is_carried {
            self.did_feet_notice |= feel_nothing_below(view.frame.ground_contact.as_ref());
        } else if self.is_carried {
            let feet = if self.did_feet_notice { "feet notice" } else { "feet notice nothing" };
            self.add(view.secs, format!("put down, {feet}"), None);
            self.down_secs = view.secs;
            self.searches.fill(Search::default());
        }
        self.is_carried = is_carried;
        if !is_carried {
            for (i, runner) in view.runners.iter().enumerate() {
                self.follow_search(i, runner, view);
            }
        }
        &self.events[num_known..]
    }

    /// As in the evaluation: found if the estimate is right and stays right for a second.
    fn follow_search(&mut self, index: usize, runner: &Runner, view: &FrameView<'_>) {
        let (Some(record), Some(truth)) = (runner.records().latest(), view.truth) else { return };
        let Some(search) = self.searches.get_mut(index).filter(|search| !search.is_over) else { return };
        let (estimate, truth) = (record.world_from_robot, truth.world_from_robot);
        let is_right = record.is_localized()
            && estimate.distance_m(&truth) < self.options.max_recovered_error_m
            && estimate.heading_difference_rad(&truth).to_degrees() < self.options.max_recovered_error_deg;
        if !is_right {
            search.right_since_secs = None;
            return;
        }
        let since_secs = *search.right_since_secs.get_or_insert(view.secs);
        if view.secs - since_secs >= self.options.min_recovered_secs {
            search.is_over = true;
            // Known only now, but told with its own time: nothing else can have happened to the robot since.
            let took_secs = since_secs - self.down_secs;
            let text = format!("{} found it, {took_secs:.1} s after {}", runner.name(), self.what_began());
            self.add(since_secs, text, Some(index));
        }
    }

    /// What the search began with.
    fn what_began(&self) -> &'static str {
        if self.down_secs > 0.0 { "it was put down" } else { "the start" }
    }

    fn add(&mut self, secs: f64, text: String, runner: Option<usize>) {
        self.events.push(Event { secs, text, runner });
    }
}

fn feel_nothing_below(contact: Option<&GroundContact>) -> bool {
    match contact {
        Some(GroundContact::Contact(is_on_ground)) => !is_on_ground,
        Some(GroundContact::Pressure(newtons)) => newtons.iter().all(|force| force.abs() < 1.0),
        None => false,
    }
}
