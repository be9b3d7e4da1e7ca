#include "transect/cpp/complex/complex.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace transect::complex {
namespace {

// A label beside a piece that a walk along a border leaves for the other one.
struct Passed {
  Label left, entered;
};

[[noreturn]] void contradict(const Place& place) {
  std::ostringstream text;
  text << "labels contradict each other at (" << place.rough[0] << ", " << place.rough[1] << ", "
       << place.rough[2] << ")";
  throw std::invalid_argument(text.str());
}

// The label after some pieces were passed: what is entered and left at one place cancels,
// in whatever order.
Label passed(Label before, const std::vector<Passed>& pieces, const Place& place) {
  std::map<Label, int> balance{{before, 1}};
  for (const auto& [left, entered] : pieces) {
    --balance[left];
    ++balance[entered];
  }
  std::optional<Label> after;
  for (const auto& [label, count] : balance) {
    if (count == 0) continue;
    if (count != 1 || after) contradict(place);
    after = label;
  }
  if (!after) contradict(place);
  return *after;
}

}  // namespace

Complex::Complex(const std::array<double, 6>& bounds, Label border) : border_(border) {
  size_ = 0;
  for (double number : bounds) size_ = std::max(size_, std::abs(number));
  for (int axis = 0; axis < 3; ++axis) {
    for (int upper : {0, 1}) {
      std::array<double, 3> normal{};
      normal[axis] = upper ? 1 : -1;
      const double at = bounds[2 * axis + upper];
      planes_.add(Plane(normal, upper ? at : -at));
      sections_.add(Section{{}, {}, border});
    }
  }
  Id corner[2][2][2];
  for (Id x : {0, 1}) {
    for (Id y : {0, 1}) {
      for (Id z : {0, 1}) {
        corner[x][y][z] = add_place({bounds[x], bounds[2 + y], bounds[4 + z]}, {x, 2 + y, 4 + z});
      }
    }
  }
  Cell cell;
  for (Id axis = 0; axis < 3; ++axis) {
    for (Id upper : {0, 1}) {
      Facet facet;
      facet.plane = 2 * axis + upper;
      for (int step = 0; step < 4; ++step) {
        Id at[3];
        at[axis] = upper;
        at[(axis + 1) % 3] = step == 1 || step == 2;
        at[(axis + 2) % 3] = step >= 2;
        facet.corners.push_back(corner[at[0]][at[1]][at[2]]);
      }
      // The normal points outward: down the axis on the lower side.
      if (!upper) std::reverse(facet.corners.begin(), facet.corners.end());
      facet.cells = {none, 0};
      facet.label = border;
      cell.facets.push_back(facets_.add(std::move(facet)));
    }
  }
  cells_.add(std::move(cell));
}

std::pair<Label, Label> Complex::labels(Id plane, const Piece& piece) const {
  const Edge& edge = sections_[plane].edges[piece.edge];
  return {edge.left, edge.right};
}

void Complex::put_on(Id place, Id plane) {
  if (places_[place].is_on(plane)) return;
  auto& planes = places_.edit(place).planes;
  planes.insert(std::lower_bound(planes.begin(), planes.end(), plane), plane);
}

void Complex::rename(Id plane, Id edge, Id place, Id other) {
  if (place == other) return;
  const auto [start, end, left, right] = sections_[plane].edges[edge];
  for (Id vertex : {start, end}) {
    if (sections_[plane].vertices[vertex] == place) sections_.edit(plane).vertices[vertex] = other;
  }
}

bool Complex::runs_along(const Piece& piece) const {
  return share_line(places_[piece.from], places_[piece.to]);
}

Border Complex::places_along(const Facet& facet) const {
  Border border;
  for (std::size_t i = 0; i < facet.corners.size(); ++i) {
    const Id here = facet.corners[i], next = facet.corners[(i + 1) % facet.corners.size()];
    border.places.push_back(here);
    border.is_corner.push_back(true);
    if (facet.marks.empty()) continue;
    const std::vector<Id> line = common(places_[here].planes, places_[next].planes);
    std::vector<Id> marks;
    for (Id mark : facet.marks) {
      if (count_common(line, places_[mark].planes) > 1) marks.push_back(mark);
    }
    const bool ascends = CGAL::compare_xyz(places_[here].exact, places_[next].exact) < 0;
    std::sort(marks.begin(), marks.end(), [&](Id one, Id other) {
      const auto order = CGAL::compare_xyz(places_[one].exact, places_[other].exact);
      return ascends ? order == CGAL::SMALLER : order == CGAL::LARGER;
    });
    for (Id mark : marks) {
      border.places.push_back(mark);
      border.is_corner.push_back(false);
    }
  }
  return border;
}

void Complex::walk(const Facet& facet, Border& border, std::size_t known, Label label) const {
  border.labels.assign(border.places.size(), label);
  std::map<Id, std::vector<Passed>> ends;
  for (const Piece& piece : facet.pieces) {
    const bool from = is_on_line(piece.from), to = is_on_line(piece.to);
    if ((!from && !to) || runs_along(piece)) continue;
    const auto [left, right] = labels(facet.plane, piece);
    // With the facet on the left the walk comes by a piece that begins here on its left.
    if (from) ends[piece.from].push_back({left, right});
    if (to) ends[piece.to].push_back({right, left});
  }
  if (ends.empty()) return;
  const std::size_t count = border.places.size();
  for (std::size_t step = 1; step <= count; ++step) {
    const std::size_t at = (known + step) % count;
    const auto found = ends.find(border.places[at]);
    if (found != ends.end()) label = passed(label, found->second, places_[border.places[at]]);
    if (step < count) border.labels[at] = label;
  }
  if (label != border.labels[known]) contradict(places_[border.places[known]]);
}

Border Complex::border(const Facet& facet) const {
  Border border = places_along(facet);
  walk(facet, border, 0, facet.label);
  return border;
}

Id Complex::coincident(const Plane& plane) const {
  const auto minor = [&](const Plane& other) {
    return CGAL::cross_product(plane.normal, other.normal) == CGAL::NULL_VECTOR &&
           plane.offset * other.normal == other.offset * plane.normal;
  };
  for (Id id = 0; id < planes_.end(); ++id) {
    if (planes_.has(id) && minor(planes_[id])) return id;
  }
  return none;
}

void Complex::begin() {
  planes_.begin();
  sections_.begin();
  places_.begin();
  facets_.begin();
  cells_.begin();
}

void Complex::commit() {
  planes_.commit();
  sections_.commit();
  places_.commit();
  facets_.commit();
  cells_.commit();
  if (places_.count() > most_places_) drop_unused_places();
}

void Complex::rollback() {
  planes_.rollback();
  sections_.rollback();
  places_.rollback();
  facets_.rollback();
  cells_.rollback();
}

void Complex::drop_unused_places() {
  std::vector<bool> is_used(places_.end(), false);
  const auto use = [&](const std::vector<Id>& places) {
    for (Id place : places) is_used[place] = true;
  };
  for (Id id = 0; id < facets_.end(); ++id) {
    if (!facets_.has(id)) continue;
    use(facets_[id].corners);
    use(facets_[id].marks);
    for (const Piece& piece : facets_[id].pieces) use({piece.from, piece.to});
  }
  for (Id id = 0; id < sections_.end(); ++id) {
    if (sections_.has(id)) use(sections_[id].vertices);
  }
  for (Id id = 0; id < places_.end(); ++id) {
    if (places_.has(id) && !is_used[id]) places_.remove(id);
  }
  most_places_ = std::max<std::size_t>(1024, 2 * places_.count());
}

}  // namespace transect::complex
