#include "transect/cpp/grid.h"

#include <openvdb/openvdb.h>
#include <openvdb/tree/LeafManager.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <vector>

#include "transect/src/ffi/grid.rs.h"

namespace transect::grid {

namespace {

using openvdb::Coord;
using openvdb::FloatTree;
using openvdb::Index;
using openvdb::MaskTree;
using FloatLeaf = FloatTree::LeafNodeType;
using MaskLeaf = MaskTree::LeafNodeType;
using Leafs = openvdb::tree::LeafManager<FloatTree>;

// Not in the material: the tree's background.
constexpr float kAbsent = -1.0F;
// One step looks two nodes far; after this many a leaf further away may be
// reached.
constexpr uint32_t kStepsPerLeaf = FloatLeaf::DIM / 2;

Coord origin(rust::Slice<const int32_t> leaves, size_t index) {
  const int dim = FloatLeaf::DIM;
  return {leaves[3 * index] * dim, leaves[3 * index + 1] * dim, leaves[3 * index + 2] * dim};
}

}  // namespace

struct Trees {
  // Its leaves are the region in which values exist; on where a node is fixed.
  MaskTree region;
  std::vector<FloatTree::Ptr> materials;
};

namespace {

// A leaf with its six neighbours, in one of the two states between which a
// step alternates: values, or Laplacians. Neighbours that the tree does not
// store have the value `absent` when they are in the region; beyond the
// region there is no flux.
class Stencil {
 public:
  Stencil(const FloatTree& tree, const MaskTree& region, const FloatLeaf& leaf, float absent)
      : center_(leaf.buffer().data()), absent_(absent) {
    for (int face = 0; face < 6; ++face) {
      Coord next = leaf.origin();
      next[face / 2] += (face % 2 != 0 ? 1 : -1) * int(FloatLeaf::DIM);
      const FloatLeaf* found = tree.probeConstLeaf(next);
      values_[face] = found != nullptr ? found->buffer().data() : nullptr;
      in_region_[face] = found != nullptr || region.probeConstLeaf(next) != nullptr;
    }
  }

  // The sum over a node's neighbours of their difference to it.
  float laplacian(Index node) const {
    const float here = center_[node];
    float sum = 0.0F;
    for (int face = 0; face < 6; ++face) {
      // A node's index has three bits for each axis, z lowest.
      const int shift = 3 * (2 - face / 2);
      const Index along = (node >> shift) & 7U;
      const bool forward = face % 2 != 0;
      if (along != (forward ? 7U : 0U)) {
        sum += center_[forward ? node + (1U << shift) : node - (1U << shift)] - here;
      } else if (values_[face] != nullptr) {
        sum += values_[face][node ^ (7U << shift)] - here;
      } else if (in_region_[face]) {
        sum += absent_ - here;
      }
    }
    return sum;
  }

 private:
  const float* center_;
  float absent_;
  std::array<const float*, 6> values_{};
  std::array<bool, 6> in_region_{};
};

// Stores the leaves of the region next to those stored, so that values can
// flow into them.
void dilate(FloatTree& tree, const MaskTree& region) {
  std::vector<Coord> missing;
  for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) {
    for (int neighbor = 0; neighbor < 27; ++neighbor) {
      const Coord step(neighbor / 9 - 1, neighbor / 3 % 3 - 1, neighbor % 3 - 1);
      const Coord next = leaf->origin() + Coord(step.x() * 8, step.y() * 8, step.z() * 8);
      if (tree.probeConstLeaf(next) == nullptr && region.probeConstLeaf(next) != nullptr) {
        missing.push_back(next);
      }
    }
  }
  for (const Coord& at : missing) tree.touchLeaf(at)->setValuesOn();
}

// One step. Laplacians are written to the second buffers, which then take the
// place of the values while the Laplacian of them is taken: no leaf reads
// what another one writes.
void step(Leafs& leafs, const FloatTree& tree, const MaskTree& region, float rate) {
  leafs.foreach ([&](FloatLeaf& leaf, size_t index) {
    const Stencil stencil(tree, region, leaf, kAbsent);
    float* out = leafs.getBuffer(index, 1).data();
    for (Index node = 0; node < FloatLeaf::SIZE; ++node) out[node] = stencil.laplacian(node);
  });
  leafs.swapLeafBuffer(1);
  leafs.foreach ([&](FloatLeaf& leaf, size_t index) {
    const Stencil stencil(tree, region, leaf, 0.0F);
    const MaskLeaf& fixed = *region.probeConstLeaf(leaf.origin());
    float* out = leafs.getBuffer(index, 1).data();
    for (Index node = 0; node < FloatLeaf::SIZE; ++node) {
      if (!fixed.isValueOn(node)) out[node] -= rate * stencil.laplacian(node);
    }
  });
  leafs.swapLeafBuffer(1);
}

void smooth_material(FloatTree& tree, const MaskTree& region, uint32_t steps, float rate) {
  for (uint32_t done = 0; done < steps; done += kStepsPerLeaf) {
    dilate(tree, region);
    Leafs leafs(tree, /*auxBuffersPerLeaf=*/1);
    const uint32_t now = std::min(kStepsPerLeaf, steps - done);
    for (uint32_t count = 0; count < now; ++count) step(leafs, tree, region, rate);
  }
}

}  // namespace

std::unique_ptr<Grid> new_grid(rust::Slice<const int32_t> leaves,
                               rust::Slice<const uint64_t> fixed) {
  auto grid = std::make_unique<Grid>();
  grid->trees = std::make_shared<Trees>();
  for (size_t index = 0; index < leaves.size() / 3; ++index) {
    MaskLeaf* leaf = grid->trees->region.touchLeaf(origin(leaves, index));
    for (Index node = 0; node < MaskLeaf::SIZE; ++node) {
      const uint64_t word = fixed[index * 8 + node / 64];
      leaf->setActiveState(node, ((word >> (node % 64)) & 1U) != 0);
    }
  }
  return grid;
}

void add_material(Grid& grid, rust::Slice<const int32_t> leaves, rust::Slice<const float> values) {
  auto tree = std::make_shared<FloatTree>(kAbsent);
  for (size_t index = 0; index < leaves.size() / 3; ++index) {
    const Coord at = origin(leaves, index);
    if (grid.trees->region.probeConstLeaf(at) == nullptr) {
      throw std::invalid_argument("a leaf of a material is not in the grid");
    }
    FloatLeaf* leaf = tree->touchLeaf(at);
    const float* first = values.data() + index * FloatLeaf::SIZE;
    std::copy(first, first + FloatLeaf::SIZE, leaf->buffer().data());
    leaf->setValuesOn();
  }
  grid.trees->materials.push_back(tree);
}

void smooth(Grid& grid, uint32_t steps, float rate) {
  for (const FloatTree::Ptr& tree : grid.trees->materials) {
    smooth_material(*tree, grid.trees->region, steps, rate);
  }
}

Leaves take_material(Grid& grid, size_t material) {
  FloatTree::Ptr tree = std::move(grid.trees->materials.at(material));
  Leaves taken;
  const size_t count = tree->leafCount();
  taken.at.reserve(3 * count);
  taken.values.reserve(FloatLeaf::SIZE * count);
  for (auto leaf = tree->cbeginLeaf(); leaf; ++leaf) {
    for (int axis = 0; axis < 3; ++axis) taken.at.push_back(leaf->origin()[axis] / 8);
    const float* values = leaf->buffer().data();
    for (Index node = 0; node < FloatLeaf::SIZE; ++node) taken.values.push_back(values[node]);
  }
  return taken;
}

}  // namespace transect::grid
