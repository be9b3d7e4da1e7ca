#include "transect/cpp/skeleton.h"

#include <CGAL/Fraction_traits.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "transect/cpp/skeleton/content.h"
#include "transect/cpp/skeleton/gauge.h"
#include "transect/cpp/skeleton/heights.h"
#include "transect/cpp/skeleton/surface.h"
#include "transect/src/ffi/skeleton.rs.h"

namespace transect::skeleton {
namespace {

// Scales need not be better than this: planes closer in angle than 2^-1000 are
// not distinct in doubles.
constexpr unsigned most_bits = 4096;

void require_finite(const rust::Vec<double>& numbers) {
  for (double number : numbers) {
    if (!std::isfinite(number)) throw std::invalid_argument("a coordinate is not a finite number");
  }
}

Plane plane(const Vector& normal, const Number& offset, unsigned bits) {
  Number scale = scale_of(normal, bits);
  scale.exact();
  return {normal, offset, scale};
}

std::vector<Plane> planes(const Input& input, unsigned bits) {
  std::vector<Plane> result;
  for (std::size_t i = 0; i + 3 < input.planes.size(); i += 4) {
    const Vector normal(input.planes[i], input.planes[i + 1], input.planes[i + 2]);
    result.push_back(plane(normal, Number(input.planes[i + 3]), bits));
  }
  for (int axis = 0; axis < 3; ++axis) {
    double unit[3] = {0, 0, 0};
    unit[axis] = 1;
    const Vector normal(unit[0], unit[1], unit[2]);
    result.push_back(plane(normal, Number(input.bounds[2 * axis]), bits));
    result.push_back(plane(-normal, -Number(input.bounds[2 * axis + 1]), bits));
  }
  return result;
}

// The point on a plane with two coordinates given.
Point on_plane(const Plane& plane, const std::uint32_t* axes, double first, double second) {
  Number made[3];
  made[axes[0]] = first;
  made[axes[1]] = second;
  const Number rest = plane.normal[axes[0]] * first + plane.normal[axes[1]] * second;
  made[axes[2]] = (plane.offset - rest) / plane.normal[axes[2]];
  return {made[0], made[1], made[2]};
}

void read_sections(const Input& input, Scene& scene) {
  scene.sections.resize(input.backgrounds.size());
  for (Index own = 0; own < scene.sections.size(); ++own) {
    Section& section = scene.sections[own];
    section.background = input.backgrounds[own];
    section.partial = input.partial[own] != 0;
    std::vector<Index> points;
    for (std::size_t i = input.vertex_starts[own]; i < input.vertex_starts[own + 1]; ++i) {
      const Point point = on_plane(scene.planes[own], &input.axes[3 * own], input.vertices[2 * i],
                                   input.vertices[2 * i + 1]);
      points.push_back(scene.points.add(point, {own}));
    }
    for (std::size_t i = input.edge_starts[own]; i < input.edge_starts[own + 1]; ++i) {
      section.pieces.push_back({points.at(input.edges[4 * i]), points.at(input.edges[4 * i + 1]),
                                input.edges[4 * i + 2], input.edges[4 * i + 3]});
    }
  }
}

// The same double whatever was computed before: intervals that are too wide to
// tell it are made exact.
double rounded(const Number& number, double size) {
  const auto [low, high] = CGAL::to_interval(number);
  if (high - low <= 4e-16 * size) return (low + high) / 2;
  return CGAL::to_double(number.exact());
}

void push_exact(const Point& point, rust::Vec<rust::String>& out) {
  using Rational = Kernel::Exact_kernel::FT;
  using Fraction = CGAL::Fraction_traits<Rational>;
  for (int axis = 0; axis < 3; ++axis) {
    Fraction::Numerator_type above;
    Fraction::Denominator_type below;
    Fraction::Decompose()(point[axis].exact(), above, below);
    std::ostringstream text;
    text << above << '/' << below;
    out.push_back(text.str());
  }
}

}  // namespace

struct Skeleton::Parts {
  Scene scene;
  Cells cells;
  std::unique_ptr<LinePoints> line_points;
  std::unique_ptr<Patches> patches;
  unsigned bits;
  // A power of two at or below the largest coordinate. What is rounded can be remembered while
  // this stays, though the box does not.
  double size = 0;

  Parts(const Input& input, unsigned bits) : scene(planes(input, bits)), bits(bits) {
    read_sections(input, scene);
    for (double number : input.bounds) size = std::max(size, std::abs(number));
    size = std::exp2(std::ilogb(size));
    const Index first_cut = static_cast<Index>(scene.points.size());
    cut_pieces(scene);
    reconcile(scene, input.tolerance, first_cut);
    cells = make_cells(scene);
    find_contradictions(scene);
    line_points = std::make_unique<LinePoints>(scene);
    patches = std::make_unique<Patches>(scene, cells);
  }

  Content content(Index cell) const { return {*patches, *line_points, cell}; }

