//! How much one page is sent.
//!
//! A page says when it has drawn an update. No more than [`MAX_IN_FLIGHT`] are on their way at a time, one if that takes long, so what a
//! page shows is never older than the time of an update on its way, however slow link or page are; what it has no time for is left
//! out. Until a page has said how fast it is, it gets the least that can be drawn: a brief scene, then the smallest image. Messages are packed
//! unless the link is fast. Images take a quarter of the time at most: after one that took long the next ones are left out first.
//! They become smaller when that happens again, step by step, and larger when they come through quickly. What stands still is sent
//! whole in the end.

use std::{collections::VecDeque, sync::Arc, time::Duration};

use super::smaller::{FAST_SECS, ImageSize, brief, smaller};
use crate::{Update, message::packed};

/// Updates on their way.
const MAX_IN_FLIGHT: usize = 2;
/// After an update that took longer than this only one is on its way, seconds.
const SLOW_SECS: f64 = 0.4;
/// A page to which nothing has come for so long shows something that stands still.
const STILL_AFTER: Duration = Duration::from_millis(400);
/// The same for a page that has drawn fewer updates than these.
const SOON: Duration = Duration::from_millis(60);
const NUM_FIRST: u64 = 3;
/// After a slower one no image is sent for its time, times this.
const REST: f64 = 3.0;

visloc_core::with_defaults! {
    /// One page.
    #[derive(Debug)]
    pub(super) struct Link {
        scene: KnownScene = KnownScene::Nothing,
        in_flight: VecDeque<Sent> = VecDeque::new(),
        image_from_secs: f64 = 0.0,
        image_size: ImageSize = ImageSize::default(),
        /// The image that was sent last, and whether whole.
        image: Option<(Arc<[u8]>, bool)> = None,
        num_drawn: u64 = 0,
        /// Whether the page shows another image than the update that it shows, or a smaller one.
        owes_image: bool = false,
        /// Whether the last update came through quickly.
        is_fast: bool = false,
        /// Whether only one update is to be on its way.
        is_slow: bool = true,
    }
}

/// What a page knows of what stays.
#[derive(Debug)]
enum KnownScene {
    Nothing,
    /// All but the rest of this one.
    Brief(Arc<[u8]>),
    Whole(Arc<[u8]>),
}

#[derive(Debug)]
struct Sent {
    at_secs: f64,
    has_image: bool,
    /// Whether it says nothing about how long updates take that are to follow each other.
    is_single: bool,
}

impl Link {
    /// Whether the page is ready for more.
    pub fn is_ready(&self) -> bool {
        self.in_flight.len() < if self.is_slow { 1 } else { MAX_IN_FLIGHT }
    }

    /// The messages of an update that this page gets now, the state last.
    pub fn messages(&mut self, update: &Update, now_secs: f64) -> Vec<Arc<[u8]>> {
        let mut messages: Vec<_> = self.scene(update).into_iter().collect();
        let is_single = !messages.is_empty();
        let image = if is_single { None } else { self.next_image(update, now_secs) };
        let has_image = image.is_some();
        messages.extend(image);
        messages.push(self.packed(&update.state));
        let shows =
            |(shown, is_whole): &(Arc<[u8]>, bool)| *is_whole && is_same(update.image.as_ref(), shown);
        self.owes_image = update.image.is_some() && !self.image.as_ref().is_some_and(shows);
        self.in_flight.push_back(Sent { at_secs: now_secs, has_image, is_single });
        messages
    }

    /// The scene, if the page does not know it: at first in brief, the rest when the page has shown a first image.
    fn scene(&mut self, update: &Update) -> Option<Arc<[u8]>> {
        let scene = &update.scene;
        let has_image = self.image.is_some() || update.image.is_none();
        match &self.scene {
            KnownScene::Whole(known) if Arc::ptr_eq(known, scene) => return None,
            KnownScene::Brief(known) if Arc::ptr_eq(known, scene) && !has_image => return None,
            KnownScene::Nothing => {
                if let Some(brief) = brief(scene) {
                    self.scene = KnownScene::Brief(Arc::clone(scene));
                    return Some(self.packed(&brief.into()));
                }
            }
            KnownScene::Brief(_) | KnownScene::Whole(_) => {}
        }
        self.scene = KnownScene::Whole(Arc::clone(scene));
        Some(self.packed(scene))
    }

