#include "transect/cpp/complex.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "transect/cpp/complex/complex.h"
#include "transect/src/ffi/complex.rs.h"

namespace transect::complex {
namespace {

constexpr Label unknown = static_cast<Label>(-1);

void require_finite(rust::Slice<const double> numbers) {
  for (double number : numbers) {
    if (!std::isfinite(number)) throw std::invalid_argument("a coordinate is not a finite number");
  }
}

Plane plane_of(rust::Slice<const double> numbers) {
  require_finite(numbers);
  return Plane({numbers[0], numbers[1], numbers[2]}, numbers[3]);
}

// Collects facets and cells in flat lists.
class Collector {
 public:
  explicit Collector(const Complex& complex) : complex_(complex) {
    out_.cell_starts.push_back(0);
    out_.corner_starts.push_back(0);
    out_.edge_starts.push_back(0);
  }

  void add_cell(Id id) {
    if (!complex_.cells().has(id)) {
      out_.removed_cells.push_back(id);
      return;
    }
    out_.cells.push_back(id);
    for (Id facet : complex_.cells()[id].facets) out_.cell_facets.push_back(facet);
    out_.cell_starts.push_back(static_cast<std::uint32_t>(out_.cell_facets.size()));
  }

  void add_facet(Id id) {
    if (!complex_.facets().has(id)) {
      out_.removed_facets.push_back(id);
      return;
    }
    const Facet& facet = complex_.facets()[id];
    out_.facets.push_back(id);
    for (Id number : {facet.plane, facet.cells[0], facet.cells[1]})
      out_.facet_ids.push_back(number);
    for (Id corner : facet.corners) {
      out_.corners.push_back(corner);
      push(out_.outlines, corner);
    }
    out_.corner_starts.push_back(static_cast<std::uint32_t>(out_.corners.size()));
    add_border(facet);
    for (const Piece& piece : facet.pieces) {
      if (complex_.runs_along(piece)) continue;
      const auto [left, right] = complex_.labels(facet.plane, piece);
      add_edge(piece.from, piece.to, left, right);
    }
    out_.edge_starts.push_back(static_cast<std::uint32_t>(out_.edge_labels.size() / 2));
  }

  Parts take() { return std::move(out_); }

 private:
  // What continues straight on with the same known label is one edge. Unknown regions keep
  // the places that they share with those beyond, so that their triangulations fit.
  void add_border(const Facet& facet) {
    const Border border = complex_.border(facet);
    const std::size_t count = border.places.size();
    std::uint32_t edges = 0;
    for (std::size_t i = 0; i < count;) {
      std::size_t next = i + 1;
      while (next < count && !border.is_corner[next] && border.labels[next] == border.labels[i] &&
             border.labels[i] != unknown) {
        ++next;
      }
      add_edge(border.places[i], border.places[next % count], border.labels[i], unknown);
      ++edges;
      i = next;
    }
    out_.border_edges.push_back(edges);
  }

  void add_edge(Id from, Id to, Label left, Label right) {
    push(out_.edges, from);
    push(out_.edges, to);
    out_.edge_labels.push_back(left);
    out_.edge_labels.push_back(right);
  }

  void push(rust::Vec<double>& numbers, Id place) const {
    for (double coordinate : complex_.places()[place].rough) numbers.push_back(coordinate);
  }

  const Complex& complex_;
  Parts out_;
};

template <typename Item>
std::vector<Id> all(const Slots<Item>& slots) {
  std::vector<Id> ids;
  for (Id id = 0; id < slots.end(); ++id) {
    if (slots.has(id)) ids.push_back(id);
  }
  return ids;
}

template <typename Item>
std::vector<Id> changed(const Slots<Item>& slots) {
  std::vector<Id> ids = slots.touched();
  std::sort(ids.begin(), ids.end());
  return ids;
}

}  // namespace

ExactComplex::ExactComplex(rust::Slice<const double> bounds, std::uint32_t border) {
  require_finite(bounds);
  std::array<double, 6> box;
  std::copy_n(bounds.begin(), 6, box.begin());
  complex_ = std::make_unique<Complex>(box, border);
}

ExactComplex::~ExactComplex() = default;

std::uint32_t ExactComplex::insert(rust::Slice<const double> plane) {
  return complex_->insert(plane_of(plane));
}

void ExactComplex::remove(std::uint32_t plane) { complex_->remove(plane); }

void ExactComplex::draw(std::uint32_t plane, rust::Slice<const double> vertices,
                        rust::Slice<const std::uint32_t> edges, std::uint32_t background) {
  require_finite(vertices);
  std::vector<Edge> own;
  for (std::size_t i = 0; i + 3 < edges.size(); i += 4) {
    own.push_back({edges[i], edges[i + 1], edges[i + 2], edges[i + 3]});
  }
  complex_->draw(plane, std::vector<double>(vertices.begin(), vertices.end()), std::move(own),
                 background);
}

void ExactComplex::erase(std::uint32_t plane) { complex_->erase(plane); }

std::uint32_t ExactComplex::coincident(rust::Slice<const double> plane) const {
  return complex_->coincident(plane_of(plane));
}

void ExactComplex::begin() { complex_->begin(); }
void ExactComplex::commit() { complex_->commit(); }
void ExactComplex::rollback() { complex_->rollback(); }
void ExactComplex::check() const { complex_->check(); }
void ExactComplex::check_places() const { complex_->check_places(); }

Parts ExactComplex::parts() const {
  Collector collector(*complex_);
  for (Id cell : all(complex_->cells())) collector.add_cell(cell);
  for (Id facet : all(complex_->facets())) collector.add_facet(facet);
  return collector.take();
}

Parts ExactComplex::changes() const {
  Collector collector(*complex_);
  for (Id cell : changed(complex_->cells())) collector.add_cell(cell);
  for (Id facet : changed(complex_->facets())) collector.add_facet(facet);
  return collector.take();
}

std::unique_ptr<ExactComplex> new_complex(rust::Slice<const double> bounds, std::uint32_t border) {
  return std::make_unique<ExactComplex>(bounds, border);
}

}  // namespace transect::complex
