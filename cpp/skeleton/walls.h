// Walls between contours and what they become on the roofs over them (Barequet
// and Vaxman 2009, §5.2).
#pragma once

#include "transect/cpp/skeleton/roofs.h"

namespace transect::skeleton {

// The wall over a contour's piece, once all roofs are overlaid.
void add_wall(const Heights& heights, const Roofs& roofs, const Lifted& lifted,
              const CellPoints& points, std::vector<Triangle>& triangles);

}  // namespace transect::skeleton
