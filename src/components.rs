//! Connected components, by union-find.

/// Numbers the connected components of `count` items; the component of the
/// first item is 0.
pub(crate) fn components(count: u32, pairs: impl Iterator<Item = [u32; 2]>) -> Vec<u32> {
    let mut parents: Vec<u32> = (0..count).collect();
    for pair in pairs {
        let [one, other] = pair.map(|item| root(&mut parents, item));
        parents[one.max(other) as usize] = one.min(other);
    }
    // A root is the smallest of its component, so it is numbered first.
    let mut numbers = vec![0; count as usize];
    let mut next = 0;
    for item in 0..count {
        let root = root(&mut parents, item);
        if root == item {
            numbers[item as usize] = next;
            next += 1;
        } else {
            numbers[item as usize] = numbers[root as usize];
        }
    }
    numbers
}

/// The root of an item's tree; halves the path on the way.
fn root(parents: &mut [u32], mut item: u32) -> u32 {
    while parents[item as usize] != item {
        parents[item as usize] = parents[parents[item as usize] as usize];
        item = parents[item as usize];
    }
    item
}
