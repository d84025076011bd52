//! The learned segmenter: a small network that has seen trees.
//!
//! A network labels the picture at a reduced, fixed size ([`letterbox`]); its answer is rounded to
//! likelihoods ([`likelihood`]), brought to the edges of the full picture ([`guided`]) and made a tree
//! of ([`labelling`]). In a photograph it looks at the foot of the tree [`again`]. What a network is fed and how its answer is read stands on its [`Card`], so that
//! users can bring their own. It runs in tract, which is built in, or in the user's ONNX Runtime.
//!
//! The paper (Argudo, Andújar & Chica 2017, *Tree Variations*, §4.3) uses a fully convolutional network
//! of 134 million parameters on pictures with alpha; ours is forty times smaller, sees photographs
//! too, and knows when it is unsure.
//!
//! Limits: a network does not say which of several trees in a photograph is meant.

mod again;
mod card;
mod guided;
mod labelling;
mod letterbox;
mod likelihood;
mod proto;
mod runtime;
mod session;

pub use card::Card;
pub use runtime::Runtime;

use super::{Provenance, SegmentError, Segmented, Segmenter, Source};
use crate::base::{Cancel, Digest, Hasher};
use crate::raster::{Image, Rect, Straight, opaque_bounds};
use card::CardError;
use guided::{PLANES, Window};
use labelling::{CutOut, OPAQUE};
use letterbox::Letterbox;
use proto::ProtoError;
use session::Sessions;
use std::borrow::Cow;
use std::sync::{Arc, OnceLock};

/// Raise it whenever the same answer of a network becomes other labels than before.
const POST_PROCESSING: u32 = 2;

/// Part of a picture that must be clear before its alpha says what is tree.
const LEAST_CLEAR: f64 = 0.002;

/// Windows that likelihoods are brought to edges in. Chosen on the hand-labelled pictures.
const WINDOW: Window = Window {
    radius: 2,
    epsilon: 1e-3,
};

/// The key that a card stands under in a model's metadata.
const METADATA_KEY: &str = "boscage";

