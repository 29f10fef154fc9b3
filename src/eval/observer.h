// SPDX-License-Identifier: Apache-2.0
// What a camera knows of a scene: the question both truths about renderings (visibility, wrong surfaces) come down to.
#pragma once

#include "uwv/core/mask.h"
#include "uwv/eval/synthetic_scene.h"

namespace uwv {

/// Share of a ray by which crossings may miss its end and still be its end. A ray that touches a ball at its rim has
/// both crossings wrong by about the square root of the rounding error, 1e-8; nothing in our scenes is this thin.
inline constexpr double end_of_ray = 1e-6;

/// A scene at one instant in front of a camera.
class Observer {
 public:
  Observer(const Scene& scene, const Camera& camera, double time);

  const Camera& camera() const { return camera_; }
  const SceneView& view() const { return view_; }
  const Eigen::Vector3d& centre_in_world() const { return camera_.world_from_cam.translation; }

  /// The pixel in which a point, given relative to the camera's centre along world axes, lies; false outside the
  /// picture and on or behind the camera plane.
  bool pixel_of(const Eigen::Vector3d& from_centre_in_world, int& x, int& y) const;
  /// No surface stands between the camera's centre and the point; the surface the point lies on does not count.
  bool unobstructed(const Eigen::Vector3d& from_centre_in_world) const;

 private:
  Camera camera_;
  SceneView view_;
};

/// The first surface through every pixel centre.
struct FirstHits {
  Image<double> depth;         ///< 0 = nothing hit.
  Image<std::int32_t> object;  ///< -1 = nothing hit.
};
FirstHits first_hits(const Observer& observer, ThreadPool& pool);

/// 1 where any pixel of the 3x3 around has another value: the one-pixel band left out on both sides of a border.
template <class T>
Image<std::uint8_t> border_band(const Image<T>& values) {
  Image<std::uint8_t> band(values.size());
  for (int y = 0; y < values.height(); ++y) {
    for (int x = 0; x < values.width(); ++x) {
      for (int j = -1; j <= 1; ++j)
        for (int i = -1; i <= 1; ++i)
          if (values.contains(x + i, y + j) && values(x + i, y + j) != values(x, y)) band(x, y) = 1;
    }
  }
  return band;
}

}  // namespace uwv
