#include "transect/cpp/eikonal.h"

#include <openvdb/math/Stencils.h>
#include <openvdb/tree/LeafManager.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace transect::vdb {

namespace {

using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::FloatTree;
using Stencil = openvdb::math::WenoStencil<FloatGrid>;

// The bounds of the check for the squared gradient, and what is aimed at from
// either side: no more than needed.
constexpr float kLow = 0.5F;
constexpr float kHigh = 1.5F;
constexpr float kLowAim = 0.55F;
constexpr float kHighAim = 1.45F;
// What one scaling may do.
constexpr float kMinScale = 0.5F;
constexpr float kMaxScale = 1.5F;
// Rounds in which all nodes concerned are scaled alike; then chance decides,
// or two nodes could undo one another for ever.
constexpr int kOrderlyRounds = 8;
// After so many rounds what is left over begins anew, changed a little.
constexpr int kRoundsPerAttempt = 40;
constexpr int kAttempts = 30;
// The distance, in voxels, that a node gets with a new sign.
constexpr float kNewDistance = 0.5F;
// How far the check looks along each axis.
constexpr int kReach = 3;

// Pseudorandom, but a function of node and round alone.
uint32_t chance(const Coord& node, int round) {
  uint32_t hash = 2166136261U;
  for (const int part : {node.x(), node.y(), node.z(), round}) {
    hash = (hash ^ static_cast<uint32_t>(part)) * 16777619U;
    hash = (hash ^ (hash >> 13U)) * 0x5bd1e995U;
    hash ^= hash >> 15U;
  }
  return hash;
}

Coord neighbor(const Coord& node, int face) {
  Coord next = node;
  next[face / 2] += face % 2 != 0 ? 1 : -1;
  return next;
}

bool is_out_of_bounds(float squared_gradient) {
  return !(squared_gradient >= kLow && squared_gradient <= kHigh);
}

class Settler {
 public:
  explicit Settler(FloatGrid& grid)
      : grid_(grid),
        original_(grid.tree()),
        values_(grid.getAccessor()),
        stencil_(grid),
        limit_(grid.background() * 0.999F) {}

  void run() {
    std::vector<Coord> failing = all_failing();
    for (int round = 0; !failing.empty() && round < kAttempts * kRoundsPerAttempt; ++round) {
      const bool anew = round > 0 && round % kRoundsPerAttempt == 0;
      for (const Coord& node : failing) {
        if (anew) {
          begin_anew(node);
        } else {
          scale_around(node, round);
        }
        changed_.push_back(node);
      }
      failing = failing_near_changes();
    }
  }

 private:
  float squared_gradient(const Coord& node) {
    stencil_.moveTo(node);
    return stencil_.zeroCrossing() ? stencil_.normSqGrad() : 1.0F;
  }

  std::vector<Coord> all_failing() {
    openvdb::tree::LeafManager<const FloatTree> leafs(grid_.tree());
    std::vector<std::vector<Coord>> found(leafs.leafCount());
    leafs.foreach ([&](const FloatTree::LeafNodeType& leaf, size_t index) {
      Stencil stencil(grid_);
      for (auto value = leaf.cbeginValueOn(); value; ++value) {
        stencil.moveTo(value);
        if (stencil.zeroCrossing() && is_out_of_bounds(stencil.normSqGrad())) {
          found[index].push_back(value.getCoord());
        }
      }
    });
    std::vector<Coord> all;
    for (const auto& part : found) all.insert(all.end(), part.begin(), part.end());
    std::sort(all.begin(), all.end());
    return all;
  }

  std::vector<Coord> failing_near_changes() {
    std::vector<Coord> near;
    for (const Coord& node : changed_) {
      for (int axis = 0; axis < 3; ++axis) {
        for (int step = -kReach; step <= kReach; ++step) {
          Coord other = node;
          other[axis] += step;
          near.push_back(other);
        }
      }
    }
    changed_.clear();
    std::sort(near.begin(), near.end());
    near.erase(std::unique(near.begin(), near.end()), near.end());
    std::vector<Coord> failing;
    for (const Coord& node : near) {
      if (values_.isValueOn(node) && is_out_of_bounds(squared_gradient(node))) {
        failing.push_back(node);
      }
    }
    return failing;
  }

  void set(const Coord& node, float value) {
    if (!values_.isValueOn(node)) return;
    values_.setValue(node, std::clamp(value, -limit_, limit_));
    changed_.push_back(node);
  }

  // Scales the node, or its neighbours across the surface, or both: a common
  // factor leaves the surface between them where it is.
  void scale_around(const Coord& node, int round) {
    const float found = squared_gradient(node);
    if (!is_out_of_bounds(found)) return;
    const bool orderly = round < kOrderlyRounds;
    const uint32_t random = chance(node, round);
    const uint32_t which = orderly ? 3U : 1U + random % 3U;
    const float beyond = orderly ? 0.0F : static_cast<float>((random >> 8U) % 1000U) / 1000.0F;
    const float aim = found > 1.0F ? kHighAim : kLowAim;
    const float wanted = (aim + (1.0F - aim) * beyond) / std::max(found, 0.01F);
    const float scale = std::clamp(std::sqrt(wanted), kMinScale, kMaxScale);
    const float here = values_.getValue(node);
    if ((which & 1U) != 0) set(node, here * scale);
    if ((which & 2U) == 0) return;
    for (int face = 0; face < 6; ++face) {
      const Coord next = neighbor(node, face);
      const float there = values_.getValue(next);
      if ((there > 0.0F) != (here > 0.0F)) set(next, there * scale);
    }
  }

  // Takes back what was done around a node, and gives it and its neighbours
  // one sign: what is too thin for any level set is left out or filled.
  void begin_anew(const Coord& node) {
    float sum = 0.0F;
    for (int x = -kReach; x <= kReach; ++x) {
      for (int y = -kReach; y <= kReach; ++y) {
        for (int z = -kReach; z <= kReach; ++z) {
          const Coord near = node.offsetBy(x, y, z);
          const float value = original_.getValue(near);
          set(near, value);
          if (std::max({std::abs(x), std::abs(y), std::abs(z)}) <= 1) sum += value;
        }
      }
    }
    const float distance = kNewDistance * static_cast<float>(grid_.voxelSize()[0]);
    const auto join = [&](const Coord& near) {
      if ((values_.getValue(near) > 0.0F) != (sum > 0.0F)) set(near, std::copysign(distance, sum));
    };
    join(node);
    for (int face = 0; face < 6; ++face) join(neighbor(node, face));
  }

  FloatGrid& grid_;
  const FloatTree original_;
  FloatGrid::Accessor values_;
  Stencil stencil_;
  float limit_;
  std::vector<Coord> changed_;
};

}  // namespace

void settle_gradients(FloatGrid& level_set) { Settler(level_set).run(); }

}  // namespace transect::vdb
