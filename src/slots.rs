//! Things with numbers that survive every change they are not part of.

use std::ops::{Index, IndexMut};

/// Items by numbers, some of which may not be in use.
#[derive(Debug, Clone, PartialEq)]
pub struct Slots<T>(Vec<Option<T>>);

impl<T> Slots<T> {
    /// One more than the largest number ever in use: what a table by numbers needs.
    pub fn end(&self) -> usize {
        self.0.len()
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.0.iter().flatten().count()
    }

    /// Whether a number is in use.
    pub fn has(&self, id: u32) -> bool {
        self.get(id).is_some()
    }

    /// What has a number, if it is in use.
    pub fn get(&self, id: u32) -> Option<&T> {
        self.0.get(id as usize)?.as_ref()
    }

    /// All, by number.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = (u32, &T)> {
        self.0.iter().enumerate().filter_map(|(id, item)| Some((id as u32, item.as_ref()?)))
    }

    /// The numbers in use, ascending.
    pub fn ids(&self) -> impl DoubleEndedIterator<Item = u32> {
        self.iter().map(|(id, _)| id)
    }

    /// All, in the order of their numbers.
    pub fn values(&self) -> impl DoubleEndedIterator<Item = &T> {
        self.0.iter().flatten()
    }

    /// All, in the order of their numbers, to be changed.
    pub fn values_mut(&mut self) -> impl DoubleEndedIterator<Item = &mut T> {
        self.0.iter_mut().flatten()
    }

    /// Puts something in the place of what had the number, and returns that.
    pub fn put(&mut self, id: u32, item: Option<T>) -> Option<T> {
        let id = id as usize;
        if id >= self.0.len() {
            self.0.resize_with(id + 1, || None);
        }
        std::mem::replace(&mut self.0[id], item)
    }
}

impl<T> From<Vec<T>> for Slots<T> {
    /// Numbered as they are.
    fn from(items: Vec<T>) -> Self {
        Self(items.into_iter().map(Some).collect())
    }
}

impl<T> Default for Slots<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> Index<u32> for Slots<T> {
    type Output = T;

    #[expect(clippy::expect_used, reason = "as with any index")]
    fn index(&self, id: u32) -> &T {
        self.0[id as usize].as_ref().expect("no item has this number")
    }
}

impl<T> IndexMut<u32> for Slots<T> {
    #[expect(clippy::expect_used, reason = "as with any index")]
    fn index_mut(&mut self, id: u32) -> &mut T {
        self.0[id as usize].as_mut().expect("no item has this number")
    }
}
