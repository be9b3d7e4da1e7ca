//! Numbers as people read them.

/// Six significant digits.
pub fn number(value: f64) -> String {
    let value = value + 0.0; // no −0
    let digits = value.abs().max(1e-300).log10().floor();
    if (-4.0..6.0).contains(&digits) {
        format!("{value:.*}", (5.0 - digits) as usize)
    } else {
        format!("{value:.5e}")
    }
}

/// Groups of three digits.
pub fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

/// Memory, rounded up.
pub fn mebibytes(bytes: u64) -> String {
    format!("{} MiB", bytes.div_ceil(1 << 20))
}
