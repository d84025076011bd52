//! What a model says of itself: the sidecar `NAME.json` beside `NAME.onnx`, or the same JSON in the
//! model's own metadata under the key `boscage`.
//!
//! ```json
//! {"format": 1, "name": "trees", "version": "1", "licence": "MIT",
//!  "input": {"name": "image", "size": [256, 256], "channels": ["r","g","b","a","has_alpha"],
//!            "mean": [0,0,0,0,0], "std": [1,1,1,1,1], "padding": "zero"},
//!  "output": {"name": "logits", "classes": ["background","trunk","crown"], "activation": "logits"},
//!  "calibration": {"temperature": 1.0, "confidence": {"estimates": "iou",
//!            "features": ["certainty", "trunk_certainty"], "not_background": 0.9,
//!            "coefficients": [-4, 5, 1]}}}
//! ```
//!
//! Sizes are height, width. Channels and classes may stand in any order; alpha channels may be left
//! out. Keys that are not known are passed over.

use serde::{Deserialize, Serialize};

/// Longest side of a network's input: 64 MB for each channel. Larger ones are slips of the pen.
const LARGEST_SIDE: u32 = 4096;

/// Shortest side: a trunk is 2 % of the tree's height.
const SMALLEST_SIDE: u32 = 32;

/// Why a card is refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CardError {
    /// It is no such JSON.
    #[error("its description is no model card: {0}")]
    Json(String),
    /// It is of another version.
    #[error("its description has format {0}; this version reads format 1")]
    Format(u32),
    /// A number or list in it makes no sense.
    #[error("its description is wrong: {0}")]
    Value(String),
}

/// A channel of the input.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Channel {
    /// Red, sRGB, 0 to 1; 0 where the picture is clear.
    R,
    /// Green.
    G,
    /// Blue.
    B,
    /// Alpha, 0 to 1; 0 everywhere in a picture without clear ground.
    A,
    /// 1 everywhere in a picture with clear ground, else 0.
    HasAlpha,
}

/// A class of the output.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Class {
    /// No part of the tree.
    Background,
    /// Stem and limbs below the foliage.
    Trunk,
    /// Foliage and what is in it.
    Crown,
}

/// What the input holds beside the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Padding {
    /// Nothing: 0 in all channels, before they are normalised.
    #[default]
    Zero,
    /// The picture's border, drawn out.
    Edge,
}

/// What the output's numbers are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Activation {
    /// Logarithms of relative likelihoods.
    #[default]
    Logits,
    /// Likelihoods of sum 1.
    Softmax,
}

/// The input: float32, 1 × channels × height × width.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Input {
    /// Its name in the graph.
    pub name: String,
    /// Height and width.
    pub size: [u32; 2],
    /// What each plane holds.
    pub channels: Vec<Channel>,
    /// What is subtracted from each channel.
    #[serde(default)]
    pub mean: Vec<f32>,
    /// What each channel is then divided by.
    #[serde(default)]
    pub std: Vec<f32>,
    /// What stands beside the picture.
    #[serde(default)]
    pub padding: Padding,
}

/// The output: float32, 1 × 3 × height × width.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Output {
    /// Its name in the graph.
    pub name: String,
    /// What each plane stands for.
    pub classes: Vec<Class>,
    /// What the numbers are.
    #[serde(default)]
    pub activation: Activation,
}

/// What the network's certainty has been worth on pictures that were held out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Calibration {
    /// What logits are divided by.
    pub temperature: f32,
    /// How good labels are expected to be; none: as good as they are certain.
    pub confidence: Option<Confidence>,
}

impl Default for Calibration {
    fn default() -> Self {
        Self {
            temperature: 1.0,
            confidence: None,
        }
    }
}

/// A model card.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Card {
    /// Version of this format: 1.
    pub format: u32,
    /// The model's name.
    #[serde(default)]
    pub name: String,
    /// Its version.
    #[serde(default)]
    pub version: String,
    /// Under which licence it may be used.
    #[serde(default)]
    pub licence: String,
    /// The input.
    pub input: Input,
    /// The output.
    pub output: Output,
    /// Calibration on pictures that were held out.
    #[serde(default)]
    pub calibration: Calibration,
}

impl Card {
    /// Reads and checks a card.
    ///
    /// # Errors
    /// [`CardError`].
    pub fn from_json(bytes: &[u8]) -> Result<Self, CardError> {
        /// Read by itself: a card of another version may look quite different.
        #[derive(Deserialize)]
        struct Versioned {
            format: u32,
        }
        let json = |error: serde_json::Error| CardError::Json(error.to_string());
        let Versioned { format } = serde_json::from_slice(bytes).map_err(json)?;
        if format != 1 {
            return Err(CardError::Format(format));
        }
        let mut card: Self = serde_json::from_slice(bytes).map_err(json)?;
        card.check()?;
        Ok(card)
    }

