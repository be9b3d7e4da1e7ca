#include "transect/cpp/skeleton/roofs.h"

#include <algorithm>
#include <set>
#include <stdexcept>

namespace transect::skeleton {

void CellPoints::unite(Index one, Index other) {
  one = first(one);
  other = first(other);
  if (one == other) return;
  if (one > other) std::swap(one, other);
  if (other < base_) throw std::logic_error("two points of sections are at one place");
  parents_[other - base_] = one;
}

namespace {

using Walls = std::array<Index, 3>;

Walls sorted(Index a, Index b, Index c) {
  Walls walls{a, b, c};
  std::sort(walls.begin(), walls.end());
  return walls;
}

// A corner of a roof while it is cut out of its first wall.
struct Corner {
  Point foot;
  Index point;   // a corner of the wall itself, or `none`
  Index beyond;  // of the side to the next corner
};
using Outline = std::vector<Corner>;

class Maker {
 public:
  Maker(const Heights& heights, CellPoints& points) : heights_(heights), points_(points) {}

  Roofs make() {
    find_edges();
    for (Index first = 0; first < heights_.count(); ++first) {
      for (Index second = first + 1; second < heights_.count(); ++second) {
        if (may_differ(first, second)) add_roof(first, second);
      }
    }
    unite_corners();
    for (Index wall = 0; wall < heights_.count(); ++wall) {
      for (const Piece& piece : heights_.sites()[wall].facet->pieces) lift(wall, piece);
    }
    place_arrivals();
    return std::move(roofs_);
  }

 private:
  const Site& site(Index wall) const { return heights_.sites()[wall]; }

  bool may_differ(Index one, Index other) const {
    return !site(one).is_uniform() || !site(other).is_uniform() ||
           site(one).facet->label != site(other).facet->label;
  }

  // The two walls at every edge of the cell.
  void find_edges() {
    for (Index wall = 0; wall < heights_.count(); ++wall) {
      const auto& corners = site(wall).facet->corners;
      for (std::size_t i = 0; i < corners.size(); ++i) {
        walls_at_[std::minmax(corners[i], corners[(i + 1) % corners.size()])].push_back(wall);
      }
    }
  }

  Outline outline(Index wall) const {
    Outline result;
    const auto& corners = site(wall).facet->corners;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const auto found = walls_at_.find(std::minmax(corners[i], corners[(i + 1) % corners.size()]));
      if (found == walls_at_.end() || found->second.size() != 2) {
        throw std::logic_error("an edge of a cell is not between two walls");
      }
      const Index beyond = found->second[found->second[0] == wall ? 1 : 0];
      result.push_back({heights_.point(corners[i]), corners[i], beyond});
    }
    return result;
  }

  Number height(Index wall, Index other, const Corner& corner) const {
    return corner.point != none ? heights_.over(wall, other, corner.point)
                                : heights_(wall, other, corner.foot);
  }

  // The part of an outline on the first wall where the roof towards the second
  // is not above that towards a third.
  Outline lower(const Outline& outline, Index first, Index second, Index third) const {
    std::vector<Number> above;
    std::vector<int> signs;
    for (const Corner& corner : outline) {
      above.push_back(height(first, third, corner) - height(first, second, corner));
      signs.push_back(CGAL::sign(above.back()));
    }
    if (*std::min_element(signs.begin(), signs.end()) >= 0) return outline;
    if (*std::max_element(signs.begin(), signs.end()) <= 0) return {};
    Outline kept;
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const std::size_t next = (i + 1) % outline.size();
      if (signs[i] >= 0) kept.push_back(outline[i]);
      if (signs[i] == 0 && signs[next] < 0) kept.back().beyond = third;
      if (signs[i] * signs[next] >= 0) continue;
      const Point &here = outline[i].foot, &there = outline[next].foot;
      const Number t = above[i] / (above[i] - above[next]);
      kept.push_back({here + t * (there - here), none, signs[i] > 0 ? third : outline[i].beyond});
    }
    return kept;
  }

  // Where walls are equally far along a whole line, what is left of an outline can be
  // a part of the line.
  static bool has_area(const Outline& outline) {
    for (std::size_t i = 2; i < outline.size(); ++i) {
      if (!CGAL::collinear(outline[0].foot, outline[i - 1].foot, outline[i].foot)) return true;
    }
    return false;
  }

