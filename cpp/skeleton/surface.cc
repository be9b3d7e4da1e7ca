#include "transect/cpp/skeleton/surface.h"

#include "transect/cpp/skeleton/overlay.h"
#include "transect/cpp/skeleton/roofs.h"
#include "transect/cpp/skeleton/walls.h"

namespace transect::skeleton {

CellSurface surface(const Scene& scene, const Cells& cells, const LinePoints& line_points,
                    Index cell) {
  const Heights heights(scene, cells, cell);
  if (!heights.labels_differ()) return {};
  CellPoints points(scene);
  Roofs roofs = make_roofs(heights, line_points, points);
  CellSurface result;
  for (Roof& roof : roofs.roofs) {
    const auto triangles = overlay(heights, roof, points);
    result.triangles.insert(result.triangles.end(), triangles.begin(), triangles.end());
  }
  for (const Lifted& lifted : roofs.lifted) {
    add_wall(heights, roofs, lifted, points, result.triangles);
  }
  for (Triangle& triangle : result.triangles) {
    for (Index& corner : triangle.corners) corner = points.first(corner);
  }
  result.added = points.added();
  return result;
}

}  // namespace transect::skeleton
