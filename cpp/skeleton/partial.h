// One cell that holds partial sections, by a partition of space in a polyhedral
// gauge (see partial.cc).
#pragma once

#include <functional>

#include "transect/cpp/skeleton/exact.h"

namespace transect::skeleton {

// What is on one plane within a cell.
struct CellPlane {
  Index plane;  // in the table of planes
  // A wall of the cell: its corners (indices of points), counter-clockwise about
  // the plane's normal. Empty for a partial section, which may be crossed by others.
  std::vector<Index> corners;
  // The cell lies in front of a wall (+1) or behind it (-1); 0 for a partial section.
  int side;
  // The contours, clipped to the cell and split where other planes of sections
  // meet this one. Those of partial sections may have `unknown` on a side, and may
  // lie on a wall of the cell.
  std::vector<Piece> pieces;
  // The label everywhere, where there is no piece.
  Label label;
};

// What a cell shows. `partial_surface` is for those with partial sections.
struct PartialCell {
  const std::vector<Plane>* planes;
  // Corners of the cell and ends of pieces; equal points have one index.
  std::vector<Point> points;
  std::vector<CellPlane> walls;    // together they close the cell; all known
  std::vector<CellPlane> patches;  // partial sections, each with something known in the cell
};

// The surfaces in a cell. Indices below the number of the cell's points mean those.
struct PartialSurface {
  std::vector<Point> added;  // the points that follow the cell's
  std::vector<Triangle> triangles;
  // Points added on the pieces of walls, which the cell on the other side has to know, and
  // all those on the walls' edges: where walls show different labels along one, each of
  // the cells around it has surfaces that end there. Between two of the cell's points.
  struct Split {
    Index from, to, point;
  };
  std::vector<Split> splits;
  // What is not exact (leaves.h): how many leaves, their volume, and the middle of the
  // largest one.
  struct Inexact {
    std::size_t leaves = 0;
    double volume = 0;
    double largest = 0;
    double at[3] = {0, 0, 0};
  };
  Inexact inexact;
};

// Is told, from any thread, which part of the work is done, roughly.
using Watch = std::function<void(double)>;

PartialSurface partial_surface(const PartialCell& cell, const Watch& watch);

}  // namespace transect::skeleton
