// A cell is divided into leaves (leaves.h), each of them among the sites that may be nearest
// in it. The surfaces of all (leaf_surfaces.h) are merged plane by plane (sheets.h).
#include "transect/cpp/skeleton/partial.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <iterator>
#include <map>
#include <utility>

#include "transect/cpp/skeleton/leaf_surfaces.h"

namespace transect::skeleton {
namespace partial {
namespace {

// How much of the time has gone by, roughly, when something is done.
constexpr double at_sites = 0.1, at_leaves = 0.2, at_surfaces = 0.7, at_seams = 0.95;

// All surfaces of a cell.
class Surfaces {
 public:
  // Leaves are cut at this part of their lengths.
  Surfaces(const PartialCell& cell, double cut_at, const Watch& watch)
      : cell_(cell),
        watch_(watch),
        body_(body(cell, halfspaces_)),
        sites_(sites(cell, gauge(cell))),
        distances_((watch(at_sites), sites_)),
        leaves_(body_, distances_, cut_at) {
    watch(at_leaves);
    const Cuts cuts(leaves_);
    const std::vector<Leaf>& leaves = leaves_.mixed();
    std::vector<LeafSurfaces> made(leaves.size());
    each(made.size(), at_leaves, at_surfaces, [&](std::size_t i) {
      Leaf leaf = leaves[i];
      leaf.body = leaf.body.apart();
      made[i] = leaf_surfaces(leaf, distances_, cuts);
    });
    for (std::size_t i = 0; i < made.size(); ++i) {
      is_apart_ = is_apart_ && made[i].is_apart;
      for (auto& [plane, tiles] : made[i].tiles) {
        std::move(tiles.begin(), tiles.end(), std::back_inserter(tiles_[plane]));
      }
      add_fronts(std::move(made[i].on_cuts), leaves[i].is_exact);
    }
    for (const Leaf& leaf : leaves_.uniform_beside_inexact()) {
      const Index plane = sites_[leaf.candidates.front().site].face->plane;
      add_fronts(fronts_on_cuts(leaf, plane, cuts), true);
    }
    add_roofs_between_leaves();
  }

  // Whether no surface lies in the planes between leaves, where none is looked for.
  bool is_apart() const { return is_apart_; }

  PartialSurface result() const {
    std::vector<std::pair<Kernel::Plane_3, const std::vector<Tile>*>> planes;
    for (const auto& [plane, tiles] : tiles_) planes.push_back({Halfspace(plane).plane(), &tiles});
    std::vector<std::vector<Seam>> seams_of(planes.size());
    each(planes.size(), at_surfaces, at_seams,
         [&](std::size_t i) { seams_of[i] = seams(planes[i].first, *planes[i].second); });
    PointNames names(cell_.points);
    for (const std::vector<Seam>& on : seams_of) {
      for (const Seam& seam : on) {
        names.name(seam.from);
        names.name(seam.to);
      }
    }
    const PointIndex index(names.points());
    std::vector<std::vector<Triangle>> triangles(planes.size());
    each(planes.size(), at_seams, 1, [&](std::size_t i) {
      triangles[i] = triangulate(planes[i].first, seams_of[i], index, names);
    });
    PartialSurface surface;
    for (const std::vector<Triangle>& on : triangles) {
      surface.triangles.insert(surface.triangles.end(), on.begin(), on.end());
    }
    add_splits(index, names, surface);
    const std::vector<Point>& points = names.points();
    surface.added.assign(points.begin() + cell_.points.size(), points.end());
    surface.inexact = inexact();
    return surface;
  }

 private:
  // A facet between leaves.
  struct Border {
    Front front;
    bool is_exact;  // its leaf
  };
  struct Borders {
    std::vector<Border> behind, before;
  };

  // Does something for all numbers below the count, in parallel and in no order.
  template <class Task>
  void each(std::size_t count, double from, double to, const Task& task) const {
    std::atomic<std::size_t> done{0};
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
      task(i);
      const double part = static_cast<double>(++done) / static_cast<double>(count);
      watch_(from + (to - from) * part);
    });
  }

  void add_fronts(std::map<PlaneKey, Fronts> fronts, bool is_exact) {
    for (auto& [plane, sides] : fronts) {
      auto& [behind, before] = borders_[plane];
      for (Front& front : sides.behind) behind.push_back({std::move(front), is_exact});
      for (Front& front : sides.before) before.push_back({std::move(front), is_exact});
    }
  }

  // Where leaves meet of which one is not exact.
  void add_roofs_between_leaves() {
    for (const auto& [plane, sides] : borders_) {
      const Halfspace halfspace(plane);
      for (const Border& back : sides.behind) {
        for (const Border& front : sides.before) {
          if (back.is_exact && front.is_exact) continue;
          if (auto tile = roof(halfspace, back.front, front.front)) {
            tiles_[plane].push_back(std::move(*tile));
          }
        }
      }
    }
  }

  void add_splits(const PointIndex& index, const PointNames& names, PartialSurface& surface) const {
    const auto add = [&](Index from, Index to) {
      for (const Point& point : index.between(cell_.points[from], cell_.points[to])) {
        surface.splits.push_back({from, to, names.at(point)});
      }
    };
    for (const CellPlane& wall : cell_.walls) {
      for (const auto& [from, to, left, right] : wall.pieces) {
        if (left != right) add(from, to);
      }
      for (std::size_t i = 0; i < wall.corners.size(); ++i) {
        add(wall.corners[i], wall.corners[(i + 1) % wall.corners.size()]);
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

  const PartialCell& cell_;
  const Watch& watch_;
  std::vector<Halfspace> halfspaces_;
  Polytope body_;
  std::vector<Site> sites_;
  Distances distances_;
  Leaves leaves_;
  bool is_apart_ = true;
  std::map<PlaneKey, std::vector<Tile>> tiles_;
  std::map<PlaneKey, Borders> borders_;
};

}  // namespace
}  // namespace partial

PartialSurface partial_surface(const PartialCell& cell, const Watch& watch) {
  // Where surfaces happen to lie in planes between leaves, others are tried. If that never
  // helps, the surface may be open, which its user sees.
  for (const double cut_at : {0.5087, 0.4931}) {
    partial::Surfaces surfaces(cell, cut_at, watch);
    if (surfaces.is_apart()) return surfaces.result();
  }
  return partial::Surfaces(cell, 0.5173, watch).result();
}

}  // namespace transect::skeleton
