#include "transect/cpp/skeleton/content.h"

#include <CGAL/Fraction_traits.h>

#include <algorithm>
#include <cstring>
#include <unordered_map>

namespace transect::skeleton {
namespace {

// Numbers one after the other, each list after its length, so that one sequence of words can
// be read in one way alone.
class Words {
 public:
  void add(std::uint64_t word) { words_.push_back(word); }

  void add(Index first, Index second) { add(std::uint64_t{first} << 32 | second); }

  void add(double number) {
    std::uint64_t word;
    static_assert(sizeof word == sizeof number);
    std::memcpy(&word, &number, sizeof word);
    add(word);
  }

  void add(const Plane& plane) {
    for (int axis = 0; axis < 3; ++axis) add(CGAL::to_double(plane.normal[axis]));
    add(CGAL::to_double(plane.offset));
  }

  void add(const CellPlane& plane) {
    add(static_cast<Index>(plane.side + 1), plane.label);
    add(static_cast<Index>(plane.corners.size()), static_cast<Index>(plane.pieces.size()));
    for (Index corner : plane.corners) add(std::uint64_t{corner});
    for (const auto& [from, to, left, right] : plane.pieces) {
      add(from, to);
      add(left, right);
    }
  }

  void add(const Point& point) {
    const auto& exact = point.exact();
    for (int axis = 0; axis < 3; ++axis) add_exact(exact[axis]);
  }

  std::vector<std::uint64_t> take() { return std::move(words_); }

 private:
  using Rational = Kernel::Exact_kernel::FT;
  using Fraction = CGAL::Fraction_traits<Rational>;

  // A reduced fraction.
  void add_exact(const Rational& number) {
    Fraction::Numerator_type above;
    Fraction::Denominator_type below;
    Fraction::Decompose()(number, above, below);
    add_whole(gmp(above));
    add_whole(gmp(below));
  }

  void add_whole(mpz_srcptr number) {
    const std::size_t size = mpz_size(number);
    add(std::uint64_t{2 * size + (mpz_sgn(number) < 0 ? 1 : 0)});
    const mp_limb_t* limbs = mpz_limbs_read(number);
    words_.insert(words_.end(), limbs, limbs + size);
  }

  std::vector<std::uint64_t> words_;
};

}  // namespace

Content::Content(const Patches& patches, const LinePoints& line_points, Index index)
    : cell(patches.cell(index, points)) {
  const Index own = static_cast<Index>(points.size());
  std::unordered_map<Index, Index> numbers;
  for (Index point = 0; point < own; ++point) numbers.emplace(points[point], point);
  for (const CellPlane& wall : cell.walls) {
    for (std::size_t i = 0; i < wall.corners.size(); ++i) {
      const Index from = wall.corners[i], to = wall.corners[(i + 1) % wall.corners.size()];
      const auto [found, is_new] = on_edges.insert({std::minmax(from, to), {}});
      if (!is_new) continue;
      for (Index point : line_points.between(points[from], points[to])) {
        const auto number = numbers.emplace(point, static_cast<Index>(points.size()));
        if (number.second) points.push_back(point);
        found->second.push_back(number.first->second);
      }
    }
  }
}

bool Content::labels_differ() const {
  const Label first = cell.walls.front().label;
  const auto differs = [&](const CellPlane& plane) {
    for (const Piece& piece : plane.pieces) {
      for (Label label : {piece.left, piece.right}) {
        if (label != first && label != unknown) return true;
      }
    }
    return plane.pieces.empty() && plane.label != first;
  };
  return std::any_of(cell.walls.begin(), cell.walls.end(), differs) ||
         std::any_of(cell.patches.begin(), cell.patches.end(), differs);
}

std::size_t Content::outline_size() const {
  std::size_t size = 0;
  for (const CellPlane& patch : cell.patches) {
    size += std::count_if(patch.pieces.begin(), patch.pieces.end(), [](const Piece& piece) {
      return piece.left == unknown || piece.right == unknown;
    });
  }
  return size;
}

std::vector<Index> Content::planes() const {
  std::vector<Index> planes;
  for (const auto* all : {&cell.walls, &cell.patches}) {
    for (const CellPlane& plane : *all) planes.push_back(plane.plane);
  }
  return planes;
}

std::vector<std::uint64_t> Content::words(const Scene& scene) const {
  Words words;
  for (const auto* all : {&cell.walls, &cell.patches}) {
    words.add(std::uint64_t{all->size()});
    for (const CellPlane& plane : *all) {
      words.add(scene.planes[plane.plane]);
      words.add(plane);
    }
  }
  words.add(std::uint64_t{on_edges.size()});
  for (const auto& [ends, on_edge] : on_edges) {
    words.add(ends.first, ends.second);
    words.add(std::uint64_t{on_edge.size()});
    for (Index point : on_edge) words.add(std::uint64_t{point});
  }
  for (Index point : points) words.add(scene.points[point]);
  return words.take();
}

}  // namespace transect::skeleton
