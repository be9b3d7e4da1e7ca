// The roofs of a convex cell: where two walls are equally far and no other is
// nearer (Barequet and Vaxman 2009, §3; on convex cells the straight skeleton
// is the medial axis).
#pragma once

#include <array>
#include <map>
#include <vector>

#include "transect/cpp/skeleton/heights.h"

namespace transect::skeleton {

// Points of a cell: those of its content, and after them what is made.
class CellPoints {
 public:
  explicit CellPoints(const Heights& heights)
      : heights_(heights), base_(static_cast<Index>(heights.content().points.size())) {}

  Index add(const Point& point) {
    added_.push_back(point);
    parents_.push_back(base_ + static_cast<Index>(parents_.size()));
    return parents_.back();
  }

  const Point& operator[](Index point) const {
    return point < base_ ? heights_.point(point) : added_[point - base_];
  }

  // The first of the indices of one point.
  Index first(Index point) const {
    while (point >= base_ && parents_[point - base_] != point) point = parents_[point - base_];
    return point;
  }

  void unite(Index one, Index other);

  const std::vector<Point>& added() const { return added_; }
  Index base() const { return base_; }

 private:
  const Heights& heights_;
  Index base_;
  std::vector<Point> added_;
  std::vector<Index> parents_;
};

// A contour's piece on the roof: `owner` says whether it comes from the first
// of the roof's walls (0) or the second (1). Labels are those left and right as
// seen from the second wall's side.
struct Chain {
  Index from, to;
  Label left, right;
  int owner;
  // From one end to the other, once the roof is overlaid.
  std::vector<Index> points;
};

// A convex polygon between two walls of the cell.
struct Roof {
  Index walls[2];
  std::vector<Index> corners;
  // The wall beyond each side, from a corner to the next: the second wall
  // itself along their common edge.
  std::vector<Index> beyond;
  // A point inside, by its foot on the first wall.
  Point middle;
  std::vector<Chain> chains;
  std::vector<Index> extra;  // points on the sides where contours of others arrive
};

// A contour's piece with what is over it: the roofs it meets from end to end.
struct Lifted {
  Index wall;
  Piece piece;
  // Roof and its chain for every straight part.
  std::vector<std::pair<std::size_t, std::size_t>> parts;
};

struct Roofs {
  std::vector<Roof> roofs;
  std::vector<Lifted> lifted;
};

// Roofs between walls that do not both show one and the same label, and the
// contours on them.
Roofs make_roofs(const Heights& heights, CellPoints& points);

}  // namespace transect::skeleton
