#include "transect/cpp/skeleton/cells.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <stdexcept>
#include <string>
#include <unordered_map>

namespace transect::skeleton {
namespace {

Point meeting_point(const Plane& a, const Plane& b, const Plane& c) {
  const Vector bc = CGAL::cross_product(b.normal, c.normal);
  const Vector ca = CGAL::cross_product(c.normal, a.normal);
  const Vector ab = CGAL::cross_product(a.normal, b.normal);
  return CGAL::ORIGIN + (a.offset * bc + b.offset * ca + c.offset * ab) / (a.normal * bc);
}

bool are_parallel(const Plane& a, const Plane& b) {
  return CGAL::cross_product(a.normal, b.normal) == CGAL::NULL_VECTOR;
}

// Cuts cells by one plane after another.
class Cutter {
 public:
  Cutter(Scene& scene, Cells& cells) : scene_(scene), cells_(cells) {}

  // The box as one cell: its planes are lower and upper x, y, z.
  void start() {
    const Index box = static_cast<Index>(scene_.sections.size());
    Index corner[2][2][2];
    for (int x : {0, 1}) {
      for (int y : {0, 1}) {
        for (int z : {0, 1}) {
          const Index a = box + x, b = box + 2 + y, c = box + 4 + z;
          corner[x][y][z] = scene_.points.add(
              meeting_point(scene_.planes[a], scene_.planes[b], scene_.planes[c]), {a, b, c});
        }
      }
    }
    Cell cell{Sides(scene_.planes.size(), 0), {}};
    for (int axis = 0; axis < 3; ++axis) {
      for (int upper : {0, 1}) {
        Facet facet{box + 2 * axis + upper, {}, 0, none, {}, outside};
        for (int step = 0; step < 4; ++step) {
          int at[3];
          at[axis] = upper;
          at[(axis + 1) % 3] = step == 1 || step == 2;
          at[(axis + 2) % 3] = step >= 2;
          facet.corners.push_back(corner[at[0]][at[1]][at[2]]);
        }
        // The normal points inward: down the axis on the upper side.
        if (upper) std::reverse(facet.corners.begin(), facet.corners.end());
        cell.sides[facet.plane] = 1;
        cell.facets.push_back(static_cast<Index>(cells_.facets.size()));
        cells_.facets.push_back(std::move(facet));
      }
    }
    cells_.cells.push_back(std::move(cell));
  }

  void cut(Index plane) {
    plane_ = plane;
    in_front_.clear();
    crossings_.clear();
    const std::size_t count = cells_.cells.size();
    for (Index cell = 0; cell < count; ++cell) {
      bool front = false, behind = false;
      for (Index facet : cells_.cells[cell].facets) {
        // A facet cut on behalf of the cell beyond has its front part elsewhere.
        if (in_front_.count(facet)) front = true;
        for (Index corner : cells_.facets[facet].corners) {
          front = front || side(corner) > 0;
          behind = behind || side(corner) < 0;
        }
      }
      if (front && behind) {
        cut_cell(cell);
      } else {
        cells_.cells[cell].sides[plane] = front ? 1 : -1;
      }
    }
  }

 private:
  std::int8_t side(Index point) const { return scene_.points.side(point, plane_); }

  // The cell keeps the part behind the plane, a new one gets that in front.
  void cut_cell(Index cell) {
    const Index other = static_cast<Index>(cells_.cells.size());
    std::vector<Index> front, behind;
    for (Index facet : std::vector<Index>(cells_.cells[cell].facets)) {
      cut_facet(facet);
      const auto cut = in_front_.find(facet);
      if (cut != in_front_.end()) {
        behind.push_back(facet);
        front.push_back(cut->second);
      } else {
        const auto& corners = cells_.facets[facet].corners;
        const bool is_front = std::any_of(corners.begin(), corners.end(),
                                          [&](Index corner) { return side(corner) > 0; });
        (is_front ? front : behind).push_back(facet);
      }
    }
    for (Index facet : front) {
      Facet& own = cells_.facets[facet];
      if (own.front == cell) own.front = other;
      if (own.behind == cell) own.behind = other;
    }
    const Index lid = static_cast<Index>(cells_.facets.size());
    cells_.facets.push_back({plane_, lid_corners(cell, behind), other, cell, {}, outside});
    front.push_back(lid);
    behind.push_back(lid);
    Cell made{cells_.cells[cell].sides, std::move(front)};
    made.sides[plane_] = 1;
    cells_.cells[cell].sides[plane_] = -1;
    cells_.cells[cell].facets = std::move(behind);
    cells_.cells.push_back(std::move(made));
  }

