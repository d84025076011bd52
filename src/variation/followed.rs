//! A tree in a picture followed from its foot along all that can be seen of it, and the limbs found so.
//!
//! Distances along the tree fall into bands; the connected parts of bands are the nodes of a tree, the Reeb graph of
//! that distance (after A. Verroust and F. Lazarus, *Extracting skeletal curves from 3D scattered data*, 2000), and
//! what hangs on a node is one limb with all its twigs.
//!
//! Limits: where limbs cross in the picture the nearer one to the foot takes what lies beyond.

use super::Tree;
use super::limbs::Limb;
use crate::base::{Cancel, Cancelled};
use crate::raster::Image;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Pixels along the longer side of the picture that a tree is followed in.
pub(super) const FOLLOWED: f64 = 400.0;

/// Alpha from which a pixel is a twig that can be followed.
const TWIG: u8 = 64;

/// What a step to a neighbour costs, straight and aslant, and how many times as much across clear pixels.
const STEPS: [u32; 2] = [5, 7];
const ACROSS_GAP: u32 = 8;

/// Width of a band of distances, in costs: three pixels.
const BAND: u32 = 15;

/// Share of the tree that a limb is at least and at most.
const LIMB: std::ops::RangeInclusive<f64> = 0.006..=0.12;

/// Stands for the limb of what belongs to none and does not stay.
const NO_LIMB: u16 = u16::MAX;

/// A tree followed from its foot, in a smaller picture.
pub(super) struct Followed {
    width: usize,
    /// Its pixels for one of the tree's picture.
    scale: f64,
    /// The node of each pixel, 0 for clear ones.
    node: Vec<u32>,
    nodes: Vec<Node>,
}

/// A connected part of a band of distances.
#[derive(Clone)]
struct Node {
    /// Its pixel nearest to the foot.
    nearest: usize,
    /// What it hangs on, 0 for nothing; and the pixel there.
    parent: u32,
    joint: usize,
    pixels: usize,
    /// With all that hangs on it.
    weight: usize,
    /// Counted from 1; 0 what stays.
    limb: u16,
}

impl Followed {
    pub(super) fn of(tree: &Tree, cancel: &Cancel) -> Result<Self, Cancelled> {
        let longer = f64::from(tree.image.width().max(tree.image.height()));
        let scale = (FOLLOWED / longer).min(1.0);
        let side = |pixels: u32| (f64::from(pixels) * scale).ceil() as usize + 1;
        let (width, height) = (side(tree.image.width()), side(tree.image.height()));
        let mut is_twig = vec![false; width * height];
        for y in 0..tree.image.height() {
            for (x, pixel) in tree.image.row(y).iter().enumerate() {
                let [u, v] = [x as f64, f64::from(y)].map(|along| (along * scale) as usize);
                is_twig[v * width + u] |= pixel.alpha() >= TWIG;
            }
        }
        let (distance, parent) = distances(&is_twig, width, cancel)?;
        let (node, mut nodes) = nodes(&is_twig, &distance, width);
        hang(&mut nodes, &node, &parent, &distance);
        let mut followed = Self {
            width,
            scale,
            node,
            nodes,
        };
        followed.take_limbs(&distance);
        Ok(followed)
    }

    /// Tells which nodes are of which limb: what hangs on the stem and is no more than a limb.
    fn take_limbs(&mut self, distance: &[u32]) {
        let mut order: Vec<usize> = (1..self.nodes.len()).collect();
        order.sort_by_key(|&node| (distance[self.nodes[node].nearest], node));
        for &node in order.iter().rev() {
            let (weight, parent) = (self.nodes[node].weight, self.nodes[node].parent);
            self.nodes[parent as usize].weight += weight;
        }
        let all: usize = self.nodes.iter().map(|node| node.pixels).sum();
        let share = |weight: usize| weight as f64 / all.max(1) as f64;
        let mut limbs = 0;
        for &node in &order {
            let parent = &self.nodes[self.nodes[node].parent as usize];
            let of_parent = parent.limb;
            let is_of_stem = self.nodes[node].parent == 0 || share(parent.weight) > *LIMB.end();
            let begins = is_of_stem && self.nodes[node].parent != 0;
            let is_limb = begins && LIMB.contains(&share(self.nodes[node].weight));
            self.nodes[node].limb = match (of_parent, is_limb) {
                (0, true) if limbs < NO_LIMB - 1 => {
                    limbs += 1;
                    limbs
                }
                (of_parent, _) => of_parent,
            };
        }
    }

    /// The limbs, in the order of their numbers.
    pub(super) fn limbs(&self) -> Vec<Limb> {
        let count = self.nodes.iter().map(|node| node.limb).max().unwrap_or(0);
        let mut places: Vec<Vec<[f64; 2]>> = vec![Vec::new(); usize::from(count) + 1];
        for (i, &node) in self.node.iter().enumerate() {
            let limb = self.nodes[node as usize].limb;
            if limb > 0 {
                places[usize::from(limb)].push(self.place(i));
            }
        }
        let mut bases = vec![[0.0; 2]; places.len()];
        for node in self.nodes.iter().skip(1) {
            if node.limb != self.nodes[node.parent as usize].limb {
                bases[usize::from(node.limb)] = self.place(node.joint);
            }
        }
        let limbs = places.into_iter().zip(bases).skip(1);
        limbs
            .map(|(places, base)| Limb::new(places, base))
            .collect()
    }

