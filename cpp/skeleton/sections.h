// Sections as straight pieces between the lines of all planes, and what they
// say along these lines.
#pragma once

#include <vector>

#include "transect/cpp/skeleton/points.h"

namespace transect::skeleton {

// What one plane shows. Pieces meet in their ends alone.
struct Section {
  std::vector<Piece> pieces;
  Label background;
  // Whether a part of the plane is unknown: it does not bound cells then.
  bool partial;
};

// A stretch of the common line of two planes on which both know and never say
// the same.
struct Contradiction {
  Index planes[2];
  Index from, to;
  std::vector<Label> labels[2];
};

struct Scene {
  // Of the sections, then the six of the box with normals pointing inward.
  std::vector<Plane> planes;
  std::vector<Section> sections;
  Points points;
  std::vector<Contradiction> contradictions;
  // How many ends of pieces were moved onto those of another section.
  std::size_t snapped = 0;

  explicit Scene(std::vector<Plane> all) : planes(std::move(all)), points(planes) {}
  Scene(const Scene&) = delete;

  bool is_section(Index plane) const { return plane < sections.size(); }
  bool bounds_cells(Index plane) const { return !is_section(plane) || !sections[plane].partial; }
};

// A number s with s |n| within 2^-bits of 1.
Number scale_of(const Vector& normal, unsigned bits);

// Cuts every piece where another section's plane crosses it.
void cut_pieces(Scene& scene);

// Where two sections change between the same labels at almost the same place
// of their common line, not farther apart than `tolerance`, the two places
// become one. Points from `first_cut` on were made by cuts: only these move.
void reconcile(Scene& scene, double tolerance, Index first_cut);

// Lists what sections contradict each other in.
void find_contradictions(Scene& scene);

// The label of a section at a point of its plane that is on no piece.
Label label_at(const Scene& scene, Index section, const Point& point);

}  // namespace transect::skeleton
