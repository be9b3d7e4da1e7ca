// Delaunay refinement of a labelled domain. No CGAL type crosses.
#pragma once

#include <cstdint>

#include "rust/cxx.h"
#include "transect/cpp/trycatch.h"

namespace transect::delaunay {

struct Criteria;
struct Facets;
struct Oracle;

// See the bridge. Throws when more vertices are needed than allowed.
Facets refine(const Oracle& oracle, rust::Slice<const double> bounds,
              rust::Slice<const double> seeds, rust::Slice<const uint32_t> seed_sides,
              rust::Slice<const double> curve_points, rust::Slice<const uint32_t> curve_ends,
              const Criteria& criteria);

}  // namespace transect::delaunay
