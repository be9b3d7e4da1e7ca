#include "transect/cpp/skeleton/walls.h"

#include <algorithm>

#include "transect/cpp/skeleton/overlay.h"

namespace transect::skeleton {
namespace {

// A straight side of a convex polygon: its points but for the last, which the
// next one begins with.
using Side = std::vector<Index>;

// The polygon over a piece: along it, up, back along the roofs, and down. It is
// convex since the lowest roof is concave; its corners are known without
// looking at coordinates.
std::vector<Side> sides(const Roofs& roofs, const Lifted& lifted, const CellPoints& points) {
  const Index from = points.first(lifted.piece.from), to = points.first(lifted.piece.to);
  std::vector<Side> result{{from}};
  Index last = to;
  const auto add = [&](const Side& side, Index end) {
    result.push_back(side);
    last = end;
  };
  for (auto part = lifted.parts.rbegin(); part != lifted.parts.rend(); ++part) {
    const Chain& chain = roofs.roofs[part->first].chains[part->second];
    Side along;
    for (Index point : chain.points) along.push_back(points.first(point));
    along.erase(std::unique(along.begin(), along.end()), along.end());
    // Chains run with their pieces, and here everything runs back.
    std::reverse(along.begin(), along.end());
    if (along.front() != last) add({last}, along.front());
    if (along.size() < 2) continue;
    const Index end = along.back();
    along.pop_back();
    add(along, end);
  }
  if (last != from) add({last}, from);
  return result;
}

}  // namespace

void add_wall(const Heights& heights, const Roofs& roofs, const Lifted& lifted,
              const CellPoints& points, std::vector<Triangle>& triangles) {
  const std::vector<Side> polygon = sides(roofs, lifted, points);
  if (polygon.size() < 3) return;
  const Site& site = heights.sites()[lifted.wall];
  const Piece& piece = lifted.piece;
  // Seen counter-clockwise it faces right of the piece, where the plane's
  // normal points into the cell.
  const Label back = site.side > 0 ? piece.left : piece.right;
  const Label front = site.side > 0 ? piece.right : piece.left;
  const auto add = [&](Index a, Index b, Index c) {
    triangles.push_back(oriented({{a, b, c}, back, front, Kind::wall, {site.plane, site.plane}}));
  };
  // A fan from a point inside a side has no flat triangle: neither have fans
  // from corners where no side has such a point.
  const auto longest =
      std::max_element(polygon.begin(), polygon.end(),
                       [](const Side& a, const Side& b) { return a.size() < b.size(); });
  const std::size_t start = longest - polygon.begin(), middle = longest->size() / 2;
  std::vector<Index> rest;  // from the side's end round to its beginning
  for (std::size_t i = 1; i < polygon.size(); ++i) {
    const Side& side = polygon[(start + i) % polygon.size()];
    rest.insert(rest.end(), side.begin(), side.end());
  }
  if (middle == 0) {
    rest.insert(rest.end(), longest->begin(), longest->end());
    for (std::size_t i = 1; i + 1 < rest.size(); ++i) add(rest[0], rest[i], rest[i + 1]);
    return;
  }
  rest.push_back(longest->front());
  const Index apex = (*longest)[middle];
  for (std::size_t i = 0; i + 1 < rest.size(); ++i) {
    // The parts of the apex's own side on either hand hang on its neighbours.
    if (i == 0) {
      Index before = apex;
      for (std::size_t j = middle + 1; j < longest->size(); ++j) {
        add(rest[1], before, (*longest)[j]);
        before = (*longest)[j];
      }
      add(rest[1], before, rest[0]);
    } else if (i + 2 == rest.size()) {
      for (std::size_t j = 0; j < middle; ++j) add(rest[i], (*longest)[j], (*longest)[j + 1]);
    } else {
      add(apex, rest[i], rest[i + 1]);
    }
  }
}

}  // namespace transect::skeleton
