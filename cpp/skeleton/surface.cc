#include "transect/cpp/skeleton/surface.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "transect/cpp/skeleton/overlay.h"
#include "transect/cpp/skeleton/roofs.h"
#include "transect/cpp/skeleton/walls.h"

namespace transect::skeleton {
namespace {

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

// The pieces between known and unknown.
std::size_t outline_size(const PartialCell& cell) {
  std::size_t size = 0;
  for (const CellPlane& patch : cell.patches) {
    size += std::count_if(patch.pieces.begin(), patch.pieces.end(), [](const Piece& piece) {
      return piece.left == unknown || piece.right == unknown;
    });
  }
  return size;
}

// Whether every label's boundary is closed but for edges on the cell's walls, where
// the next cell goes on.
bool is_closed(const PartialCell& cell, const PartialSurface& made) {
  std::map<std::pair<Index, Index>, std::map<Label, int>> balance;
  for (const Triangle& triangle : made.triangles) {
    for (int corner = 0; corner < 3; ++corner) {
      const Index from = triangle.corners[corner], to = triangle.corners[(corner + 1) % 3];
      const int way = from < to ? 1 : -1;
      auto& labels = balance[std::minmax(from, to)];
      labels[triangle.back] += way;
      labels[triangle.front] -= way;
    }
  }
  const auto point = [&](Index index) {
    const Index own = static_cast<Index>(cell.points.size());
    return index < own ? cell.points[index] : made.added[index - own];
  };
  const auto is_on_wall = [&](const std::pair<Index, Index>& edge) {
    return std::any_of(cell.walls.begin(), cell.walls.end(), [&](const CellPlane& wall) {
      const Plane& plane = (*cell.planes)[wall.plane];
      return CGAL::is_zero(plane.distance(point(edge.first))) &&
             CGAL::is_zero(plane.distance(point(edge.second)));
    });
  };
  return std::all_of(balance.begin(), balance.end(), [&](const auto& entry) {
    const bool is_balanced = std::all_of(entry.second.begin(), entry.second.end(),
                                         [](const auto& label) { return label.second == 0; });
    return is_balanced || is_on_wall(entry.first);
  });
}

CellSurface among_partial_sections(const Prepared& prepared, Index index, const Watch& watch) {
  std::vector<Index> shared;
  const PartialCell cell = prepared.patches.cell(index, shared);
  CellSurface result;
  if (!labels_differ(cell)) return result;
  if (outline_size(cell) > prepared.most_pieces) {
    result.is_left_out = true;
    return result;
  }
  PartialSurface made = partial_surface(cell, watch);
  if (!is_closed(cell, made)) {
    result.is_left_out = true;
    return result;
  }
  const Index base = static_cast<Index>(prepared.scene.points.size());
  const auto number = [&](Index point) {
    const Index own = static_cast<Index>(shared.size());
    return point < own ? shared[point] : base + (point - own);
  };
  result.inexact = made.inexact;
  result.added = std::move(made.added);
  result.triangles = std::move(made.triangles);
  for (Triangle& triangle : result.triangles) {
    for (Index& corner : triangle.corners) corner = number(corner);
    triangle = oriented(triangle);
  }
  std::set<std::pair<Index, Index>> split;
  for (const auto& [from, to, point] : made.splits) {
    result.splits.push_back({number(from), number(to), number(point)});
    split.insert(std::minmax(number(from), number(to)));
  }
  // Other cells around an edge have points on it of contours that this one does not see.
  for (const Index facet : prepared.cells.cells[index].facets) {
    const std::vector<Index>& corners = prepared.cells.facets[facet].corners;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Index from = corners[i], to = corners[(i + 1) % corners.size()];
      if (split.count(std::minmax(from, to)) == 0) continue;
      for (const Index point : prepared.line_points.between(from, to)) {
        result.splits.push_back({from, to, point});
      }
    }
  }
  return result;
}

// Puts points and triangles in an order of their own: that of a triangulation's vertices and
// faces hangs on the addresses by which CGAL orders the edges it flips.
void arrange(CellSurface& made, Index shared) {
  std::vector<Index> order(made.added.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](Index a, Index b) { return made.added[a] < made.added[b]; });
  std::vector<Point> added;
  std::vector<Index> numbers(order.size());
  for (Index point : order) {
    numbers[point] = shared + static_cast<Index>(added.size());
    added.push_back(made.added[point]);
  }
  made.added = std::move(added);
  const auto renumber = [&](Index& point) {
    if (point >= shared) point = numbers[point - shared];
  };
  for (Split& split : made.splits) {
    for (Index* point : {&split.from, &split.to, &split.point}) renumber(*point);
  }
  for (auto& [corners, back, front, kind, planes] : made.triangles) {
    for (Index& corner : corners) renumber(corner);
    std::rotate(corners, std::min_element(corners, corners + 3), corners + 3);
  }
  std::stable_sort(
      made.triangles.begin(), made.triangles.end(), [](const Triangle& a, const Triangle& b) {
        return std::lexicographical_compare(a.corners, a.corners + 3, b.corners, b.corners + 3);
      });
}

}  // namespace

CellSurface surface(const Prepared& prepared, Index cell, const Watch& watch) {
  CellSurface made = prepared.patches.in(cell) ? among_partial_sections(prepared, cell, watch)
                                               : between_full_sections(prepared, cell);
  arrange(made, static_cast<Index>(prepared.scene.points.size()));
  return made;
}

}  // namespace transect::skeleton
