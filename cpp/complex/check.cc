// What must hold for every cell complex, decided exactly.
#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "transect/cpp/complex/complex.h"

namespace transect::complex {
namespace {

using Side = std::pair<Id, Id>;

void ensure(bool holds, const char* whose, Id id, const char* what) {
  if (!holds) throw std::logic_error(std::string(whose) + ' ' + std::to_string(id) + ' ' + what);
}

void add_sides(const Facet& facet, std::vector<Side>& sides) {
  for (std::size_t i = 0; i < facet.corners.size(); ++i) {
    sides.push_back(std::minmax(facet.corners[i], facet.corners[(i + 1) % facet.corners.size()]));
  }
}

template <typename Item>
void sort_unique(std::vector<Item>& items) {
  std::sort(items.begin(), items.end());
  items.erase(std::unique(items.begin(), items.end()), items.end());
}

}  // namespace

// Two cells at every inner facet and one at every outer one; labels that agree.
void Complex::check_facet(Id id) const {
  const Facet& facet = facets_[id];
  ensure(facet.corners.size() > 2, "facet", id, "has less than three corners");
  for (Id corner : facet.corners) {
    ensure(places_[corner].is_on(facet.plane), "facet", id, "has a corner beside its plane");
  }
  const bool is_box = facet.plane < 6;
  ensure(is_box == (facet.cells[0] == none) && facet.cells[1] != none, "facet", id, "lacks a cell");
  for (Id cell : facet.cells) {
    if (cell == none) continue;
    const auto& facets = cells_[cell].facets;
    ensure(std::count(facets.begin(), facets.end(), id) == 1, "facet", id, "is not in its cell");
  }
  if (!facet.pieces.empty()) border(facet);
}

// Convex and closed.
void Complex::check_cell(Id id) const {
  std::vector<Side> sides;
  std::vector<Id> corners, planes;
  for (Id index : cells_[id].facets) {
    const Facet& facet = facets_[index];
    ensure(facet.cells[0] == id || facet.cells[1] == id, "cell", id, "has another one's facet");
    planes.push_back(facet.plane);
    corners.insert(corners.end(), facet.corners.begin(), facet.corners.end());
    add_sides(facet, sides);
  }
  sort_unique(planes);
  sort_unique(corners);
  ensure(planes.size() == cells_[id].facets.size(), "cell", id, "has two facets on one plane");
  std::sort(sides.begin(), sides.end());
  bool closes = sides.size() >= 12 && sides.size() % 2 == 0;
  for (std::size_t i = 0; closes && i < sides.size(); i += 2) {
    closes = sides[i] == sides[i + 1] && (i + 2 == sides.size() || sides[i + 1] != sides[i + 2]);
  }
  ensure(closes, "cell", id, "is not closed");
  for (Id index : cells_[id].facets) {
    const int way = facets_[index].cells[0] == id ? 1 : -1;
    for (Id corner : corners) {
      ensure(way * side(corner, facets_[index].plane) >= 0, "cell", id, "is not convex");
    }
  }
}

void Complex::check() const {
  std::vector<Id> corners;
  std::vector<Side> sides;
  for (Id id = 0; id < facets_.end(); ++id) {
    if (!facets_.has(id)) continue;
    check_facet(id);
    corners.insert(corners.end(), facets_[id].corners.begin(), facets_[id].corners.end());
    add_sides(facets_[id], sides);
  }
  for (Id id = 0; id < cells_.end(); ++id) {
    if (cells_.has(id)) check_cell(id);
  }
  sort_unique(corners);
  sort_unique(sides);
  // Euler's relation for a ball cut into cells.
  if (corners.size() + facets_.count() != sides.size() + cells_.count() + 1) {
    throw std::logic_error("V - E + F - C is not 1");
  }
}

void Complex::check_places() const {
  for (Id id = 0; id < places_.end(); ++id) {
    if (!places_.has(id)) continue;
    for (Id plane : places_[id].planes) {
      ensure(side_of(places_[id], planes_[plane]) == 0, "place", id, "is not on all its planes");
    }
  }
}

}  // namespace transect::complex
