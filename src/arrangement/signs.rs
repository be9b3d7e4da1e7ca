//! Exact names: on which side of every plane something lies.

use std::borrow::Borrow;

/// One sign per plane (a covector of the arrangement), two bits each: 00 on
/// the plane, 01 in front, 10 behind. It names a vertex, a face or a cell.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Signs(Box<[u64]>);

/// Planes per word.
const PER_WORD: usize = 32;
/// The lower bit of every plane's two.
const LOWER: u64 = 0x5555_5555_5555_5555;

impl Signs {
    /// On all of `count` planes.
    pub fn on_all(count: usize) -> Self {
        Self(vec![0; count.div_ceil(PER_WORD)].into())
    }

    /// From one sign (−1, 0, 1) per plane.
    pub fn new(signs: &[i8]) -> Self {
        let mut all = Self::on_all(signs.len());
        for (plane, &sign) in signs.iter().enumerate() {
            all.0[plane / PER_WORD] |= bits(sign) << shift(plane);
        }
        all
    }

    /// The sign (−1, 0, 1) for a plane.
    pub fn get(&self, plane: usize) -> i8 {
        match self.0[plane / PER_WORD] >> shift(plane) & 0b11 {
            0b01 => 1,
            0b10 => -1,
            _ => 0,
        }
    }

    /// Changes the sign for a plane.
    pub fn set(&mut self, plane: usize, sign: i8) {
        set(&mut self.0, plane, sign);
    }

    /// The same but for one plane.
    pub fn with(&self, plane: usize, sign: i8) -> Self {
        let mut changed = self.clone();
        changed.set(plane, sign);
        changed
    }

    /// Takes the other's sign where this one has none: the name of what is
    /// spanned by two points of one face.
    pub fn join(&mut self, other: &Self) {
        for (own, other) in self.0.iter_mut().zip(&other.0) {
            *own |= other & !occupied(*own);
        }
    }

    /// Whether something with this name is in the closure of something with
    /// the other: its signs are the other's, or zero.
    pub fn bounds(&self, other: &Self) -> bool {
        self.0.iter().zip(&other.0).all(|(own, other)| (own ^ other) & occupied(*own) == 0)
    }

    /// The words, for a look-up by a buffer.
    pub fn words(&self) -> &[u64] {
        &self.0
    }
}

impl Borrow<[u64]> for Signs {
    fn borrow(&self) -> &[u64] {
        &self.0
    }
}

/// Changes the sign for a plane in the words of some signs.
pub(crate) fn set(words: &mut [u64], plane: usize, sign: i8) {
    let word = &mut words[plane / PER_WORD];
    *word = *word & !(0b11 << shift(plane)) | bits(sign) << shift(plane);
}

fn shift(plane: usize) -> usize {
    2 * (plane % PER_WORD)
}

fn bits(sign: i8) -> u64 {
    match sign {
        0 => 0b00,
        1.. => 0b01,
        ..0 => 0b10,
    }
}

/// Both bits of every plane that has a sign.
fn occupied(word: u64) -> u64 {
    let lower = (word | word >> 1) & LOWER;
    lower | lower << 1
}
