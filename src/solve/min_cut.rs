//! Minimum cuts: the cheapest set of edges that parts the source of a network from its sink.
//!
//! Two trees of unsaturated arcs grow towards one another, one from the source and one from the
//! sink; where they touch, flow is pushed along the path through both; the arcs that it saturates
//! cut branches off, which look for a new parent in their own tree or fall free. Searching goes on
//! in the trees that are left instead of beginning anew, which suits the short paths of pictures:
//! near-linear in practice, though the worst case is not.
//!
//! This work is based on: Y. Boykov & V. Kolmogorov, *An Experimental Comparison of Min-Cut/Max-Flow
//! Algorithms for Energy Minimization in Vision*, PAMI 26(9), 2004, with the marks of distance and
//! time of V. Kolmogorov's thesis (2004), which keep paths short and searches for an origin brief.
//!
//! Of all minimum cuts the one with the smallest source's side is given: the nodes that flow can
//! still reach. It is unique, so nothing of how the flow was found shows in it.
//!
//! Limits: one thread; a worst case that is polynomial only with distances (O(n² m · cut)). Pictures
//! of 10⁵ pixels take tens of milliseconds.

use super::network::Network;
use crate::base::{Cancel, Cancelled};
use std::collections::VecDeque;

/// A cheapest cut.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cut {
    /// What flows, which is what the cut costs.
    pub flow: i64,
    /// For each node whether it is on the source's side: of all cheapest cuts that with the fewest
    /// nodes there.
    pub on_source_side: Vec<bool>,
}

/// How many nodes are grown between two looks at the flag that stops the work: some microseconds
/// each at most.
const GROWN_BETWEEN_CHECKS: u32 = 256;

/// Instead of the arc to a parent: none, the node is in no tree.
const FREE: u32 = u32::MAX;
/// Instead of the arc to a parent: the node is joined with its tree's terminal itself.
const ROOT: u32 = u32::MAX - 1;
/// Instead of the arc to a parent: the node has just lost it.
const ORPHAN: u32 = u32::MAX - 2;
/// The distance of a node that has no way to its terminal.
const FAR: u32 = u32::MAX;

/// What the search knows of a node.
#[derive(Debug, Clone, Copy)]
struct Node {
    /// The arc to the parent, or [`FREE`], [`ROOT`], [`ORPHAN`].
    parent: u32,
    /// When the distance was last known to be true.
    time: u32,
    /// Number of arcs to the terminal, at `time`.
    distance: u32,
    /// Which tree it belongs to, if any.
    from_sink: bool,
    /// Whether it waits in the queue of nodes that may grow.
    is_active: bool,
}

impl Network {
    /// The cheapest cut between source and sink (see the module's text).
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub fn min_cut(self, cancel: &Cancel) -> Result<Cut, Cancelled> {
        let mut search = Search::new(self);
        let mut grown = 0;
        while let Some(node) = search.next_active() {
            if grown % GROWN_BETWEEN_CHECKS == 0 {
                cancel.check()?;
            }
            grown += 1;
            while let Some(bridge) = search.grown(node) {
                search.time += 1;
                search.augment(bridge);
                search.adopt();
                if search.nodes[node].parent == FREE {
                    break;
                }
            }
        }
        let nodes = search.nodes.iter();
        Ok(Cut {
            flow: search.flow,
            on_source_side: nodes
                .map(|node| node.parent != FREE && !node.from_sink)
                .collect(),
        })
    }
}

/// The two trees while they grow.
struct Search {
    network: Network,
    nodes: Vec<Node>,
    active: VecDeque<u32>,
    orphans: VecDeque<u32>,
    time: u32,
    flow: i64,
}

impl Search {
    /// Trees that are their roots only.
    fn new(network: Network) -> Self {
        let rooted = |&terminal: &i32| Node {
            parent: if terminal == 0 { FREE } else { ROOT },
            time: 0,
            distance: 1,
            from_sink: terminal < 0,
            is_active: terminal != 0,
        };
        let nodes: Vec<Node> = network.terminals.iter().map(rooted).collect();
        let active = (0u32..).zip(&nodes).filter(|(_, node)| node.is_active);
        Self {
            active: active.map(|(index, _)| index).collect(),
            orphans: VecDeque::new(),
            time: 0,
            flow: network.straight,
            nodes,
            network,
        }
    }