    /// Where pixel `i` of the smaller picture lies in that of the tree.
    fn place(&self, i: usize) -> [f64; 2] {
        [i % self.width, i / self.width].map(|along| (along as f64 + 0.5) / self.scale - 0.5)
    }

    /// The limb of each pixel of the tree's picture, 0 for what stays, [`NO_LIMB`] for what is nowhere near a twig:
    /// soft edges are of the twig beside them.
    pub(super) fn limb_of_pixels(&self, tree: &Tree) -> Image<u16> {
        let height = self.node.len() / self.width;
        let of = |x: u32, y: u32| {
            let [u, v] = [x, y].map(|along| (f64::from(along) * self.scale) as usize);
            let rows = v.saturating_sub(1)..(v + 2).min(height);
            let near = rows.flat_map(|v| {
                let columns = u.saturating_sub(1)..(u + 2).min(self.width);
                columns.map(move |u| self.node[v * self.width + u])
            });
            let own = self.node[v * self.width + u];
            let node = [own].into_iter().chain(near).find(|&node| node > 0);
            node.map_or(NO_LIMB, |node| self.nodes[node as usize].limb)
        };
        let (width, height) = (tree.image.width(), tree.image.height());
        let pixels = (0..width * height).map(|i| of(i % width, i / width));
        Image::from_pixels(width, height, pixels.collect())
    }
}

/// How far all pixels are from the foot along the tree, and the pixel before each on the way.
fn distances(
    is_twig: &[bool],
    width: usize,
    cancel: &Cancel,
) -> Result<(Vec<u32>, Vec<usize>), Cancelled> {
    let height = is_twig.len() / width;
    let mut distance = vec![u32::MAX; is_twig.len()];
    let mut parent: Vec<usize> = (0..is_twig.len()).collect();
    let lowest = is_twig.iter().rposition(|&is| is).unwrap_or(0) / width;
    let foot = (lowest * width..(lowest + 1) * width).filter(|&i| is_twig[i]);
    let mut open: BinaryHeap<Reverse<(u32, usize)>> = foot.map(|i| Reverse((0, i))).collect();
    for Reverse((_, i)) in &open {
        distance[*i] = 0;
    }
    let mut steps = 0u32;
    while let Some(Reverse((at, i))) = open.pop() {
        if at > distance[i] {
            continue;
        }
        steps += 1;
        if steps.is_multiple_of(4096) {
            cancel.check()?;
        }
        let (x, y) = (i % width, i / width);
        for v in y.saturating_sub(1)..(y + 2).min(height) {
            for u in x.saturating_sub(1)..(x + 2).min(width) {
                let other = v * width + u;
                let step = STEPS[usize::from(u != x && v != y)];
                let times = if is_twig[other] { 1 } else { ACROSS_GAP };
                let there = at + step * times;
                if there < distance[other] {
                    distance[other] = there;
                    parent[other] = i;
                    open.push(Reverse((there, other)));
                }
            }
        }
    }
    Ok((distance, parent))
}

/// The connected parts of bands of distances, from 1; node 0 is what is none.
fn nodes(is_twig: &[bool], distance: &[u32], width: usize) -> (Vec<u32>, Vec<Node>) {
    let height = is_twig.len() / width;
    let nothing = Node {
        nearest: 0,
        parent: 0,
        joint: 0,
        pixels: 0,
        weight: 0,
        limb: 0,
    };
    let (mut node, mut nodes) = (vec![0u32; is_twig.len()], vec![nothing.clone()]);
    let mut open = Vec::new();
    for start in 0..is_twig.len() {
        if !is_twig[start] || node[start] > 0 {
            continue;
        }
        let number = nodes.len() as u32;
        let mut new = Node {
            nearest: start,
            ..nothing.clone()
        };
        node[start] = number;
        open.push(start);
        while let Some(i) = open.pop() {
            new.pixels += 1;
            if distance[i] < distance[new.nearest] {
                new.nearest = i;
            }
            let (x, y) = (i % width, i / width);
            for v in y.saturating_sub(1)..(y + 2).min(height) {
                for u in x.saturating_sub(1)..(x + 2).min(width) {
                    let other = v * width + u;
                    let is_same = is_twig[other] && distance[other] / BAND == distance[i] / BAND;
                    if is_same && node[other] == 0 {
                        node[other] = number;
                        open.push(other);
                    }
                }
            }
        }
        new.weight = new.pixels;
        nodes.push(new);
    }
    (node, nodes)
}

/// Hangs each node on the one that the way to the foot goes through.
fn hang(nodes: &mut [Node], node: &[u32], parent: &[usize], distance: &[u32]) {
    for (number, own) in nodes.iter_mut().enumerate().skip(1) {
        let mut at = own.nearest;
        while distance[at] > 0 && (node[at] == 0 || node[at] == number as u32) {
            at = parent[at];
        }
        if node[at] != number as u32 {
            (own.parent, own.joint) = (node[at], at);
        }
    }
}
