//! What a mesh is like whatever its shape: closed or open, in how many parts, with how many handles.
//!
//! A mesh is watertight here when it is the boundary of a solid as printers and engines want it:
//! every edge belongs to two triangles that pass it in opposite directions, and the triangles around
//! each vertex form one closed fan. For such a mesh the Euler characteristic
//! χ = vertices − edges + triangles gives the number of handles: χ = 2 (parts − genus).
//!
//! Everything is counted in linear time by sorting what meets at each vertex; positions are not
//! looked at. Limits: whether parts intersect in space is not asked.

use super::Mesh;

/// Counts that describe how the triangles of a mesh hang together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Topology {
    /// Vertices that a triangle uses.
    pub vertices: usize,
    /// Pairs of vertices that a triangle joins.
    pub edges: usize,
    /// Triangles.
    pub triangles: usize,
    /// Parts that share no vertex.
    pub components: usize,
    /// Edges that do not belong to exactly two triangles in opposite directions.
    pub bad_edges: usize,
    /// Vertices whose triangles do not form one closed fan.
    pub bad_vertices: usize,
}

impl Topology {
    /// Counts `mesh`.
    ///
    /// # Panics
    /// When a triangle names a vertex that is not there.
    pub fn of(mesh: &Mesh) -> Self {
        let corners = Corners::of(mesh);
        let (mut edges, mut bad_edges, mut bad_vertices, mut vertices) = (0, 0, 0, 0);
        for vertex in 0..mesh.positions.len() {
            let fan = corners.around(vertex);
            if fan.is_empty() {
                continue;
            }
            vertices += 1;
            bad_vertices += usize::from(!is_closed_fan(fan));
            let (all, bad) = edges_to_larger(vertex as u32, fan);
            edges += all;
            bad_edges += bad;
        }
        Self {
            vertices,
            edges,
            triangles: mesh.triangles.len(),
            components: components(mesh),
            bad_edges,
            bad_vertices,
        }
    }

    /// Whether the mesh has triangles and bounds a solid.
    pub fn is_watertight(&self) -> bool {
        self.triangles > 0 && self.bad_edges == 0 && self.bad_vertices == 0
    }

    /// The Euler characteristic: vertices − edges + triangles.
    pub fn euler(&self) -> i64 {
        self.vertices as i64 - self.edges as i64 + self.triangles as i64
    }

    /// The number of handles of all parts together; `None` unless the mesh is watertight.
    pub fn genus(&self) -> Option<u64> {
        let genus = self.components as i64 - self.euler() / 2;
        self.is_watertight().then_some(genus as u64)
    }
}

/// For each vertex the corners there: the next and the previous vertex of each triangle.
struct Corners {
    /// Where the corners of each vertex begin; one entry more than vertices.
    starts: Vec<u32>,
    /// (next, previous), in the order of the triangles.
    ends: Vec<[u32; 2]>,
}

impl Corners {
    fn of(mesh: &Mesh) -> Self {
        let mut starts = vec![0u32; mesh.positions.len() + 1];
        for &vertex in mesh.triangles.as_flattened() {
            starts[vertex as usize + 1] += 1;
        }
        for vertex in 1..starts.len() {
            starts[vertex] += starts[vertex - 1];
        }
        let mut free = starts.clone();
        let mut ends = vec![[0; 2]; mesh.triangles.len() * 3];
        for &[a, b, c] in &mesh.triangles {
            for [here, next, previous] in [[a, b, c], [b, c, a], [c, a, b]] {
                ends[free[here as usize] as usize] = [next, previous];
                free[here as usize] += 1;
            }
        }
        Self { starts, ends }
    }

