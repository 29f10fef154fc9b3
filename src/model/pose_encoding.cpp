// SPDX-License-Identifier: Apache-2.0
#include "model/pose_encoding.h"

#include <cmath>
#include <numbers>

#include "uwv/core/error.h"

namespace uwv::model {

EncodedCamera decode_pose(std::span<const double> encoding, Size frame, std::string_view what) {
  require(encoding.size() == 9, "a pose is encoded in 9 numbers, not {}", encoding.size());
  const Eigen::Vector4d xyzw(encoding[3], encoding[4], encoding[5], encoding[6]);
  if (!(xyzw.norm() > 1e-6) || !xyzw.allFinite())
    fail(ErrorCode::value_invalid, "{}: the pose's quaternion ({}, {}, {}, {}) is no rotation", what, xyzw[0], xyzw[1],
         xyzw[2], xyzw[3]);
  const double fov_y = encoding[7], fov_x = encoding[8];
  for (const double fov : {fov_y, fov_x})
    if (!(fov > 0 && fov < std::numbers::pi))
      fail(ErrorCode::value_invalid, "{}: a field of view is {} radians; more than 0 and less than pi is wanted", what,
           fov);
  EncodedCamera camera;
  const Eigen::Vector4d unit = xyzw.normalized();
  camera.transform.rotation = Eigen::Quaterniond(unit[3], unit[0], unit[1], unit[2]).toRotationMatrix();
  camera.transform.translation = {encoding[0], encoding[1], encoding[2]};
  camera.intrinsics = {frame.width / 2.0 / std::tan(fov_x / 2), frame.height / 2.0 / std::tan(fov_y / 2),
                       frame.width / 2.0, frame.height / 2.0};
  return camera;
}

}  // namespace uwv::model
