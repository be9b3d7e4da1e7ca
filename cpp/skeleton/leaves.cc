#include "transect/cpp/skeleton/leaves.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

namespace transect::skeleton::partial {
namespace {

// With more sites a part is divided without a look at zones.
constexpr std::size_t most_sites = 100;
// As many zones are partitioned at once rather than divided.
constexpr std::size_t few_zones = 80;
// As many are partitioned where a part is not divided further.
constexpr std::size_t most_zones = 400;
// How small parts get, relative to the cell, and how small when there are many: planes that
// all but coincide are hard to tell apart everywhere.
constexpr double smallest_part = 1.0 / 512, small_part = 1.0 / 48;
constexpr std::size_t many_parts = 2000, many_parts_a_site = 10;
// Sites in a leaf that is not exact, besides those that touch it.
constexpr std::size_t nearest_sites = 4;

// The distance between two boxes.
double gap(const CGAL::Bbox_3& a, const CGAL::Bbox_3& b) {
  double sum = 0;
  for (int i = 0; i < 3; ++i) {
    const double way = std::max({0.0, a.min(i) - b.max(i), b.min(i) - a.max(i)});
    sum += way * way;
  }
  return std::sqrt(sum);
}

double longest(const CGAL::Bbox_3& box, int* axis = nullptr) {
  double length = -1;
  for (int i = 0; i < 3; ++i) {
    if (box.max(i) - box.min(i) <= length) continue;
    length = box.max(i) - box.min(i);
    if (axis) *axis = i;
  }
  return length;
}

// The largest distance of a site from some places, and no less.
double farthest(const Candidate& candidate, const Distances& distances,
                const std::vector<Place>& places) {
  double result = -std::numeric_limits<double>::infinity();
  for (Index zone : candidate.zones) {
    const Rough& rough = distances.rough({candidate.site, zone});
    for (const Place& place : places) {
      const auto [value, error] = rough.at(place);
      result = std::max(result, value + error);
    }
  }
  return result;
}

// The only label that candidates can have between some places, if that is clear.
std::optional<Label> only_label(const std::vector<Candidate>& candidates,
                                const Distances& distances, const std::vector<Place>& corners) {
  Shown all;
  for (const auto& [site, zones] : candidates) {
    for (Index zone : zones) {
      const Owner owner{site, zone};
      if (distances.zone(owner).is_inner) continue;
      const Shown one =
          shown(distances.sites()[site], distances.zone(owner), distances.rough(owner), corners);
      if (one.only) all.add(*one.only);
      if (one.is_mixed || all.is_mixed) return {};
    }
  }
  return all.only;
}

std::size_t count_zones(const std::vector<Candidate>& candidates) {
  std::size_t count = 0;
  for (const Candidate& candidate : candidates) count += candidate.zones.size();
  return count;
}

}  // namespace

Leaves::Around::Around(const Site& site) {
  for (const Point& corner : site.corners) box += corner.bbox();
  const Place normal = rough_place(CGAL::ORIGIN + site.normal);
  const double length = std::hypot(normal[0], normal[1], normal[2]);
  const Place on = rough_place(site.corners[0]);
  for (int i = 0; i < 3; ++i) {
    unit[i] = normal[i] / length;
    offset += unit[i] * on[i];
  }
}

std::pair<double, double> Leaves::Around::heights(const std::vector<Place>& places) const {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Place& at : places) {
    const double height = unit[0] * at[0] + unit[1] * at[1] + unit[2] * at[2] - offset;
    low = std::min(low, height);
    high = std::max(high, height);
  }
  return {low, high};
}

Leaves::Leaves(const Polytope& cell, const Distances& distances, double cut_at)
    : cell_(cell), distances_(distances), cut_at_(cut_at) {
  const double all = std::numeric_limits<double>::infinity();
  Part whole{cell, {-all, -all, -all, all, all, all}, {}};
  const std::vector<Site>& sites = distances.sites();
  for (Index site = 0; site < sites.size(); ++site) {
    if (sites[site].is_plane()) continue;
    whole.candidates.push_back({site, {}});
    for (Index zone = 0; zone < sites[site].zones.size(); ++zone) {
      whole.candidates.back().zones.push_back(zone);
    }
  }
  for (const Site& site : sites) around_.emplace_back(site);
  size_ = longest(bounds(cell.places()));
  queue_.push_back(std::move(whole));
  // By breadth: large parts first, before there are many.
  while (!queue_.empty()) {
    Part part = std::move(queue_.front());
    queue_.pop_front();
    settle(std::move(part));
  }
  for (const Leaf& leaf : mixed_) {
    if (!leaf.is_exact) inexact_.push_back(leaf.box);
  }
  for (Leaf& leaf : mixed_) leaf.is_beside_inexact = is_beside_inexact(leaf.box);
}

bool Leaves::is_beside_inexact(const CGAL::Bbox_3& box) const {
  return std::any_of(inexact_.begin(), inexact_.end(),
                     [&](const CGAL::Bbox_3& other) { return CGAL::do_overlap(box, other); });
}

