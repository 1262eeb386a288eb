//! A moment of a run, to be turned into messages.

use std::sync::Arc;

use serde_json::Value;
use visloc_core::GrayImage;
use visloc_io::image_codec::encode_jpeg;

use crate::{MessageBuilder, MessageError, MessageKind, StudioError, Update};

/// Quality of the images that are sent.
const JPEG_QUALITY: u8 = 80;

/// What a message is made of.
pub(super) struct Parts {
    pub header: Value,
    pub arrays: Vec<(&'static str, Vec<f64>)>,
}

impl Parts {
    fn message(self, kind: MessageKind) -> Result<MessageBuilder, MessageError> {
        let mut message = MessageBuilder::new(kind, &self.header)?;
        for (name, values) in self.arrays {
            message.floats(name, values);
        }
        Ok(message)
    }
}

/// A moment of a run, copied, so that messages can be made of it while the run goes on.
pub struct SlamMoment {
    pub(super) scene: Arc<[u8]>,
    pub(super) state: Parts,
    pub(super) image: Parts,
    pub(super) pixels: GrayImage,
}

impl SlamMoment {
    /// The messages. `image` is the one of this frame, if it has been made before.
    ///
    /// # Errors
    /// If it cannot be encoded.
    pub fn update(self, image: Option<Arc<[u8]>>) -> Result<Update, StudioError> {
        let Self { scene, state, image: parts, pixels } = self;
        let state = state.message(MessageKind::State)?.finish().into();
        let image = match image {
            Some(image) => image,
            None => {
                let mut message = parts.message(MessageKind::Image)?;
                message.bytes("jpeg", &jpeg(&pixels)?);
                message.finish().into()
            }
        };
        Ok(Update { scene, state, image: Some(image) })
    }
}

impl SlamMoment {
    /// The messages without the picture.
    pub(crate) fn without_picture(self) -> Result<Update, StudioError> {
        let image = self.image.message(MessageKind::Image)?.finish().into();
        let state = self.state.message(MessageKind::State)?.finish().into();
        Ok(Update { scene: self.scene, state, image: Some(image) })
    }
}

fn jpeg(pixels: &GrayImage) -> Result<Vec<u8>, StudioError> {
    Ok(encode_jpeg(&pixels.to_rgb(), JPEG_QUALITY)?)
}
