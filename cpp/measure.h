// Questions about triangle meshes, answered by CGAL. No CGAL type crosses.
#pragma once

#include <cstdint>
#include <memory>

#include "rust/cxx.h"
#include "transect/cpp/trycatch.h"

namespace transect::measure {

struct Facts;

rust::String library_versions();

// Corner coordinates by threes, triangles by threes. Throws on an index out of
// range.
Facts measure(rust::Slice<const double> points, rust::Slice<const uint32_t> triangles);
// The pairs of triangles that cross each other, whether they share vertices or not. Those
// that only touch in corners or edges at the same place do not. With triangles that are
// asked for, only pairs with one of these.
rust::Vec<uint32_t> crossings(rust::Slice<const double> points,
                              rust::Slice<const uint32_t> triangles,
                              rust::Slice<const uint32_t> asked);

// An AABB tree over the triangles that have an area, with all that queries
// need built: after that they only read.
class Tree {
 public:
  struct Impl;
  explicit Tree(std::unique_ptr<const Impl> impl);
  ~Tree();
  const Impl& impl() const { return *impl_; }

 private:
  std::unique_ptr<const Impl> impl_;
};
std::unique_ptr<Tree> new_tree(rust::Slice<const double> points,
                               rust::Slice<const uint32_t> triangles);
// For each point (by threes) the distance to the nearest triangle.
rust::Vec<double> distances(const Tree& tree, rust::Slice<const double> points);
// For each point (by threes) the number of the nearest triangle, as given.
rust::Vec<uint32_t> nearest_triangles(const Tree& tree, rust::Slice<const double> points);

}  // namespace transect::measure