  void cut_facet(Index facet) {
    if (in_front_.count(facet)) return;  // for the cell beyond
    std::vector<Index> front, behind;
    const std::vector<Index> corners = cells_.facets[facet].corners;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Index here = corners[i], next = corners[(i + 1) % corners.size()];
      if (side(here) >= 0) front.push_back(here);
      if (side(here) <= 0) behind.push_back(here);
      if (side(here) * side(next) < 0) {
        const Index point = crossing(here, next);
        front.push_back(point);
        behind.push_back(point);
      }
    }
    if (front.size() < 3 || behind.size() < 3) return;
    Facet made = cells_.facets[facet];
    made.corners = std::move(front);
    cells_.facets[facet].corners = std::move(behind);
    in_front_[facet] = static_cast<Index>(cells_.facets.size());
    cells_.facets.push_back(std::move(made));
  }

  // Where the edge between two corners crosses the plane.
  Index crossing(Index one, Index other) {
    const auto key = std::minmax(one, other);
    const auto found = crossings_.find(key);
    if (found != crossings_.end()) return found->second;
    const Sides &a = scene_.points.sides(one), &b = scene_.points.sides(other);
    std::vector<Index> through;  // two planes whose line the edge is on
    for (Index plane = 0; plane < a.size() && through.size() < 2; ++plane) {
      if (a[plane] != 0 || b[plane] != 0) continue;
      if (!through.empty() && are_parallel(scene_.planes[through[0]], scene_.planes[plane])) {
        continue;
      }
      through.push_back(plane);
    }
    if (through.size() < 2) throw std::logic_error("an edge of a cell is on less than two planes");
    const Point point =
        meeting_point(scene_.planes[through[0]], scene_.planes[through[1]], scene_.planes[plane_]);
    Sides sides(a.size());
    for (Index plane = 0; plane < sides.size(); ++plane) {
      const bool decided = a[plane] * b[plane] >= 0;
      sides[plane] =
          decided ? (a[plane] != 0 ? a[plane] : b[plane]) : scene_.points.side_of(point, plane);
    }
    sides[plane_] = 0;
    const Index made = scene_.points.add(point, std::move(sides));
    crossings_.emplace(key, made);
    return made;
  }

  // The polygon that closes the part behind the plane, counter-clockwise about
  // the plane's normal: against the direction in which its facets, seen from
  // outside, run along it.
  std::vector<Index> lid_corners(Index cell, const std::vector<Index>& facets) const {
    std::map<Index, Index> next;
    for (Index index : facets) {
      const Facet& facet = cells_.facets[index];
      for (std::size_t i = 0; i < facet.corners.size(); ++i) {
        const Index from = facet.corners[i], to = facet.corners[(i + 1) % facet.corners.size()];
        if (side(from) != 0 || side(to) != 0) continue;
        const bool faces_outward = facet.behind == cell;
        faces_outward ? next[to] = from : next[from] = to;
      }
    }
    std::vector<Index> corners;
    if (next.empty()) throw std::logic_error("a cut cell has no lid");
    Index corner = next.begin()->first;
    do {
      corners.push_back(corner);
      const auto found = next.find(corner);
      if (found == next.end() || corners.size() > next.size()) {
        throw std::logic_error("the lid of a cut cell is not closed");
      }
      corner = found->second;
    } while (corner != corners.front());
    return corners;
  }

