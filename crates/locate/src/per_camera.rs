//! A robot's cameras look one after the other.

/// What belongs to the cameras that did not take the present image.
#[derive(Debug, Clone, Default)]
pub(crate) struct OtherCameras<T>(Vec<(usize, T)>);

impl<T> OtherCameras<T> {
    /// None: the robot has one camera so far.
    pub const fn none() -> Self {
        Self(Vec::new())
    }

    /// The next image is of the camera `to`: lays aside what belongs to the camera `from`, and takes up what belongs to that one, or something
    /// new if it is its first image.
    pub fn look_through(&mut self, now: &mut T, (from, to): (usize, usize), new: impl FnOnce(&T) -> T) {
        if from == to {
            return;
        }
        let known = self.0.iter().position(|(index, _)| *index == to);
        let next = known.map_or_else(|| new(now), |i| self.0.swap_remove(i).1);
        self.0.push((from, std::mem::replace(now, next)));
    }

    /// That of a camera, if it has taken an image and is not the present one.
    pub fn get(&self, camera_index: usize) -> Option<&T> {
        self.iter().find(|(index, _)| *index == camera_index).map(|(_, of)| of)
    }

    /// With the index of each camera.
    pub fn iter(&self) -> impl Iterator<Item = (usize, &T)> {
        self.0.iter().map(|(index, of)| (*index, of))
    }

    /// To change them.
    pub fn values_mut(&mut self) -> impl Iterator<Item = &mut T> {
        self.0.iter_mut().map(|(_, of)| of)
    }

    /// Sets that of a camera that is not the present one.
    pub fn set(&mut self, camera_index: usize, value: T) {
        match self.0.iter_mut().find(|(index, _)| *index == camera_index) {
            Some((_, of)) => *of = value,
            None => self.0.push((camera_index, value)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_camera_keeps_its_own() {
        let (mut now, mut others) = ("top".to_owned(), OtherCameras::none());
        others.look_through(&mut now, (0, 0), |_| unreachable!());
        others.look_through(&mut now, (0, 3), |top| format!("beside {top}"));
        assert_eq!((now.as_str(), others.get(0).map(String::as_str)), ("beside top", Some("top")));
        now.push('!');
        others.look_through(&mut now, (3, 0), |_| unreachable!());
        assert_eq!((now.as_str(), others.get(3).map(String::as_str)), ("top", Some("beside top!")));
        others.set(3, "back".to_owned());
        assert_eq!(others.iter().collect::<Vec<_>>(), [(3, &"back".to_owned())]);
    }
}
