//! Connected parts of labelled nodes, by runs along rows: a part of a million
//! nodes is a few thousand runs.

use std::ops::Range;

use crate::sets::components;

/// Nodes of one label in a row along z.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Run<L> {
    /// Its nodes: `start..end` along z.
    pub start: i32,
    /// As `start`.
    pub end: i32,
    /// What they have in common.
    pub label: L,
}

impl<L> Run<L> {
    /// How many nodes.
    pub fn len(&self) -> u64 {
        (self.end - self.start) as u64
    }
}

/// Which nodes are neighbours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Neighbors {
    /// Those that differ by one in one coordinate.
    Six,
    /// Those that differ by one at most in each.
    All,
}

impl Neighbors {
    /// The steps to later rows, and how far apart two runs may be in them.
    fn steps(self) -> (&'static [[usize; 2]], i32) {
        match self {
            Self::Six => (&[[0, 1], [1, 0]], 0),
            Self::All => (&[[0, 1], [1, 0], [1, 1], [1, usize::MAX]], 1),
        }
    }
}

/// Runs in a rectangle of rows.
#[derive(Debug, Clone)]
pub struct Runs<L> {
    /// Row (x, y) is at `x * dims[1] + y`.
    pub dims: [usize; 2],
    /// By row and place, apart from each other or of different labels.
    pub runs: Vec<Run<L>>,
    /// Where each row's runs begin, and where the last ends.
    starts: Vec<usize>,
}

impl<L: Copy + PartialEq> Runs<L> {
    /// From the runs of each row in turn.
    pub fn new(dims: [usize; 2], mut row: impl FnMut([usize; 2], &mut Vec<Run<L>>)) -> Self {
        let (mut runs, mut starts) = (Vec::new(), vec![0]);
        for x in 0..dims[0] {
            for y in 0..dims[1] {
                row([x, y], &mut runs);
                starts.push(runs.len());
            }
        }
        Self { dims, runs, starts }
    }

    /// The indices of a row's runs.
    pub fn row(&self, row: usize) -> Range<usize> {
        self.starts[row]..self.starts[row + 1]
    }

    /// The row of a run.
    pub fn row_of(&self, run: usize) -> [usize; 2] {
        let row = self.starts.partition_point(|&start| start <= run) - 1;
        [row / self.dims[1], row % self.dims[1]]
    }

    /// The number of each run's connected part.
    pub fn parts(&self, neighbors: Neighbors) -> Vec<u32> {
        let (steps, apart) = neighbors.steps();
        let mut pairs = Vec::new();
        for row in 0..self.dims[0] * self.dims[1] {
            let [x, y] = [row / self.dims[1], row % self.dims[1]];
            for &[dx, dy] in steps {
                // A step of usize::MAX is one back.
                let (x, y) = (x + dx, y.wrapping_add(dy));
                if x < self.dims[0] && y < self.dims[1] {
                    let other = self.row(x * self.dims[1] + y);
                    pairs.extend(self.touching(self.row(row), self, other, apart));
                }
            }
        }
        components(self.runs.len() as u32, pairs.into_iter())
    }

    /// The pairs of a run of one row and a run of another row, of these runs or
    /// of others, that have the same label and are no farther from each other
    /// along z.
    pub fn touching(
        &self,
        row: Range<usize>,
        others: &Self,
        mut other: Range<usize>,
        apart: i32,
    ) -> Vec<[u32; 2]> {
        let mut pairs = Vec::new();
        for own in row {
            let run = &self.runs[own];
            while other.start < other.end && others.runs[other.start].end + apart <= run.start {
                other.start += 1;
            }
            for next in other.clone() {
                let found = &others.runs[next];
                if found.start >= run.end + apart {
                    break;
                }
                if found.label == run.label {
                    pairs.push([own as u32, next as u32]);
                }
            }
        }
        pairs
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The runs of letters in rows of text, one plane of rows.
    fn text(rows: &[&str]) -> Runs<char> {
        Runs::new([1, rows.len()], |[_, y], runs| {
            let letters: Vec<char> = rows[y].chars().collect();
            let mut start = 0;
            for run in letters.chunk_by(PartialEq::eq) {
                let end = start + run.len();
                if run[0] != '.' {
                    runs.push(Run { start: start as i32, end: end as i32, label: run[0] });
                }
                start = end;
            }
        })
    }

    fn count(rows: &[&str], neighbors: Neighbors) -> u32 {
        text(rows).parts(neighbors).into_iter().max().map_or(0, |last| last + 1)
    }

    #[test]
    fn parts_are_joined_across_sides_or_corners() {
        let bent = ["aaa..", "..a..", "..aaa", "....."];
        assert_eq!((count(&bent, Neighbors::Six), count(&bent, Neighbors::All)), (1, 1));
        let corner = ["aa...", "..aa."];
        assert_eq!((count(&corner, Neighbors::Six), count(&corner, Neighbors::All)), (2, 1));
        let back = ["..aa.", "aa..."];
        assert_eq!((count(&back, Neighbors::Six), count(&back, Neighbors::All)), (2, 1));
        let apart = ["aa...", "...aa"];
        assert_eq!((count(&apart, Neighbors::Six), count(&apart, Neighbors::All)), (2, 2));
    }

    #[test]
    fn labels_part() {
        let two = ["aabb", "aabb"];
        assert_eq!(count(&two, Neighbors::All), 2);
        let ring = ["aaaa", "abba", "aaaa"];
        assert_eq!(count(&ring, Neighbors::Six), 2);
    }

    #[test]
    fn rows_in_a_square_meet_at_their_edges() {
        // Rows (0, 0) and (1, 1): neighbours by their corner alone; and (1, 0)
        // and (0, 1), which steps reach backward.
        let at = |own: [[usize; 2]; 2]| {
            Runs::new([2, 2], |row, runs| {
                if own.contains(&row) {
                    runs.push(Run { start: 0, end: 3, label: () });
                }
            })
        };
        for own in [[[0, 0], [1, 1]], [[0, 1], [1, 0]]] {
            assert_eq!(at(own).parts(Neighbors::Six), [0, 1]);
            assert_eq!(at(own).parts(Neighbors::All), [0, 0]);
        }
        let runs = at([[0, 1], [1, 0]]);
        assert_eq!((runs.row_of(0), runs.row_of(1)), ([0, 1], [1, 0]));
    }
}
