// The surfaces in one cell.
#pragma once

#include "transect/cpp/skeleton/cells.h"

namespace transect::skeleton {

struct CellSurface {
  std::vector<Point> added;  // the points that follow the scene's
  std::vector<Triangle> triangles;
};

CellSurface surface(const Scene& scene, const Cells& cells, const LinePoints& line_points,
                    Index cell);

}  // namespace transect::skeleton