    /// The card as JSON.
    pub fn to_json(&self) -> Vec<u8> {
        serde_json::to_vec(self).unwrap_or_else(|_| unreachable!("cards hold numbers and text"))
    }

    /// Number of the input's channels.
    pub fn channels(&self) -> usize {
        self.input.channels.len()
    }

    /// Rows and columns of input and output.
    pub fn size(&self) -> (usize, usize) {
        let [height, width] = self.input.size;
        (height as usize, width as usize)
    }

    /// The plane of the output that stands for `class`.
    pub fn plane(&self, class: Class) -> usize {
        let classes = &self.output.classes;
        classes
            .iter()
            .position(|own| *own == class)
            .unwrap_or_else(|| unreachable!("a card names all classes"))
    }

    fn check(&mut self) -> Result<(), CardError> {
        let wrong = |what: String| Err(CardError::Value(what));
        let [height, width] = self.input.size;
        let sides = SMALLEST_SIDE..=LARGEST_SIDE;
        if !sides.contains(&height) || !sides.contains(&width) {
            let (least, most) = (SMALLEST_SIDE, LARGEST_SIDE);
            return wrong(format!(
                "an input of {height}×{width}; sides are {least} to {most}"
            ));
        }
        self.check_channels()?;
        let classes = &self.output.classes;
        let all = [Class::Background, Class::Trunk, Class::Crown];
        if classes.len() != all.len() || !all.iter().all(|class| classes.contains(class)) {
            return wrong("its classes must be background, trunk and crown".to_owned());
        }
        let temperature = self.calibration.temperature;
        if !(temperature.is_finite() && temperature > 0.0) {
            return wrong(format!("a temperature of {temperature}"));
        }
        match &self.calibration.confidence {
            Some(confidence) => confidence.check(),
            None => Ok(()),
        }
    }

    fn check_channels(&mut self) -> Result<(), CardError> {
        let wrong = |what: &str| Err(CardError::Value(what.to_owned()));
        let Input {
            channels,
            mean,
            std,
            ..
        } = &mut self.input;
        let is_twice = |i: usize| channels[..i].contains(&channels[i]);
        let has_colours = [Channel::R, Channel::G, Channel::B]
            .iter()
            .all(|colour| channels.contains(colour));
        if !has_colours || (0..channels.len()).any(is_twice) {
            return wrong("its channels must be r, g and b, perhaps a and has_alpha, each once");
        }
        if mean.is_empty() {
            *mean = vec![0.0; channels.len()];
        }
        if std.is_empty() {
            *std = vec![1.0; channels.len()];
        }
        if mean.len() != channels.len() || std.len() != channels.len() {
            return wrong("mean and std need a number for each channel");
        }
        let divides = |std: &f32| std.is_finite() && *std > 0.0;
        if !mean.iter().all(|mean| mean.is_finite()) || !std.iter().all(divides) {
            return wrong("mean must be finite and std positive");
        }
        Ok(())
    }
}

fn sure_background() -> f32 {
    0.9
}

/// How certain a network was of one picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Certainty {
    /// The mean likelihood of the likeliest class, of the pixels that may be tree.
    pub overall: f32,
    /// The mean likelihood of trunk, of the pixels where trunk is likeliest; 0.5 if there are none.
    pub trunk: f32,
}

/// What a confidence is computed from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Feature {
    /// [`Certainty::overall`].
    Certainty,
    /// [`Certainty::trunk`].
    TrunkCertainty,
}

/// What a confidence means.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Estimate {
    /// The mean overlap (intersection over union) of crown and trunk with those of a person.
    Iou,
}

/// How good labels are expected to be: 1 / (1 + exp(−(c₀ + c₁·feature₁ + …))).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Confidence {
    /// What it means.
    pub estimates: Estimate,
    /// What it is computed from.
    pub features: Vec<Feature>,
    /// Likelihood of background from which on a pixel has no part in [`Certainty::overall`].
    #[serde(default = "sure_background")]
    pub not_background: f32,
    /// The constant, and one number for each feature.
    pub coefficients: Vec<f64>,
}

impl Confidence {
    fn check(&self) -> Result<(), CardError> {
        let is_finite = self.coefficients.iter().all(|c| c.is_finite());
        if self.coefficients.len() == self.features.len() + 1 && is_finite {
            Ok(())
        } else {
            let what = "confidence needs a constant and a number for each feature";
            Err(CardError::Value(what.to_owned()))
        }
    }

