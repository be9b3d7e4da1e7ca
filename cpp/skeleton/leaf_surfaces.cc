#include "transect/cpp/skeleton/leaf_surfaces.h"

#include <algorithm>
#include <utility>

namespace transect::skeleton::partial {
namespace {

// Adds a facet to those in its plane.
void add(Front front, const PlaneName& name, std::map<PlaneKey, Fronts>& fronts) {
  auto& [behind, before] = fronts[name.key];
  (name.flipped ? before : behind).push_back(std::move(front));
}

class Surfaces {
 public:
  Surfaces(const Leaf& leaf, const Distances& distances, const Cuts& cuts)
      : leaf_(leaf), distances_(distances), cuts_(cuts), bisectors_(distances) {}

  LeafSurfaces make() {
    Territory territory(leaf_, distances_, bisectors_);
    for (const Region& region : territory.regions()) add_region(region);
    for (const auto& [plane, sides] : fronts_) {
      const Halfspace halfspace(plane);
      for (const Front& back : sides.behind) {
        for (const Front& front : sides.before) {
          if (auto tile = roof(halfspace, back, front)) {
            made_.tiles[plane].push_back(std::move(*tile));
          }
        }
      }
    }
    return std::move(made_);
  }

 private:
  void add_region(const Region& region) {
    const auto labels = std::make_shared<RegionLabels>(region, distances_);
    for (const Halfspace* plane : labels->changes_along()) {
      made_.is_apart = made_.is_apart && !cuts_.has(*plane);
    }
    add_walls(*labels);
    std::vector<Outline> outlines = region.body.outlines();
    for (std::size_t i = 0; i < outlines.size(); ++i) {
      const Halfspace* plane = region.body.facets[i].plane;
      const bool on_cut = cuts_.leaves.is_cut(plane);
      made_.is_apart = made_.is_apart && (on_cut || !cuts_.has(*plane));
      if (on_cut && !leaf_.is_beside_inexact) continue;
      const CGAL::Bbox_3 box = outlines[i].box();
      Front front{std::move(outlines[i]), box, labels->lines_on(*plane), labels};
      add(std::move(front), name_of(plane), on_cut ? made_.on_cuts : fronts_);
    }
    labels->leave_region();
  }

  void add_walls(const RegionLabels& labels) {
    for (const Change& change : labels.changes()) {
      const Polygon& p = change.polygon;
      const PlaneName name = plane_name(Kernel::Plane_3(p[0], p[1], p[2]));
      const Index from = labels.plane();
      const Sides sides{change.back, change.front, Kind::wall, {from, from}};
      const Sides seen = name.flipped ? sides.flipped() : sides;
      Polygon polygon = p;
      if (name.flipped) std::reverse(polygon.begin(), polygon.end());
      made_.tiles[name.key].push_back({polygon, {}, [seen](const Point&) { return seen; }});
    }
  }

  const PlaneName& name_of(const Halfspace* plane) {
    const auto at = names_.find(plane);
    if (at != names_.end()) return at->second;
    return names_.emplace(plane, plane_name(*plane)).first->second;
  }

  const Leaf& leaf_;
  const Distances& distances_;
  const Cuts& cuts_;
  Bisectors bisectors_;
  std::map<const Halfspace*, PlaneName> names_;
  std::map<PlaneKey, Fronts> fronts_;
  LeafSurfaces made_;
};

// Clips what lies in the plane of a facet to that facet.
bool keep_within(Polygon& line, const Front& front) {
  return std::all_of(front.outline.sides.begin(), front.outline.sides.end(),
                     [&](const Halfspace& side) { return clip(line, side.plane()); });
}

}  // namespace

std::optional<Tile> roof(const Halfspace& plane, const Front& back, const Front& front) {
  const auto &behind = back.labels, &before = front.labels;
  if (behind->only() && behind->only() == before->only()) return {};
  if (!CGAL::do_overlap(back.box, front.box)) return {};
  Outline common = back.outline;
  for (const Halfspace& side : front.outline.sides) {
    if (!common.clip(plane, side)) return {};
  }
  const auto between = [behind, before](const Point& point) {
    return Sides{
        behind->at(point), before->at(point), Kind::roof, {behind->plane(), before->plane()}};
  };
  Tile tile{common.polygon(), {}, between};
  // A line is on one of the two, and within it.
  for (const auto& [own, other] : {std::pair(&back, &front), std::pair(&front, &back)}) {
    for (Polygon line : own->lines) {
      if (keep_within(line, *other)) tile.lines.push_back(std::move(line));
    }
  }
  if (tile.lines.empty()) {
    const Sides all = between(CGAL::centroid(tile.polygon[0], tile.polygon[1], tile.polygon[2]));
    if (all.back == all.front) return {};
    tile.sides = [all](const Point&) { return all; };
  }
  return tile;
}

Cuts::Cuts(const Leaves& leaves) : leaves(leaves) {
  for (const Halfspace& cut : leaves.cuts()) keys.insert(plane_name(cut).key);
}

bool Cuts::has(const Halfspace& plane) const {
  const auto [a, b, c, d] = plane.coefficients();
  return (*a == 0) + (*b == 0) + (*c == 0) == 2 && keys.count(plane_name(plane).key) != 0;
}

LeafSurfaces leaf_surfaces(const Leaf& leaf, const Distances& distances, const Cuts& cuts) {
  return Surfaces(leaf, distances, cuts).make();
}

std::map<PlaneKey, Fronts> fronts_on_cuts(const Leaf& leaf, Index plane, const Cuts& cuts) {
  const auto labels = std::make_shared<RegionLabels>(*leaf.label, plane);
  std::map<PlaneKey, Fronts> fronts;
  std::vector<Outline> outlines = leaf.body.outlines();
  for (std::size_t i = 0; i < outlines.size(); ++i) {
    const Halfspace* on = leaf.body.facets[i].plane;
    if (!cuts.leaves.is_cut(on)) continue;
    const CGAL::Bbox_3 box = outlines[i].box();
    add({std::move(outlines[i]), box, {}, labels}, plane_name(*on), fronts);
  }
  return fronts;
}

}  // namespace transect::skeleton::partial
