//! The skeleton of a tree: a graph of points, grown towards points that still want leaves.
//!
//! Space colonisation after Runions, Lane & Prusinkiewicz, *Modeling Trees with a Space
//! Colonization Algorithm* (2007): every attraction point pulls the skeleton node nearest to it;
//! pulled nodes grow one step in the mean direction of their points; points that a node has
//! reached are used up. Departures: a tropism is added to the mean direction, each step is jogged
//! a little so that limbs are crooked, and a node that would repeat one of its children rests.
//!
//! The frame of all of `branches`: metres, the foot of the stem at the origin, x to the right in
//! the picture, y up, z towards the viewer.

use crate::base::{Cancel, Cancelled, Random};
use glam::Vec3;

/// The golden angle in radians: what turns by it never stands above itself.
pub(super) const GOLDEN_ANGLE: f32 = 2.399_963_2;

/// A point of the skeleton.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// Where it is, in metres.
    pub position: Vec3,
    /// The node it grew from, always an earlier one; `None` for the first.
    pub parent: Option<u32>,
}

/// A tree as a graph: nodes in the order they grew, so that parents stand before children.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Skeleton {
    /// All nodes; the first is the root.
    pub nodes: Vec<Node>,
}

/// How a skeleton grows towards attraction points.
#[derive(Debug, Clone, Copy)]
pub struct Reach {
    /// Length of one step in metres; limbs cannot bend more sharply than over this length.
    pub step_m: f32,
    /// A point nearer than this to a node is used up, in metres; more than a step and a half,
    /// or points are circled for ever.
    pub kill_m: f32,
    /// A point further away than this pulls nobody, in metres.
    pub influence_m: f32,
    /// Added to the unit direction of growth: y > 0 makes limbs rise.
    pub tropism: Vec3,
    /// Nodes below this height do not grow, in metres: the bare part of the stem.
    pub bare_m: f32,
    /// Sideways error of each step as a share of it; 0.1 is a smooth limb, 0.4 a gnarled one.
    pub crook: f32,
}

impl Skeleton {
    /// Lets a node grow from `parent`, an earlier one, and returns its index.
    pub fn grow(&mut self, position: Vec3, parent: Option<u32>) -> u32 {
        debug_assert!(parent.is_none_or(|p| (p as usize) < self.nodes.len()));
        self.nodes.push(Node { position, parent });
        (self.nodes.len() - 1) as u32
    }

    /// For each node the nodes that grew from it, in order.
    pub fn children(&self) -> Vec<Vec<u32>> {
        let mut children = vec![Vec::new(); self.nodes.len()];
        for (index, node) in self.nodes.iter().enumerate() {
            if let Some(parent) = node.parent {
                children[parent as usize].push(index as u32);
            }
        }
        children
    }

    /// The unit direction in which the node grew; up for the first.
    pub fn direction(&self, node: u32) -> Vec3 {
        let node = self.nodes[node as usize];
        node.parent.map_or(Vec3::Y, |parent| {
            (node.position - self.nodes[parent as usize].position).normalize_or(Vec3::Y)
        })
    }

    /// Pulls every inner node halfway to the middle of its neighbours along the limb, `times`
    /// times: takes the kinks out of grown limbs. Root and tips stay.
    pub fn relax(&mut self, times: usize) {
        let mut main_child: Vec<Option<u32>> = vec![None; self.nodes.len()];
        for (index, node) in self.nodes.iter().enumerate() {
            if let Some(parent) = node.parent {
                main_child[parent as usize].get_or_insert(index as u32);
            }
        }
        for _ in 0..times {
            let old: Vec<Vec3> = self.nodes.iter().map(|node| node.position).collect();
            for (index, node) in self.nodes.iter_mut().enumerate() {
                if let (Some(parent), Some(child)) = (node.parent, main_child[index]) {
                    let middle = (old[parent as usize] + old[child as usize]) * 0.5;
                    node.position = (old[index] + middle) * 0.5;
                }
            }
        }
    }
}

/// What one attraction point knows: itself, its nearest node, and how far that is.
struct Attractor {
    position: Vec3,
    nearest: u32,
    distance_squared: f32,
}

/// Grows `skeleton`, which must not be empty, until all reachable `attractors` are used up.
///
/// # Errors
/// [`Cancelled`].
pub fn colonise(
    skeleton: &mut Skeleton,
    attractors: &[Vec3],
    reach: &Reach,
    random: &mut Random,
    cancel: &Cancel,
) -> Result<(), Cancelled> {
    /// More steps than any crown is deep.
    const MAX_ROUNDS: usize = 400;
    let mut waiting: Vec<Attractor> = attractors
        .iter()
        .map(|&position| Attractor {
            position,
            nearest: 0,
            distance_squared: f32::INFINITY,
        })
        .collect();
    let mut tips = vec![Vec::new(); skeleton.nodes.len()];
    let mut fresh = 0;
    for _ in 0..MAX_ROUNDS {
        cancel.check()?;
        notice(&mut waiting, skeleton, fresh, reach.bare_m);
        waiting.retain(|point| point.distance_squared > reach.kill_m * reach.kill_m);
        fresh = skeleton.nodes.len();
        grow_once(skeleton, &waiting, &mut tips, reach, random);
        if skeleton.nodes.len() == fresh {
            break;
        }
    }
    Ok(())
}

