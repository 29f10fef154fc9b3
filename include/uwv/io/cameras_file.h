// SPDX-License-Identifier: Apache-2.0
// Camera paths in files: read into OpenCV axes, written from them. docs/formats.md has the field tables.
//
//   format      file                            pose stored                 intrinsics      read and written by
//   uwv         .json with "uwv_cameras"        world_from_cam, OpenCV      per frame       this library
//   nerfstudio  .json with "frames"             world_from_cam, OpenGL      global or per   nerfstudio, instant-ngp
//   tum         text, 8 numbers a line          world_from_cam, OpenCV      none            SLAM data sets and tools
//   redwood     text, 3 numbers, then 4 rows    world_from_cam, OpenCV      none            Open3D trajectory.log
//
// OpenGL camera axes (x right, y up, z backwards) become OpenCV's by turning y and z; the world's axes stay as they
// are. TUM quaternions are stored x y z w, with the real part last.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "uwv/core/camera.h"
#include "uwv/core/monitor.h"

namespace uwv {

/// Cameras in the order of the clip.
struct CameraTrack {
  std::vector<Camera> cameras;
  /// Seconds, one per camera; where a file tells no times, the camera's number 0, 1, 2, ...
  std::vector<double> times;
};

struct CamerasFileOptions {
  /// The pictures' size. Intrinsics of files that state another size are resized to it. {0, 0} = the file's own, which
  /// only the JSON formats have.
  Size size;
  /// For files without intrinsics; refers to `size`.
  std::optional<Intrinsics> intrinsics;
  /// Throws std::invalid_argument for negative sizes, or intrinsics without a size or with a zero focal length.
  void check() const;
};

enum class CamerasFormat { uwv, nerfstudio, tum, redwood };
std::string_view to_string(CamerasFormat format);
/// Throws std::invalid_argument naming the known formats.
CamerasFormat cameras_format_named(std::string_view name);

/// Reads at least one camera; the format is recognised by the contents. Nerfstudio frames come in the natural order of
/// their file_path. `monitor` is warned of lens distortion, which is ignored. Throws Error naming the file and the line
/// or JSON pointer: file_not_found, file_damaged (not the text or JSON it should be), format_unknown, value_invalid (a
/// pose that is NaN, singular or mirrored, a zero focal length, a fisheye lens, missing size or intrinsics).
CameraTrack read_cameras(const std::string& path, const CamerasFileOptions& options, Monitor& monitor);

/// Writes a track; reading it back gives the same cameras to 1e-9 or better (rotations of TUM: 1e-12). TUM and redwood
/// lose intrinsics and sizes, nerfstudio and redwood lose times. Nerfstudio frames are named images/00000.png, ...
/// Throws Error(output_failed), std::invalid_argument for an empty track or when `times` has another length.
void write_cameras(const std::string& path, const CameraTrack& track, CamerasFormat format);

}  // namespace uwv
