// What a section shows, on the facets of its plane.
#include <algorithm>
#include <map>
#include <optional>
#include <queue>
#include <set>
#include <stdexcept>
#include <string>
#include <unordered_map>

#include "transect/cpp/above.h"
#include "transect/cpp/complex/complex.h"

namespace transect::complex {
namespace {

// A direction in which a piece leaves a place.
struct Leaving {
  Vector direction;
  Label left, right;
};

}  // namespace

class Artist {
 public:
  Artist(Complex& complex, Id plane) : complex_(complex), plane_(plane) {
    for (Id id = 0; id < complex.planes_.end(); ++id) {
      if (id != plane && complex.planes_.has(id)) others_.push_back(id);
    }
    for (Id id = 0; id < complex.facets_.end(); ++id) {
      if (complex.facets_.has(id) && complex.facets_[id].plane == plane) facets_.push_back(id);
    }
  }

  void draw() {
    for (Id facet : facets_) {
      Facet& own = complex_.facets_.edit(facet);
      own.pieces.clear();
      own.marks.clear();
      own.label = section().background;
    }
    if (section().edges.empty() || facets_.empty()) return;
    for (Id facet : facets_) names_.emplace(name_of(facet), facet);
    for (Id vertex : section().vertices) sides_.push_back(sides_of(vertex));
    for (Id edge = 0; edge < section().edges.size(); ++edge) add(edge);
    find_labels();
  }

 private:
  using Sides = std::string;  // −1, 0 or 1 for each of the other planes

  // Where an edge crosses other planes.
  struct Crossing {
    Number along;
    std::vector<std::size_t> planes;  // indices into `others_`
    Id place;
  };

  const Section& section() const { return complex_.sections_[plane_]; }
  const Plane& plane() const { return complex_.planes_[plane_]; }

  Sides sides_of(Id place) const {
    Sides sides;
    for (Id other : others_) sides.push_back(static_cast<char>(complex_.side(place, other)));
    return sides;
  }

  // On which side of all others a facet is: no other has this name.
  std::string name_of(Id facet) const {
    Sides name(others_.size(), 0);
    for (std::size_t i = 0; i < others_.size(); ++i) {
      for (Id corner : complex_.facets_[facet].corners) {
        name[i] = static_cast<char>(complex_.side(corner, others_[i]));
        if (name[i] != 0) break;
      }
    }
    return name;
  }

  std::vector<Crossing> crossings(Id start, Id end, const Sides& from, const Sides& to) const {
    std::vector<Crossing> crossings;
    const Point &a = complex_.places_[start].exact, &b = complex_.places_[end].exact;
    for (std::size_t i = 0; i < others_.size(); ++i) {
      if (from[i] * to[i] >= 0) continue;
      const Plane& other = complex_.planes_[others_[i]];
      const Number at_start = other.value(a);
      crossings.push_back({at_start / (at_start - other.value(b)), {i}, none});
    }
    std::sort(crossings.begin(), crossings.end(),
              [](const Crossing& one, const Crossing& two) { return one.along < two.along; });
    std::vector<Crossing> distinct;
    for (Crossing& crossing : crossings) {
      if (!distinct.empty() && distinct.back().along == crossing.along) {
        distinct.back().planes.push_back(crossing.planes.front());
      } else {
        distinct.push_back(std::move(crossing));
      }
    }
    return distinct;
  }

  // Cuts an edge into pieces and puts them on their facets.
  void add(Id index) {
    const Edge edge = section().edges[index];
    const Id start = section().vertices[edge.start], end = section().vertices[edge.end];
    const Sides &from = sides_[edge.start], &to = sides_[edge.end];
    const Point a = complex_.places_[start].exact, b = complex_.places_[end].exact;
    std::vector<Crossing> cuts = crossings(start, end, from, to);
    // The names of the pieces, and of the places between them: all that is not crossed is
    // on the side of both ends.
    Sides name = from, target = to;
    for (std::size_t i = 0; i < name.size(); ++i) {
      if (name[i] == 0) name[i] = to[i];
    }
    Id here = start;
    Sides here_sides = from;
    for (std::size_t cut = 0; cut <= cuts.size(); ++cut) {
      Id there = end;
      Sides there_sides = to;
      if (cut < cuts.size()) {
        there_sides = name;
        std::vector<Id> planes{plane_};
        for (std::size_t other : cuts[cut].planes) {
          there_sides[other] = 0;
          planes.push_back(others_[other]);
        }
        for (std::size_t i = 0; i < name.size(); ++i) {
          if (name[i] == 0) planes.push_back(others_[i]);
        }
        std::sort(planes.begin(), planes.end());
        there = complex_.add_place(a + cuts[cut].along * (b - a), std::move(planes));
      }
      put({index, here, there}, name, here_sides, there_sides, b - a);
      if (cut == cuts.size()) break;
      for (std::size_t other : cuts[cut].planes) name[other] = -name[other];
      here = there;
      here_sides = there_sides;
    }
  }

