//! How well the classical segmenter does on real billboards that were labelled by hand.

use boscage::base::Cancel;
use boscage::raster::{ReadLimits, Straight, encode_grey_png, Compression, Image, read_image};
use boscage::segment::{Classical, Label, Labels, Segmenter, crown_baseline, grey_from_labels, labels_from_grey};
use std::path::{Path, PathBuf};

fn data() -> Option<PathBuf> {
    let folder = PathBuf::from(std::env::var_os("BOSCAGE_DATA").unwrap_or("../shared/data".into()));
    let found = folder.join("pins.csv").is_file();
    if !found {
        println!("skipped: no labelled pictures in {}", folder.display());
    }
    found.then_some(folder)
}

fn iou(ours: &Labels, theirs: &Labels, class: Label) -> f64 {
    let pairs = || ours.pixels().iter().zip(theirs.pixels());
    let both = pairs().filter(|&(a, b)| *a == class && *b == class).count();
    let either = pairs().filter(|&(a, b)| *a == class || *b == class).count();
    both as f64 / either.max(1) as f64
}

#[test]
fn table() {
    let Some(folder) = data() else { return };
    let pins = std::fs::read_to_string(folder.join("pins.csv")).unwrap();
    let only = std::env::var("ONLY").ok();
    for set in ["billboards", "photos"] {
        let (mut trunks, mut crowns, mut bases) = (vec![], vec![], vec![]);
        for line in pins.lines().skip(1) {
            let f: Vec<&str> = line.split(',').collect();
            let name = f[0];
            if only.as_ref().is_some_and(|o| !name.contains(o.as_str())) { continue; }
            let labels = labels_from_grey(&read_image(&folder.join(format!("labels/{name}.labels.png")), ReadLimits::default()).unwrap().map(|p| p.0[0]));
            let ext = if set == "photos" { "jpg" } else { "png" };
            let path = folder.join(format!("{set}/{name}.{ext}"));
            if !path.is_file() { continue; }
            let mut image = read_image(&path, ReadLimits::default()).unwrap();
            if set == "photos" {
                for (p, l) in image.pixels_mut().iter_mut().zip(labels.pixels()) {
                    if *l == Label::Background { *p = Straight([0; 4]); }
                }
            }
            let start = std::time::Instant::now();
            let ours = Classical.segment(&image, &Cancel::new()).unwrap();
            let ms = start.elapsed().as_secs_f64() * 1e3;
            let crown = iou(&ours, &labels, Label::Crown);
            let trunk = iou(&ours, &labels, Label::Trunk);
            let h: f64 = f[1].parse().unwrap();
            let truth: f64 = f[2].parse().unwrap();
            let base = crown_baseline(&ours);
            let err = base.map(|b| (f64::from(b) - truth) / h);
            println!("{name:36} crown {crown:.3} trunk {trunk:.3} base {:>6} truth {truth:5} err {:6.1}% {ms:.1}ms", base.map_or(-1, |b| b as i64), 100.0 * err.unwrap_or(1.0));
            crowns.push(crown);
            if truth >= 0.0 { trunks.push(trunk); bases.push(err.map_or(1.0, f64::abs)); }
            if let Some(dir) = std::env::var_os("LOOK") {
                std::fs::write(Path::new(&dir).join(format!("{name}.png")), encode_grey_png(&grey_from_labels(&ours), Compression::Fast)).unwrap();
            }
            let _: Option<Image<u8>> = None;
        }
        bases.sort_by(f64::total_cmp);
        let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
        if !bases.is_empty() {
        println!("{set}: crown {:.4} trunk {:.4} base median {:.4} mean {:.4} n {}", mean(&crowns), mean(&trunks), bases[bases.len() / 2], mean(&bases), trunks.len());
        }
    }
}
