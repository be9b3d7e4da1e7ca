// Isotropic remeshing of one patch of a surface by CGAL. No CGAL type crosses.
#pragma once

#include <cstdint>

#include "rust/cxx.h"
#include "transect/cpp/trycatch.h"

namespace transect::fairing {

struct Patch;

// Corner coordinates by threes, triangles by threes, for every vertex whether it
// is pinned. Edges of one triangle and pinned vertices stay as they are; other
// edges become about `edge_length` long. Nothing comes back when the triangles
// are no manifold, or none has an area. Throws on an index out of range.
Patch remesh(rust::Slice<const double> points, rust::Slice<const uint32_t> triangles,
             rust::Slice<const uint8_t> pinned, double edge_length, uint32_t iterations);

}  // namespace transect::fairing