  Scene& scene_;
  Cells& cells_;
  Index plane_ = none;
  std::unordered_map<Index, Index> in_front_;  // the front parts of cut facets
  std::map<std::pair<Index, Index>, Index> crossings_;
};

// What no other facet has: the plane, and the sides of all others.
std::string name_of(Sides sides, Index plane) {
  sides[plane] = 0;
  std::string name(sides.begin(), sides.end());
  return name + std::to_string(plane);
}

void place_pieces(const Scene& scene, Cells& cells) {
  std::unordered_map<std::string, Index> facet_of;
  for (Index facet = 0; facet < cells.facets.size(); ++facet) {
    const Facet& own = cells.facets[facet];
    const Cell& cell = cells.cells[own.front != none ? own.front : own.behind];
    facet_of.emplace(name_of(cell.sides, own.plane), facet);
  }
  for (Index plane = 0; plane < scene.sections.size(); ++plane) {
    if (scene.sections[plane].partial) continue;
    for (const Piece& piece : scene.sections[plane].pieces) {
      Sides sides(scene.planes.size(), 0);
      for (Index other = 0; other < sides.size(); ++other) {
        const auto from = scene.points.side(piece.from, other);
        if (scene.bounds_cells(other)) {
          sides[other] = from != 0 ? from : scene.points.side(piece.to, other);
        }
      }
      const auto found = facet_of.find(name_of(sides, plane));
      if (found != facet_of.end()) cells.facets[found->second].pieces.push_back(piece);
    }
  }
}

void place_labels(const Scene& scene, Cells& cells) {
  for (Facet& facet : cells.facets) {
    if (!facet.pieces.empty() || !scene.is_section(facet.plane)) continue;
    Vector sum = CGAL::NULL_VECTOR;
    for (Index corner : facet.corners) sum = sum + (scene.points[corner] - CGAL::ORIGIN);
    const Point middle = CGAL::ORIGIN + sum / Number(static_cast<double>(facet.corners.size()));
    facet.label = label_at(scene, facet.plane, middle);
  }
}

// Makes points at one place one point, in pieces and corners. Only points on two
// planes or more can coincide.
void unite_points(Scene& scene, Cells& cells) {
  std::vector<Index> order;
  for (Index point = 0; point < scene.points.size(); ++point) {
    const Sides& sides = scene.points.sides(point);
    if (std::count(sides.begin(), sides.end(), 0) >= 2) order.push_back(point);
  }
  std::sort(order.begin(), order.end(), [&](Index a, Index b) {
    if (a == b) return false;
    const auto order = CGAL::compare_xyz(scene.points[a], scene.points[b]);
    return order == CGAL::SMALLER || (order == CGAL::EQUAL && a < b);
  });
  std::vector<Index> first(scene.points.size());
  std::iota(first.begin(), first.end(), 0);
  for (std::size_t i = 1; i < order.size(); ++i) {
    if (scene.points[order[i]] == scene.points[order[i - 1]]) first[order[i]] = first[order[i - 1]];
  }
  for (Section& section : scene.sections) {
    for (Piece& piece : section.pieces) {
      piece.from = first[piece.from];
      piece.to = first[piece.to];
    }
  }
  for (Facet& facet : cells.facets) {
    for (Index& corner : facet.corners) corner = first[corner];
  }
}

}  // namespace

Cells make_cells(Scene& scene) {
  Cells cells;
  Cutter cutter(scene, cells);
  cutter.start();
  for (Index plane = 0; plane < scene.sections.size(); ++plane) {
    if (scene.bounds_cells(plane)) cutter.cut(plane);
  }
  unite_points(scene, cells);
  place_pieces(scene, cells);
  place_labels(scene, cells);
  return cells;
}

LinePoints::LinePoints(const Scene& scene) : scene_(scene) {
  std::vector<bool> is_taken(scene.points.size(), false);
  for (const Section& section : scene.sections) {
    for (const Piece& piece : section.pieces) {
      for (Index point : {piece.from, piece.to}) {
        if (is_taken[point]) continue;
        is_taken[point] = true;
        Sides sides = scene.points.sides(point);
        int zeros = 0;
        for (Index plane = 0; plane < sides.size(); ++plane) {
          if (!scene.bounds_cells(plane))
            sides[plane] = 0;
          else if (sides[plane] == 0)
            ++zeros;
        }
        if (zeros >= 2) points_[std::string(sides.begin(), sides.end())].push_back(point);
      }
    }
  }
}

const std::vector<Index>& LinePoints::between(Index corner, Index other) const {
  static const std::vector<Index> nothing;
  const Sides &a = scene_.points.sides(corner), &b = scene_.points.sides(other);
  Sides sides(a.size(), 0);
  for (Index plane = 0; plane < sides.size(); ++plane) {
    if (scene_.bounds_cells(plane)) sides[plane] = a[plane] != 0 ? a[plane] : b[plane];
  }
  const auto found = points_.find(std::string(sides.begin(), sides.end()));
  return found == points_.end() ? nothing : found->second;
}

}  // namespace transect::skeleton
