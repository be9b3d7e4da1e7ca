// The exact subdivision of one plane of the box, by CGAL's Arrangement_2. No
// CGAL type crosses.
#pragma once

#include <cstdint>

#include "rust/cxx.h"
#include "transect/cpp/trycatch.h"

namespace transect::arrangement {

struct Subdivision;

rust::Vec<std::uint32_t> first_coincident(rust::Slice<const double> planes);

Subdivision subdivide(rust::Slice<const double> planes, rust::Slice<const std::uint32_t> distinct,
                      std::uint32_t own, rust::Slice<const std::uint32_t> axes,
                      rust::Slice<const double> bounds, rust::Slice<const double> vertices,
                      rust::Slice<const std::uint32_t> edges);

}  // namespace transect::arrangement
