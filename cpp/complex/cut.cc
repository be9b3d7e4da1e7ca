// Inserting a plane: the cells that it crosses are cut, and their facets with what is drawn
// on them.
#include <algorithm>
#include <limits>
#include <map>
#include <queue>
#include <stdexcept>
#include <unordered_map>
#include <unordered_set>

#include "transect/cpp/complex/complex.h"

namespace transect::complex {
namespace {

Point meeting_point(const Plane& a, const Plane& b, const Plane& c) {
  const Vector bc = CGAL::cross_product(b.normal, c.normal);
  const Vector ca = CGAL::cross_product(c.normal, a.normal);
  const Vector ab = CGAL::cross_product(a.normal, b.normal);
  return CGAL::ORIGIN + (a.offset * bc + b.offset * ca + c.offset * ab) / (a.normal * bc);
}

}  // namespace

class Cutter {
 public:
  Cutter(Complex& complex, Id plane)
      : complex_(complex), plane_(plane), sides_(complex.places_.end(), unknown_side) {}

  void cut() {
    const std::vector<Id> cells = zone();
    for (Id cell : cells) cut_cell(cell);
  }

 private:
  static constexpr std::int8_t unknown_side = 2;

  // On which sides of the plane corners are.
  struct Sides {
    bool front = false, behind = false;
    int on = 0;
    bool is_cut() const { return front && behind; }
    bool touches() const { return on > 0 || is_cut(); }
  };

  int side(Id place) {
    if (place >= sides_.size()) sides_.resize(place + 1, unknown_side);
    if (sides_[place] == unknown_side) {
      sides_[place] = static_cast<std::int8_t>(complex_.side(place, plane_));
    }
    return sides_[place];
  }

  void add(const Facet& facet, Sides& sides) {
    for (Id corner : facet.corners) {
      const int own = side(corner);
      sides.front = sides.front || own > 0;
      sides.behind = sides.behind || own < 0;
      sides.on += own == 0;
    }
  }

  Sides sides_of(const Cell& cell) {
    Sides sides;
    for (Id facet : cell.facets) add(complex_.facets_[facet], sides);
    return sides;
  }

  // How far a cell's nearest corner is, roughly.
  double distance(const Cell& cell) const {
    const Plane& plane = complex_.planes_[plane_];
    double least = std::numeric_limits<double>::infinity();
    for (Id facet : cell.facets) {
      for (Id corner : complex_.facets_[facet].corners) {
        const auto& at = complex_.places_[corner].rough;
        double value = -plane.rough_offset;
        for (int axis = 0; axis < 3; ++axis) value += plane.rough_normal[axis] * at[axis];
        least = std::min(least, std::abs(value));
      }
    }
    return least;
  }

  template <typename Visit>
  void for_each_neighbour(Id cell, Visit visit) const {
    for (Id facet : complex_.cells_[cell].facets) {
      const auto& [front, behind] = complex_.facets_[facet].cells;
      const Id beyond = front == cell ? behind : front;
      if (beyond != none) visit(facet, beyond);
    }
  }

  // A cell that touches the plane, `none` if it misses the box: always on from the cell
  // that came nearest.
  Id first_touched() {
    Id start = 0;
    while (!complex_.cells_.has(start)) ++start;
    using Entry = std::pair<double, Id>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<Entry>> open;
    std::unordered_set<Id> seen{start};
    open.push({distance(complex_.cells_[start]), start});
    while (!open.empty()) {
      const Id cell = open.top().second;
      open.pop();
      if (sides_of(complex_.cells_[cell]).touches()) return cell;
      for_each_neighbour(cell, [&](Id, Id beyond) {
        if (seen.insert(beyond).second) open.push({distance(complex_.cells_[beyond]), beyond});
      });
    }
    return none;
  }

  // The cells that the plane cuts; what it merely touches learns so.
  std::vector<Id> zone() {
    std::vector<Id> cut;
    const Id first = first_touched();
    if (first == none) return cut;
    std::vector<Id> open{first};
    std::unordered_set<Id> seen{first}, touched;
    while (!open.empty()) {
      const Id cell = open.back();
      open.pop_back();
      if (sides_of(complex_.cells_[cell]).is_cut()) cut.push_back(cell);
      touched.insert(complex_.cells_[cell].facets.begin(), complex_.cells_[cell].facets.end());
      for_each_neighbour(cell, [&](Id facet, Id beyond) {
        Sides sides;
        add(complex_.facets_[facet], sides);
        if (sides.touches() && seen.insert(beyond).second) open.push_back(beyond);
      });
    }
    // Labels first: what runs along the plane counts as a border's once it is on it.
    for (Id facet : touched) find_labels(facet);
    for (Id facet : touched) touch(facet);
    return cut;
  }