    /// The next node that may grow, taken out of the queue.
    fn next_active(&mut self) -> Option<usize> {
        while let Some(index) = self.active.pop_front() {
            let node = &mut self.nodes[index as usize];
            node.is_active = false;
            if node.parent != FREE {
                return Some(index as usize);
            }
        }
        None
    }

    /// Puts a node into the queue of those that may grow, unless it is there.
    fn activate(&mut self, index: usize) {
        let node = &mut self.nodes[index];
        if !node.is_active {
            node.is_active = true;
            self.active.push_back(index as u32);
        }
    }

    fn arcs_of(&self, node: usize) -> std::ops::Range<usize> {
        self.network.first[node] as usize..self.network.first[node + 1] as usize
    }

    /// How much may flow along `arc` away from the root, when its tail is in the tree of the sink
    /// or not.
    #[inline]
    fn outwards(&self, arc: usize, from_sink: bool) -> i32 {
        let arc = &self.network.arcs[arc];
        if from_sink {
            self.network.arcs[arc.sister as usize].residual
        } else {
            arc.residual
        }
    }

    /// Adds the free nodes around `node` to its tree; stops at the first arc over which it touches
    /// the other tree, and gives it as an arc from the source's tree to the sink's.
    fn grown(&mut self, index: usize) -> Option<usize> {
        let node = self.nodes[index];
        for arc in self.arcs_of(index) {
            if self.outwards(arc, node.from_sink) == 0 {
                continue;
            }
            let there = self.network.arcs[arc];
            let other = self.nodes[there.head as usize];
            if other.parent == FREE || (other.from_sink == node.from_sink && is_longer(other, node))
            {
                let is_new = other.parent == FREE;
                let child = &mut self.nodes[there.head as usize];
                child.parent = there.sister;
                child.time = node.time;
                child.distance = node.distance + 1;
                child.from_sink = node.from_sink;
                if is_new {
                    self.activate(there.head as usize);
                }
            } else if other.from_sink != node.from_sink {
                let bridge = if node.from_sink {
                    there.sister as usize
                } else {
                    arc
                };
                return Some(bridge);
            }
        }
        None
    }

    /// Pushes as much as possible from the source over `bridge` to the sink.
    fn augment(&mut self, bridge: usize) {
        let arc = self.network.arcs[bridge];
        let tail = self.network.arcs[arc.sister as usize].head as usize;
        let amount = arc
            .residual
            .min(self.room(tail, false))
            .min(self.room(arc.head as usize, true));
        self.network.arcs[bridge].residual -= amount;
        self.network.arcs[arc.sister as usize].residual += amount;
        self.push(tail, amount, false);
        self.push(arc.head as usize, amount, true);
        self.flow += i64::from(amount);
    }

    /// The most that may flow between the terminal and `index` through the tree.
    fn room(&self, mut index: usize, from_sink: bool) -> i32 {
        let mut least = i32::MAX;
        loop {
            let parent = self.nodes[index].parent;
            if parent == ROOT {
                return least.min(self.network.terminals[index].abs());
            }
            let arc = self.network.arcs[parent as usize];
            least = least.min(self.outwards(arc.sister as usize, from_sink));
            index = arc.head as usize;
        }
    }

    /// Pushes `amount` through the tree between the terminal and `index`; nodes whose arc from the
    /// parent is full become orphans.
    fn push(&mut self, mut index: usize, amount: i32, from_sink: bool) {
        loop {
            let parent = self.nodes[index].parent;
            if parent == ROOT {
                let terminal = &mut self.network.terminals[index];
                *terminal += if from_sink { amount } else { -amount };
                if *terminal == 0 {
                    self.nodes[index].parent = ORPHAN;
                    self.orphans.push_front(index as u32);
                }
                return;
            }
            let up = parent as usize;
            let down = self.network.arcs[up].sister as usize;
            let (with, against) = if from_sink { (up, down) } else { (down, up) };
            self.network.arcs[with].residual -= amount;
            self.network.arcs[against].residual += amount;
            if self.network.arcs[with].residual == 0 {
                self.nodes[index].parent = ORPHAN;
                self.orphans.push_front(index as u32);
            }
            index = self.network.arcs[up].head as usize;
        }
    }