  // A piece along the line of other planes is on the facets on both sides.
  void put(Piece piece, const Sides& name, const Sides& from, const Sides& to,
           const Vector& direction) {
    for (const Sides& beside : beside(name, direction)) {
      const auto found = names_.find(beside);
      if (found == names_.end()) continue;  // outside the box
      Piece own = piece;
      own.from = ended(found->second, piece.edge, piece.from, from);
      own.to = ended(found->second, piece.edge, piece.to, to);
      complex_.facets_.edit(found->second).pieces.push_back(own);
    }
  }

  // The names without zeros on the left and the right of a line in some direction, on
  // which the planes are whose side is zero.
  std::vector<Sides> beside(const Sides& name, const Vector& direction) const {
    if (name.find('\0') == Sides::npos) return {name};
    const Vector left = CGAL::cross_product(plane().normal, direction);
    std::vector<Sides> both{name, name};
    for (std::size_t i = 0; i < name.size(); ++i) {
      if (name[i] != 0) continue;
      const int side = static_cast<int>(CGAL::sign(complex_.planes_[others_[i]].normal * left));
      both[0][i] = static_cast<char>(side);
      both[1][i] = static_cast<char>(-side);
    }
    return both;
  }

  // Where a piece ends: a place on one line is a mark on both sides of it, one on several
  // lines is a corner of the facet.
  Id ended(Id facet, Id edge, Id place, const Sides& sides) {
    if (complex_.places_[place].planes.size() < 2) return place;
    std::optional<Vector> line;
    for (Id other : complex_.places_[place].planes) {
      if (other == plane_) continue;
      const Vector own = CGAL::cross_product(plane().normal, complex_.planes_[other].normal);
      if (!line) {
        line = own;
      } else if (CGAL::cross_product(*line, own) != CGAL::NULL_VECTOR) {
        const Id corner = corner_at(facet, place);
        complex_.rename(plane_, edge, place, corner);
        return corner;
      }
    }
    for (const Sides& beside : beside(sides, *line)) {
      const auto found = names_.find(beside);
      if (found == names_.end()) continue;
      auto& marks = complex_.facets_.edit(found->second).marks;
      if (std::find(marks.begin(), marks.end(), place) == marks.end()) marks.push_back(place);
    }
    return place;
  }

  Id corner_at(Id facet, Id place) const {
    const auto& planes = complex_.places_[place].planes;
    for (Id corner : complex_.facets_[facet].corners) {
      if (count_common(complex_.places_[corner].planes, planes) == planes.size()) return corner;
    }
    throw std::logic_error("a place on several lines is no corner of its facet");
  }

  // The facets' labels: from pieces at their borders, and from facet to facet.
  void find_labels() {
    std::map<std::pair<Id, Id>, std::vector<Id>> beside;  // facets by their sides
    std::queue<Id> open;
    for (Id facet : facets_) {
      const auto& corners = complex_.facets_[facet].corners;
      for (std::size_t i = 0; i < corners.size(); ++i) {
        beside[std::minmax(corners[i], corners[(i + 1) % corners.size()])].push_back(facet);
      }
      if (find_label(facet)) open.push(facet);
    }
    if (open.empty()) {
      const Id facet = facets_.front();
      set_label(facet, 0, label_on_border(complex_.facets_[facet]));
      open.push(facet);
    }
    while (!open.empty()) {
      const Id facet = open.front();
      open.pop();
      const auto corners = complex_.facets_[facet].corners;
      for (std::size_t i = 0; i < corners.size(); ++i) {
        for (Id next : beside[std::minmax(corners[i], corners[(i + 1) % corners.size()])]) {
          if (labelled_.count(next) != 0) continue;
          pass(facet, corners[i], next);
          open.push(next);
        }
      }
    }
  }

  // From the first piece that a border's walk comes by, if there is one.
  bool find_label(Id id) {
    const Facet& facet = complex_.facets_[id];
    if (facet.pieces.empty()) return false;
    const Border border = complex_.places_along(facet);
    for (std::size_t i = 0; i < border.places.size(); ++i) {
      const Id place = border.places[i];
      const auto leaving = leaving_from(facet, place);
      if (leaving.empty()) continue;
      const Id next = border.places[(i + 1) % border.places.size()];
      const Vector along = complex_.places_[next].exact - complex_.places_[place].exact;
      const Leaving& first = *std::min_element(
          leaving.begin(), leaving.end(), [&](const Leaving& one, const Leaving& other) {
            const int turn = turned(one.direction, other.direction);
            if (turn != 0) return turn > 0;
            return one.direction * along > 0 && other.direction * along < 0;
          });
      const bool is_along = turned(along, first.direction) == 0 && along * first.direction > 0;
      set_label(id, i, is_along ? first.left : first.right);
      return true;
    }
    return false;
  }

