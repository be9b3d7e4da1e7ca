// The indicators of all materials as OpenVDB trees, and their smoothing. No
// OpenVDB type crosses.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "rust/cxx.h"
#include "transect/cpp/trycatch.h"

namespace transect::grid {

struct Trees;
struct Leaves;

/// A tree for each material, and the region in which they have values.
struct Grid {
  std::shared_ptr<Trees> trees;
};

/// A grid of the given leaves (three coordinates each, in leaves), with one
/// bit for every node that stays as it is (eight words a leaf, bit n of the
/// leaf's node n).
std::unique_ptr<Grid> new_grid(rust::Slice<const int32_t> leaves,
                               rust::Slice<const uint64_t> fixed);

/// Adds a material that is -1 but for some leaves of the grid.
void add_material(Grid& grid, rust::Slice<const int32_t> leaves, rust::Slice<const float> values);

/// Smooths every material by so many steps f -= rate * (Laplacian of the
/// Laplacian of f), in voxels.
void smooth(Grid& grid, uint32_t steps, float rate);

/// Takes the leaves of a material out of the grid, in no certain order.
Leaves take_material(Grid& grid, size_t material);

}  // namespace transect::grid
