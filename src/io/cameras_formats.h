// SPDX-License-Identifier: Apache-2.0
// Readers and writers of the single camera formats; cameras_file.cpp chooses among them.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "uwv/io/cameras_file.h"

namespace uwv::io {

/// A file's text together with what its readers need.
struct CamerasText {
  const std::string& path;
  std::string_view text;
  const CamerasFileOptions& options;
};

CameraTrack read_tum(const CamerasText& file);
std::string format_tum(const CameraTrack& track);

CameraTrack read_redwood(const CamerasText& file);
std::string format_redwood(const CameraTrack& track);

CameraTrack read_uwv_cameras(const nlohmann::json& json, const std::string& path, const CamerasFileOptions& options);
std::string format_uwv_cameras(const CameraTrack& track);

CameraTrack read_nerfstudio(const nlohmann::json& json, const std::string& path, const CamerasFileOptions& options,
                            Monitor& monitor);
std::string format_nerfstudio(const CameraTrack& track);

/// The camera for pictures of options.size (when stated), made from intrinsics that refer to `stated`. Throws
/// Error(value_invalid) beginning with `where` unless focal lengths are finite and not 0 and the centre is finite.
Camera make_camera(const Intrinsics& intrinsics, Size stated, const Rigid3& world_from_cam,
                   const CamerasFileOptions& options, const std::string& where);

}  // namespace uwv::io
