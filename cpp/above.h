// What is above a point in a plane.
#pragma once

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>

#include <cstdint>
#include <optional>

namespace transect {

// Edges pass by a point one after the other: the first one on the way up from it says which
// label is below. They meet in their ends alone, and count with their left end and without
// their right one.
class Above {
 public:
  using Point = CGAL::Exact_predicates_exact_constructions_kernel::Point_2;
  using Label = std::uint32_t;

  // `background` is the label where nothing is above.
  Above(Point point, Label background) : point_(std::move(point)), label_(background) {}

  // An edge that the point is not on, with the labels left and right of it.
  void pass(const Point& from, const Point& to, Label left, Label right) {
    const auto order = CGAL::compare_x(from, to);
    if (order == CGAL::EQUAL) return;
    const Bar bar = order == CGAL::SMALLER ? Bar{from, to, right} : Bar{to, from, left};
    if (CGAL::compare_x(bar.low, point_) == CGAL::LARGER) return;
    if (CGAL::compare_x(bar.high, point_) != CGAL::LARGER) return;
    if (CGAL::orientation(bar.low, bar.high, point_) != CGAL::RIGHT_TURN) return;
    if (nearest_ && !is_below(bar, *nearest_)) return;
    nearest_ = bar;
    label_ = bar.below;
  }

  Label label() const { return label_; }

 private:
  // An edge from left to right.
  struct Bar {
    Point low, high;
    Label below;
  };

  // Whether bar a is below bar b just right of a place that both span.
  static bool is_below(const Bar& a, const Bar& b) {
    if (CGAL::compare_x(a.low, b.low) == CGAL::SMALLER) return !is_below(b, a);
    const auto turn = CGAL::orientation(b.low, b.high, a.low);
    if (turn != CGAL::COLLINEAR) return turn == CGAL::RIGHT_TURN;
    return CGAL::orientation(b.low, b.high, a.high) == CGAL::RIGHT_TURN;
  }

  Point point_;
  Label label_;
  std::optional<Bar> nearest_;
};

}  // namespace transect
