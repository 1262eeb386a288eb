//! How much one page is sent.
//!
//! A page says when it has drawn an update. No more than [`MAX_IN_FLIGHT`] are on their way at a time, one if that takes long, so what a
//! page shows is never older than the time of an update on its way, however slow link or page are; what it has no time for is left
//! out. Images take a quarter of the time at most: after one that took long the next ones are left out first. When that happens
//! again, images become smaller, step by step, and larger again when they come through quickly. What stands still is sent whole in
//! the end.

use std::{collections::VecDeque, sync::Arc};

use super::smaller::{FAST_SECS, ImageSize, smaller};
use crate::Update;

/// Updates on their way.
const MAX_IN_FLIGHT: usize = 2;
/// After an update that took longer than this only one is on its way, seconds.
const SLOW_SECS: f64 = 0.4;
/// After a slower one no image is sent for its time, times this.
const REST: f64 = 3.0;

/// One page.
#[derive(Debug, Default)]
pub(super) struct Link {
    scene: Option<Arc<[u8]>>,
    in_flight: VecDeque<Sent>,
    image_from_secs: f64,
    image_size: ImageSize,
    /// Whether the last image was left out or made smaller.
    owes_image: bool,
    /// Whether the last update took long.
    is_slow: bool,
}

#[derive(Debug)]
struct Sent {
    at_secs: f64,
    has_image: bool,
}

impl Link {
    /// Whether the page is ready for more.
    pub fn is_ready(&self) -> bool {
        self.in_flight.len() < if self.is_slow { 1 } else { MAX_IN_FLIGHT }
    }

    /// The messages of an update that this page gets now, the state last.
    pub fn messages(&mut self, update: &Update, now_secs: f64) -> Vec<Arc<[u8]>> {
        let mut messages = Vec::new();
        if !self.scene.as_ref().is_some_and(|known| Arc::ptr_eq(known, &update.scene)) {
            messages.push(Arc::clone(&update.scene));
            self.scene = Some(Arc::clone(&update.scene));
        }
        let image = update.image.as_ref().filter(|_| now_secs >= self.image_from_secs);
        self.owes_image = update.image.is_some() && (image.is_none() || self.image_size.level() > 0);
        messages.extend(image.map(|image| smaller(image, self.image_size.level())));
        messages.push(Arc::clone(&update.state));
        self.in_flight.push_back(Sent { at_secs: now_secs, has_image: image.is_some() });
        messages
    }

    /// Whether a page to which nothing new comes should get the whole image of what it shows.
    pub fn owes_image(&self) -> bool {
        self.owes_image && self.in_flight.is_empty()
    }

    /// The whole image of the update that a page shows, with its state.
    pub fn whole(&mut self, update: &Update, now_secs: f64) -> Vec<Arc<[u8]>> {
        self.owes_image = false;
        // How long it takes says nothing about images that are to follow each other.
        self.in_flight.push_back(Sent { at_secs: now_secs, has_image: false });
        update.image.iter().chain([&update.state]).cloned().collect()
    }

    /// The page has drawn the oldest update that was on its way.
    pub fn drawn(&mut self, now_secs: f64) {
        let Some(sent) = self.in_flight.pop_front() else { return };
        let took_secs = now_secs - sent.at_secs;
        self.is_slow = took_secs > SLOW_SECS;
        if !sent.has_image {
            return;
        }
        self.image_size.note(took_secs);
        if took_secs > FAST_SECS {
            self.image_from_secs = now_secs + REST * took_secs;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn update() -> Update {
        Update { scene: Arc::from([1; 4]), state: Arc::from([2; 4]), image: Some(Arc::from([3; 4])) }
    }

    fn kinds(messages: &[Arc<[u8]>]) -> Vec<u8> {
        messages.iter().map(|message| message[0]).collect()
    }

    #[test]
    fn a_stalled_page_gets_two_updates_and_no_more() {
        let (mut link, update) = (Link::default(), update());
        assert_eq!(kinds(&link.messages(&update, 0.0)), [1, 3, 2]);
        assert!(link.is_ready());
        assert_eq!(kinds(&link.messages(&update, 0.1)), [3, 2], "it knows the scene");
        assert!(!link.is_ready());
        link.drawn(0.11);
        assert!(link.is_ready());
        (0..5).for_each(|_| link.drawn(0.12));
        assert_eq!(link.in_flight.len(), 0, "a page cannot gain room by saying too much");
    }

    #[test]
    fn what_stands_still_is_sent_whole_once() {
        let (mut link, update) = (Link::default(), update());
        link.messages(&update, 0.0);
        link.drawn(0.01);
        assert!(!link.owes_image(), "it was whole");
        for i in 1..=4 {
            link.messages(&update, f64::from(100 * i));
            link.drawn(f64::from(100 * i) + 0.9);
        }
        assert!(link.image_size.level() > 0 && link.owes_image());
        assert_eq!(kinds(&link.whole(&update, 500.0)), [3, 2]);
        assert!(!link.owes_image());
        link.drawn(505.0);
        assert!(!link.owes_image() && link.is_ready());
    }

    #[test]
    fn slow_links_get_fewer_images() {
        let (mut slow, mut fast, update) = (Link::default(), Link::default(), update());
        let mut num_images = [0, 0];
        for i in 0..100 {
            let now_secs = f64::from(i);
            for (n, (link, took_secs)) in [(&mut slow, 0.9), (&mut fast, 0.02)].into_iter().enumerate() {
                num_images[n] += usize::from(kinds(&link.messages(&update, now_secs)).contains(&3));
                link.drawn(now_secs + took_secs);
            }
        }
        assert_eq!(num_images[1], 100);
        assert!((20..=34).contains(&num_images[0]), "{num_images:?}");
    }
}
