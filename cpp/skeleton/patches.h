// Which partial sections are in which cell.
#pragma once

#include "transect/cpp/skeleton/cells.h"
#include "transect/cpp/skeleton/partial.h"

namespace transect::skeleton {

// What cells show, and known parts of partial sections in them.
class Patches {
 public:
  Patches(const Scene& scene, const Cells& cells);

  // The cell with its own numbers of points, and the scene's number of each.
  PartialCell cell(Index cell, std::vector<Index>& shared) const;

 private:
  const Scene& scene_;
  const Cells& cells_;
  std::vector<std::vector<CellPlane>> patches_;  // points by the scene's numbers
};

}  // namespace transect::skeleton
