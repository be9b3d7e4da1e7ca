//! The order of files of a stack, by the numbers in their names.

use std::cmp::Ordering;

/// Names as people order them: slice2 before slice10.
pub fn compare(one: &str, other: &str) -> Ordering {
    let mut parts = parts(one).into_iter().zip(parts(other));
    let differing = parts.find_map(|pair| {
        let order = match pair {
            (Part::Number(one), Part::Number(other)) => by_value(one, other),
            (one, other) => one.text().cmp(other.text()),
        };
        (order != Ordering::Equal).then_some(order)
    });
    // Parts are the same as far as they go: the rest decides, and leading zeros.
    differing.unwrap_or_else(|| (one.len(), one).cmp(&(other.len(), other)))
}

/// Numbers of any length, leading zeros aside.
fn by_value(one: &str, other: &str) -> Ordering {
    let [one, other] = [one, other].map(|digits| digits.trim_start_matches('0'));
    (one.len(), one).cmp(&(other.len(), other))
}

/// The places of slices in a stack, in steps from the first, by the numbers in their names, which
/// are in order: where one number alone differs between them, it is the slice's. The step is the
/// largest that leads to all of them, so that evenly numbered slices are one step apart, whatever
/// that is. `None` where names have no such numbers.
pub fn places(names: &[String]) -> Option<Numbering> {
    let numbers: Vec<Vec<u64>> = names.iter().map(|name| numbers(name)).collect();
    let (first, rest) = numbers.split_first()?;
    if rest.is_empty() || rest.iter().any(|other| other.len() != first.len()) {
        return None;
    }
    let differs = |place: &usize| rest.iter().any(|other| other[*place] != first[*place]);
    let differing: Vec<usize> = (0..first.len()).filter(differs).collect();
    let &[place] = differing.as_slice() else { return None };
    let numbers: Vec<u64> = numbers.iter().map(|numbers| numbers[place]).collect();
    let steps: Option<Vec<u64>> = numbers
        .windows(2)
        .map(|pair| pair[1].checked_sub(pair[0]).filter(|&step| step > 0))
        .collect();
    let step = steps?.into_iter().fold(0, greatest_common_divisor);
    let places = numbers.iter().map(|number| (number - numbers[0]) / step.max(1)).collect();
    Some(Numbering { numbers, step, places })
}

/// How slices are numbered.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Numbering {
    /// In order.
    pub numbers: Vec<u64>,
    /// What all of them differ by, or by a multiple of it.
    pub step: u64,
    /// From the first, in steps.
    pub places: Vec<u64>,
}

impl Numbering {
    /// The first number that is missing, and how many are.
    pub fn missing(&self) -> Option<(u64, u64)> {
        let gap = self.places.windows(2).position(|pair| pair[1] != pair[0] + 1)?;
        let last = self.places.last()?;
        Some((self.numbers[gap] + self.step, last + 1 - self.places.len() as u64))
    }
}

fn greatest_common_divisor(one: u64, other: u64) -> u64 {
    if other == 0 { one } else { greatest_common_divisor(other, one % other) }
}

/// All numbers in a name; those that are too long to count by tell nothing.
fn numbers(name: &str) -> Vec<u64> {
    let parts = parts(name).into_iter();
    parts.filter_map(|part| part.number()).filter_map(|digits| digits.parse().ok()).collect()
}

#[derive(Debug, Clone, Copy)]
enum Part<'a> {
    Text(&'a str),
    Number(&'a str),
}

impl<'a> Part<'a> {
    fn text(self) -> &'a str {
        match self {
            Self::Text(text) | Self::Number(text) => text,
        }
    }

    fn number(self) -> Option<&'a str> {
        match self {
            Self::Number(digits) => Some(digits),
            Self::Text(_) => None,
        }
    }
}

/// A name as texts and numbers in turn.
fn parts(name: &str) -> Vec<Part<'_>> {
    let mut parts = Vec::new();
    let mut rest = name;
    while let Some(first) = rest.chars().next() {
        let is_number = first.is_ascii_digit();
        let end = rest.find(|c: char| c.is_ascii_digit() != is_number).unwrap_or(rest.len());
        let (part, after) = rest.split_at(end);
        parts.push(if is_number { Part::Number(part) } else { Part::Text(part) });
        rest = after;
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(names: &[&str]) -> Vec<String> {
        names.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn names_are_in_the_order_of_their_numbers() {
        let ordered = ["a1b10", "a1b9c", "a2", "a02", "a10", "b", "slice2", "slice10", "slice10b"];
        let mut names = ordered;
        names.sort_unstable();
        names.sort_by(|one, other| compare(one, other));
        let expected = ["a1b9c", "a1b10", "a2", "a02", "a10", "b", "slice2", "slice10", "slice10b"];
        assert_eq!(names, expected);
        assert_eq!(compare("99999999999999999999998", "99999999999999999999999"), Ordering::Less);
    }

    #[test]
    fn evenly_numbered_slices_are_one_step_apart() {
        let numbering = places(&named(&["mask_1_v2.png", "mask_5_v2.png", "mask_9_v2.png"]));
        let numbering = numbering.expect("numbers");
        assert_eq!((numbering.step, &numbering.places[..]), (4, &[0, 1, 2][..]));
        assert_eq!(numbering.missing(), None);
    }

    #[test]
    fn missing_numbers_leave_a_gap() {
        let numbering = places(&named(&["1", "2", "5", "6"])).expect("numbers");
        assert_eq!(numbering.places, [0, 1, 4, 5]);
        assert_eq!(numbering.missing(), Some((3, 2)));
    }

    #[test]
    fn names_without_one_number_that_differs_tell_no_places() {
        assert_eq!(places(&named(&["1a2", "2a3"])), None);
        assert_eq!(places(&named(&["a", "b"])), None);
        assert_eq!(places(&named(&["a1", "b"])), None);
        assert_eq!(places(&named(&["a1", "b1"])), None);
        assert_eq!(places(&named(&["a1", "a01"])), None);
        assert_eq!(places(&named(&["a1"])), None);
    }
}
