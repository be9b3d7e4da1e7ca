// A cell is divided into leaves (leaves.h), each of them among the sites that may be nearest
// in it (territory.h), and every region has labels (labels.h). Surfaces are then
//
//   walls   within a region, where its labels change
//   roofs   between two regions whose labels differ
//
// Both are boundaries of one function of space, so the boundary of every label is closed.
#include "transect/cpp/skeleton/partial.h"

#include <algorithm>
#include <deque>
#include <map>
#include <memory>
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

// A leaf's regions and their labels.
struct Parts {
  Bisectors bisectors;
  std::deque<Region> regions;
  std::deque<std::shared_ptr<RegionLabels>> labels;
  bool is_exact;
};

// A facet of a region.
struct Front {
  const Parts* parts;
  Index region;
  const Facet* facet;

  const Region& whole() const { return parts->regions[region]; }
  const std::shared_ptr<RegionLabels>& labels() const { return parts->labels[region]; }
};

// Names of the planes of a leaf's facets: of all leaves they would fill the memory.
struct LocalNames {
  PlaneNames names;
  std::map<const Halfspace*, PlaneNames::Name> known;

  PlaneNames::Name name_of(const Halfspace* plane) {
    const auto at = known.find(plane);
    if (at != known.end()) return at->second;
    return known[plane] = names.name(plane->plane());
  }
  void clear() { *this = LocalNames(); }
};

// Facets in one plane: of regions behind it and before it.
struct Fronts {
  std::vector<Front> behind, before;
};

// All surfaces of a cell, plane by plane.
class Surfaces {
 public:
  // Leaves are cut at this part of their lengths.
  Surfaces(const PartialCell& cell, double cut_at)
      : cell_(cell),
        body_(body(cell, halfspaces_)),
        sites_(sites(cell, gauge(cell))),
        distances_(sites_),
        leaves_(body_, distances_, cut_at) {
    for (const Leaf& leaf : leaves_.mixed()) {
      if (!leaf.is_exact) inexact_.push_back(leaf.box);
    }
    for (const Halfspace& cut : leaves_.cuts()) cuts_.name(cut.plane());
    for (const Leaf& leaf : leaves_.mixed()) add_leaf(leaf);
    if (!inexact_.empty()) add_roofs_between_leaves();
  }

  // Whether no surface lies in the planes between leaves, where none is looked for.
  bool is_apart() const { return is_apart_; }