  void add_roof(Index first, Index second) {
    Outline area = outline(first);
    for (Index third = 0; third < heights_.count() && !area.empty(); ++third) {
      if (third != first && third != second) area = lower(area, first, second, third);
    }
    if (!has_area(area)) return;
    Roof roof;
    roof.walls[0] = first;
    roof.walls[1] = second;
    Vector sum = CGAL::NULL_VECTOR;
    for (std::size_t i = 0; i < area.size(); ++i) {
      const Index before = area[(i + area.size() - 1) % area.size()].beyond;
      roof.corners.push_back(corner_of(area[i], first, second, before));
      roof.beyond.push_back(area[i].beyond);
      sum = sum + (area[i].foot - CGAL::ORIGIN);
    }
    roof.middle = CGAL::ORIGIN + sum / Number(static_cast<double>(area.size()));
    roof_of_[{first, second}] = roofs_.roofs.size();
    roofs_.roofs.push_back(std::move(roof));
  }

  // Four walls name a point in general position: roofs that meet there share it.
  Index corner_of(const Corner& corner, Index first, Index second, Index before) {
    if (corner.point != none) return corner.point;
    std::array<Index, 4> walls{first, second, before, corner.beyond};
    std::sort(walls.begin(), walls.end());
    const auto found = corner_.find(walls);
    if (found != corner_.end()) return found->second;
    const Index made =
        points_.add(heights_.lifted(first, corner.foot, heights_(first, second, corner.foot)));
    corner_.emplace(walls, made);
    return made;
  }

  // Where more than four walls are equally far a corner has several names.
  void unite_corners() {
    std::vector<Index> made;
    for (const auto& entry : corner_) made.push_back(entry.second);
    std::sort(made.begin(), made.end(), [&](Index a, Index b) {
      if (a == b) return false;
      const auto order = CGAL::compare_xyz(points_[a], points_[b]);
      return order == CGAL::SMALLER || (order == CGAL::EQUAL && a < b);
    });
    for (std::size_t i = 1; i < made.size(); ++i) {
      if (points_[made[i - 1]] == points_[made[i]]) points_.unite(made[i - 1], made[i]);
    }
  }

  // What is over an end of a contour's piece.
  struct End {
    std::vector<Number> heights;  // towards every wall
    Index lifted;
    std::vector<Index> lowest;  // the walls whose roofs are there
  };

  const End& end(Index wall, Index point) {
    const auto [found, is_new] = ends_.insert({{wall, point}, {}});
    End& made = found->second;
    if (!is_new) return made;
    for (Index other = 0; other < heights_.count(); ++other) {
      made.heights.push_back(other == wall ? Number(0) : heights_.over(wall, other, point));
      if (other == wall) continue;
      const auto order = made.lowest.empty()
                             ? CGAL::SMALLER
                             : CGAL::compare(made.heights[other], made.heights[made.lowest[0]]);
      if (order == CGAL::SMALLER) made.lowest.clear();
      if (order != CGAL::LARGER) made.lowest.push_back(other);
    }
    const Number& height = made.heights[made.lowest[0]];
    const bool on_edge = heights_.is_on(made.lowest[0], point);
    made.lifted =
        on_edge ? point : points_.add(heights_.lifted(wall, heights_.point(point), height));
    if (!on_edge) arrive(wall, made.lowest, made.lifted);
    return made;
  }

  // A contour of `wall` reaches the sides between the roofs towards `others`.
  void arrive(Index wall, const std::vector<Index>& others, Index point) {
    for (std::size_t i = 0; i < others.size(); ++i) {
      for (std::size_t j = i + 1; j < others.size(); ++j) {
        arrivals_[sorted(wall, others[i], others[j])].push_back(point);
      }
    }
  }

  // Of the roofs towards `others` the lowest by their heights there. Of several as low
  // all along the piece some may be as narrow as the line over it, and are none.
  Index lowest(Index wall, const std::vector<Index>& others, const std::vector<Number>& heights) {
    Index best = none;
    for (Index other : others) {
      if (best != none) {
        const auto order = CGAL::compare(heights[other], heights[best]);
        if (order == CGAL::LARGER || (order == CGAL::EQUAL && !has_roof(wall, other))) continue;
      }
      best = other;
    }
    return best;
  }

  bool has_roof(Index one, Index other) const {
    return roof_of_.count(std::minmax(one, other)) != 0;
  }

