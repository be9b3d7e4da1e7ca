// Edge collapse by quadric error. No CGAL type crosses.
#pragma once

#include <cstdint>

#include "rust/cxx.h"
#include "transect/cpp/trycatch.h"

namespace transect::decimation {

struct Simplified;
struct Watch;

// Corner coordinates by threes, triangles by threes; for every vertex a name, or kNoName
// (`u32::MAX`) where it may move, how far it may come from what it is made of, and how far it has
// come. Throws on an index out of range, and when the triangles are no manifold.
Simplified simplify(rust::Slice<const double> points, rust::Slice<const uint32_t> triangles,
                    rust::Slice<const uint32_t> names, rust::Slice<const double> limits,
                    rust::Slice<const double> reached, std::size_t wanted, const Watch& watch);

}  // namespace transect::decimation
