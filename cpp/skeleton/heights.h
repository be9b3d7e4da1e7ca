// How far the roof over every wall of a cell is.
//
// A point x at the distance t in front of wall i has its foot y on it and is
// x = y + t r_i, with r_i along the wall's normal so that the distance grows by
// one along it. Its distance to wall k is a + c t, a being that of y, and c < 1.
// The two are equal at t = a / (1 − c): the height of the roof towards k over y,
// linear in y. The roof over y is the lowest of these, so it is concave.
#pragma once

#include <vector>

#include "transect/cpp/skeleton/content.h"

namespace transect::skeleton {

// A wall of a cell.
struct Site {
  Index plane;
  int side;  // +1 when the plane's normal points into the cell
  const CellPlane* facet;
  Vector inward;
  Vector rise;

  bool is_uniform() const { return facet->pieces.empty(); }
};

class Heights {
 public:
  Heights(const Scene& scene, const Content& content);

  const Scene& scene() const { return scene_; }
  const Content& content() const { return content_; }
  const std::vector<Site>& sites() const { return sites_; }
  Index count() const { return static_cast<Index>(sites_.size()); }

  // Of the roof between `own` and `other`, over a point of `own`.
  Number operator()(Index own, Index other, const Point& foot) const;

  // The same for a point of the content, which is on the planes that it is on.
  Number over(Index own, Index other, Index point) const;

  bool is_on(Index site, Index point) const {
    return scene_.points.side(content_.points[point], sites_[site].plane) == 0;
  }
  const Point& point(Index point) const { return scene_.points[content_.points[point]]; }

  Point lifted(Index own, const Point& foot, const Number& height) const {
    return foot + height * sites_[own].rise;
  }

  // The foot on a wall of any point.
  Point foot(Index own, const Point& point) const;

 private:
  Number distance(Index site, const Point& point) const {
    return Number(sites_[site].side) * scene_.planes[sites_[site].plane].distance(point);
  }

  const Scene& scene_;
  const Content& content_;
  std::vector<Site> sites_;
  std::vector<std::vector<Number>> factors_;  // 1 / (1 − c)
};

// Whether scales are good enough in every cell: feet are on their walls when
// s_i |n_i|² > s_k n_i·n_k for inward normals.
bool scales_suffice(const Scene& scene, const Cells& cells);

}  // namespace transect::skeleton
