// The exact subdivision of a plane by segments. No CGAL type crosses.
#pragma once

#include "rust/cxx.h"
#include "transect/cpp/trycatch.h"

namespace transect::partition {

struct Partition;

Partition partition(rust::Slice<const double> points, rust::Slice<const std::uint32_t> segments);

}  // namespace transect::partition
