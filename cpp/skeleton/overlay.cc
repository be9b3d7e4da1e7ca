#include "transect/cpp/skeleton/overlay.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Constrained_triangulation_plus_2.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <algorithm>
#include <stdexcept>

namespace transect::skeleton {
namespace {

struct VertexInfo {
  Index point = none;
};

// The label of either wall under a triangle, and its sides with their contours.
struct FaceInfo {
  Label labels[2] = {unknown, unknown};
  bool is_border[2][3] = {{false, false, false}, {false, false, false}};
};

using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<VertexInfo, Kernel>;
using FaceBase =
    CGAL::Triangulation_face_base_with_info_2<FaceInfo, Kernel,
                                              CGAL::Constrained_triangulation_face_base_2<Kernel>>;
using Structure = CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>;
using Delaunay = CGAL::Constrained_triangulation_plus_2<
    CGAL::Constrained_Delaunay_triangulation_2<Kernel, Structure, CGAL::Exact_intersections_tag>>;
using Vertex = Delaunay::Vertex_handle;
using Face = Delaunay::Face_handle;

class Overlay {
 public:
  Overlay(const Heights& heights, Roof& roof, CellPoints& points)
      : heights_(heights),
        roof_(roof),
        points_(points),
        normal_(normal(heights, roof)),
        view_(normal_) {}

  std::vector<Triangle> make() {
    insert();
    name_crossings();
    for (int owner : {0, 1}) label(owner);
    std::vector<Triangle> triangles;
    for (Face face : triangulation_.finite_face_handles()) {
      const auto& labels = face->info().labels;
      if (labels[0] == labels[1]) continue;
      Triangle triangle{{}, labels[0], labels[1], Kind::roof, {plane(0), plane(1)}};
      for (int corner = 0; corner < 3; ++corner) {
        triangle.corners[corner] = face->vertex(corner)->info().point;
      }
      triangles.push_back(oriented(triangle));
    }
    return triangles;
  }

 private:
  // From the first wall's side to the second's.
  static Vector normal(const Heights& heights, const Roof& roof) {
    const Site &a = heights.sites()[roof.walls[0]], &b = heights.sites()[roof.walls[1]];
    const auto& planes = heights.scene().planes;
    return planes[a.plane].scale * a.inward - planes[b.plane].scale * b.inward;
  }

  Index plane(int owner) const { return heights_.sites()[roof_.walls[owner]].plane; }

  Vertex insert(Index point) {
    point = points_.first(point);
    const Vertex vertex = triangulation_.insert(view_(points_[point]), hint_);
    hint_ = vertex->face();
    Index& known = vertex->info().point;
    if (known == none) {
      known = point;
    } else {
      points_.unite(known, point);
    }
    return vertex;
  }

  void insert() {
    for (Index corner : roof_.corners) insert(corner);
    for (Index point : roof_.extra) insert(point);
    for (const Chain& chain : roof_.chains) {
      const Vertex from = insert(chain.from), to = insert(chain.to);
      ends_.push_back({from, to});
    }
    for (const auto& [from, to] : ends_) {
      constraints_.push_back(triangulation_.insert_constraint(from, to));
    }
  }

  bool is_point(std::size_t chain) const { return ends_[chain].first == ends_[chain].second; }

  // Contours of the two walls cross where they did not know of each other.
  void name_crossings() {
    for (Vertex vertex : triangulation_.finite_vertex_handles()) {
      Index& point = vertex->info().point;
      point = point == none ? points_.add(on_roof(vertex->point())) : points_.first(point);
    }
    for (std::size_t i = 0; i < constraints_.size(); ++i) {
      std::vector<Index>& chain = roof_.chains[i].points;
      if (is_point(i)) {
        chain.assign(1, ends_[i].first->info().point);
        continue;
      }
      for (Vertex vertex : triangulation_.vertices_in_constraint(constraints_[i])) {
        chain.push_back(vertex->info().point);
      }
    }
  }