    fn of(&self, certainty: Certainty) -> f32 {
        let features = self.features.iter().map(|feature| match feature {
            Feature::Certainty => f64::from(certainty.overall),
            Feature::TrunkCertainty => f64::from(certainty.trunk),
        });
        let terms = features.zip(&self.coefficients[1..]).map(|(x, c)| x * c);
        (1.0 / (1.0 + libm::exp(-(self.coefficients[0] + terms.sum::<f64>())))) as f32
    }
}

impl Calibration {
    /// See [`Confidence::not_background`].
    pub fn sure_background(&self) -> f32 {
        match &self.confidence {
            Some(confidence) => confidence.not_background,
            None => sure_background(),
        }
    }

    /// What labels of this certainty are worth, 0 to 1.
    pub fn confidence_of(&self, certainty: Certainty) -> f32 {
        match &self.confidence {
            Some(confidence) => confidence.of(certainty),
            None => certainty.overall,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use serde_json::{Value, json};

    fn sound() -> Value {
        json!({
            "format": 1, "name": "t", "version": "1", "licence": "MIT", "trained_by": "someone",
            "input": {"name": "image", "size": [64, 96], "channels": ["r", "g", "b", "a", "has_alpha"],
                "mean": [0, 0, 0, 0, 0], "std": [1, 1, 1, 1, 1], "padding": "zero"},
            "output": {"name": "logits", "classes": ["crown", "background", "trunk"], "activation": "logits"},
            "calibration": {"temperature": 1.5, "confidence": {
                "estimates": "iou", "not_background": 0.9, "features": ["certainty", "trunk_certainty"],
                "coefficients": [-1, 2, 0.5]}},
        })
    }

    fn read(card: &Value) -> Result<Card, CardError> {
        Card::from_json(card.to_string().as_bytes())
    }

    #[test]
    fn a_card_is_read_with_its_defaults() {
        let card = read(&sound()).unwrap();
        assert_eq!((card.size(), card.channels()), ((64, 96), 5));
        assert_eq!(card.plane(Class::Crown), 0);
        let short = json!({"format": 1,
            "input": {"name": "x", "size": [32, 32], "channels": ["b", "g", "r"]},
            "output": {"name": "y", "classes": ["background", "trunk", "crown"]}});
        let short = read(&short).unwrap();
        assert_eq!(
            (short.input.mean, short.input.std),
            (vec![0.0; 3], vec![1.0; 3])
        );
        let sure = Certainty {
            overall: 0.7,
            trunk: 0.5,
        };
        assert_eq!(short.calibration.confidence_of(sure), 0.7);
    }

    #[test]
    fn confidence_is_the_logistic_function_of_certainty() {
        let calibration = read(&sound()).unwrap().calibration;
        let sure = Certainty {
            overall: 0.9,
            trunk: 0.8,
        };
        let expected = 1.0 / (1.0 + (-(-1.0 + 1.8 + 0.4f64)).exp());
        assert!((f64::from(calibration.confidence_of(sure)) - expected).abs() < 1e-6);
    }

    #[test]
    fn wrong_cards_are_refused_with_the_reason() {
        let changed = |pointer: &str, value: Value| {
            let mut card = sound();
            *card.pointer_mut(pointer).unwrap() = value;
            read(&card).unwrap_err().to_string()
        };
        for (pointer, value, reason) in [
            ("/format", json!(2), "format 2"),
            ("/input/size", json!([8, 64]), "8×64"),
            ("/input/size", json!([64]), "no model card"),
            (
                "/input/channels",
                json!(["r", "g", "x", "a", "b"]),
                "unknown variant `x`",
            ),
            (
                "/input/channels",
                json!(["r", "g", "g", "b", "a"]),
                "each once",
            ),
            ("/input/mean", json!([0, 0, 0]), "number for each channel"),
            ("/input/std", json!([1, 1, 0, 1, 1]), "std positive"),
            (
                "/input/padding",
                json!("reflect"),
                "unknown variant `reflect`",
            ),
            (
                "/output/classes",
                json!(["crown", "trunk", "trunk"]),
                "classes",
            ),
            ("/output/activation", json!("sigmoid"), "unknown variant"),
            ("/calibration/temperature", json!(0), "temperature of 0"),
            (
                "/calibration/confidence/coefficients",
                json!([0.6, 0.2]),
                "each feature",
            ),
        ] {
            let told = changed(pointer, value);
            assert!(told.contains(reason), "{pointer}: {told}");
        }
    }

    proptest! {
        #[test]
        fn any_bytes_are_read_without_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = Card::from_json(&bytes);
        }

        #[test]
        fn any_change_of_a_byte_is_read_without_panic(at in 0usize..500, byte in any::<u8>()) {
            let mut text = sound().to_string().into_bytes();
            let at = at % text.len();
            text[at] = byte;
            let _ = Card::from_json(&text);
        }
    }
}