  PartialSurface result() {
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
    surface.inexact = inexact();
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

  PartialSurface::Inexact inexact() const {
    PartialSurface::Inexact result;
    for (const Leaf& leaf : leaves_.mixed()) {
      if (leaf.is_exact) continue;
      const double volume = leaf.body.volume();
      ++result.leaves;
      result.volume += volume;
      if (volume <= result.largest) continue;
      result.largest = volume;
      const Place middle = rough_place(leaf.body.centre());
      std::copy(middle.begin(), middle.end(), result.at);
    }
    return result;
  }

  bool is_beside_inexact(const Leaf& leaf) const {
    return std::any_of(inexact_.begin(), inexact_.end(),
                       [&](const CGAL::Bbox_3& box) { return CGAL::do_overlap(box, leaf.box); });
  }

  void add_leaf(const Leaf& leaf) {
    auto parts = std::make_unique<Parts>(Parts{Bisectors(distances_), {}, {}, leaf.is_exact});
    Territory territory(leaf, distances_, parts->bisectors);
    for (Region& region : territory.regions()) {
      parts->regions.push_back(std::move(region));
      parts->labels.push_back(std::make_shared<RegionLabels>(parts->regions.back(), distances_));
      for (const Halfspace* plane : parts->labels.back()->changes_along()) {
        is_apart_ = is_apart_ && !is_in_cut(plane->plane());
      }
    }
    for (const auto& labels : parts->labels) add_walls(*labels);
    std::map<Index, Fronts> fronts;
    add_fronts(*parts, false, fronts);
    for (const auto& [plane, sides] : fronts) {
      for (const Front& back : sides.behind) {
        for (const Front& front : sides.before) add_roof(plane, back, front);
      }
    }
    for (const auto& labels : parts->labels) labels->leave_region();
    local_.clear();
    if (is_beside_inexact(leaf)) beside_inexact_.push_back(std::move(parts));
  }

  void add_walls(const RegionLabels& labels) {
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

  // Where leaves meet of which one is not exact.
  void add_roofs_between_leaves() {
    for (Leaf& leaf : leaves_.uniform_beside_inexact()) {
      const Index plane = sites_[leaf.candidates.front().site].face->plane;
      auto parts = std::make_unique<Parts>(Parts{Bisectors(distances_), {}, {}, true});
      parts->regions.push_back({{none, none}, std::move(leaf.body)});
      parts->labels.push_back(std::make_shared<RegionLabels>(*leaf.label, plane));
      beside_inexact_.push_back(std::move(parts));
    }
    std::map<Index, Fronts> fronts;
    for (const auto& parts : beside_inexact_) add_fronts(*parts, true, fronts);
    for (const auto& [plane, sides] : fronts) {
      for (const Front& back : sides.behind) {
        for (const Front& front : sides.before) {
          if (!back.parts->is_exact || !front.parts->is_exact) add_roof(plane, back, front);
        }
      }
    }
  }

  // The facets of regions that lie between leaves, or the others.
  void add_fronts(const Parts& parts, bool on_cuts, std::map<Index, Fronts>& fronts) {
    for (Index region = 0; region < parts.regions.size(); ++region) {
      for (const Facet& facet : parts.regions[region].body.facets) {
        const bool on_cut = leaves_.is_cut(facet.plane);
        is_apart_ = is_apart_ && (on_cut || !is_in_cut(facet.plane->plane()));
        if (on_cut != on_cuts) continue;
        const PlaneNames::Name name = local_.name_of(facet.plane);
        auto& [behind, before] = fronts[name.plane];
        (name.flipped ? before : behind).push_back({&parts, region, &facet});
      }
    }
  }

  void add_roof(Index plane, const Front& back, const Front& front) {
    const std::shared_ptr<RegionLabels>&behind = back.labels(), &before = front.labels();
    if (behind->only() && behind->only() == before->only()) return;
    Tile tile{back.whole().body.polygon(*back.facet), {}, {}};
    if (!CGAL::do_overlap(bounds(tile.polygon), bounds(front.whole().body.polygon(*front.facet))) ||
        !keep_within(tile.polygon, plane, front)) {
      return;
    }
    add_lines(tile, plane, back, front);
    add_lines(tile, plane, front, back);
    tile.sides = [behind, before](const Point& point) {
      return Sides{
          behind->at(point), before->at(point), Kind::roof, {behind->plane(), before->plane()}};
    };
    if (tile.lines.empty()) {
      const Sides all =
          tile.sides(CGAL::centroid(tile.polygon[0], tile.polygon[1], tile.polygon[2]));
      if (all.back == all.front) return;
      tile.sides = [all](const Point&) { return all; };
    }
    // The name is of the same coefficients there: neither plane is turned.
    tiles_[names_.name(local_.names.planes()[plane]).plane].push_back(std::move(tile));
  }

  // Clips what lies in the plane of one of the region's facets to that facet.
  bool keep_within(Polygon& polygon, Index plane, const Front& front) {
    for (const Facet& facet : front.whole().body.facets) {
      if (local_.name_of(facet.plane).plane != plane && !clip(polygon, facet.plane->plane()))
        return false;
    }
    return true;
  }

  // Where changes of labels within the region end on the plane.
  void add_lines(Tile& tile, Index plane, const Front& own, const Front& other) {
    const CGAL::Bbox_3 box = bounds(tile.polygon);
    for (const Change& change : own.labels()->changes()) {
      Polygon line;
      for (std::size_t i = 0; i < change.polygon.size(); ++i) {
        const Point& corner = change.polygon[i];
        if (side(local_.names.planes()[plane], corner) == 0) line.push_back(corner);
      }
      if (line.size() != 2 || !CGAL::do_overlap(box, bounds(line))) continue;
      if (keep_within(line, plane, other)) tile.lines.push_back(std::move(line));
    }
  }

  // Whether a plane is one between leaves, which are square to the axes.
  bool is_in_cut(const Kernel::Plane_3& plane) const {
    const int zeros =
        CGAL::is_zero(plane.a()) + CGAL::is_zero(plane.b()) + CGAL::is_zero(plane.c());
    return zeros == 2 && cuts_.has(plane);
  }

  const PartialCell& cell_;
  std::vector<Halfspace> halfspaces_;
  Polytope body_;
  std::vector<Site> sites_;
  Distances distances_;
  Leaves leaves_;
  std::vector<CGAL::Bbox_3> inexact_;  // leaves
  std::vector<std::unique_ptr<Parts>> beside_inexact_;
  PlaneNames names_;  // of tiles
  PlaneNames cuts_;
  LocalNames local_;
  bool is_apart_ = true;
  std::map<Index, std::vector<Tile>> tiles_;
};

}  // namespace
}  // namespace partial

std::size_t partial_sites(const PartialCell& cell) { return partial::count_sites(cell); }

PartialSurface partial_surface(const PartialCell& cell) {
  // Where surfaces happen to lie in planes between leaves, others are tried. If that never
  // helps, the surface may be open, which its user sees.
  for (const double cut_at : {0.5087, 0.4931}) {
    partial::Surfaces surfaces(cell, cut_at);
    if (surfaces.is_apart()) return surfaces.result();
  }
  return partial::Surfaces(cell, 0.5173).result();
}

}  // namespace transect::skeleton