  void find_labels(Id facet) {
    const Facet& own = complex_.facets_[facet];
    Sides sides;
    add(own, sides);
    if (sides.is_cut() && !own.pieces.empty()) borders_.emplace(facet, complex_.border(own));
  }

  // Corners and marks of a facet that are on the plane.
  void touch(Id facet) {
    Sides sides;
    add(complex_.facets_[facet], sides);
    if (sides.on > 0) {
      for (Id corner : complex_.facets_[facet].corners) {
        if (side(corner) == 0) complex_.put_on(corner, plane_);
      }
    }
    if (sides.on < 2 && !sides.is_cut()) return;
    for (Id mark : complex_.facets_[facet].marks) {
      if (side(mark) == 0) complex_.put_on(mark, plane_);
    }
  }

  // The cell keeps the part behind the plane, a new one gets that in front.
  void cut_cell(Id cell) {
    const Id other = complex_.cells_.add({});
    std::vector<Id> front, behind;
    for (Id facet : std::vector<Id>(complex_.cells_[cell].facets)) {
      cut_facet(facet);
      const auto cut = fronts_.find(facet);
      if (cut != fronts_.end()) {
        behind.push_back(facet);
        front.push_back(cut->second);
      } else {
        Sides sides;
        add(complex_.facets_[facet], sides);
        (sides.front ? front : behind).push_back(facet);
      }
    }
    Facet lid;
    lid.plane = plane_;
    lid.corners = lid_corners(cell, behind);
    lid.cells = {other, cell};
    for (Id facet : front) {
      for (Id& beside : complex_.facets_.edit(facet).cells) {
        if (beside == cell) beside = other;
      }
    }
    const Id made = complex_.facets_.add(std::move(lid));
    front.push_back(made);
    behind.push_back(made);
    complex_.cells_.edit(cell).facets = std::move(behind);
    complex_.cells_.edit(other).facets = std::move(front);
  }

  // The facet keeps the part behind the plane.
  void cut_facet(Id id) {
    if (fronts_.count(id) != 0) return;  // for the cell beyond
    Sides sides;
    add(complex_.facets_[id], sides);
    if (!sides.is_cut()) return;
    const Facet old = complex_.facets_[id];
    Facet front, behind;
    front.plane = behind.plane = old.plane;
    front.cells = behind.cells = old.cells;
    std::vector<Id> ends;  // of the line that cuts it
    for (std::size_t i = 0; i < old.corners.size(); ++i) {
      const Id here = old.corners[i], next = old.corners[(i + 1) % old.corners.size()];
      if (side(here) >= 0) front.corners.push_back(here);
      if (side(here) <= 0) behind.corners.push_back(here);
      if (side(here) == 0) ends.push_back(here);
      if (side(here) * side(next) >= 0) continue;
      const Id made = crossing(here, next, old);
      front.corners.push_back(made);
      behind.corners.push_back(made);
      ends.push_back(made);
    }
    begin_off_the_plane(front, id);
    begin_off_the_plane(behind, id);
    share_out(old, ends, front, behind);
    complex_.facets_.edit(id) = std::move(behind);
    fronts_[id] = complex_.facets_.add(std::move(front));
  }

  // Makes the first corner of a part one that the facet had, whose label is known.
  void begin_off_the_plane(Facet& part, Id facet) {
    auto& corners = part.corners;
    const auto first =
        std::find_if(corners.begin(), corners.end(), [&](Id corner) { return side(corner) != 0; });
    std::rotate(corners.begin(), first, corners.end());
    part.label = complex_.facets_[facet].label;
    const auto found = borders_.find(facet);
    if (found == borders_.end()) return;
    const auto& [places, is_corner, labels] = found->second;
    part.label = labels[std::find(places.begin(), places.end(), corners.front()) - places.begin()];
  }

  // Pieces and marks, to the parts they are in.
  void share_out(const Facet& old, const std::vector<Id>& ends, Facet& front, Facet& behind) {
    std::map<Id, Id> renamed;  // marks where the plane meets the border now
    for (Id mark : old.marks) {
      const int own = side(mark);
      if (own > 0) front.marks.push_back(mark);
      if (own < 0) behind.marks.push_back(mark);
      if (own != 0) continue;
      std::vector<Id> line = complex_.places_[mark].planes;
      line.erase(std::lower_bound(line.begin(), line.end(), plane_));
      renamed[mark] = end_on(line, ends);
    }
    const auto mark = [&](Id place) {
      complex_.put_on(place, plane_);
      if (std::find(ends.begin(), ends.end(), place) != ends.end()) return;
      for (Facet* part : {&front, &behind}) {
        auto& marks = part->marks;
        if (std::find(marks.begin(), marks.end(), place) == marks.end()) marks.push_back(place);
      }
    };
    for (Piece piece : old.pieces) {
      for (Id* end : {&piece.from, &piece.to}) {
        const auto found = renamed.find(*end);
        if (found != renamed.end()) complex_.rename(old.plane, piece.edge, *end, found->second);
        if (found != renamed.end()) *end = found->second;
        if (side(*end) == 0) mark(*end);
      }
      const int from = side(piece.from), to = side(piece.to);
      if (from * to < 0) {
        const auto line =
            common(complex_.places_[piece.from].planes, complex_.places_[piece.to].planes);
        const Id place = line.size() > 1 ? end_on(line, ends) : crossing(old.plane, piece);
        mark(place);
        (from > 0 ? front : behind).pieces.push_back({piece.edge, piece.from, place});
        (from > 0 ? behind : front).pieces.push_back({piece.edge, place, piece.to});
        continue;
      }
      if (from >= 0 && to >= 0) front.pieces.push_back(piece);
      if (from <= 0 && to <= 0) behind.pieces.push_back(piece);
    }
  }

