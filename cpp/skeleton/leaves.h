// A cell with many sites is divided into leaves, until only a few sites can be nearest
// anywhere in a leaf, or all that can have one label. Most of a cell then needs no
// partition at all, and the rest one among a few (nearest.h).
//
// Leaves divide the cell only, not the answer: it is that of the whole cell. But where
// more sites than can be done meet in a leaf too small to be divided further, only those
// that touch it and the nearest others are asked, and the leaf is not exact.
#pragma once

#include <deque>
#include <optional>
#include <unordered_set>
#include <vector>

#include "transect/cpp/skeleton/nearest.h"

namespace transect::skeleton::partial {

struct Leaf {
  Polytope body;
  CGAL::Bbox_3 box;                   // the body is the cell's part within it
  std::vector<Candidate> candidates;  // just one where there is only one label
  // The only label that candidates have in the leaf.
  std::optional<Label> label;
  bool is_exact = true;
  bool is_beside_inexact = false;  // or not exact itself
};

class Leaves {
 public:
  // Cuts are made at this part of a leaf's length.
  Leaves(const Polytope& cell, const Distances& distances, double cut_at);

  const std::vector<Leaf>& mixed() const { return mixed_; }
  // Those of one label that touch a leaf that is not exact.
  std::vector<Leaf> uniform_beside_inexact();
  // The planes between leaves.
  const std::deque<Halfspace>& cuts() const { return cuts_; }
  bool is_cut(const Halfspace* plane) const { return is_cut_.count(plane) != 0; }
  // Whether a box touches a leaf that is not exact.
  bool is_beside_inexact(const CGAL::Bbox_3& box) const;

 private:
  struct Part {
    Polytope body;
    CGAL::Bbox_3 box;
    std::vector<Candidate> candidates;
  };
  void settle(Part part);
  double smallest() const;
  void drop_far(const std::vector<Place>& corners, Part& part);
  void join_known(const std::vector<Place>& corners, Part& part) const;
  void split(const Part& part);
  const Halfspace& cut(int axis, int side, double at);

  const Polytope& cell_;
  const Distances& distances_;
  double cut_at_;
  // Where a site is, rounded.
  struct Around {
    CGAL::Bbox_3 box;
    Place unit;  // its plane's normal
    double offset = 0;

    explicit Around(const Site& site);
    // The lowest and the highest over the plane.
    std::pair<double, double> heights(const std::vector<Place>& places) const;
  };
  std::vector<Around> around_;
  double size_;  // the cell's longest side
  std::deque<Halfspace> cuts_;
  std::unordered_set<const Halfspace*> is_cut_;
  std::deque<Part> queue_;
  std::vector<Leaf> mixed_, uniform_;
  std::vector<CGAL::Bbox_3> inexact_;  // leaves
};

}  // namespace transect::skeleton::partial