/// Why a file is no segmentation model.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ModelError {
    /// The file is not read.
    #[error(transparent)]
    File(#[from] ProtoError),
    /// Nothing says how the model is to be fed.
    #[error("nothing describes it: neither a file of its name ending in .json nor its metadata")]
    Undescribed,
    /// What says so is wrong.
    #[error(transparent)]
    Card(#[from] CardError),
    /// The runtime does not take it.
    #[error(transparent)]
    Run(#[from] SegmentError),
}

/// A trained network that labels trees; clones share it.
#[derive(Clone)]
pub struct Learned(Arc<Network>);

struct Network {
    card: Card,
    digest: Digest,
    sessions: Sessions,
}

impl Learned {
    /// The network of `model`, an ONNX file, as `sidecar` or else its own metadata describes it.
    ///
    /// It is not run before the first picture. A model that is not known to be sound must have passed
    /// [`Learned::try_out`] in another process before it may run in this one: malformed ones make the
    /// runtimes crash, eat memory or never end.
    ///
    /// # Errors
    /// [`ModelError`] but for [`ModelError::Run`].
    pub fn new(model: Cow<'static, [u8]>, sidecar: Option<&[u8]>) -> Result<Self, ModelError> {
        let metadata = proto::metadata(&model, METADATA_KEY)?;
        let described = sidecar.or(metadata).ok_or(ModelError::Undescribed)?;
        let card = Card::from_json(described)?;
        Ok(Self(Arc::new(Network {
            digest: Hasher::new("segmentation model")
                .with(&model)
                .with(&card.to_json())
                .finish(),
            card,
            sessions: Sessions::new(model),
        })))
    }

    /// The network that comes with the program.
    ///
    /// # Errors
    /// As [`Learned::new`], where the program was built from a broken one.
    pub fn built_in() -> Result<Self, ModelError> {
        const MODEL: &[u8] = include_bytes!("../../../models/segmenter.onnx");
        static BUILT_IN: OnceLock<Result<Learned, ModelError>> = OnceLock::new();
        let built_in = BUILT_IN.get_or_init(|| Self::new(Cow::Borrowed(MODEL), None));
        built_in.clone()
    }

    /// What the model says of itself.
    pub fn card(&self) -> &Card {
        &self.0.card
    }

    /// The digest of the model's file and of what describes it.
    pub fn digest(&self) -> Digest {
        self.0.digest
    }

    /// The model's file.
    pub fn model(&self) -> &[u8] {
        self.0.sessions.model()
    }

    /// Runs the network on grey, on white and on noise.
    ///
    /// # Errors
    /// [`SegmentError::Model`] when it does not take what its card says, or gives something else.
    pub fn try_out(&self) -> Result<(), SegmentError> {
        let [height, width] = self.0.card.input.size;
        let count = width as usize * height as usize * self.0.card.channels();
        let mut random = crate::base::Seed(1).random();
        let noise = (0..count).map(|_| random.unit() as f32).collect();
        for tensor in [vec![0.5; count], vec![1.0; count], noise] {
            let answer = self.0.sessions.run(&self.0.card, &tensor)?;
            likelihood::likelihoods(&answer, &self.0.card)?;
        }
        Ok(())
    }
}

impl Segmenter for Learned {
    fn name(&self) -> &'static str {
        "learned"
    }

    fn key(&self) -> String {
        let runtime = Runtime::of_process().map_or("none", Runtime::name);
        format!("learned {POST_PROCESSING}, {}, {runtime}", self.0.digest)
    }

    fn model(&self) -> Option<Digest> {
        Some(self.0.digest)
    }

    fn prepare(&self) {
        self.0.sessions.prepare(&self.0.card);
    }

    fn segmented(
        &self,
        image: &Image<Straight>,
        cancel: &Cancel,
    ) -> Result<Segmented, SegmentError> {
        cancel.check()?;
        let clear = image.pixels().iter().filter(|p| p.alpha() < OPAQUE).count();
        let has_alpha = clear as f64 >= LEAST_CLEAR * image.pixels().len() as f64;
        let shown = if has_alpha {
            opaque_bounds(&image.map(|p| p.alpha() >= OPAQUE))
        } else {
            Some(image.rect())
        };
        let provenance = |confidence| Provenance {
            source: Source::Learned,
            confidence: Some(confidence),
            reason: None,
        };
        let Some(crop) = shown else {
            let labels = image.map(|_| super::Label::Background);
            return Ok(Segmented {
                labels,
                provenance: provenance(1.0),
            });
        };
        let whole = || self.looked_at(image, crop, has_alpha, cancel);
        let (whole, cut, fine) = if has_alpha {
            // What alpha cuts out the rules need no network to judge.
            let rules = || CutOut::by_alpha(image, crop, cancel);
            let (whole, cut) = rayon::join(whole, rules);
            let whole = whole?;
            let fine = whole.fine(image, has_alpha);
            (whole, cut?, fine)
        } else {
            let whole = whole()?;
            let fine = self.fine_of_photo(image, &whole, cancel)?;
            let cut = CutOut::by_likelihood(image, crop, &fine, cancel)?;
            (whole, cut, fine)
        };
        let calibration = &self.0.card.calibration;
        let sure = calibration.sure_background();
        let certainty = likelihood::certainty(&whole.coarse, whole.letterbox.inner, sure);
        cancel.check()?;
        Ok(Segmented {
            labels: labelling::labelled(image, crop, &cut, &fine),
            provenance: provenance(calibration.confidence_of(certainty)),
        })
    }
}

/// A part of a picture as the network sees it.
struct Look {
    letterbox: Letterbox,
    /// The part at the network's size.
    reduced: Image<[f32; 4]>,
    /// What the network says of it, rounded.
    coarse: Image<[f32; PLANES]>,
}

impl Look {
    /// What the network says at the size of the part, brought to its edges; with clear ground, of what
    /// is opaque.
    fn fine(&self, image: &Image<Straight>, has_alpha: bool) -> Image<[f32; PLANES]> {
        let mut of_tree = Cow::Borrowed(&self.coarse);
        if has_alpha {
            likelihood::of_opaque(of_tree.to_mut());
        }
        let functions = guided::fitted(&self.reduced, &of_tree, WINDOW);
        guided::applied(&functions, &self.letterbox, image)
    }
}

impl Learned {
    fn looked_at(
        &self,
        image: &Image<Straight>,
        part: Rect,
        has_alpha: bool,
        cancel: &Cancel,
    ) -> Result<Look, SegmentError> {
        let [height, width] = self.0.card.input.size;
        let letterbox = Letterbox::new(part, width, height);
        let reduced = letterbox.reduced(image);
        cancel.check()?;
        let tensor = letterbox.tensor(&reduced, &self.0.card, has_alpha);
        let answer = self.0.sessions.run(&self.0.card, &tensor)?;
        cancel.check()?;
        Ok(Look {
            letterbox,
            reduced,
            coarse: likelihood::likelihoods(&answer, &self.0.card)?,
        })
    }

    /// What the network says of a photograph that it saw whole and whose tree's foot it sees again; with
    /// clear ground there is no need: alpha gives trunks their edges.
    fn fine_of_photo(
        &self,
        image: &Image<Straight>,
        whole: &Look,
        cancel: &Cancel,
    ) -> Result<Image<[f32; PLANES]>, SegmentError> {
        let part = again::foot(&whole.coarse, &whole.letterbox);
        let closer = || -> Result<Option<_>, SegmentError> {
            let Some(part) = part else { return Ok(None) };
            let look = self.looked_at(image, part, false, cancel)?;
            Ok(Some((part, look.fine(image, false))))
        };
        let (mut fine, closer) = rayon::join(|| whole.fine(image, false), closer);
        if let Some((part, closer)) = closer? {
            again::put(&mut fine, whole.letterbox.crop, &closer, part);
        }
        Ok(fine)
    }
}