void Leaves::settle(Part part) {
  const std::vector<Place> corners = part.body.places();
  drop_far(corners, part);
  join_known(corners, part);
  const bool is_small = longest(bounds(corners)) < size_ * smallest();
  if (part.candidates.size() > most_sites && !is_small) return split(part);
  std::vector<Spread> spreads = nearest(part.candidates, distances_, corners);
  part.candidates.clear();
  for (Spread& spread : spreads) part.candidates.push_back(std::move(spread.candidate));
  if (const auto label = only_label(part.candidates, distances_, corners)) {
    part.candidates.resize(1);
    uniform_.push_back({{}, part.box, std::move(part.candidates), label});
    return;
  }
  const std::size_t zones = count_zones(part.candidates);
  if (zones > few_zones && !is_small) return split(part);
  Leaf leaf{std::move(part.body), part.box, std::move(part.candidates), {}};
  leaf.is_exact = zones <= most_zones;
  if (!leaf.is_exact) {
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t i = 0; i < spreads.size(); ++i) {
      order.push_back({spreads[i].touches() ? 0 : spreads[i].sum, i});
    }
    std::sort(order.begin(), order.end());
    std::vector<Candidate> kept;
    std::size_t others = 0;
    for (const auto& [distance, i] : order) {
      if (distance > 0 && ++others > nearest_sites) break;
      kept.push_back(std::move(leaf.candidates[i]));
    }
    std::sort(kept.begin(), kept.end(),
              [](const Candidate& a, const Candidate& b) { return a.site < b.site; });
    leaf.candidates = std::move(kept);
  }
  mixed_.push_back(std::move(leaf));
}

double Leaves::smallest() const {
  const std::size_t many = many_parts + many_parts_a_site * distances_.sites().size();
  return mixed_.size() + queue_.size() < many ? smallest_part : small_part;
}

// What is farther away than the nearest site so far from all of the part: the gauge is within
// the unit ball, so its distance is no less than the Euclidean one.
void Leaves::drop_far(const std::vector<Place>& corners, Part& part) {
  const CGAL::Bbox_3 box = bounds(corners);
  std::vector<double> gaps;
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < part.candidates.size(); ++i) {
    const Around& around = around_[part.candidates[i].site];
    const auto [low, high] = around.heights(corners);
    const double beside = gap(box, around.box);
    gaps.push_back(std::max({beside, low, -high}));
    order.push_back({std::max(beside, std::abs(low + high) / 2), i});
  }
  // One of those that look nearest.
  const std::size_t tried = std::min<std::size_t>(order.size(), 3);
  std::partial_sort(order.begin(), order.begin() + tried, order.end());
  double limit = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < tried; ++i) {
    limit = std::min(limit, farthest(part.candidates[order[i].second], distances_, corners));
  }
  // The gauge may be larger by rounded scales, and places are rounded: in a thin cell that is
  // more than the distances.
  double size = 0;
  for (int i = 0; i < 3; ++i) size = std::max({size, std::abs(box.min(i)), std::abs(box.max(i))});
  limit = (1 + 1e-6) * limit + 1e-12 * std::max(size, size_);
  std::vector<Candidate> kept;
  for (std::size_t i = 0; i < gaps.size(); ++i) {
    if (gaps[i] <= limit) kept.push_back(std::move(part.candidates[i]));
  }
  part.candidates = std::move(kept);
}

// Sites of one plane become the plane where it is known all over: zones of the edges that they
// have in common would be many.
void Leaves::join_known(const std::vector<Place>& corners, Part& part) const {
  const std::vector<Site>& sites = distances_.sites();
  std::vector<Candidate> kept;
  for (auto first = part.candidates.begin(), last = first; first != part.candidates.end();
       first = last) {
    const Face* face = sites[first->site].face.get();
    while (last != part.candidates.end() && sites[last->site].face.get() == face) ++last;
    Index plane = first->site;
    if (last - first > 1) {
      while (!sites[plane].is_plane()) --plane;
      if (knows_all(sites[plane], distances_.rough({plane, 0}), corners)) {
        kept.push_back({plane, {0, 1}});
        continue;
      }
    }
    std::move(first, last, std::back_inserter(kept));
  }
  part.candidates = std::move(kept);
}

void Leaves::split(const Part& part) {
  const CGAL::Bbox_3 box = bounds(part.body.places());
  int axis = 0;
  const double length = longest(box, &axis);
  const double at = box.min(axis) + cut_at_ * length;
  for (int side : {1, -1}) {
    Part half{part.body, part.box, part.candidates};
    if (!half.body.clip(cut(axis, side, at))) continue;
    double low[3], high[3];
    for (int i = 0; i < 3; ++i) {
      low[i] = i == axis && side < 0 ? at : part.box.min(i);
      high[i] = i == axis && side > 0 ? at : part.box.max(i);
    }
    half.box = {low[0], low[1], low[2], high[0], high[1], high[2]};
    queue_.push_back(std::move(half));
  }
}

std::vector<Leaf> Leaves::uniform_beside_inexact() {
  std::vector<Leaf> found;
  for (const Leaf& leaf : uniform_) {
    if (!is_beside_inexact(leaf.box)) continue;
    found.push_back(leaf);
    Polytope& body = found.back().body = cell_;
    for (int axis = 0; axis < 3; ++axis) {
      if (std::isfinite(leaf.box.max(axis))) body.clip(cut(axis, 1, leaf.box.max(axis)));
      if (std::isfinite(leaf.box.min(axis))) body.clip(cut(axis, -1, leaf.box.min(axis)));
    }
  }
  return found;
}

// What is below a place on an axis (side 1), or above it.
const Halfspace& Leaves::cut(int axis, int side, double at) {
  double normal[3] = {0, 0, 0};
  normal[axis] = side;
  cuts_.emplace_back(Kernel::Plane_3(normal[0], normal[1], normal[2], -side * at));
  is_cut_.insert(&cuts_.back());
  return cuts_.back();
}

}  // namespace transect::skeleton::partial
