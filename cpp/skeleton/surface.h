// The surfaces in one cell.
#pragma once

#include "transect/cpp/skeleton/patches.h"

namespace transect::skeleton {

// A point on a contour's piece that only one of the cells beside it knows.
struct Split {
  Index from, to, point;
};

struct CellSurface {
  std::vector<Point> added;  // the points that follow the scene's
  std::vector<Triangle> triangles;
  std::vector<Split> splits;
  // There are too many partial sections to partition the cell, or its partition came
  // out open: it has no surface.
  bool is_left_out = false;
  PartialSurface::Inexact inexact;
};

// What does not change while cells are worked on.
struct Prepared {
  const Scene& scene;
  const Cells& cells;
  const LinePoints& line_points;
  const Patches& patches;
  // A cell with more pieces between known and unknown has no surface.
  std::size_t most_pieces;
};

// Whoever watches is told little of cells between full sections alone: they are done soon.
CellSurface surface(const Prepared& prepared, Index cell, const Watch& watch);

}  // namespace transect::skeleton