  // The end of the cut on a line of the border, given by its planes.
  Id end_on(const std::vector<Id>& line, const std::vector<Id>& ends) const {
    for (Id end : ends) {
      if (count_common(line, complex_.places_[end].planes) > 1) return end;
    }
    throw std::logic_error("a line of a facet's border that is cut has no end of the cut");
  }

  // Where the edge between two corners of a facet crosses the plane: at a mark, if there
  // is one.
  Id crossing(Id one, Id other, const Facet& facet) {
    const auto key = std::minmax(one, other);
    const auto found = crossings_.find(key);
    if (found != crossings_.end()) return found->second;
    std::vector<Id> planes = common(complex_.places_[one].planes, complex_.places_[other].planes);
    Id made = none;
    for (Id mark : facet.marks) {
      if (side(mark) == 0 && count_common(planes, complex_.places_[mark].planes) > 1) made = mark;
    }
    if (made == none) {
      if (planes.size() < 2) throw std::logic_error("an edge of a cell is on less than two planes");
      const Point point = meeting_point(complex_.planes_[planes[0]], complex_.planes_[planes[1]],
                                        complex_.planes_[plane_]);
      made = complex_.add_place(point, planes);
    }
    for (Id plane : planes) complex_.put_on(made, plane);
    complex_.put_on(made, plane_);
    set_on(made);
    crossings_.emplace(key, made);
    return made;
  }

  // Where a piece crosses the plane: its edge does.
  Id crossing(Id plane, const Piece& piece) {
    const Section& section = complex_.sections_[plane];
    const Edge& edge = section.edges[piece.edge];
    const Point& from = complex_.places_[section.vertices[edge.start]].exact;
    const Point& to = complex_.places_[section.vertices[edge.end]].exact;
    const Plane& own = complex_.planes_[plane_];
    const Number at_from = own.value(from), at_to = own.value(to);
    const Point point = from + at_from / (at_from - at_to) * (to - from);
    const Id made = complex_.add_place(point, {std::min(plane, plane_), std::max(plane, plane_)});
    set_on(made);
    return made;
  }

  void set_on(Id place) {
    side(place);
    sides_[place] = 0;
  }

  // The polygon that closes the part behind the plane, counter-clockwise about the plane's
  // normal: against the direction in which its facets, seen from outside, run along it.
  std::vector<Id> lid_corners(Id cell, const std::vector<Id>& facets) {
    std::map<Id, Id> next;
    for (Id index : facets) {
      const Facet& facet = complex_.facets_[index];
      for (std::size_t i = 0; i < facet.corners.size(); ++i) {
        const Id from = facet.corners[i], to = facet.corners[(i + 1) % facet.corners.size()];
        if (side(from) != 0 || side(to) != 0) continue;
        const bool faces_outward = facet.cells[1] == cell;
        faces_outward ? next[to] = from : next[from] = to;
      }
    }
    if (next.empty()) throw std::logic_error("a cut cell has no lid");
    std::vector<Id> corners;
    Id corner = next.begin()->first;
    do {
      corners.push_back(corner);
      const auto found = next.find(corner);
      if (found == next.end() || corners.size() > next.size()) {
        throw std::logic_error("the lid of a cut cell is not closed");
      }
      corner = found->second;
    } while (corner != corners.front());
    return corners;
  }

  Complex& complex_;
  Id plane_;
  std::vector<std::int8_t> sides_;
  std::unordered_map<Id, Border> borders_;  // of cut facets on which something is drawn
  std::unordered_map<Id, Id> fronts_;       // the front parts of cut facets
  std::map<std::pair<Id, Id>, Id> crossings_;
};

Id Complex::insert(const Plane& plane) {
  const Id id = planes_.add(plane);
  if (sections_.add(Section{}) != id) throw std::logic_error("planes and sections differ");
  Cutter(*this, id).cut();
  return id;
}

}  // namespace transect::complex
