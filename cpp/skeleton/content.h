// What a cell's surfaces follow from, in numbers of its own. Nothing else of the scene
// bears on them, so that cells with the same content, of whatever scene, have the same
// surfaces.
#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "transect/cpp/skeleton/patches.h"

namespace transect::skeleton {

struct Content {
  // The scene's number of every point: those of the cell, then others on its edges.
  std::vector<Index> points;
  // Walls come in the order of their planes.
  PartialCell cell;
  // Where contours, of whatever plane, meet the cell's edges; by the ends in ascending order.
  std::map<std::pair<Index, Index>, std::vector<Index>> on_edges;

  Content(const Patches& patches, const LinePoints& line_points, Index cell);

  bool has_patches() const { return !cell.patches.empty(); }
  // Whether there are two labels in the cell.
  bool labels_differ() const;
  // How many pieces are between known and unknown.
  std::size_t outline_size() const;

  // The scene's numbers of its planes: of the walls, then of the patches.
  std::vector<Index> planes() const;
  // All of it, which for other content are other words.
  std::vector<std::uint64_t> words(const Scene& scene) const;
};

}  // namespace transect::skeleton
