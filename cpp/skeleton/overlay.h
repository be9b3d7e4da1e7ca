// Both walls' contours together on a roof between them (Barequet and Vaxman
// 2009, §5.1).
#pragma once

#include "transect/cpp/skeleton/roofs.h"

namespace transect::skeleton {

// Triangles where the two walls' labels differ; fills in the roof's chains.
// New points are where contours of the two cross.
std::vector<Triangle> overlay(const Heights& heights, Roof& roof, CellPoints& points);

// The triangle as meshes want it: a material behind, the smaller number if both
// are.
Triangle oriented(const Triangle& triangle);

}  // namespace transect::skeleton