    /// The image, unless the page has it or has no time for it.
    fn next_image(&mut self, update: &Update, now_secs: f64) -> Option<Arc<[u8]>> {
        let image = update.image.as_ref()?;
        let has_it = self.image.as_ref().is_some_and(|(shown, _)| Arc::ptr_eq(shown, image));
        if self.num_drawn == 0 || has_it || now_secs < self.image_from_secs {
            return None;
        }
        let level = self.image_size.level();
        self.image = Some((Arc::clone(image), level == 0));
        Some(self.packed(&smaller(image, level)))
    }

    fn packed(&self, message: &Arc<[u8]>) -> Arc<[u8]> {
        if self.is_fast { Arc::clone(message) } else { packed(message).into() }
    }

    /// Whether a page to which nothing new comes should get the rest of what it shows: what the scene left out, and the whole image.
    pub fn owes_rest(&self) -> bool {
        (self.owes_image || matches!(self.scene, KnownScene::Brief(_))) && self.in_flight.is_empty()
    }

    /// How long nothing new has to come until the rest is sent. A new page shows something as soon as possible.
    pub fn still_after(&self) -> Duration {
        if self.num_drawn < NUM_FIRST { SOON } else { STILL_AFTER }
    }

    /// The rest of the update that a page shows, with its state.
    pub fn rest(&mut self, update: &Update, now_secs: f64) -> Vec<Arc<[u8]>> {
        if self.image.is_none() && update.image.is_some() {
            // A small one first.
            return self.messages(update, now_secs);
        }
        let scene = self.scene(update);
        let image = update.image.as_ref().filter(|_| self.owes_image).map(|image| self.packed(image));
        self.image = update.image.as_ref().map(|image| (Arc::clone(image), true));
        self.owes_image = false;
        self.in_flight.push_back(Sent { at_secs: now_secs, has_image: false, is_single: true });
        scene.into_iter().chain(image).chain([self.packed(&update.state)]).collect()
    }

    /// The page has drawn the oldest update that was on its way.
    pub fn drawn(&mut self, now_secs: f64) {
        let Some(sent) = self.in_flight.pop_front() else { return };
        self.num_drawn += 1;
        let took_secs = now_secs - sent.at_secs;
        if !sent.is_single || took_secs < FAST_SECS {
            (self.is_fast, self.is_slow) = (took_secs < FAST_SECS, took_secs > SLOW_SECS);
        }
        if !sent.has_image {
            return;
        }
        self.image_size.note(took_secs);
        if took_secs > FAST_SECS {
            self.image_from_secs = now_secs + REST * took_secs;
        }
    }
}

