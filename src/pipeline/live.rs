//! A crown while it is being made: after each edit only what the edit touches is computed anew.
//!
//! The steps of [`super::crown()`] are kept with what they were made from. A new k needs another sheet,
//! mesh and radius; a new ρ only the last step; a stroke of the brush everything, which is done on a
//! thinned picture first ([`Quality::Coarse`]). Foliage, which takes most of the time, waits until the
//! hand rests ([`Quality::Full`]); until then the crown wears the foliage it had, or the photograph,
//! laid on from the front and mirrored behind.
//!
//! A [`LiveCrown`] is a handful of shared parts: jobs work on copies, and what a job has found is taken
//! up again by [`LiveCrown::adopt`]. A `Full` crown is, to the byte, what [`super::crown()`] makes.

use super::crown::{
    ColoredSurface, CrownError, CrownSettings, CrownShape, Inflated, Silhouette, base_radius,
    check, colored, shape_of_regions,
};
use super::request::{CrownRequest, Regions, Thinning};
use crate::base::{Cancel, Progress, Seed};
use crate::crown::{InflationError, ReliefSettings, height_cubemap, radius_with_relief};
use crate::paint::TiledMask;
use crate::raster::{Cubemap, Image, Mask, Straight};
use crate::scene::Crown;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// How good a crown must be, and so how long it takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quality {
    /// From a thinned picture, at a quarter of the texels: while a mask is painted or k is dragged.
    Coarse,
    /// Its own size, with the foliage that is there: while ρ is dragged, and when the hand slows down.
    Fine,
    /// As [`super::crown()`] makes it.
    Full,
}

/// What a crown is made from. Pictures are told apart by where they lie, labels by what they are.
#[derive(Debug, Clone)]
pub struct LiveInput {
    /// The photograph.
    pub photo: Arc<Image<Straight>>,
    /// Its labels.
    pub labels: Arc<TiledMask>,
}

impl PartialEq for LiveInput {
    fn eq(&self, other: &Self) -> bool {
        let same_labels = Arc::ptr_eq(&self.labels, &other.labels) || self.labels == other.labels;
        Arc::ptr_eq(&self.photo, &other.photo) && same_labels
    }
}

/// A crown and what of it is new.
#[derive(Debug, Clone)]
pub struct LiveResult {
    /// The crown.
    pub crown: Arc<Crown>,
    /// Another number when the colours may be others.
    pub color_version: u64,
    /// The line around it.
    pub silhouette: Arc<Silhouette>,
    /// The least and the largest k along it; unknown of several regions.
    pub k: Option<[f64; 2]>,
    /// The labels of the sub-crowns there are.
    pub sub_crowns: Vec<u8>,
}

/// Longer side of a thinned crown, pixels, and texels of its cubemaps.
const COARSE_PX: u32 = 192;
const COARSE_SIZE: u32 = 128;

/// Steps by which a place beside the crown is drawn in until it lies on foliage.
const INWARDS: u32 = 24;

/// Something that was computed, with what it was computed from.
#[derive(Debug)]
struct Slot<K, V>(Option<Arc<Made<K, V>>>);

#[derive(Debug)]
struct Made<K, V> {
    key: K,
    value: V,
    version: u64,
}

impl<K, V> Clone for Slot<K, V> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<K, V> Default for Slot<K, V> {
    fn default() -> Self {
        Self(None)
    }
}

/// Numbers things in the order in which they were made, in all copies.
static MADE: AtomicU64 = AtomicU64::new(1);

impl<K: PartialEq, V> Slot<K, V> {
    /// What belongs to `key`: as it is, or made by `make`.
    fn get(
        &mut self,
        key: K,
        make: impl FnOnce(&K) -> Result<V, CrownError>,
    ) -> Result<Arc<Made<K, V>>, CrownError> {
        if let Some(made) = self.0.as_ref().filter(|made| made.key == key) {
            return Ok(Arc::clone(made));
        }
        let value = make(&key)?;
        let version = MADE.fetch_add(1, Ordering::Relaxed);
        let made = Arc::new(Made {
            key,
            value,
            version,
        });
        self.0 = Some(Arc::clone(&made));
        Ok(made)
    }