/// Lets the points notice the nodes from index `fresh` on that may grow.
fn notice(waiting: &mut [Attractor], skeleton: &Skeleton, fresh: usize, bare_m: f32) {
    for point in waiting {
        for (index, node) in skeleton.nodes.iter().enumerate().skip(fresh) {
            let distance_squared = point.position.distance_squared(node.position);
            if node.position.y >= bare_m && distance_squared < point.distance_squared {
                point.distance_squared = distance_squared;
                point.nearest = index as u32;
            }
        }
    }
}

/// One step of every node that is pulled. `tips` holds the positions grown from each node.
fn grow_once(
    skeleton: &mut Skeleton,
    waiting: &[Attractor],
    tips: &mut Vec<Vec<Vec3>>,
    reach: &Reach,
    random: &mut Random,
) {
    let count = skeleton.nodes.len();
    let mut pulls = vec![Vec3::ZERO; count];
    for point in waiting {
        if point.distance_squared < reach.influence_m * reach.influence_m {
            let from = skeleton.nodes[point.nearest as usize].position;
            pulls[point.nearest as usize] += (point.position - from).normalize_or_zero();
        }
    }
    for (index, pull) in pulls.into_iter().enumerate() {
        let Some(mean) = pull.try_normalize() else {
            continue;
        };
        let jog = random_in_ball(random) * reach.crook;
        let direction = (mean + reach.tropism + jog).normalize_or(mean);
        let position = skeleton.nodes[index].position + direction * reach.step_m;
        let apart = 0.35 * reach.step_m;
        if tips[index]
            .iter()
            .all(|&old: &Vec3| old.distance(position) > apart)
        {
            skeleton.grow(position, Some(index as u32));
            tips[index].push(position);
            tips.push(Vec::new());
        }
    }
}

/// A point uniform in the unit ball.
pub(super) fn random_in_ball(random: &mut Random) -> Vec3 {
    loop {
        let mut side = || random.between(-1.0, 1.0) as f32;
        let point = Vec3::new(side(), side(), side());
        if point.length_squared() <= 1.0 {
            return point;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Seed;

    fn grown(seed: u64) -> Skeleton {
        let mut random = Seed(seed).random();
        let points: Vec<Vec3> = (0..200)
            .map(|_| Vec3::new(0.0, 4.0, 0.0) + random_in_ball(&mut random) * 2.0)
            .collect();
        let reach = Reach {
            step_m: 0.2,
            kill_m: 0.4,
            influence_m: 9.0,
            tropism: Vec3::ZERO,
            bare_m: 0.0,
            crook: 0.1,
        };
        let mut skeleton = Skeleton::default();
        skeleton.grow(Vec3::ZERO, None);
        colonise(&mut skeleton, &points, &reach, &mut random, &Cancel::new()).unwrap();
        for point in points {
            let nearest = skeleton
                .nodes
                .iter()
                .map(|node| node.position.distance(point))
                .fold(f32::INFINITY, f32::min);
            assert!(nearest < 1.0, "a point was left {nearest} m away");
        }
        skeleton
    }

    #[test]
    fn every_point_is_reached_and_parents_stand_before_children() {
        let skeleton = grown(1);
        for (index, node) in skeleton.nodes.iter().enumerate() {
            assert_eq!(node.parent.is_none(), index == 0);
            assert!(node.parent.is_none_or(|parent| (parent as usize) < index));
        }
        assert_eq!(skeleton, grown(1));
        assert_ne!(skeleton, grown(2));
    }

    #[test]
    fn relaxing_keeps_root_and_tips() {
        let mut skeleton = Skeleton::default();
        let root = skeleton.grow(Vec3::ZERO, None);
        let knee = skeleton.grow(Vec3::new(1.0, 1.0, 0.0), Some(root));
        skeleton.grow(Vec3::new(0.0, 2.0, 0.0), Some(knee));
        skeleton.relax(1);
        assert_eq!(skeleton.nodes[0].position, Vec3::ZERO);
        assert_eq!(skeleton.nodes[1].position, Vec3::new(0.5, 1.0, 0.0));
        assert_eq!(skeleton.nodes[2].position, Vec3::new(0.0, 2.0, 0.0));
    }
}
