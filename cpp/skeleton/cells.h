// The convex cells between full sections, in the box.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "transect/cpp/skeleton/sections.h"

namespace transect::skeleton {

// A part of a plane that no other full section cuts.
struct Facet {
  Index plane;
  std::vector<Index> corners;  // counter-clockwise about the plane's normal, the least first
  Index front, behind;         // the cells; `none` beyond the box
  std::vector<Piece> pieces;   // not those along its edges
  Label label;                 // everywhere, when there is no piece
};

struct Cell {
  Sides sides;                // of every plane that bounds cells; 0 for the others
  std::vector<Index> facets;  // in the order of their planes
};

struct Cells {
  std::vector<Facet> facets;
  std::vector<Cell> cells;
};

// The places on the edges of cells where contours meet them, on whatever plane.
class LinePoints {
 public:
  explicit LinePoints(const Scene& scene);
  // Between two corners of an edge, in no order.
  const std::vector<Index>& between(Index corner, Index other) const;

 private:
  const Scene& scene_;
  std::map<std::string, std::vector<Index>> points_;  // by the sides of the edge
};

// Cuts the box, whose planes are the scene's last six, by all full sections,
// and puts pieces and labels on the facets.
Cells make_cells(Scene& scene);

}  // namespace transect::skeleton
