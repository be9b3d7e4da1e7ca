// Questions about triangle meshes, answered by CGAL. No CGAL type crosses.
#pragma once

#include "rust/cxx.h"
#include "transect/cpp/trycatch.h"

namespace transect::measure {

rust::String library_versions();

}  // namespace transect::measure