    /// Takes what `other` has when it was made later.
    fn adopt(&mut self, other: Self) {
        let version = |slot: &Self| slot.0.as_ref().map_or(0, |made| made.version);
        if version(&other) > version(self) {
            *self = other;
        }
    }
}

/// Size and envelope: what an inflation depends on.
type VolumeKey = (u64, u32, crate::crown::Envelope);

/// What a shape depends on beside the mask.
#[derive(Debug, Clone, PartialEq)]
struct ShapeKey {
    source: u64,
    settings: CrownSettings,
    depths: BTreeMap<u8, f64>,
}

impl ShapeKey {
    fn of(source: &Made<LiveInput, Source>, request: &CrownRequest) -> Self {
        Self {
            source: source.version,
            settings: of_shape(&request.settings),
            depths: match source.value.regions.is_parted() {
                true => request.sub_crown_depths.clone(),
                false => BTreeMap::new(),
            },
        }
    }
}

/// A photograph and its regions, thinned or not.
struct Source {
    photo: Arc<Image<Straight>>,
    regions: Regions,
    thinning: Thinning,
}

/// The steps to a surface without relief.
#[derive(Clone, Default)]
struct Shapes {
    source: Slot<LiveInput, Source>,
    inflated: Slot<VolumeKey, Inflated>,
    shape: Slot<ShapeKey, (CrownShape, Cubemap<f32>)>,
}

/// A shape and its radius.
type MadeShape = Made<ShapeKey, (CrownShape, Cubemap<f32>)>;

/// What foliage depends on.
#[derive(Debug, Clone, PartialEq)]
struct FoliageKey {
    input: LiveInput,
    shape: u64,
    settings: CrownSettings,
    seed: Seed,
}

/// The steps of a crown, kept.
#[derive(Clone, Default)]
pub struct LiveCrown {
    coarse: Shapes,
    fine: Shapes,
    foliage: Slot<FoliageKey, Cubemap<Straight>>,
    projected: Slot<u64, Cubemap<Straight>>,
    height: Slot<(u64, ReliefSettings), Cubemap<f32>>,
}

impl std::fmt::Debug for LiveCrown {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("LiveCrown").finish_non_exhaustive()
    }
}

impl LiveCrown {
    /// The crown of `input`, at most as good as `quality`. Stages of `progress`: those of
    /// [`super::crown()`] that are not kept.
    ///
    /// # Errors
    /// [`CrownError`]. What was found before an error is kept.
    pub fn update(
        &mut self,
        input: &LiveInput,
        request: &CrownRequest,
        quality: Quality,
        progress: Progress<'_>,
        cancel: &Cancel,
    ) -> Result<LiveResult, CrownError> {
        let mut request = request.clone();
        let shapes = match quality {
            Quality::Coarse => {
                request.settings.size = request.settings.size.min(COARSE_SIZE);
                &mut self.coarse
            }
            Quality::Fine | Quality::Full => &mut self.fine,
        };
        let source = shapes.source(input, quality)?;
        check(
            &source.value.photo,
            &source.value.regions.union,
            &request.settings,
        )?;
        let shape = shapes.shape(&source, &request, progress, cancel)?;
        let silhouette = shapes.silhouette(&source);
        let (color, color_version) = match quality {
            Quality::Full => {
                self.foliage(input, &source.value, &shape, &request, progress, cancel)?
            }
            Quality::Coarse | Quality::Fine => self.color_at_hand(&source, &shape, cancel)?,
        };
        let stage = progress.stage("relief", 1);
        let settings = &request.settings;
        let height = self.height.get((color_version, settings.relief), |_| {
            Ok(height_cubemap(&color, &settings.relief, cancel)?)
        })?;
        let (shape, base_m) = &shape.value;
        let steepest = settings.relief.steepest;
        let radius_m = radius_with_relief(base_m, &height.value, settings.rho, steepest);
        stage.advance();
        drop(stage);
        let crown = Crown {
            center_m: shape.frame.center_m,
            radius_m,
            color,
            height: height.value.clone(),
            base_mesh: shape.base_mesh.clone(),
            cover: settings.cover as f32,
            stem: settings.stem,
        };
        Ok(LiveResult {
            crown: Arc::new(crown),
            color_version,
            silhouette,
            k: shape.k,
            sub_crowns: source.value.regions.sub_crowns(),
        })
    }

