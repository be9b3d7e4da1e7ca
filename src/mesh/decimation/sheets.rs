//! Simplifying the surfaces between curves: all in one call, so that what changes least goes
//! first, wherever it is.

use glam::DVec3;

use super::reduced::Reduced;
use crate::error::{Error, Result};
use crate::ffi::decimation::{Simplified, Watch, simplify};
use crate::mesh::Mesh;
use crate::mesh::nearest::flat;
use crate::mesh::network::{Ends, Kind, Network};
use crate::mesh::pieces::Piece;
use crate::progress::Progress;

/// Collapses for which progress is told of one step.
pub const STEP: usize = 1024;

/// Of a vertex that may move.
const NO_NAME: u32 = u32::MAX;

impl Reduced {
    /// Collapses edges between curves until so many triangles are left, or none can be collapsed.
    ///
    /// # Errors
    /// When cancelled, or when CGAL fails.
    pub fn reduce_sheets(&mut self, wanted: usize, progress: &dyn Progress) -> Result<()> {
        let network = self.network()?;
        let curves = curves(&network);
        let (pieces, whole): (Vec<_>, Vec<_>) =
            network.pieces_of_patches().into_iter().partition(Piece::is_manifold);
        let is_named = named(&curves, &pieces, self.mesh.vertices.len());
        let sheets = Sheets::new(&pieces, &is_named);
        let left: usize = whole.iter().map(|piece| piece.triangles.len()).sum();
        let made = self.simplified(&sheets, wanted.saturating_sub(left), progress)?;
        progress.go_on()?;
        let to = self.take(&sheets, &made, &pieces, &whole, &is_named);
        let mut expected: Vec<Ends> = curves.iter().map(|&ends| renamed(ends, &to)).collect();
        expected.sort_unstable();
        let is_new = |ends: &Ends| expected.binary_search(ends).is_err();
        let found = self::curves(&self.network()?);
        self.torn = found.into_iter().filter(is_new).collect::<Vec<_>>().into_flattened();
        Ok(())
    }

    pub fn network(&self) -> Result<Network> {
        Network::new(&self.mesh, &self.kept.iter().copied().collect::<Vec<_>>())
    }

    fn simplified(
        &self,
        sheets: &Sheets,
        wanted: usize,
        progress: &dyn Progress,
    ) -> Result<Simplified> {
        let own = |of: &[f64]| -> Vec<f64> {
            sheets.vertices.iter().map(|&vertex| of[vertex as usize]).collect()
        };
        let places = sheets.vertices.iter().map(|&vertex| self.mesh.vertices[vertex as usize]);
        let points = flat(&places.collect::<Vec<DVec3>>());
        let triangles = sheets.triangles.as_flattened();
        let (limits, reached) = (own(&self.limits), own(&self.reached));
        let far = [&limits[..], &reached];
        simplify(&points, triangles, &sheets.names, far, wanted, &Watch(progress))
            .map_err(|exception| Error::library("decimation", &exception))
    }

    /// Makes the network of simplified sheets and of pieces that stay as they are. Returns the
    /// number of every vertex that there was.
    fn take(
        &mut self,
        sheets: &Sheets,
        made: &Simplified,
        pieces: &[Piece],
        whole: &[Piece],
        is_named: &[bool],
    ) -> Vec<u32> {
        // Those with a name come first, in their order.
        let mut to = vec![NO_NAME; is_named.len()];
        let mut mesh = Mesh::default();
        for vertex in (0..is_named.len()).filter(|&vertex| is_named[vertex]) {
            to[vertex] = mesh.vertices.len() as u32;
            mesh.vertices.push(self.mesh.vertices[vertex]);
        }
        let mut numbers = Vec::with_capacity(made.names.len());
        for (&name, place) in made.names.iter().zip(made.points.chunks_exact(3)) {
            numbers.push(if name == NO_NAME {
                mesh.vertices.push(DVec3::from_slice(place));
                mesh.vertices.len() as u32 - 1
            } else {
                to[name as usize]
            });
        }
        for (&vertex, &place) in sheets.vertices.iter().zip(&made.places) {
            if !is_named[vertex as usize] {
                to[vertex as usize] = numbers[place as usize];
            }
        }
        for (corners, &origin) in made.triangles.as_chunks::<3>().0.iter().zip(&made.origins) {
            mesh.triangles.push(corners.map(|corner| numbers[corner as usize]));
            mesh.sides.push(pieces[sheets.pieces[origin as usize] as usize].sides);
        }
        for piece in whole {
            let name = |corner: u32| to[piece.vertices[corner as usize] as usize];
            mesh.triangles.extend(piece.triangles.iter().map(|triangle| triangle.map(name)));
            mesh.sides.resize(mesh.triangles.len(), piece.sides);
        }
        self.follow(&to, mesh.vertices.len());
        for (&number, &reached) in numbers.iter().zip(&made.reached) {
            let own = &mut self.reached[number as usize];
            *own = own.max(reached);
        }
        self.mesh = mesh;
        to
    }
}

/// Pieces one after the other.
struct Sheets {
    /// For every vertex its number in the network.
    vertices: Vec<u32>,
    /// The same for those that stay where they are.
    names: Vec<u32>,
    triangles: Vec<[u32; 3]>,
    /// For every triangle its piece.
    pieces: Vec<u32>,
}

impl Sheets {
    fn new(pieces: &[Piece], is_named: &[bool]) -> Self {
        let [vertices, names, numbers] = [Vec::new(), Vec::new(), Vec::new()];
        let mut all = Self { vertices, names, triangles: Vec::new(), pieces: numbers };
        for (number, piece) in pieces.iter().enumerate() {
            let first = all.vertices.len() as u32;
            all.vertices.extend(&piece.vertices);
            all.triangles.extend(piece.triangles.iter().map(|own| own.map(|at| first + at)));
            all.pieces.resize(all.triangles.len(), number as u32);
        }
        let name = |&vertex: &u32| if is_named[vertex as usize] { vertex } else { NO_NAME };
        all.names = all.vertices.iter().map(name).collect();
        all
    }
}

/// The edges at which not just one surface goes on, sorted.
pub fn curves(network: &Network) -> Vec<Ends> {
    let edges = network.edges();
    let curves = edges.iter().filter(|sides| network.kind(sides) != Kind::Surface);
    curves.map(|sides| sides[0].0).collect()
}

/// The vertices that more than one patch has, or one more than once, and those on borders.
fn named(curves: &[Ends], pieces: &[Piece], count: usize) -> Vec<bool> {
    let mut times = vec![0u32; count];
    pieces.iter().flat_map(|piece| &piece.vertices).for_each(|&own| times[own as usize] += 1);
    let mut is_named: Vec<bool> = times.into_iter().map(|times| times != 1).collect();
    curves.as_flattened().iter().for_each(|&end| is_named[end as usize] = true);
    is_named
}

fn renamed(ends: Ends, to: &[u32]) -> Ends {
    let [one, other] = ends.map(|end| to[end as usize]);
    [one.min(other), one.max(other)]
}
