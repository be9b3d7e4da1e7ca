// The exact cell complex of the planes in a box (Bermano, Vaxman and Gotsman §4.2 and §7):
// a plane is inserted by cutting the cells it crosses, and removed by joining them again.
// Nothing else changes, nor does its number.
#pragma once

#include <utility>
#include <vector>

#include "transect/cpp/complex/slots.h"

namespace transect::complex {

// Seen with the plane's normal pointing at the viewer.
struct Edge {
  Id start, end;  // vertices of the section
  Label left, right;
};

// What is drawn on a plane. Edges meet in their ends alone.
struct Section {
  std::vector<Id> vertices;  // places
  std::vector<Edge> edges;
  Label background = 0;
};

// From a place to a place, the way that its edge goes.
struct Piece {
  Id edge;  // of the section on the facet's plane
  Id from, to;

  bool operator==(const Piece& other) const {
    return edge == other.edge && from == other.from && to == other.to;
  }
};

struct Facet {
  Id plane = none;
  std::vector<Id> corners;              // places, counter-clockwise about the plane's normal
  std::array<Id, 2> cells{none, none};  // in front and behind; `none` beyond the box
  std::vector<Piece> pieces;            // those along its border as well
  std::vector<Id> marks;                // places, in no order
  Label label = 0;                      // next to the border, from the first corner on
};

struct Cell {
  std::vector<Id> facets;
};

// The places along a facet's border, from its first corner on, and the label of the facet
// next to the border from each to the next.
struct Border {
  std::vector<Id> places;
  std::vector<bool> is_corner;
  std::vector<Label> labels;
};

class Complex {
 public:
  // The six planes of the box have the numbers 0 to 5: lower and upper x, y, z, their
  // normals pointing outward.
  Complex(const std::array<double, 6>& bounds, Label border);

  // Cuts all cells that a plane crosses, and returns its number. It must be none of those
  // that are there.
  Id insert(const Plane& plane);
  // Joins the cells on both sides of a plane, which must not be the box's.
  void remove(Id plane);
  // Draws a section on a plane, in place of what was there. Vertices are given by their two
  // kept coordinates.
  void draw(Id plane, const std::vector<double>& vertices, std::vector<Edge> edges,
            Label background);
  // Takes away what is drawn on a plane of the box.
  void erase(Id plane);
  // The plane that is the same set of points, or `none`.
  Id coincident(const Plane& plane) const;

  const Slots<Plane>& planes() const { return planes_; }
  const Slots<Place>& places() const { return places_; }
  const Slots<Facet>& facets() const { return facets_; }
  const Slots<Cell>& cells() const { return cells_; }
  // The left and right label of a piece on a plane.
  std::pair<Label, Label> labels(Id plane, const Piece& piece) const;

  Border border(const Facet& facet) const;
  // Whether a piece runs along the border of its facet.
  bool runs_along(const Piece& piece) const;

  // What was changed since can be taken back, until it is committed.
  void begin();
  void commit();
  void rollback();

  // Throws when something is not as it must be.
  void check() const;
  // The same for what places are said to be on: every one is computed exactly.
  void check_places() const;

 private:
  friend class Cutter;
  friend class Joiner;
  friend class Artist;

  int side(Id place, Id plane) const {
    return places_[place].is_on(plane) ? 0 : side_of(places_[place], planes_[plane]);
  }
  Id add_place(const Point& point, std::vector<Id> planes) {
    return places_.add(Place(point, std::move(planes), size_));
  }
  // Whether a place is on two planes at least.
  bool is_on_line(Id place) const { return places_[place].planes.size() > 1; }
  void put_on(Id place, Id plane);
  // Where an edge of a section ends in a place, it ends in another one instead.
  void rename(Id plane, Id edge, Id place, Id other);
  // The places of a border, without labels.
  Border places_along(const Facet& facet) const;
  // The labels of a border from the one that is known after a place of it.
  void walk(const Facet& facet, Border& border, std::size_t known, Label label) const;
  void drop_unused_places();
  void check_facet(Id id) const;
  void check_cell(Id id) const;

  double size_;  // the largest coordinate
  Label border_;
  Slots<Plane> planes_;
  Slots<Section> sections_;  // by the planes' numbers
  Slots<Place> places_;
  Slots<Facet> facets_;
  Slots<Cell> cells_;
  std::size_t most_places_ = 1024;  // with more, those that nothing uses are dropped
};

}  // namespace transect::complex
