//! The segmenter that is asked unless somebody says otherwise: the network, and the rules where there
//! is no network, it fails, or it is unsure.

use super::{Classical, Learned, SegmentError, Segmented, Segmenter};
use crate::base::{Cancel, Digest};
use crate::raster::{Image, Straight};
use std::sync::OnceLock;

/// Confidence below which the rules are asked instead: about what they reach on cut-out trees that they
/// were not made for.
const LEAST_CONFIDENCE: f32 = 0.5;

/// The same for photographs with their background, in which the rules see next to nothing.
const LEAST_OF_PHOTO: f32 = 0.35;

/// First the network, then the rules.
#[derive(Clone)]
pub struct Auto {
    learned: Result<Learned, String>,
}

/// The segmenter of the process: [`Auto`] with the network that is built in.
pub fn standard() -> &'static Auto {
    static STANDARD: OnceLock<Auto> = OnceLock::new();
    STANDARD.get_or_init(|| Auto {
        learned: Learned::built_in().map_err(|error| error.to_string()),
    })
}

impl Auto {
    /// With `learned` as the network.
    pub fn with(learned: Learned) -> Self {
        Self {
            learned: Ok(learned),
        }
    }

    /// The network, or why there is none.
    ///
    /// # Errors
    /// The reason, one line.
    pub fn learned(&self) -> Result<&Learned, &str> {
        self.learned.as_ref().map_err(String::as_str)
    }
}

impl Segmenter for Auto {
    fn name(&self) -> &'static str {
        "auto"
    }

    fn key(&self) -> String {
        match &self.learned {
            Ok(learned) => format!(
                "auto {LEAST_CONFIDENCE} {LEAST_OF_PHOTO}, {}, {}",
                learned.key(),
                Classical.key()
            ),
            Err(_) => format!("auto, {}", Classical.key()),
        }
    }

    fn model(&self) -> Option<Digest> {
        self.learned.as_ref().ok().map(Learned::digest)
    }

    fn prepare(&self) {
        if let Ok(learned) = &self.learned {
            learned.prepare();
        }
    }

    fn segmented(
        &self,
        image: &Image<Straight>,
        cancel: &Cancel,
    ) -> Result<Segmented, SegmentError> {
        let (confidence, reason) = match &self.learned {
            Err(reason) => (None, format!("there is no network: {reason}")),
            Ok(learned) => match learned.segmented(image, cancel) {
                Err(SegmentError::Cancelled(cancelled)) => return Err(cancelled.into()),
                Err(error) => (None, error.to_string()),
                Ok(found) => match found.provenance.confidence {
                    Some(confidence) if confidence < least(image) => {
                        let least = least(image);
                        let reason = format!(
                            "the network was unsure: confidence {confidence:.2} is below {least}"
                        );
                        (Some(confidence), reason)
                    }
                    _ => return Ok(found),
                },
            },
        };
        let mut found = Classical.segmented(image, cancel)?;
        found.provenance.confidence = confidence;
        found.provenance.reason = Some(reason);
        Ok(found)
    }
}

/// The confidence that the network must have.
fn least(image: &Image<Straight>) -> f32 {
    match image.pixels().iter().any(|pixel| pixel.alpha() < 128) {
        true => LEAST_CONFIDENCE,
        false => LEAST_OF_PHOTO,
    }
}