    fn around(&self, vertex: usize) -> &[[u32; 2]] {
        &self.ends[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
    }
}

/// Whether the corners of a vertex follow one another in a single circle.
fn is_closed_fan(fan: &[[u32; 2]]) -> bool {
    let mut at = fan[0][1];
    for step in 1..=fan.len() {
        if at == fan[0][0] {
            return step == fan.len();
        }
        let mut following = fan.iter().filter(|corner| corner[0] == at);
        match (following.next(), following.next()) {
            (Some(corner), None) => at = corner[1],
            _ => return false,
        }
    }
    false
}

/// The number of edges from `vertex` to vertices of larger index, and how many of them are bad.
fn edges_to_larger(vertex: u32, fan: &[[u32; 2]]) -> (usize, usize) {
    let (mut edges, mut bad) = (0, 0);
    for (i, corner) in fan.iter().enumerate() {
        for (side, &other) in corner.iter().enumerate() {
            let ends = fan[..i].as_flattened().iter().chain(&corner[..side]);
            if other < vertex || ends.copied().any(|earlier| earlier == other) {
                continue;
            }
            edges += 1;
            let passing = |way: usize| fan.iter().filter(|c| c[way] == other).count();
            bad += usize::from(other == vertex || passing(0) != 1 || passing(1) != 1);
        }
    }
    (edges, bad)
}

/// Parts that share no vertex.
fn components(mesh: &Mesh) -> usize {
    let mut parents: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    let mut used = vec![false; mesh.positions.len()];
    for &[a, b, c] in &mesh.triangles {
        for (one, other) in [(a, b), (b, c)] {
            let (one, other) = (root(&mut parents, one), root(&mut parents, other));
            parents[one.max(other) as usize] = one.min(other);
        }
        used[a as usize] = true;
        used[b as usize] = true;
        used[c as usize] = true;
    }
    let is_root = |vertex: usize| used[vertex] && parents[vertex] as usize == vertex;
    (0..parents.len()).filter(|&vertex| is_root(vertex)).count()
}

/// The root of the tree that `vertex` is in, with the way there halved.
fn root(parents: &mut [u32], mut vertex: u32) -> u32 {
    while parents[vertex as usize] != vertex {
        let grandparent = parents[parents[vertex as usize] as usize];
        parents[vertex as usize] = grandparent;
        vertex = grandparent;
    }
    vertex
}

#[cfg(test)]
mod tests {
    use super::super::mesh::tests::{beside, tetrahedron};
    use super::*;
    use glam::DVec3;

    #[test]
    fn a_tetrahedron_is_closed_and_an_open_one_is_not() {
        let mut mesh = tetrahedron();
        let closed = Topology::of(&mesh);
        assert!(closed.is_watertight());
        assert_eq!((closed.vertices, closed.edges, closed.euler()), (4, 6, 2));
        assert_eq!(closed.genus(), Some(0));
        mesh.triangles[0].swap(0, 1);
        assert_eq!(Topology::of(&mesh).bad_edges, 3);
        mesh.triangles.remove(0);
        let open = Topology::of(&mesh);
        assert_eq!((open.bad_edges, open.bad_vertices), (3, 3));
        assert_eq!(open.genus(), None);
        assert!(!Topology::of(&Mesh::default()).is_watertight());
    }

    #[test]
    fn two_solids_that_touch_in_a_vertex_or_an_edge_are_not_one() {
        let mirrored = tetrahedron().moved(|p| -p).reversed();
        let apart = beside(&tetrahedron(), &mirrored);
        let two = Topology::of(&apart);
        assert!(two.is_watertight());
        assert_eq!((two.components, two.genus()), (2, Some(0)));
        let weld = |from: u32, to: u32| {
            move |t: &[u32; 3]| t.map(|vertex| if vertex == from { to } else { vertex })
        };
        let mut touching = apart.clone();
        touching.triangles = apart.triangles.iter().map(weld(4, 0)).collect();
        let vertex = Topology::of(&touching);
        assert_eq!((vertex.bad_edges, vertex.bad_vertices), (0, 1));
        touching.triangles = touching.triangles.iter().map(weld(5, 1)).collect();
        assert!(Topology::of(&touching).bad_edges > 0);
    }

    #[test]
    fn a_torus_has_a_handle() {
        let (round, across) = (7u32, 5u32);
        let id = |i: u32, j: u32| (i % round) * across + j % across;
        let quads = (0..round).flat_map(|i| (0..across).map(move |j| (i, j)));
        let triangles = quads
            .flat_map(|(i, j)| {
                let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
                [[a, b, c], [a, c, d]]
            })
            .collect();
        let torus = Topology::of(&Mesh {
            positions: vec![DVec3::ZERO; (round * across) as usize],
            triangles,
        });
        assert!(torus.is_watertight());
        assert_eq!((torus.euler(), torus.genus()), (0, Some(1)));
    }
}
