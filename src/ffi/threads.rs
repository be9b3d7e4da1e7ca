//! How many threads the C++ libraries may use (`cpp/threads.cc`).

#[cxx::bridge(namespace = "transect::threads")]
mod bridge {
    unsafe extern "C++" {
        include!("transect/cpp/threads.h");

        /// Limits TBB, which OpenVDB runs on, to `count` threads from now on.
        fn limit_threads(count: usize) -> Result<()>;
    }
}

pub use bridge::*;