    /// Finds a new parent for each orphan, or frees it and makes its children orphans.
    fn adopt(&mut self) {
        while let Some(orphan) = self.orphans.pop_front() {
            let index = orphan as usize;
            match self.nearest_parent(index) {
                Some((arc, distance)) => {
                    let node = &mut self.nodes[index];
                    node.parent = arc;
                    node.time = self.time;
                    node.distance = distance + 1;
                }
                None => self.free(index),
            }
        }
    }

    /// The arc to the neighbour in the same tree that is nearest to the terminal and has a way
    /// there, with its distance.
    fn nearest_parent(&mut self, index: usize) -> Option<(u32, u32)> {
        let from_sink = self.nodes[index].from_sink;
        let mut nearest = None;
        let mut shortest = FAR;
        for arc in self.arcs_of(index) {
            let there = self.network.arcs[arc];
            let other = self.nodes[there.head as usize];
            let may_be = other.from_sink == from_sink && other.parent != FREE;
            if !may_be || self.outwards(there.sister as usize, from_sink) == 0 {
                continue;
            }
            let distance = self.distance(there.head as usize);
            if distance < shortest {
                shortest = distance;
                nearest = Some((arc as u32, distance));
            }
        }
        nearest
    }

    /// The number of arcs from `start` to its terminal, [`FAR`] when an orphan is between; what was
    /// learnt on the way is kept.
    fn distance(&mut self, start: usize) -> u32 {
        let (mut index, mut steps) = (start, 0);
        let total = loop {
            let node = &mut self.nodes[index];
            if node.time == self.time {
                break steps + node.distance;
            }
            match node.parent {
                ROOT => {
                    node.time = self.time;
                    node.distance = 1;
                    break steps + 1;
                }
                ORPHAN | FREE => return FAR,
                parent => index = self.network.arcs[parent as usize].head as usize,
            }
            steps += 1;
        };
        let (mut index, mut left) = (start, total);
        while self.nodes[index].time != self.time {
            let node = &mut self.nodes[index];
            node.time = self.time;
            node.distance = left;
            left -= 1;
            index = self.network.arcs[node.parent as usize].head as usize;
        }
        total
    }

    /// Takes an orphan out of its tree.
    fn free(&mut self, index: usize) {
        let from_sink = self.nodes[index].from_sink;
        for arc in self.arcs_of(index) {
            let there = self.network.arcs[arc];
            let neighbour = there.head as usize;
            let other = self.nodes[neighbour];
            if other.parent == FREE || other.from_sink != from_sink {
                continue;
            }
            if self.outwards(there.sister as usize, from_sink) > 0 {
                self.activate(neighbour);
            }
            if other.parent == there.sister {
                self.nodes[neighbour].parent = ORPHAN;
                self.orphans.push_back(neighbour as u32);
            }
        }
        self.nodes[index].parent = FREE;
    }
}

/// Whether `other` would be nearer to its terminal as a child of `node`, as far as both know.
fn is_longer(other: Node, node: Node) -> bool {
    other.time <= node.time && other.distance > node.distance + 1
}

#[cfg(test)]
mod tests {
    use super::super::{Edge, HARD};
    use super::*;
    use crate::base::{Random, Seed};

