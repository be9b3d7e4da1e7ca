#include "transect/cpp/skeleton/cells.h"

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <string>
#include <unordered_map>

#include "transect/cpp/complex/complex.h"

namespace transect::skeleton {
namespace {

// The cell complex of all full sections' planes, in the scene's numbers.
class Translator {
 public:
  explicit Translator(Scene& scene) : scene_(scene), complex_(bounds(scene), outside) {
    for (Index plane = 0; plane < 6; ++plane) planes_[plane] = scene.sections.size() + plane;
    for (Index plane = 0; plane < scene.sections.size(); ++plane) {
      if (!scene.bounds_cells(plane)) continue;
      const complex::Plane own(numbers(scene.planes[plane].normal),
                               CGAL::to_double(scene.planes[plane].offset));
      if (complex_.coincident(own) == complex::none) planes_[complex_.insert(own)] = plane;
    }
  }

  Cells cells() {
    const auto& facets = complex_.facets();
    const auto& cells = complex_.cells();
    Cells result;
    // Nothing was removed: numbers have no gaps.
    for (Index id = 0; id < facets.end(); ++id) result.facets.push_back(facet(facets[id]));
    for (Index id = 0; id < cells.end(); ++id) {
      Cell cell{Sides(scene_.planes.size(), 0), cells[id].facets};
      for (Index index : cell.facets) add_sides(result.facets[index], cell.sides);
      result.cells.push_back(std::move(cell));
    }
    return result;
  }

 private:
  static std::array<double, 3> numbers(const Vector& normal) {
    return {CGAL::to_double(normal.x()), CGAL::to_double(normal.y()), CGAL::to_double(normal.z())};
  }

  // The scene's last six planes are lower and upper x, y, z, their normals pointing inward.
  static std::array<double, 6> bounds(const Scene& scene) {
    std::array<double, 6> bounds;
    for (Index i = 0; i < 6; ++i) {
      const double offset = CGAL::to_double(scene.planes[scene.sections.size() + i].offset);
      bounds[i] = i % 2 == 0 ? offset : -offset;
    }
    return bounds;
  }

  Facet facet(const complex::Facet& own) {
    Facet facet{planes_.at(own.plane), {}, own.cells[0], own.cells[1], {}, outside};
    for (complex::Id corner : own.corners) facet.corners.push_back(point(corner));
    if (own.plane < 6) {  // normals point outward there
      std::reverse(facet.corners.begin(), facet.corners.end());
      std::swap(facet.front, facet.behind);
    }
    return facet;
  }

  Index point(complex::Id place) {
    const auto [found, is_new] = points_.emplace(place, none);
    if (!is_new) return found->second;
    std::vector<Index> known;
    for (complex::Id plane : complex_.places()[place].planes) known.push_back(planes_.at(plane));
    found->second = scene_.points.add(complex_.places()[place].exact, known);
    return found->second;
  }

  void add_sides(const Facet& facet, Sides& sides) const {
    for (Index corner : facet.corners) {
      for (Index plane = 0; plane < sides.size(); ++plane) {
        if (sides[plane] == 0 && scene_.bounds_cells(plane)) {
          sides[plane] = scene_.points.side(corner, plane);
        }
      }
    }
  }

  Scene& scene_;
  complex::Complex complex_;
  std::map<complex::Id, Index> planes_;
  std::unordered_map<complex::Id, Index> points_;
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

// Orders facets and corners by what they are and not by how they came to be, which hangs on
// planes that are elsewhere.
void arrange(const Scene& scene, Cells& cells) {
  for (Facet& facet : cells.facets) {
    const auto first =
        std::min_element(facet.corners.begin(), facet.corners.end(), [&](Index a, Index b) {
          return a != b && CGAL::compare_xyz(scene.points[a], scene.points[b]) == CGAL::SMALLER;
        });
    std::rotate(facet.corners.begin(), first, facet.corners.end());
  }
  for (Cell& cell : cells.cells) {
    std::sort(cell.facets.begin(), cell.facets.end(),
              [&](Index a, Index b) { return cells.facets[a].plane < cells.facets[b].plane; });
  }
}

}  // namespace

Cells make_cells(Scene& scene) {
  Cells cells = Translator(scene).cells();
  unite_points(scene, cells);
  arrange(scene, cells);
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