    /// Whether a new k of this picture needs no inflation: then [`Quality::Fine`] is quick.
    pub fn is_inflated(&self, input: &LiveInput) -> bool {
        let source = self.fine.source.0.as_ref();
        let inflated = self.fine.inflated.0.as_ref();
        source.is_some_and(|source| {
            source.key == *input && inflated.is_some_and(|made| made.key.0 == source.version)
        })
    }

    /// Whether the surface before relief is known: then [`Quality::Fine`] takes no longer than
    /// [`Quality::Coarse`].
    pub fn is_shaped(&self, input: &LiveInput, request: &CrownRequest) -> bool {
        let source = self.fine.source.0.as_ref();
        let shape = self.fine.shape.0.as_ref();
        source.zip(shape).is_some_and(|(source, shape)| {
            source.key == *input && shape.key == ShapeKey::of(source, request)
        })
    }

    /// Takes up what a copy of this one has found.
    pub fn adopt(&mut self, copy: Self) {
        self.coarse.adopt(copy.coarse);
        self.fine.adopt(copy.fine);
        self.foliage.adopt(copy.foliage);
        self.projected.adopt(copy.projected);
        self.height.adopt(copy.height);
    }

    /// The foliage that belongs to a shape.
    fn foliage(
        &mut self,
        input: &LiveInput,
        source: &Source,
        shape: &MadeShape,
        request: &CrownRequest,
        progress: Progress<'_>,
        cancel: &Cancel,
    ) -> Result<(Cubemap<Straight>, u64), CrownError> {
        let key = FoliageKey {
            input: input.clone(),
            shape: shape.version,
            settings: without_relief(&request.settings),
            seed: request.seed,
        };
        let made = self.foliage.get(key, |key| {
            let mask = &source.regions.union;
            let surface = shape.value.clone();
            let (settings, seed) = (&request.settings, key.seed);
            let colored = colored(
                &source.photo,
                mask,
                surface,
                settings,
                seed,
                progress,
                cancel,
            )?;
            let ColoredSurface { color, .. } = colored;
            Ok(color)
        })?;
        Ok((made.value.clone(), made.version))
    }

    /// The foliage of this photograph that was made last, or else the photograph itself.
    fn color_at_hand(
        &mut self,
        source: &Made<LiveInput, Source>,
        shape: &MadeShape,
        cancel: &Cancel,
    ) -> Result<(Cubemap<Straight>, u64), CrownError> {
        let foliage = self.foliage.0.as_ref();
        let of_photo = |made: &&Arc<Made<FoliageKey, Cubemap<Straight>>>| {
            Arc::ptr_eq(&made.key.input.photo, &source.key.photo)
        };
        if let Some(made) = foliage.filter(of_photo) {
            return Ok((made.value.clone(), made.version));
        }
        let made = self.projected.get(shape.version, |_| {
            cancel.check()?;
            let Source { photo, regions, .. } = &source.value;
            Ok(photo_around(photo, &regions.union, &shape.value))
        })?;
        Ok((made.value.clone(), made.version))
    }
}

impl Shapes {
    fn source(
        &mut self,
        input: &LiveInput,
        quality: Quality,
    ) -> Result<Arc<Made<LiveInput, Source>>, CrownError> {
        self.source.get(input.clone(), |input| {
            let labels = &input.labels;
            let (thinning, is_thinned) = match quality {
                Quality::Coarse => (Thinning::to(labels, COARSE_PX), true),
                Quality::Fine | Quality::Full => (Thinning::none(labels), false),
            };
            let regions = Regions::new(labels, thinning).ok_or(InflationError::Empty)?;
            let photo = match is_thinned {
                true => Arc::new(thinning.photo(&input.photo)),
                false => Arc::clone(&input.photo),
            };
            Ok(Source {
                photo,
                regions,
                thinning,
            })
        })
    }

