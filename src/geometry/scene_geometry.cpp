// SPDX-License-Identifier: Apache-2.0
#include "uwv/geometry/scene_geometry.h"

namespace uwv {

std::string_view to_string(GeometryProvider provider) {
  switch (provider) {
    case GeometryProvider::import: return "import";
    case GeometryProvider::network: return "network";
    case GeometryProvider::sfm: return "sfm";
    default: return "prior";
  }
}

}  // namespace uwv
