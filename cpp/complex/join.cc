// Removing a plane: the cells on both sides of it become one again, and so do their facets
// with what is drawn on them.
#include <algorithm>
#include <map>
#include <set>
#include <stdexcept>

#include "transect/cpp/complex/complex.h"

namespace transect::complex {

class Joiner {
 public:
  Joiner(Complex& complex, Id plane) : complex_(complex), plane_(plane) {}

  void join() {
    std::vector<Id> joined;
    for (Id id = 0; id < complex_.facets_.end(); ++id) {
      if (complex_.facets_.has(id) && complex_.facets_[id].plane == plane_) {
        joined.push_back(join_cells(id));
      }
    }
    for (Id cell : joined) join_facets(cell);
    for (Id id = 0; id < complex_.places_.end(); ++id) {
      if (complex_.places_.has(id) && complex_.places_[id].is_on(plane_)) {
        auto& planes = complex_.places_.edit(id).planes;
        planes.erase(std::lower_bound(planes.begin(), planes.end(), plane_));
      }
    }
    mark_lost_corners();
  }

 private:
  // The cell behind the facet, which gets all that the one in front has.
  Id join_cells(Id lid) {
    const auto [front, behind] = complex_.facets_[lid].cells;
    std::vector<Id> facets = complex_.cells_[behind].facets;
    for (Id facet : complex_.cells_[front].facets) {
      if (facet == lid) continue;
      facets.push_back(facet);
      for (Id& beside : complex_.facets_.edit(facet).cells) {
        if (beside == front) beside = behind;
      }
    }
    facets.erase(std::find(facets.begin(), facets.end(), lid));
    complex_.cells_.edit(behind).facets = std::move(facets);
    complex_.cells_.remove(front);
    complex_.facets_.remove(lid);
    return behind;
  }

  void join_facets(Id cell) {
    std::map<Id, Id> first;  // by plane
    for (Id facet : std::vector<Id>(complex_.cells_[cell].facets)) {
      const auto [found, is_new] = first.emplace(complex_.facets_[facet].plane, facet);
      if (!is_new) join_facets(found->second, facet);
    }
  }

  // The first one stays.
  void join_facets(Id one, Id other) {
    const Facet a = complex_.facets_[one], b = complex_.facets_[other];
    Facet made;
    made.plane = a.plane;
    made.cells = a.cells;
    made.corners = rest_of(a);
    const std::vector<Id> beyond = rest_of(b);
    if (made.corners.front() != beyond.back() || made.corners.back() != beyond.front()) {
      throw std::logic_error("two facets of one cell and plane do not meet");
    }
    made.corners.insert(made.corners.end(), beyond.begin() + 1, beyond.end() - 1);
    begin_off_the_plane(made, a);
    join_pieces(a, b, made);
    for (Id end : {beyond.front(), beyond.back()}) {
      if (!is_straight(end)) continue;
      made.corners.erase(std::find(made.corners.begin(), made.corners.end(), end));
      Lost& lost = lost_[{made.plane, end}];
      lost.facets.push_back(one);
      lost.is_drawn = lost.is_drawn ||
                      std::any_of(made.pieces.begin(), made.pieces.end(), [&](const Piece& piece) {
                        return piece.from == end || piece.to == end;
                      });
    }
    for (const Facet* part : {&a, &b}) {
      for (Id mark : part->marks) {
        if (is_on_border(mark)) made.marks.push_back(mark);
      }
    }
    for (Id cell : b.cells) {
      if (cell == none) continue;
      auto& facets = complex_.cells_.edit(cell).facets;
      facets.erase(std::find(facets.begin(), facets.end(), other));
    }
    complex_.facets_.remove(other);
    complex_.facets_.edit(one) = std::move(made);
  }

  bool is_on(Id place) const { return complex_.places_[place].is_on(plane_); }