    fn shape(
        &mut self,
        source: &Made<LiveInput, Source>,
        request: &CrownRequest,
        progress: Progress<'_>,
        cancel: &Cancel,
    ) -> Result<Arc<MadeShape>, CrownError> {
        let settings = &request.settings;
        let regions = &source.value.regions;
        let key = ShapeKey::of(source, request);
        let inflated = &mut self.inflated;
        self.shape.get(key, |_| {
            let stage = progress.stage("shape", 2);
            let shape = if regions.is_parted() {
                let regions = request.sub_crowns(regions);
                let masks: Vec<&Mask> = regions.iter().map(|region| &region.mask).collect();
                shape_of_regions(&regions, &masks, settings, progress, cancel)?
            } else {
                let key = (source.version, settings.size, settings.envelope);
                let inflated = inflated.get(key, |_| {
                    Inflated::new(&regions.union, settings, progress, cancel)
                })?;
                inflated.value.shape(settings, cancel)?
            };
            stage.advance();
            let base_m = base_radius(&shape, settings, cancel)?;
            stage.advance();
            Ok((shape, base_m))
        })
    }

    /// That of the mask that was inflated last, if it is this one, in the photograph as it is.
    fn silhouette(&self, source: &Made<LiveInput, Source>) -> Arc<Silhouette> {
        let made = self.inflated.0.as_ref();
        let Some(made) = made.filter(|made| made.key.0 == source.version) else {
            return Arc::default();
        };
        let thinning = source.value.thinning;
        let own = &made.value.silhouette;
        match thinning.is_none() {
            true => Arc::clone(own),
            false => Arc::new(own.moved(|place| thinning.in_photo(place))),
        }
    }

    fn adopt(&mut self, copy: Self) {
        self.source.adopt(copy.source);
        self.inflated.adopt(copy.inflated);
        self.shape.adopt(copy.shape);
    }
}

/// What of `settings` a shape depends on; the rest as by default.
fn of_shape(settings: &CrownSettings) -> CrownSettings {
    CrownSettings {
        size: settings.size,
        envelope: settings.envelope,
        k: settings.k.clone(),
        copies: settings.copies,
        height_m: settings.height_m,
        trunk_height_m: settings.trunk_height_m,
        ..CrownSettings::default()
    }
}

/// What of `settings` colours depend on; the rest as by default.
fn without_relief(settings: &CrownSettings) -> CrownSettings {
    CrownSettings {
        rho: CrownSettings::default().rho,
        relief: ReliefSettings::default(),
        stem: None,
        cover: 1.0,
        ..settings.clone()
    }
}

/// The photograph seen straight through the crown: on the front as it was taken, mirrored behind.
/// Where the surface is beside the mask, the nearest foliage towards the centre.
fn photo_around(
    photo: &Image<Straight>,
    mask: &Mask,
    (shape, base_m): &(CrownShape, Cubemap<f32>),
) -> Cubemap<Straight> {
    let center = shape.photo_center;
    let scale = shape.photo_px_per_m;
    Cubemap::from_directions(base_m.size(), |direction| {
        let direction = direction.normalize();
        let reach = f64::from(base_m.nearest(direction)) * scale;
        let inward = |step: u32| {
            let share = 1.0 - f64::from(step) / f64::from(INWARDS);
            let x = center.x + direction.x * reach * share;
            let y = center.y - direction.y * reach * share;
            let place = [x, y].map(|place| libm::round(place) as i64);
            let is_inside = mask.get(place[0], place[1]) == Some(true);
            is_inside.then(|| photo.at(place[0] as u32, place[1] as u32))
        };
        let Straight([r, g, b, _]) = (0..=INWARDS)
            .find_map(inward)
            .unwrap_or(Straight([96, 112, 64, 255]));
        Straight([r, g, b, 255])
    })
}

#[cfg(test)]
mod tests;
