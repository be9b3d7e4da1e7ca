// The surfaces in one cell.
#pragma once

#include "transect/cpp/skeleton/content.h"

namespace transect::skeleton {

// A point on a contour's piece that only one of the cells beside it knows.
struct Split {
  Index from, to, point;
};

struct CellSurface {
  std::vector<Point> added;  // the points that follow the content's
  std::vector<Triangle> triangles;
  std::vector<Split> splits;
  // There are too many partial sections to partition the cell, or its partition came
  // out open: it has no surface.
  bool is_left_out = false;
  PartialSurface::Inexact inexact;
};

// In the content's numbers of points and planes. Whoever watches is told little of cells
// between full sections alone: they are done soon.
CellSurface surface(const Scene& scene, const Content& content, const Watch& watch);

}  // namespace transect::skeleton
