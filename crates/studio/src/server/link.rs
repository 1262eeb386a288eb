//! How much one page is sent.
//!
//! A page says when it has drawn an update. No more than [`MAX_IN_FLIGHT`] are on their way at a time, and one at a time if that takes
//! long, so what a page shows is never older than the time of an update on its way; what it has no time for is left out. Images take
//! a quarter of the time at most: after one that took long the next ones are left out first, and if it took very long they are made
//! smaller. An image that was left out follows if nothing newer comes.

use std::{collections::VecDeque, sync::Arc};

use super::smaller::smaller;
use crate::Update;

/// Updates on their way.
const MAX_IN_FLIGHT: usize = 2;
/// After an update that took longer than this only one is on its way, seconds.
const SLOW_SECS: f64 = 0.4;
/// Images that are drawn within this time cost nothing, seconds: a page on this computer that is merely busy keeps all of them.
const FAST_SECS: f64 = 0.15;
/// After a slower one no image is sent for its time, times this.
const REST: f64 = 3.0;
/// After an image that took longer than this the next ones are small, seconds.
const LARGE_SECS: f64 = 0.6;
/// If a small image took less than this the next one is a large one again, seconds: it has about five times as many bytes.
const SMALL_SECS: f64 = 0.1;

/// One page.
#[derive(Debug, Default)]
pub(super) struct Link {
    scene: Option<Arc<[u8]>>,
    /// The last image that was sent, as the engine made it.
    image: Option<Arc<[u8]>>,
    in_flight: VecDeque<Sent>,
    image_from_secs: f64,
    has_drawn: bool,
    is_slow: bool,
    takes_small_images: bool,
    owes_image: bool,
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

    /// The time at which the latest image may follow that was left out, if it was.
    pub fn image_due_secs(&self) -> Option<f64> {
        (self.owes_image && self.has_drawn && self.is_ready()).then_some(self.image_from_secs)
    }

    /// The messages of an update that this page gets now, the state last.
    pub fn messages(&mut self, update: &Update, now_secs: f64) -> Vec<Arc<[u8]>> {
        let mut messages = Vec::new();
        if !self.scene.as_ref().is_some_and(|known| Arc::ptr_eq(known, &update.scene)) {
            messages.push(Arc::clone(&update.scene));
            self.scene = Some(Arc::clone(&update.scene));
        }
        let is_known =
            |image: &&Arc<[u8]>| self.image.as_ref().is_some_and(|known| Arc::ptr_eq(known, image));
        let image = update.image.as_ref().filter(|image| !is_known(image));
        // How fast the link is tells the first update.
        let may_send = self.has_drawn && now_secs >= self.image_from_secs;
        self.owes_image = image.is_some() && !may_send;
        let image = image.filter(|_| may_send);
        if let Some(image) = image {
            let small = self.takes_small_images.then(|| smaller(image)).flatten();
            messages.push(small.unwrap_or_else(|| Arc::clone(image)));
            self.image = Some(Arc::clone(image));
        }
        messages.push(Arc::clone(&update.state));
        self.in_flight.push_back(Sent { at_secs: now_secs, has_image: image.is_some() });
        messages
    }

    /// The page has drawn the oldest update that was on its way.
    pub fn drawn(&mut self, now_secs: f64) {
        let Some(sent) = self.in_flight.pop_front() else { return };
        let took_secs = now_secs - sent.at_secs;
        self.has_drawn = true;
        self.is_slow = took_secs > SLOW_SECS;
        if !sent.has_image {
            return;
        }
        if took_secs > FAST_SECS {
            self.image_from_secs = now_secs + REST * took_secs;
        }
        self.takes_small_images = took_secs > if self.takes_small_images { SMALL_SECS } else { LARGE_SECS };
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

    /// A link over which a first update went in no time.
    fn opened(update: &Update) -> Link {
        let mut link = Link::default();
        link.messages(update, 0.0);
        link.drawn(0.0);
        link
    }

    #[test]
    fn a_stalled_page_gets_two_updates_and_no_more() {
        let mut link = Link::default();
        assert_eq!(kinds(&link.messages(&update(), 0.0)), [1, 2], "no image before the link is known");
        assert!(link.is_ready());
        let mut link = opened(&update());
        let update = update();
        assert_eq!(kinds(&link.messages(&update, 0.0)), [1, 3, 2], "another scene");
        assert!(link.is_ready());
        assert_eq!(kinds(&link.messages(&update, 0.1)), [2], "it knows scene and image");
        assert!(!link.is_ready());
        link.drawn(0.11);
        assert!(link.is_ready());
        (0..5).for_each(|_| link.drawn(0.12));
        assert_eq!(link.in_flight.len(), 0, "a page cannot gain room by saying too much");
    }

    #[test]
    fn slow_links_get_fewer_images_and_one_update_at_a_time() {
        let (mut slow, mut fast) = (opened(&update()), opened(&update()));
        let mut num_images = [0, 0];
        for i in 0..100 {
            let now_secs = f64::from(i);
            for (n, (link, took_secs)) in [(&mut slow, 0.9), (&mut fast, 0.02)].into_iter().enumerate() {
                num_images[n] += usize::from(kinds(&link.messages(&update(), now_secs)).contains(&3));
                link.drawn(now_secs + took_secs);
            }
        }
        assert_eq!(num_images[1], 100);
        assert!((20..=34).contains(&num_images[0]), "{num_images:?}");
        slow.messages(&update(), 100.0);
        fast.messages(&update(), 100.0);
        assert!(!slow.is_ready() && fast.is_ready());
    }

    #[test]
    fn an_image_that_was_left_out_follows() {
        let mut link = Link::default();
        assert_eq!(link.image_due_secs(), None, "nothing is owed");
        let update = update();
        link.messages(&update, 0.0);
        assert_eq!(link.image_due_secs(), None, "how fast the link is nobody knows yet");
        link.drawn(0.1);
        assert_eq!(link.image_due_secs(), Some(0.0));
        assert_eq!(kinds(&link.messages(&update, 0.1)), [3, 2]);
        link.drawn(1.1);
        assert_eq!(link.image_due_secs(), None, "the page has it");
        // A slow link: the next one is owed until the link has rested.
        let next = Update { image: Some(Arc::from([3; 4])), ..update };
        assert_eq!(kinds(&link.messages(&next, 1.2)), [2]);
        link.drawn(1.3);
        let due_secs = link.image_due_secs().unwrap();
        assert!(due_secs > 4.0);
        assert_eq!(kinds(&link.messages(&next, due_secs)), [3, 2]);
    }

    #[test]
    fn images_become_small_on_a_slow_link_and_large_again_on_a_fast_one() {
        let mut link = opened(&update());
        let mut sizes = Vec::new();
        for (i, took_secs) in [0.02, 0.9, 0.5, 0.05, 0.02].into_iter().enumerate() {
            let now_secs = 10.0 * i as f64;
            let mut update = update();
            update.image = Some(super::super::smaller::tests::large());
            let large = update.image.as_ref().unwrap().len();
            let sent = link.messages(&update, now_secs).into_iter().find(|message| message[0] == 3).unwrap();
            sizes.push(sent.len() == large);
            link.drawn(now_secs + took_secs);
        }
        assert_eq!(sizes, [true, true, false, false, true]);
    }
}
