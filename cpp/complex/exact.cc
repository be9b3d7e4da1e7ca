#include "transect/cpp/complex/exact.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace transect::complex {

Plane::Plane(const std::array<double, 3>& given, double offset)
    : rough_normal(given),
      rough_offset(offset),
      normal(given[0], given[1], given[2]),
      offset(offset) {
  const double size[3] = {std::abs(given[0]), std::abs(given[1]), std::abs(given[2])};
  const int dropped = size[0] >= size[1] && size[0] >= size[2] ? 0 : size[1] >= size[2] ? 1 : 2;
  axes = {(dropped + 1) % 3, (dropped + 2) % 3, dropped};
  if (given[dropped] < 0) std::swap(axes[0], axes[1]);
}

Place::Place(Point point, std::vector<Id> on, double size)
    : exact(std::move(point)), planes(std::move(on)) {
  const auto round = [&] {
    error = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const auto [low, high] = CGAL::to_interval(exact[axis]);
      rough[axis] = low + (high - low) / 2;
      error = std::max(error, high - low);
    }
  };
  round();
  // Intervals that are wider say something about how the place was computed.
  if (!(error <= 1e-14 * size)) {
    exact.exact();
    round();
  }
}

bool Place::is_on(Id plane) const {
  return std::binary_search(planes.begin(), planes.end(), plane);
}

int side_of(const Place& place, const Plane& plane) {
  const auto& [a, b, c] = plane.rough_normal;
  const double x = a * place.rough[0], y = b * place.rough[1], z = c * place.rough[2];
  const double value = x + y + z - plane.rough_offset;
  // Products and sums are each rounded by less than 2^-52, unless they are too small for that.
  const double error =
      4e-15 * (std::abs(x) + std::abs(y) + std::abs(z) + std::abs(plane.rough_offset)) +
      2 * place.error * (std::abs(a) + std::abs(b) + std::abs(c)) + 1e-300;
  if (std::abs(value) > error) return value > 0 ? 1 : -1;
  return static_cast<int>(CGAL::sign(plane.value(place.exact)));
}

std::vector<Id> common(const std::vector<Id>& one, const std::vector<Id>& other) {
  std::vector<Id> both;
  std::set_intersection(one.begin(), one.end(), other.begin(), other.end(),
                        std::back_inserter(both));
  return both;
}

std::size_t count_common(const std::vector<Id>& one, const std::vector<Id>& other) {
  std::size_t count = 0;
  for (auto a = one.begin(), b = other.begin(); a != one.end() && b != other.end();) {
    count += *a == *b;
    const bool step_a = *a <= *b, step_b = *b <= *a;
    a += step_a;
    b += step_b;
  }
  return count;
}

}  // namespace transect::complex
