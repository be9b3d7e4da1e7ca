// Constrained Delaunay triangulation of polygonal regions, by CGAL. No CGAL type crosses.
#pragma once

#include <cstdint>

#include "rust/cxx.h"
#include "transect/cpp/trycatch.h"

namespace transect::triangulation {

struct Triangulation;

Triangulation triangulate(rust::Slice<const double> points,
                          rust::Slice<const std::uint32_t> segments,
                          rust::Slice<const std::uint32_t> regions, double spacing);

}  // namespace transect::triangulation
