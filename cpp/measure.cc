#include "transect/cpp/measure.h"

#include <CGAL/version.h>
#include <openvdb/version.h>

#include <string>

namespace transect::measure {

rust::String library_versions() {
  return std::string("CGAL ") + CGAL_VERSION_STR + ", OpenVDB " + OPENVDB_LIBRARY_VERSION_STRING;
}

}  // namespace transect::measure