fn is_same(a: Option<&Arc<[u8]>>, b: &Arc<[u8]>) -> bool {
    a.is_some_and(|a| Arc::ptr_eq(a, b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Message, MessageBuilder, MessageKind};

    /// The next moment: scene and messages that do not change are the same allocations.
    fn moment(scene: &Arc<[u8]>) -> Update {
        Update { scene: Arc::clone(scene), state: Arc::from([2; 8]), image: Some(Arc::from([3; 8])) }
    }

    fn update() -> Update {
        moment(&Arc::from([1; 8]))
    }

    fn kinds(messages: &[Arc<[u8]>]) -> Vec<u8> {
        messages.iter().map(|message| message[0]).collect()
    }

    /// A page that has shown its first updates within a moment.
    fn known(scene: &Arc<[u8]>) -> Link {
        let mut link = Link::default();
        for _ in 0..8 {
            link.messages(&moment(scene), 0.0);
            link.drawn(0.01);
        }
        assert_eq!(link.image_size.level(), 0);
        link
    }

    #[test]
    fn a_new_page_gets_the_scene_then_an_image_then_what_the_scene_left_out() {
        let header = serde_json::json!({ "title": "field", "pipeline": [1, 2], "contenders": [{ "name": "mc", "parameters": [3] }] });
        let scene: Arc<[u8]> = MessageBuilder::new(MessageKind::Scene, &header).unwrap().finish().into();
        let mut link = Link::default();
        let first = link.messages(&moment(&scene), 0.0);
        assert_eq!(kinds(&first), [1, 2], "no image before the page has shown that it draws");
        let brief = Message::read(&first[0]).unwrap().header;
        assert!(
            !brief.contains_key("pipeline") && brief["contenders"][0] == serde_json::json!({ "name": "mc" })
        );
        assert!(!link.is_ready(), "one at a time until it is known how fast the page is");
        link.drawn(0.3);
        assert_eq!(kinds(&link.messages(&moment(&scene), 0.3)), [3, 2]);
        link.drawn(0.6);
        let rest = link.messages(&moment(&scene), 0.6);
        assert_eq!(kinds(&rest), [1, 2]);
        assert_eq!(Message::read(&rest[0]).unwrap().header, *header.as_object().unwrap());
        link.drawn(1.5);
        assert_eq!(kinds(&link.messages(&moment(&scene), 1.6)), [3, 2]);
    }

    #[test]
    fn a_stalled_page_gets_two_updates_and_no_more() {
        let scene = Arc::from([1; 8]);
        let mut link = known(&scene);
        assert_eq!(kinds(&link.messages(&moment(&scene), 0.0)), [3, 2]);
        assert!(link.is_ready());
        assert_eq!(kinds(&link.messages(&moment(&scene), 0.1)), [3, 2], "it knows the scene");
        assert!(!link.is_ready());
        link.drawn(0.11);
        assert!(link.is_ready());
        (0..5).for_each(|_| link.drawn(0.12));
        assert_eq!(link.in_flight.len(), 0, "a page cannot gain room by saying too much");
        let mut stalled = Link::default();
        stalled.messages(&moment(&scene), 0.0);
        assert!(!stalled.is_ready(), "nor does one that never drew anything get more");
    }

    #[test]
    fn what_stands_still_is_sent_whole_once() {
        let scene = Arc::from([1; 8]);
        let mut link = known(&scene);
        assert!(!link.owes_rest(), "it was whole");
        for i in 1..=4 {
            link.messages(&moment(&scene), f64::from(100 * i));
            link.drawn(f64::from(100 * i) + 0.9);
        }
        assert!(link.image_size.level() > 0 && link.owes_rest());
        assert_eq!(kinds(&link.rest(&moment(&scene), 500.0)), [3, 2]);
        assert!(!link.owes_rest());
        link.drawn(505.0);
        assert!(!link.owes_rest() && link.is_ready());
    }

    #[test]
    fn a_new_page_that_stands_still_gets_everything() {
        let header = serde_json::json!({ "pipeline": [1, 2] });
        let scene: Arc<[u8]> = MessageBuilder::new(MessageKind::Scene, &header).unwrap().finish().into();
        let (mut link, update) = (Link::default(), moment(&scene));
        let mut all = vec![kinds(&link.messages(&update, 0.0))];
        for i in 1..10 {
            link.drawn(f64::from(i));
            if link.owes_rest() {
                all.push(kinds(&link.rest(&update, f64::from(i))));
            }
        }
        assert_eq!(all, [vec![1, 2], vec![3, 2], vec![1, 3, 2]]);
    }

    #[test]
    fn an_image_that_the_page_has_is_not_sent_again() {
        let update = update();
        let mut link = known(&update.scene);
        assert_eq!(kinds(&link.messages(&update, 1.0)), [3, 2]);
        link.drawn(1.01);
        let told = Update { state: Arc::from([2; 9]), ..update.clone() };
        assert_eq!(kinds(&link.messages(&told, 1.1)), [2]);
        assert!(!link.owes_rest());
        link.drawn(1.11);
        assert!(!link.owes_rest(), "it shows it already");
    }

    #[test]
    fn slow_links_get_fewer_images() {
        let scene = Arc::from([1; 8]);
        let (mut slow, mut fast) = (known(&scene), known(&scene));
        let mut num_images = [0, 0];
        for i in 1..=100 {
            let now_secs = f64::from(i);
            for (n, (link, took_secs)) in [(&mut slow, 0.9), (&mut fast, 0.02)].into_iter().enumerate() {
                num_images[n] += usize::from(kinds(&link.messages(&moment(&scene), now_secs)).contains(&3));
                link.drawn(now_secs + took_secs);
            }
        }
        assert_eq!(num_images[1], 100);
        assert!((20..=34).contains(&num_images[0]), "{num_images:?}");
    }

    #[test]
    fn only_fast_links_get_messages_as_they_are() {
        let header = serde_json::json!({ "text": "a".repeat(500) });
        let state: Arc<[u8]> = MessageBuilder::new(MessageKind::State, &header).unwrap().finish().into();
        let scene = Arc::from([1; 8]);
        let mut link = known(&scene);
        let size = |link: &mut Link| {
            let update = Update { state: Arc::clone(&state), image: None, ..moment(&scene) };
            link.messages(&update, 1.0)[0].len()
        };
        assert_eq!(size(&mut link), state.len());
        link.drawn(1.5);
        assert!(size(&mut link) < state.len() / 4);
    }
}
