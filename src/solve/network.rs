//! Flow networks: nodes joined by edges of a capacity each way, and each node to a source and a sink.
//!
//! What [`Network::min_cut`](super::min_cut) cuts. The edges of a node lie next to one another in
//! memory (compressed rows); they keep the order in which they were given, so results do not depend
//! on anything else.
//!
//! Limits: capacities are whole numbers from 0 to [`HARD`]; whoever has real ones scales them. Edges
//! from a node to itself are not allowed, several between the same two nodes are.

/// A capacity that no cut of finite cost goes through: larger than the sum of the others would be
/// better still, but pictures stay far below it (a seam of 10⁵ texels of the largest cost, 1,530, is
/// 1.5 · 10⁸) and two of it still fit into an `i32`.
pub const HARD: i32 = 1 << 29;

/// An edge between two nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Edge {
    /// One end.
    pub a: u32,
    /// The other end.
    pub b: u32,
    /// How much may flow from `a` to `b`; what a cut pays with `a` on the source's side and `b` on
    /// the sink's.
    pub forward: i32,
    /// How much may flow from `b` to `a`.
    pub backward: i32,
}

/// One direction of an edge.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Arc {
    /// The node it leads to.
    pub(super) head: u32,
    /// The arc of the same edge that leads back.
    pub(super) sister: u32,
    /// How much more may flow.
    pub(super) residual: i32,
}

/// A network whose flow is still to be found.
#[derive(Debug, Clone)]
pub struct Network {
    /// The arcs of node n are `first[n]..first[n + 1]`.
    pub(super) first: Vec<u32>,
    pub(super) arcs: Vec<Arc>,
    /// What may still come from the source (positive) or go to the sink (negative).
    pub(super) terminals: Vec<i32>,
    /// What flows from the source through a node straight to the sink.
    pub(super) straight: i64,
}

impl Network {
    /// A network of `nodes` nodes without terminals.
    ///
    /// # Panics
    /// When an edge names a node that is not there or joins one with itself, or when a capacity is
    /// negative or above [`HARD`].
    ///
    /// ```
    /// use boscage::base::Cancel;
    /// use boscage::solve::{Edge, Network};
    /// let edge = |a, b, capacity| Edge { a, b, forward: capacity, backward: 0 };
    /// let mut network = Network::new(3, &[edge(0, 1, 5), edge(1, 2, 3), edge(0, 2, 1)]);
    /// network.join_source(0, 100);
    /// network.join_sink(2, 100);
    /// let cut = network.min_cut(&Cancel::new()).unwrap();
    /// assert_eq!(cut.flow, 4);
    /// assert_eq!(cut.on_source_side, [true, true, false]);
    /// ```
    pub fn new(nodes: usize, edges: &[Edge]) -> Self {
        let mut first = vec![0u32; nodes + 1];
        for edge in edges {
            assert_ne!(edge.a, edge.b, "an edge joins two nodes");
            first[edge.a as usize + 1] += 1;
            first[edge.b as usize + 1] += 1;
        }
        for node in 0..nodes {
            first[node + 1] += first[node];
        }
        let mut next = first.clone();
        let mut take = |node: u32| {
            let arc = next[node as usize];
            next[node as usize] += 1;
            arc
        };
        let mut arcs = vec![Arc::default(); 2 * edges.len()];
        for edge in edges {
            let (there, back) = (take(edge.a), take(edge.b));
            arcs[there as usize] = Arc::new(edge.b, back, edge.forward);
            arcs[back as usize] = Arc::new(edge.a, there, edge.backward);
        }
        Self {
            first,
            arcs,
            terminals: vec![0; nodes],
            straight: 0,
        }
    }

    /// A grid whose pixels are joined with their four neighbours; node y · `width` + x is pixel
    /// (x, y). Capacities are the same both ways: `right(x, y)` between (x, y) and (x + 1, y),
    /// `down(x, y)` between (x, y) and (x, y + 1).
    ///
    /// # Panics
    /// As [`Network::new`].
    pub fn grid(
        width: u32,
        height: u32,
        mut right: impl FnMut(u32, u32) -> i32,
        mut down: impl FnMut(u32, u32) -> i32,
    ) -> Self {
        let (columns, rows) = (width as usize, height as usize);
        let mut first = Vec::with_capacity(columns * rows + 1);
        first.push(0u32);
        for y in 0..rows {
            for x in 0..columns {
                let degree = u32::from(x > 0)
                    + u32::from(x + 1 < columns)
                    + u32::from(y > 0)
                    + u32::from(y + 1 < rows);
                first.push(first[y * columns + x] + degree);
            }
        }
        let mut arcs = vec![Arc::default(); first[columns * rows] as usize];
        // Left and up come first among the arcs of a pixel, then right and down.
        for y in 0..rows {
            for x in 0..columns {
                let node = y * columns + x;
                let mut there = first[node] + u32::from(x > 0) + u32::from(y > 0);
                let mut join = |other: usize, back: u32, capacity: i32| {
                    arcs[there as usize] = Arc::new(other as u32, back, capacity);
                    arcs[back as usize] = Arc::new(node as u32, there, capacity);
                    there += 1;
                };
                if x + 1 < columns {
                    join(node + 1, first[node + 1], right(x as u32, y as u32));
                }
                if y + 1 < rows {
                    let below = node + columns;
                    let back = first[below] + u32::from(x > 0);
                    join(below, back, down(x as u32, y as u32));
                }
            }
        }
        Self {
            first,
            arcs,
            terminals: vec![0; columns * rows],
            straight: 0,
        }
    }

    /// Lets `capacity` more flow from the source to `node`: what a cut pays with `node` on the
    /// sink's side. [`HARD`] holds the node on the source's side.
    ///
    /// # Panics
    /// When the node is not there or the capacity is not in 0..=[`HARD`].
    pub fn join_source(&mut self, node: usize, capacity: i32) {
        assert!((0..=HARD).contains(&capacity), "capacity {capacity}");
        self.add_terminal(node, capacity);
    }

    /// Lets `capacity` more flow from `node` to the sink: what a cut pays with `node` on the
    /// source's side. [`HARD`] holds the node on the sink's side.
    ///
    /// # Panics
    /// As [`Network::join_source`].
    pub fn join_sink(&mut self, node: usize, capacity: i32) {
        assert!((0..=HARD).contains(&capacity), "capacity {capacity}");
        self.add_terminal(node, -capacity);
    }

    /// Source and sink joined with the same node: the smaller of the two flows straight through.
    fn add_terminal(&mut self, node: usize, amount: i32) {
        let terminal = &mut self.terminals[node];
        if (*terminal > 0) != (amount > 0) {
            self.straight += i64::from(terminal.abs().min(amount.abs()));
        }
        *terminal = terminal.saturating_add(amount).clamp(-i32::MAX, i32::MAX);
    }
}

impl Arc {
    fn new(head: u32, sister: u32, capacity: i32) -> Self {
        assert!((0..=HARD).contains(&capacity), "capacity {capacity}");
        Self {
            head,
            sister,
            residual: capacity,
        }
    }
}