  // The corners from the one where a facet leaves the plane to the one where it meets it.
  std::vector<Id> rest_of(const Facet& facet) const {
    std::vector<Id> corners = facet.corners;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Id here = corners[i], next = corners[(i + 1) % corners.size()];
      if (!is_on(here) || !is_on(next)) continue;
      std::rotate(corners.begin(), corners.begin() + (i + 1) % corners.size(), corners.end());
      return corners;
    }
    throw std::logic_error("a facet of a cell that is joined does not end at the plane");
  }

  void begin_off_the_plane(Facet& made, const Facet& part) const {
    const Border border = complex_.border(part);
    std::size_t at = 0;
    while (!border.is_corner[at] || is_on(border.places[at])) ++at;
    made.label = border.labels[at];
    std::rotate(made.corners.begin(),
                std::find(made.corners.begin(), made.corners.end(), border.places[at]),
                made.corners.end());
  }

  // How many planes a place is on without the one that goes.
  std::size_t left(Id place) const {
    return complex_.places_[place].planes.size() - (is_on(place) ? 1 : 0);
  }
  bool is_on_border(Id place) const { return left(place) > 1; }

  // Whether all planes through a place but the one that goes share a line.
  bool is_straight(Id place) const {
    std::vector<const Plane*> through;
    for (Id plane : complex_.places_[place].planes) {
      if (plane != plane_) through.push_back(&complex_.planes_[plane]);
    }
    if (through.size() < 3) return true;
    const Vector line = CGAL::cross_product(through[0]->normal, through[1]->normal);
    return std::all_of(through.begin() + 2, through.end(),
                       [&](const Plane* plane) { return CGAL::is_zero(plane->normal * line); });
  }

  // Pieces that only the plane parted become one again.
  void join_pieces(const Facet& a, const Facet& b, Facet& made) {
    std::map<std::pair<Id, Id>, Piece> ahead;  // by edge, and by where they begin
    std::set<std::pair<Id, Id>> parted;
    const Section& section = complex_.sections_[a.plane];
    for (const Facet* part : {&a, &b}) {
      for (const Piece& piece : part->pieces) {
        ahead.emplace(std::make_pair(piece.edge, piece.from), piece);
        const Id vertex = section.vertices[section.edges[piece.edge].end];
        if (piece.to != vertex && is_on(piece.to) && goes_on(piece)) {
          parted.insert({piece.edge, piece.to});
        }
      }
    }
    for (auto& [key, piece] : ahead) {
      if (parted.count(key) != 0) continue;
      for (auto next = ahead.find({piece.edge, piece.to});
           next != ahead.end() && parted.count(next->first) != 0;
           next = ahead.find({piece.edge, piece.to})) {
        piece.to = next->second.to;
      }
      made.pieces.push_back(piece);
    }
  }

  // Whether a piece goes on beyond its end: no other plane crosses it there.
  bool goes_on(const Piece& piece) const {
    const auto& planes = complex_.places_[piece.to].planes;
    return std::all_of(planes.begin(), planes.end(), [&](Id plane) {
      return plane == plane_ || complex_.places_[piece.from].is_on(plane);
    });
  }

  // Corners that are none any more are marks, on both sides of their line, where something
  // drawn ends in them.
  void mark_lost_corners() {
    for (const auto& [key, lost] : lost_) {
      if (!lost.is_drawn) continue;
      for (Id facet : lost.facets) complex_.facets_.edit(facet).marks.push_back(key.second);
    }
  }

  struct Lost {
    std::vector<Id> facets;
    bool is_drawn = false;
  };

  Complex& complex_;
  Id plane_;
  std::map<std::pair<Id, Id>, Lost> lost_;  // by plane and place
};

void Complex::remove(Id plane) {
  if (plane < 6) throw std::logic_error("a plane of the box cannot be removed");
  Joiner(*this, plane).join();
  planes_.remove(plane);
  sections_.remove(plane);
}

}  // namespace transect::complex
