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

CellSurface between_full_sections(const Scene& scene, const Content& content) {
  const Heights heights(scene, content);
  CellPoints points(heights);
  Roofs roofs = make_roofs(heights, points);
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

CellSurface among_partial_sections(const Content& content, const Watch& watch) {
  CellSurface result;
  PartialSurface made = partial_surface(content.cell, watch);
  if (!is_closed(content.cell, made)) {
    result.is_left_out = true;
    return result;
  }
  const Index own = static_cast<Index>(content.cell.points.size());
  const Index base = static_cast<Index>(content.points.size());
  const auto number = [&](Index point) { return point < own ? point : base + (point - own); };
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
  for (const auto& [ends, on_edge] : content.on_edges) {
    if (split.count(ends) == 0) continue;
    for (const Index point : on_edge) result.splits.push_back({ends.first, ends.second, point});
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

// Planes by their numbers in the content.
void renumber_planes(CellSurface& made, const Content& content) {
  const std::vector<Index> planes = content.planes();
  for (Triangle& triangle : made.triangles) {
    for (Index& plane : triangle.planes) {
      plane = static_cast<Index>(std::find(planes.begin(), planes.end(), plane) - planes.begin());
    }
  }
}

}  // namespace

CellSurface surface(const Scene& scene, const Content& content, const Watch& watch) {
  CellSurface made = content.has_patches() ? among_partial_sections(content, watch)
                                           : between_full_sections(scene, content);
  renumber_planes(made, content);
  arrange(made, static_cast<Index>(content.points.size()));
  return made;
}

}  // namespace transect::skeleton