    /// The cheapest cut by trying all of them; bit n of the set is node n on the source's side.
    /// Edges first, then what joins each node with source and sink.
    fn cheapest(edges: &[Edge], ends: &[(i32, i32)]) -> (i64, u32) {
        let cost =
            |set: u32| {
                let inside = |node: usize| set >> node & 1 == 1;
                let cut = edges.iter().map(|edge| {
                    match (inside(edge.a as usize), inside(edge.b as usize)) {
                        (true, false) => i64::from(edge.forward),
                        (false, true) => i64::from(edge.backward),
                        _ => 0,
                    }
                });
                let terminals = ends.iter().enumerate().map(|(node, &(source, sink))| {
                    i64::from(if inside(node) { sink } else { source })
                });
                cut.sum::<i64>() + terminals.sum::<i64>()
            };
        let sets = 0..1u32 << ends.len();
        sets.map(|set| (cost(set), set.count_ones(), set))
            .min()
            .map(|(cost, _, set)| (cost, set))
            .unwrap()
    }

    fn random_edges(random: &mut Random, nodes: usize) -> Vec<Edge> {
        let count = random.below(3 * nodes);
        (0..count)
            .map(|_| {
                let a = random.below(nodes);
                let b = (a + 1 + random.below(nodes - 1)) % nodes;
                Edge {
                    a: a as u32,
                    b: b as u32,
                    forward: random.below(8) as i32,
                    backward: random.below(8) as i32,
                }
            })
            .collect()
    }

    #[test]
    fn no_cut_of_small_networks_is_cheaper() {
        let mut random = Seed(5).random();
        for round in 0..1500 {
            let nodes = 2 + random.below(8);
            let edges = random_edges(&mut random, nodes);
            let mut terminal = |i: i32| if random.below(3) == 0 { i } else { 0 };
            let ends: Vec<(i32, i32)> = (0..nodes as i32)
                .map(|i| (terminal(9 - i % 3), terminal(4 + i % 5)))
                .collect();
            let mut network = Network::new(nodes, &edges);
            for (node, &(source, sink)) in ends.iter().enumerate() {
                network.join_source(node, source);
                network.join_sink(node, sink);
            }
            let found = network.min_cut(&Cancel::new()).unwrap();
            let (cost, set) = cheapest(&edges, &ends);
            assert_eq!(found.flow, cost, "round {round}");
            let ours = (0..nodes).filter(|&node| found.on_source_side[node]);
            assert_eq!(
                ours.fold(0, |set, node| set | 1 << node),
                set,
                "round {round}"
            );
        }
    }

    #[test]
    fn a_grid_is_the_network_of_its_edges() {
        let (width, height) = (13u32, 9u32);
        let mut random = Seed(6).random();
        let across: Vec<i32> = (0..width * height)
            .map(|_| random.below(50) as i32)
            .collect();
        let down: Vec<i32> = (0..width * height)
            .map(|_| random.below(50) as i32)
            .collect();
        let index = |x: u32, y: u32| y * width + x;
        let mut edges = Vec::new();
        let mut edge = |a, b, capacity| {
            edges.push(Edge {
                a,
                b,
                forward: capacity,
                backward: capacity,
            });
        };
        for y in 0..height {
            for x in 0..width {
                if x + 1 < width {
                    edge(index(x, y), index(x + 1, y), across[index(x, y) as usize]);
                }
                if y + 1 < height {
                    edge(index(x, y), index(x, y + 1), down[index(x, y) as usize]);
                }
            }
        }
        let right = |x, y| across[index(x, y) as usize];
        let below = |x, y| down[index(x, y) as usize];
        let mut networks = [
            Network::grid(width, height, right, below),
            Network::new((width * height) as usize, &edges),
        ];
        let cuts = networks.each_mut().map(|network| {
            for y in 0..height {
                network.join_source(index(0, y) as usize, HARD);
                network.join_sink(index(width - 1, y) as usize, HARD);
            }
            network.clone().min_cut(&Cancel::new()).unwrap()
        });
        assert_eq!(cuts[0], cuts[1]);
        assert!(cuts[0].flow > 0);
    }

    #[test]
    fn a_cancelled_search_stops() {
        let mut network = Network::grid(4, 4, |_, _| 1, |_, _| 1);
        network.join_source(0, 1);
        network.join_sink(15, 1);
        let cancel = Cancel::new();
        cancel.cancel();
        assert_eq!(network.min_cut(&cancel), Err(Cancelled));
    }
}