  // Positive when the second direction is counter-clockwise of the first.
  int turned(const Vector& first, const Vector& second) const {
    return static_cast<int>(CGAL::sign(plane().normal * CGAL::cross_product(first, second)));
  }

  std::vector<Leaving> leaving_from(const Facet& facet, Id place) const {
    std::vector<Leaving> leaving;
    for (const Piece& piece : facet.pieces) {
      if (piece.from != place && piece.to != place) continue;
      const auto [left, right] = complex_.labels(plane_, piece);
      const Vector way = complex_.places_[piece.to].exact - complex_.places_[piece.from].exact;
      if (piece.from == place) {
        leaving.push_back({way, left, right});
      } else {
        leaving.push_back({-way, right, left});
      }
    }
    return leaving;
  }

  // The label after a place of a facet's border.
  void set_label(Id id, std::size_t place, Label label) {
    Border border = complex_.places_along(complex_.facets_[id]);
    complex_.walk(complex_.facets_[id], border, place, label);
    complex_.facets_.edit(id).label = border.labels.front();
    labelled_.insert(id);
  }

  // To the facet beyond the side that begins in a corner.
  void pass(Id id, Id corner, Id beyond) {
    const Facet& facet = complex_.facets_[id];
    const Border border = complex_.border(facet);
    const std::size_t at =
        std::find(border.places.begin(), border.places.end(), corner) - border.places.begin();
    const Id next = border.places[(at + 1) % border.places.size()];
    Label label = border.labels[at];
    for (const Piece& piece : facet.pieces) {
      const auto [left, right] = complex_.labels(plane_, piece);
      if (piece.from == corner && piece.to == next) label = right;
      if (piece.from == next && piece.to == corner) label = left;
    }
    const Border other = complex_.places_along(complex_.facets_[beyond]);
    const auto place = std::find(other.places.begin(), other.places.end(), next);
    if (place == other.places.end()) throw std::logic_error("a mark is on one side of its line");
    set_label(beyond, place - other.places.begin(), label);
  }

  // The label along the border of a facet that no contour enters or leaves. Those outside
  // the box may touch it in places.
  Label label_on_border(const Facet& facet) const {
    const Point& from = complex_.places_[facet.corners[0]].exact;
    const Vector side = complex_.places_[facet.corners[1]].exact - from;
    for (int parts = 2;; ++parts) {
      if (const auto label = label_at(from + side / Number(parts))) return *label;
    }
  }

  // The label at a point, unless it is on an edge.
  std::optional<Label> label_at(const Point& point) const {
    const Point2 seen = plane().seen(point);
    Above above(seen, section().background);
    for (const auto& [start, end, left, right] : section().edges) {
      const Point2 from = seen_vertex(start), to = seen_vertex(end);
      if (CGAL::collinear(from, seen, to) &&
          CGAL::collinear_are_ordered_along_line(from, seen, to)) {
        return std::nullopt;
      }
      above.pass(from, to, left, right);
    }
    return above.label();
  }

  Point2 seen_vertex(Id vertex) const {
    return plane().seen(complex_.places_[section().vertices[vertex]].exact);
  }

  Complex& complex_;
  Id plane_;
  std::vector<Id> others_;
  std::vector<Id> facets_;
  std::unordered_map<std::string, Id> names_;
  std::vector<Sides> sides_;  // of the vertices
  std::set<Id> labelled_;
};

void Complex::draw(Id plane, const std::vector<double>& vertices, std::vector<Edge> edges,
                   Label background) {
  Section section{{}, std::move(edges), background};
  const Plane& own = planes_[plane];
  const auto [first, second, dropped] = own.axes;
  for (std::size_t i = 0; i + 1 < vertices.size(); i += 2) {
    Number at[3];
    at[first] = vertices[i];
    at[second] = vertices[i + 1];
    at[dropped] = (own.offset - own.normal[first] * at[first] - own.normal[second] * at[second]) /
                  own.normal[dropped];
    Place place({at[0], at[1], at[2]}, {plane}, size_);
    for (Id other = 0; other < planes_.end(); ++other) {
      if (other == plane || !planes_.has(other) || side_of(place, planes_[other]) != 0) continue;
      place.planes.insert(std::lower_bound(place.planes.begin(), place.planes.end(), other), other);
    }
    section.vertices.push_back(places_.add(std::move(place)));
  }
  sections_.edit(plane) = std::move(section);
  Artist(*this, plane).draw();
}

void Complex::erase(Id plane) {
  sections_.edit(plane) = Section{{}, {}, border_};
  Artist(*this, plane).draw();
}

}  // namespace transect::complex
