// SPDX-License-Identifier: Apache-2.0
// A clip's estimated geometry on disk: OUT/geometry, which a later run may name as its --depth.
//
//   geometry.json         what it is of (frames, start, stride, size) and how it was found
//   depth.npz             depth of every used frame, working size
//   confidence.npz        the same shape, 8 bits: 255 = measured and confirmed, 128 and more = measured, 0 = a guess
//   cameras.json          source cameras, in the unit of the depth
//   normals.npz           unit normals in each camera's frame, half floats; only where a network gave some
//   foreground_mask.mp4   white = foreground; only where there is any
//   background.mp4, background_depth.npz
//                         the scene behind the foreground; only with a foreground
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/geometry_estimation.h"
#include "uwv/core/monitor.h"

namespace uwv::pipeline {

/// What a geometry folder says of itself.
struct GeometryFolder {
  std::string path;
  long start = 0, stride = 1, frames = 0;  ///< Which frames of the clip it is of.
  bool has_foreground = false, has_background = false, has_normals = false;
  nlohmann::json description =
      nlohmann::json::object();  ///< All of geometry.json; an empty object for a folder yet to be written.

  std::string depth() const { return path + "/depth.npz"; }
  std::string normals() const { return path + "/normals.npz"; }
  std::string cameras() const { return path + "/cameras.json"; }
  std::string foreground() const { return has_foreground ? path + "/foreground_mask.mp4" : ""; }
  std::string background() const { return path + "/background.mp4"; }
  std::string confidence() const { return path + "/confidence.npz"; }
  std::string background_depth() const { return path + "/background_depth.npz"; }
};

/// The folder at `path`, or nothing when that is no geometry folder. Throws Error(file_damaged) when geometry.json is
/// broken.
std::optional<GeometryFolder> open_geometry_folder(const std::string& path);

/// Writes the folder; has_foreground and its like follow from `geometry`. Its facts become part of geometry.json.
/// Throws Error(output_failed).
void write_geometry_folder(const GeometryFolder& folder, const EstimatedGeometry& geometry, double fps,
                           Monitor& monitor);

}  // namespace uwv::pipeline
