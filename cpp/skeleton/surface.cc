#include "transect/cpp/skeleton/surface.h"

#include <algorithm>

#include "transect/cpp/skeleton/overlay.h"
#include "transect/cpp/skeleton/roofs.h"
#include "transect/cpp/skeleton/walls.h"

namespace transect::skeleton {
namespace {

// More convex sites of partial sections take minutes: the number of territories
// grows exponentially with them.
constexpr std::size_t most_sites = 4;

CellSurface between_full_sections(const Prepared& prepared, Index cell) {
  const Heights heights(prepared.scene, prepared.cells, cell);
  if (!heights.labels_differ()) return {};
  CellPoints points(prepared.scene);
  Roofs roofs = make_roofs(heights, prepared.line_points, points);
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

bool labels_differ(const PartialCell& cell) {
  const Label first = cell.walls.front().label;
  const auto differs = [&](const CellPlane& plane) {
    for (const Piece& piece : plane.pieces) {
      for (Label label : {piece.left, piece.right}) {
        if (label != first && label != unknown) return true;
      }
    }
    return plane.pieces.empty() && plane.label != first;
  };
  return std::any_of(cell.walls.begin(), cell.walls.end(), differs) ||
         std::any_of(cell.patches.begin(), cell.patches.end(), differs);
}

CellSurface among_partial_sections(const Prepared& prepared, Index index) {
  std::vector<Index> shared;
  const PartialCell cell = prepared.patches.cell(index, shared);
  CellSurface result;
  if (!labels_differ(cell)) return result;
  if (partial_sites(cell) > most_sites) {
    result.is_left_out = true;
    return result;
  }
  PartialSurface made = partial_surface(cell);
  const Index base = static_cast<Index>(prepared.scene.points.size());
  const auto number = [&](Index point) {
    const Index own = static_cast<Index>(shared.size());
    return point < own ? shared[point] : base + (point - own);
  };
  result.added = std::move(made.added);
  result.triangles = std::move(made.triangles);
  for (Triangle& triangle : result.triangles) {
    for (Index& corner : triangle.corners) corner = number(corner);
    triangle = oriented(triangle);
  }
  for (const auto& split : made.splits) {
    const Piece& piece = cell.walls[split.wall].pieces[split.piece];
    result.splits.push_back({number(piece.from), number(piece.to), number(split.point)});
  }
  return result;
}

}  // namespace

CellSurface surface(const Prepared& prepared, Index cell) {
  return prepared.patches.in(cell) ? among_partial_sections(prepared, cell)
                                   : between_full_sections(prepared, cell);
}

}  // namespace transect::skeleton
