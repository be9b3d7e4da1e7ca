// The surfaces in one leaf. It is divided into regions (territory.h), and every region has
// labels (labels.h). Surfaces are then
//
//   walls   within a region, where its labels change
//   roofs   between two regions whose labels differ
//
// Both are boundaries of one function of space, so the boundary of every label is closed.
#pragma once

#include <map>
#include <memory>
#include <set>

#include "transect/cpp/skeleton/labels.h"
#include "transect/cpp/skeleton/sheets.h"

namespace transect::skeleton::partial {

// A facet of a region.
struct Front {
  Outline outline;
  CGAL::Bbox_3 box;            // around it
  std::vector<Polygon> lines;  // on it, where labels change
  std::shared_ptr<const RegionLabels> labels;
};

// Facets in one plane: of regions behind it and before it.
struct Fronts {
  std::vector<Front> behind, before;
};

// The roof where two facets meet, one of what is behind the plane and one of what is before
// it; none if they do not, or if labels are the same.
std::optional<Tile> roof(const Halfspace& plane, const Front& back, const Front& front);

struct LeafSurfaces {
  std::map<PlaneKey, std::vector<Tile>> tiles;
  // What is in planes between leaves, where the leaf is beside one that is not exact.
  std::map<PlaneKey, Fronts> on_cuts;
  // Whether no surface lies in planes between leaves.
  bool is_apart = true;
};

// The planes between leaves.
struct Cuts {
  const Leaves& leaves;
  std::set<PlaneKey> keys;

  explicit Cuts(const Leaves& leaves);
  // Whether a plane is one of them, which are square to the axes.
  bool has(const Halfspace& plane) const;
};

LeafSurfaces leaf_surfaces(const Leaf& leaf, const Distances& distances, const Cuts& cuts);

// The facets between leaves of a leaf with one label.
std::map<PlaneKey, Fronts> fronts_on_cuts(const Leaf& leaf, Index plane, const Cuts& cuts);

}  // namespace transect::skeleton::partial
