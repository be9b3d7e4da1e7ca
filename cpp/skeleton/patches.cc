#include "transect/cpp/skeleton/patches.h"

#include <map>
#include <string>
#include <unordered_map>

namespace transect::skeleton {
namespace {

using CellNames = std::unordered_map<std::string, Index>;

std::string name_of(const Sides& sides) { return std::string(sides.begin(), sides.end()); }

// The cells in which a piece lies, or on whose walls.
std::vector<Index> cells_of(const Scene& scene, const CellNames& names, const Piece& piece) {
  std::vector<Sides> all{Sides(scene.planes.size(), 0)};
  for (Index plane = 0; plane < scene.planes.size(); ++plane) {
    if (!scene.bounds_cells(plane)) continue;
    const auto from = scene.points.side(piece.from, plane);
    const auto side = from != 0 ? from : scene.points.side(piece.to, plane);
    const std::size_t count = all.size();
    for (std::size_t i = 0; i < count; ++i) {
      all[i][plane] = side != 0 ? side : 1;
      if (side != 0) continue;
      all.push_back(all[i]);
      all.back()[plane] = -1;
    }
  }
  std::vector<Index> cells;
  for (const Sides& sides : all) {
    const auto found = names.find(name_of(sides));
    if (found != names.end()) cells.push_back(found->second);
  }
  return cells;
}

// Points of the polygon in which a plane crosses a cell.
std::vector<Point> crossing(const Scene& scene, const Cells& cells, Index cell, Index plane) {
  std::vector<Point> points;
  bool is_front = false, is_behind = false;
  for (Index facet : cells.cells[cell].facets) {
    const auto& corners = cells.facets[facet].corners;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Index here = corners[i], next = corners[(i + 1) % corners.size()];
      const auto side = scene.points.side(here, plane);
      is_front = is_front || side > 0;
      is_behind = is_behind || side < 0;
      const Point &from = scene.points[here], &to = scene.points[next];
      if (side == 0) points.push_back(from);
      if (side * scene.points.side(next, plane) >= 0) continue;
      const Plane& own = scene.planes[plane];
      const Number a = own.distance(from), b = own.distance(to);
      points.push_back(from + a / (a - b) * (to - from));
    }
  }
  if (!is_front || !is_behind) points.clear();
  return points;
}

}  // namespace

Patches::Patches(const Scene& scene, const Cells& cells)
    : scene_(scene), cells_(cells), patches_(cells.cells.size()) {
  CellNames names;
  for (Index cell = 0; cell < cells.cells.size(); ++cell) {
    names.emplace(name_of(cells.cells[cell].sides), cell);
  }
  for (Index plane = 0; plane < scene.sections.size(); ++plane) {
    if (!scene.sections[plane].partial) continue;
    std::map<Index, std::vector<Piece>> pieces;
    for (const Piece& piece : scene.sections[plane].pieces) {
      for (Index cell : cells_of(scene, names, piece)) pieces[cell].push_back(piece);
    }
    for (Index cell = 0; cell < cells.cells.size(); ++cell) {
      const std::vector<Point> points = crossing(scene, cells, cell, plane);
      if (points.empty()) continue;
      CellPlane patch{plane, {}, 0, pieces[cell], unknown};
      if (patch.pieces.empty()) {
        Vector sum = CGAL::NULL_VECTOR;
        for (const Point& point : points) sum = sum + (point - CGAL::ORIGIN);
        const Number count(static_cast<double>(points.size()));
        patch.label = label_at(scene, plane, CGAL::ORIGIN + sum / count);
        if (patch.label == unknown) continue;
      }
      patches_[cell].push_back(std::move(patch));
    }
  }
}

PartialCell Patches::cell(Index cell, std::vector<Index>& shared) const {
  PartialCell result;
  result.planes = &scene_.planes;
  std::unordered_map<Index, Index> numbers;
  const auto number = [&](Index point) {
    const auto [found, is_new] = numbers.emplace(point, static_cast<Index>(shared.size()));
    if (is_new) {
      shared.push_back(point);
      result.points.push_back(scene_.points[point]);
    }
    return found->second;
  };
  const auto renumber = [&](CellPlane& plane) {
    for (Index& corner : plane.corners) corner = number(corner);
    for (Piece& piece : plane.pieces) {
      piece.from = number(piece.from);
      piece.to = number(piece.to);
    }
  };
  for (Index index : cells_.cells[cell].facets) {
    const Facet& facet = cells_.facets[index];
    CellPlane wall{facet.plane, facet.corners, facet.front == cell ? 1 : -1, facet.pieces,
                   facet.label};
    renumber(wall);
    result.walls.push_back(std::move(wall));
  }
  for (CellPlane patch : patches_[cell]) {
    renumber(patch);
    result.patches.push_back(std::move(patch));
  }
  return result;
}

}  // namespace transect::skeleton
