// Delaunay refinement of a labelled domain. No CGAL type crosses.
#pragma once

#include <cstdint>
#include <memory>

#include "rust/cxx.h"
#include "transect/cpp/trycatch.h"

namespace transect::delaunay {

struct Criteria;
struct Facets;
struct Oracle;

// A triangulation that is refined as often as there are new seeds. It asks the
// oracle that it was made with.
class Refinement {
 public:
  Refinement(const Oracle& oracle, rust::Slice<const double> bounds,
             rust::Slice<const double> curve_points, rust::Slice<const uint32_t> curve_ends,
             const Criteria& criteria);
  ~Refinement();

  // See the bridge. Throws when more vertices are needed than allowed.
  Facets refine(rust::Slice<const double> seeds, rust::Slice<const uint32_t> sides);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

std::unique_ptr<Refinement> new_refinement(const Oracle& oracle, rust::Slice<const double> bounds,
                                           rust::Slice<const double> curve_points,
                                           rust::Slice<const uint32_t> curve_ends,
                                           const Criteria& criteria);

}  // namespace transect::delaunay
