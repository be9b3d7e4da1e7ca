//! Where the program's memory comes from, and how it ends when there is none left.

use std::alloc::{GlobalAlloc, Layout, System};
use std::io::Write;

use crate::output;

/// The system's allocator. Where it has no memory, the program ends with exit status 1, one line
/// and no half-written file, instead of being aborted: not all that a file asks for is known
/// before it is read.
#[derive(Debug)]
pub struct Allocator;

// SAFETY: all requests go to the system's allocator as they are; what it returns is returned.
unsafe impl GlobalAlloc for Allocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promise about the layout is the one that is asked for.
        require(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as above.
        require(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, place: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: as above.
        require(unsafe { System.realloc(place, layout, size) }, size)
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(place, layout) }
    }
}

fn require(place: *mut u8, size: usize) -> *mut u8 {
    if place.is_null() {
        end(size);
    }
    place
}

/// Allocates nothing.
#[cold]
fn end(size: usize) -> ! {
    let mut line = [0; 200];
    let mut rest = &mut line[..];
    let _ = writeln!(
        rest,
        "error: there is not enough memory ({} MiB more are needed at once): use smaller input, a \
         lower resolution, or more memory",
        size.div_ceil(1 << 20)
    );
    let left = rest.len();
    let length = line.len() - left;
    let _ = std::io::stderr().write_all(&line[..length]);
    output::remove_temporary_files_without_waiting();
    std::process::exit(1);
}
