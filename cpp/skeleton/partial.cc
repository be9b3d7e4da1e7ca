// A cell is divided among the sites in it (territory.h), and every region has labels
// (labels.h). Surfaces are then
//
//   walls   within a region, where its labels change
//   roofs   between two regions whose labels differ
//
// Both are boundaries of one function of space, so the boundary of every label is closed.
#include "transect/cpp/skeleton/partial.h"

#include <algorithm>
#include <deque>
#include <map>
#include <utility>

#include "transect/cpp/skeleton/labels.h"
#include "transect/cpp/skeleton/sheets.h"

namespace transect::skeleton {
namespace partial {
namespace {

CGAL::Bbox_3 bounds(const Polygon& polygon) {
  CGAL::Bbox_3 box;
  for (const Point& corner : polygon) box += corner.bbox();
  return box;
}

// A facet of a region, as a part of its plane.
struct Front {
  Index region;
  Polygon polygon;
  CGAL::Bbox_3 box;
};

// All surfaces of a cell, plane by plane.
class Surfaces {
 public:
  explicit Surfaces(const PartialCell& cell)
      : cell_(cell),
        body_(body(cell, halfspaces_)),
        sites_(sites(cell, gauge(cell))),
        territory_(body_, sites_) {
    for (const Region& region : territory_.regions()) {
      labels_.emplace_back(region, sites_[region.owner.site]);
    }
  }

  PartialSurface result() {
    add_walls();
    add_roofs();
    PointNames names(cell_.points);
    std::map<Index, std::vector<Seam>> seams_of;
    for (const auto& [plane, tiles] : tiles_) {
      std::vector<Seam>& on = seams_of[plane] = seams(names_.planes()[plane], tiles);
      for (const Seam& seam : on) {
        names.name(seam.from);
        names.name(seam.to);
      }
    }
    const PointIndex index(names.points());
    PartialSurface surface;
    for (const auto& [plane, on] : seams_of) {
      triangulate(names_.planes()[plane], on, index, names, surface.triangles);
    }
    add_splits(index, names, surface);
    const std::vector<Point>& points = names.points();
    surface.added.assign(points.begin() + cell_.points.size(), points.end());
    return surface;
  }

 private:
  void add_splits(const PointIndex& index, PointNames& names, PartialSurface& surface) const {
    for (Index wall = 0; wall < cell_.walls.size(); ++wall) {
      const std::vector<Piece>& pieces = cell_.walls[wall].pieces;
      for (Index piece = 0; piece < pieces.size(); ++piece) {
        const auto& [from, to, left, right] = pieces[piece];
        if (left == right) continue;
        for (const Point& point : index.between(cell_.points[from], cell_.points[to])) {
          surface.splits.push_back({wall, piece, names.name(point)});
        }
      }
    }
  }

  void add_walls() {
    for (const RegionLabels& labels : labels_) {
      for (const Change& change : labels.changes()) {
        const Polygon& p = change.polygon;
        const PlaneNames::Name name = names_.name(Kernel::Plane_3(p[0], p[1], p[2]));
        const Index from = labels.plane();
        const Sides sides{change.back, change.front, Kind::wall, {from, from}};
        const Sides seen = name.flipped ? sides.flipped() : sides;
        Polygon polygon = p;
        if (name.flipped) std::reverse(polygon.begin(), polygon.end());
        tiles_[name.plane].push_back({polygon, {}, [seen](const Point&) { return seen; }});
      }
    }
  }

  void add_roofs() {
    // Facets by planes, of regions behind the plane and before it.
    std::map<Index, std::pair<std::vector<Front>, std::vector<Front>>> fronts;
    const std::vector<Region>& regions = territory_.regions();
    for (Index i = 0; i < regions.size(); ++i) {
      for (const Facet& facet : regions[i].body.facets) {
        const PlaneNames::Name name = name_of(facet.plane);
        auto& [behind, before] = fronts[name.plane];
        const Polygon polygon = regions[i].body.polygon(facet);
        (name.flipped ? before : behind).push_back({i, polygon, bounds(polygon)});
      }
    }
    for (const auto& [plane, sides] : fronts) {
      for (const Front& back : sides.first) {
        for (const Front& front : sides.second) {
          if (CGAL::do_overlap(back.box, front.box)) add_roof(plane, back, front);
        }
      }
    }
  }

  void add_roof(Index plane, const Front& back, const Front& front) {
    Tile tile{back.polygon, {}, {}};
    if (!keep_within(tile.polygon, plane, front.region)) return;
    add_lines(tile, plane, back.region, front.region);
    add_lines(tile, plane, front.region, back.region);
    const RegionLabels &behind = labels_[back.region], &before = labels_[front.region];
    tile.sides = [&behind, &before](const Point& point) {
      return Sides{
          behind.at(point), before.at(point), Kind::roof, {behind.plane(), before.plane()}};
    };
    if (tile.lines.empty()) {
      const Sides all =
          tile.sides(CGAL::centroid(tile.polygon[0], tile.polygon[1], tile.polygon[2]));
      if (all.back == all.front) return;
      tile.sides = [all](const Point&) { return all; };
    }
    tiles_[plane].push_back(std::move(tile));
  }

  // Clips what lies in the plane of one of the region's facets to that facet.
  bool keep_within(Polygon& polygon, Index plane, Index region) {
    for (const Facet& facet : territory_.regions()[region].body.facets) {
      if (name_of(facet.plane).plane != plane && !clip(polygon, *facet.plane)) return false;
    }
    return true;
  }

  // Where changes of labels within the region end on the plane.
  void add_lines(Tile& tile, Index plane, Index region, Index other) {
    const CGAL::Bbox_3 box = bounds(tile.polygon);
    for (const Change& change : labels_[region].changes()) {
      Polygon line;
      for (std::size_t i = 0; i < change.polygon.size(); ++i) {
        const Point& corner = change.polygon[i];
        if (side(names_.planes()[plane], corner) == 0) line.push_back(corner);
      }
      if (line.size() != 2 || !CGAL::do_overlap(box, bounds(line))) continue;
      if (keep_within(line, plane, other)) tile.lines.push_back(std::move(line));
    }
  }

  PlaneNames::Name name_of(const Halfspace* plane) {
    const auto at = name_of_.find(plane);
    if (at != name_of_.end()) return at->second;
    return name_of_[plane] = names_.name(*plane);
  }

  const PartialCell& cell_;
  std::vector<Halfspace> halfspaces_;
  Polytope body_;
  std::vector<Site> sites_;
  Territory territory_;
  std::deque<RegionLabels> labels_;
  PlaneNames names_;
  std::map<const Halfspace*, PlaneNames::Name> name_of_;
  std::map<Index, std::vector<Tile>> tiles_;
};

}  // namespace
}  // namespace partial

std::size_t partial_sites(const PartialCell& cell) { return partial::count_sites(cell); }

PartialSurface partial_surface(const PartialCell& cell) { return partial::Surfaces(cell).result(); }

}  // namespace transect::skeleton