  bool scales_suffice() const {
    const auto is_partial = [](const Section& section) { return section.partial; };
    const auto& sections = scene.sections;
    return skeleton::scales_suffice(scene, cells) &&
           (std::none_of(sections.begin(), sections.end(), is_partial) ||
            partial::Gauge::scales_suffice(scene.planes));
  }
};

Skeleton::Skeleton(const Input& input) {
  require_finite(input.planes);
  require_finite(input.vertices);
  require_finite(input.bounds);
  for (unsigned bits = input.bits; bits <= most_bits; bits *= 2) {
    parts_ = std::make_unique<Parts>(input, bits);
    if (parts_->scales_suffice()) return;
  }
  throw std::runtime_error("two planes are too nearly parallel");
}

Skeleton::~Skeleton() = default;

std::uint32_t Skeleton::cells() const {
  return static_cast<std::uint32_t>(parts_->cells.cells.size());
}

std::uint32_t Skeleton::bits() const { return parts_->bits; }

std::uint32_t Skeleton::snapped() const {
  return static_cast<std::uint32_t>(parts_->scene.snapped);
}

rust::Vec<double> Skeleton::points() const {
  rust::Vec<double> out;
  for (Index point = 0; point < parts_->scene.points.size(); ++point) {
    for (int axis = 0; axis < 3; ++axis) {
      out.push_back(rounded(parts_->scene.points[point][axis], parts_->size));
    }
  }
  return out;
}

rust::Vec<rust::String> Skeleton::exact_points() const {
  rust::Vec<rust::String> out;
  for (Index point = 0; point < parts_->scene.points.size(); ++point) {
    push_exact(parts_->scene.points[point], out);
  }
  return out;
}

rust::Vec<std::uint32_t> Skeleton::contours() const {
  rust::Vec<std::uint32_t> out;
  for (const Section& section : parts_->scene.sections) {
    for (const Piece& piece : section.pieces) {
      if (piece.left == unknown || piece.right == unknown) continue;
      out.push_back(piece.from);
      out.push_back(piece.to);
    }
  }
  return out;
}

rust::Vec<ContradictionOutput> Skeleton::contradictions() const {
  rust::Vec<ContradictionOutput> out;
  for (const Contradiction& found : parts_->scene.contradictions) {
    ContradictionOutput made;
    made.sections = {found.planes[0], found.planes[1]};
    for (Index point : {found.from, found.to}) {
      for (int axis = 0; axis < 3; ++axis) {
        made.ends.push_back(rounded(parts_->scene.points[point][axis], parts_->size));
      }
    }
    for (Label label : found.labels[0]) made.first.push_back(label);
    for (Label label : found.labels[1]) made.second.push_back(label);
    out.push_back(std::move(made));
  }
  return out;
}

CellKey Skeleton::key(std::uint32_t cell, bool exact, std::uint32_t most_pieces) const {
  CellKey out;
  const Content content = parts_->content(cell);
  if (!content.labels_differ()) return out;
  const std::vector<std::uint64_t> words = content.words(parts_->scene);
  out.words.reserve(words.size() + 4);
  out.words.push_back(parts_->bits);  // with their normals they make the scales of planes
  out.words.push_back(std::ilogb(parts_->size));
  out.words.push_back(exact);
  out.words.push_back(content.outline_size() > most_pieces);
  std::copy(words.begin(), words.end(), std::back_inserter(out.words));
  for (Index point : content.points) out.points.push_back(point);
  for (Index plane : content.planes()) out.planes.push_back(plane);
  return out;
}

CellOutput Skeleton::surface(std::uint32_t cell, bool exact, std::uint32_t most_pieces,
                             const Watcher& watcher) const {
  CellOutput out;
  const Content content = parts_->content(cell);
  out.is_left_out = content.outline_size() > most_pieces;
  if (out.is_left_out) return out;
  const CellSurface made =
      skeleton::surface(parts_->scene, content, [&](double part) { watcher.reach(part); });
  out.is_left_out = made.is_left_out;
  out.inexact_parts = static_cast<std::uint32_t>(made.inexact.leaves);
  out.inexact_volume = made.inexact.volume;
  if (made.inexact.leaves > 0) {
    for (double coordinate : made.inexact.at) out.inexact_at.push_back(coordinate);
  }
  for (const Split& split : made.splits) {
    for (Index point : {split.from, split.to, split.point}) out.splits.push_back(point);
  }
  for (const Point& point : made.added) {
    for (int axis = 0; axis < 3; ++axis) out.points.push_back(rounded(point[axis], parts_->size));
    if (exact) push_exact(point, out.exact);
  }
  for (const Triangle& triangle : made.triangles) {
    for (Index corner : triangle.corners) out.corners.push_back(corner);
    out.labels.push_back(triangle.back);
    out.labels.push_back(triangle.front);
    out.walls.push_back(triangle.kind == Kind::wall);
    for (Index plane : triangle.planes) out.planes.push_back(plane);
  }
  return out;
}

std::unique_ptr<Skeleton> prepare(const Input& input) { return std::make_unique<Skeleton>(input); }

}  // namespace transect::skeleton