  // Follows the lowest roof from one end of a piece to the other.
  void lift(Index wall, const Piece& piece) {
    const End &from = end(wall, piece.from), &to = end(wall, piece.to);
    const auto& p = from.heights;
    const auto& q = to.heights;
    Lifted lifted{wall, piece, {}};
    Index current = lowest(wall, from.lowest, q);
    Index start = from.lifted;
    while (true) {
      // The next roof is the first that comes below this one.
      Number first(2);
      std::vector<Index> next{current};
      for (Index other = 0; other < heights_.count(); ++other) {
        if (other == wall || other == current || !(q[other] < q[current])) continue;
        const Number t =
            (p[other] - p[current]) / ((p[other] - p[current]) - (q[other] - q[current]));
        const auto order = CGAL::compare(t, first);
        if (order == CGAL::LARGER) continue;
        if (order == CGAL::SMALLER) next.assign(1, current);
        first = t;
        next.push_back(other);
      }
      if (next.size() == 1) break;
      const Point &a = points_[piece.from], &b = points_[piece.to];
      const Number height = p[current] + first * (q[current] - p[current]);
      const Index stop = points_.add(heights_.lifted(wall, a + first * (b - a), height));
      arrive(wall, next, stop);
      add_part(lifted, current, start, stop);
      start = stop;
      current = lowest(wall, next, q);
    }
    add_part(lifted, current, start, to.lifted);
    roofs_.lifted.push_back(std::move(lifted));
  }

  void add_part(Lifted& lifted, Index other, Index from, Index to) {
    const Index wall = lifted.wall;
    const auto found = roof_of_.find(std::minmax(wall, other));
    if (found == roof_of_.end()) throw std::logic_error("a contour is under no roof");
    Roof& roof = roofs_.roofs[found->second];
    const int owner = roof.walls[0] == wall ? 0 : 1;
    // The view is from the second wall's side: against the first wall's inward
    // normal, along the second's.
    const bool same = (site(wall).side > 0) == (owner == 0);
    const Piece& piece = lifted.piece;
    lifted.parts.push_back({found->second, roof.chains.size()});
    roof.chains.push_back(
        {from, to, same ? piece.left : piece.right, same ? piece.right : piece.left, owner, {}});
  }

  using SideName = std::pair<Index, Index>;

  SideName side_name(const Roof& roof, std::size_t side) const {
    return std::minmax(points_.first(roof.corners[side]),
                       points_.first(roof.corners[(side + 1) % roof.corners.size()]));
  }

  // Every roof beside a place where a contour passes from one roof to the next
  // has to know it. Where more than three walls are equally far along a side, it
  // has several names, but one pair of ends.
  void place_arrivals() {
    std::map<Walls, std::set<SideName>> named;
    std::map<SideName, std::vector<std::size_t>> roofs_at;
    for (std::size_t roof = 0; roof < roofs_.roofs.size(); ++roof) {
      const Roof& own = roofs_.roofs[roof];
      for (std::size_t side = 0; side < own.beyond.size(); ++side) {
        const SideName name = side_name(own, side);
        named[sorted(own.walls[0], own.walls[1], own.beyond[side])].insert(name);
        roofs_at[name].push_back(roof);
      }
    }
    for (const auto& [walls, arrived] : arrivals_) {
      const auto found = named.find(walls);
      for (Index point : arrived) {
        if (found == named.end())
          place_anywhere(point);
        else
          for (const SideName& name : found->second) place(point, roofs_at[name]);
      }
    }
    const auto& on_edges = heights_.content().on_edges;
    for (const auto& [name, roofs] : roofs_at) {
      const auto found = on_edges.find(name);
      if (found == on_edges.end()) continue;
      for (Index point : found->second) place(point, roofs);
    }
  }

  void place(Index point, const std::vector<std::size_t>& roofs) {
    for (std::size_t roof : roofs) roofs_.roofs[roof].extra.push_back(point);
  }

  void place_anywhere(Index point) {
    for (Roof& roof : roofs_.roofs) {
      for (std::size_t i = 0; i < roof.corners.size(); ++i) {
        const Point& from = points_[roof.corners[i]];
        const Point& to = points_[roof.corners[(i + 1) % roof.corners.size()]];
        if (Kernel::Segment_3(from, to).has_on(points_[point])) roof.extra.push_back(point);
      }
    }
  }

  const Heights& heights_;
  CellPoints& points_;
  Roofs roofs_;
  std::map<std::pair<Index, Index>, std::vector<Index>> walls_at_;
  std::map<std::pair<Index, Index>, std::size_t> roof_of_;
  std::map<std::array<Index, 4>, Index> corner_;
  std::map<std::pair<Index, Index>, End> ends_;
  std::map<Walls, std::vector<Index>> arrivals_;
};

}  // namespace

Roofs make_roofs(const Heights& heights, CellPoints& points) {
  return Maker(heights, points).make();
}

}  // namespace transect::skeleton