  // The point of the roof's plane that is seen there.
  Point on_roof(const Kernel::Point_2& seen) const {
    const Point& base = points_[roof_.corners[0]];
    const Number along = normal_[view_.first] * (base[view_.first] - seen.x()) +
                         normal_[view_.second] * (base[view_.second] - seen.y());
    Number made[3];
    made[view_.first] = seen.x();
    made[view_.second] = seen.y();
    made[view_.dropped] = base[view_.dropped] + along / normal_[view_.dropped];
    return {made[0], made[1], made[2]};
  }

  // Contours say the labels beside them; what is not beside one has its
  // neighbours' labels.
  void label(int owner) {
    std::vector<Face> reached;
    for (std::size_t i = 0; i < constraints_.size(); ++i) {
      const Chain& chain = roof_.chains[i];
      if (chain.owner != owner || is_point(i)) continue;
      auto vertex = triangulation_.vertices_in_constraint_begin(constraints_[i]);
      const auto end = triangulation_.vertices_in_constraint_end(constraints_[i]);
      for (Vertex from = *vertex; ++vertex != end; from = *vertex) {
        mark(from, *vertex, owner, chain.left, reached);
        mark(*vertex, from, owner, chain.right, reached);
      }
    }
    if (reached.empty()) return label_all(owner);
    while (!reached.empty()) {
      const Face face = reached.back();
      reached.pop_back();
      for (int side = 0; side < 3; ++side) {
        const Face next = face->neighbor(side);
        if (face->info().is_border[owner][side] || triangulation_.is_infinite(next)) continue;
        if (set(next, owner, face->info().labels[owner])) reached.push_back(next);
      }
    }
  }

  // The triangle left of an edge.
  void mark(Vertex from, Vertex to, int owner, Label label, std::vector<Face>& reached) {
    Face face;
    int side;
    if (!triangulation_.is_edge(from, to, face, side)) {
      throw std::logic_error("a contour on a roof is no edge of it");
    }
    if (face->vertex(triangulation_.ccw(side)) != from) {
      const Face other = face->neighbor(side);
      side = triangulation_.mirror_index(face, side);
      face = other;
    }
    face->info().is_border[owner][side] = true;
    if (triangulation_.is_infinite(face)) return;
    if (set(face, owner, label)) reached.push_back(face);
  }

  // Whether the label is new.
  bool set(Face face, int owner, Label label) {
    Label& known = face->info().labels[owner];
    if (known == label) return false;
    if (known != unknown) throw std::logic_error("a part of a roof has two labels from one side");
    known = label;
    return true;
  }

  // Without a contour the roof has one label, that of any foot.
  void label_all(int owner) {
    const Site& site = heights_.sites()[roof_.walls[owner]];
    Label label = site.facet->label;
    if (!site.is_uniform()) {
      const Index first = roof_.walls[0], second = roof_.walls[1];
      Point foot = roof_.middle;
      if (owner == 1) {
        const Number height = heights_(first, second, roof_.middle);
        foot = heights_.foot(second, heights_.lifted(first, roof_.middle, height));
      }
      // The whole section is asked, but what is drawn on the wall decides it.
      label = label_at(heights_.scene(), site.plane, foot);
    }
    for (Face face : triangulation_.finite_face_handles()) face->info().labels[owner] = label;
  }

  const Heights& heights_;
  Roof& roof_;
  CellPoints& points_;
  Vector normal_;
  View view_;
  Delaunay triangulation_;
  Face hint_;
  std::vector<std::pair<Vertex, Vertex>> ends_;
  std::vector<Delaunay::Constraint_id> constraints_;
};

}  // namespace

std::vector<Triangle> overlay(const Heights& heights, Roof& roof, CellPoints& points) {
  return Overlay(heights, roof, points).make();
}

Triangle oriented(const Triangle& triangle) {
  const auto rank = [](Label label) { return label == outside ? unknown : label; };
  if (rank(triangle.back) < rank(triangle.front)) return triangle;
  Triangle turned = triangle;
  std::swap(turned.back, turned.front);
  std::swap(turned.corners[1], turned.corners[2]);
  return turned;
}

}  // namespace transect::skeleton
