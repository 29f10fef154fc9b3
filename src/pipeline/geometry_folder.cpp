// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry_folder.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "io/disk_file.h"
#include "io/json_text.h"
#include "uwv/io/cameras_file.h"
#include "uwv/io/depth_writer.h"
#include "uwv/io/npy.h"
#include "uwv/io/video_writer.h"

namespace uwv::pipeline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using nlohmann::ordered_json;

constexpr const char* description_name = "geometry.json";

long whole_number(const json& description, const char* key, long least, const std::string& path) {
  const auto found = description.find(key);
  if (found == description.end() || !found->is_number_integer() || found->get<long>() < least)
    fail(ErrorCode::file_damaged, "{}: /{}: found {}, wanted a whole number of at least {}; make the folder anew", path,
         key, found == description.end() ? "nothing" : found->dump(), least);
  return found->get<long>();
}

void write_depths(const GeometryFolder& folder, const SceneGeometry& geometry, Size size, Monitor& monitor) {
  const auto writer = make_depth_writer(folder.depth(), {}, size, folder.frames, monitor);
  for (const FrameGeometry& frame : geometry.frames) writer->write(frame.depth);
  writer->finish();
}

void write_background(const GeometryFolder& folder, const BackgroundLayer& background, double fps, Monitor& monitor) {
  const Size size = background.colour.front().size();
  const auto depths = make_depth_writer(folder.background_depth(), {}, size, folder.frames, monitor);
  constexpr int hardly_lossy = 4;  // it is shown beside the source's own pixels
  VideoWriter colours(folder.background(), size, {.fps = fps, .crf = hardly_lossy});
  for (std::size_t i = 0; i < background.colour.size(); ++i) {
    colours.write(background.colour[i]);
    depths->write(background.depth[i]);
  }
  colours.finish();
  depths->finish();
}

void write_confidences(const GeometryFolder& folder, const SceneGeometry& geometry, Size size) {
  NpzWriter writer(folder.confidence());
  constexpr int fast = 1;  // flat regions shrink to nothing at any level
  writer.begin("confidence", DType::u8, {static_cast<std::size_t>(size.height), static_cast<std::size_t>(size.width)},
               fast);
  std::vector<std::uint8_t> bytes(size.pixels());
  for (const FrameGeometry& frame : geometry.frames) {
    std::transform(frame.confidence.pixels().begin(), frame.confidence.pixels().end(), bytes.begin(),
                   [](float c) { return static_cast<std::uint8_t>(std::lround(255.0F * std::clamp(c, 0.0F, 1.0F))); });
    writer.append<std::uint8_t>(bytes);
  }
  writer.end();
  writer.finish();
}

void write_normals(const GeometryFolder& folder, const SceneGeometry& geometry, Size size) {
  NpzWriter writer(folder.normals());
  writer.begin("normals", DType::f16,
               {static_cast<std::size_t>(size.height), static_cast<std::size_t>(size.width), std::size_t{3}});
  std::vector<Eigen::half> values(size.pixels() * 3);
  for (const NormalMap& map : geometry.normals) {
    for (std::size_t p = 0; p < size.pixels(); ++p)
      for (Eigen::Index c = 0; c < 3; ++c)
        values[p * 3 + static_cast<std::size_t>(c)] = static_cast<Eigen::half>(map.pixels()[p][c]);
    writer.append(std::as_bytes(std::span(values)));
  }
  writer.end();
  writer.finish();
}

void write_foreground(const GeometryFolder& folder, std::span<const ForegroundMask> foreground, double fps) {
  VideoWriter writer(folder.foreground(), foreground.front().size(), VideoWriterOptions::for_masks(fps));
  ImageRgb picture(foreground.front().size());
  for (const ForegroundMask& mask : foreground) {
    std::transform(mask.pixels().begin(), mask.pixels().end(), picture.pixels().begin(), [](std::uint8_t inside) {
      const auto grey = static_cast<std::uint8_t>(inside != 0 ? 255 : 0);
      return Rgb8{grey, grey, grey};
    });
    writer.write(picture);
  }
  writer.finish();
}

void write_description(const GeometryFolder& folder, const ordered_json& facts, Size size) {
  ordered_json description = {{"start", folder.start},
                              {"stride", folder.stride},
                              {"frames", folder.frames},
                              {"size", fmt::format("{}x{}", size.width, size.height)}};
  description.update(facts);
  std::ofstream file(fs::path(folder.path) / description_name);
  file << description.dump(1) << '\n';
  file.close();
  if (!file) fail(ErrorCode::output_failed, "{}/{}: cannot be written", folder.path, description_name);
}

}  // namespace

std::optional<GeometryFolder> open_geometry_folder(const std::string& path) {
  const std::string description_path = (fs::path(path) / description_name).string();
  if (path.empty() || !fs::is_directory(path) || !fs::exists(description_path)) return std::nullopt;
  constexpr std::uint64_t max_bytes = 64U << 20U;
  const json description = io::parse_json(io::read_text(description_path, max_bytes), description_path);
  if (!description.is_object())
    fail(ErrorCode::file_damaged, "{}: found no JSON object; make the folder anew", description_path);
  GeometryFolder folder;
  folder.path = path;
  folder.description = description;
  folder.start = whole_number(description, "start", 0, description_path);
  folder.stride = whole_number(description, "stride", 1, description_path);
  folder.frames = whole_number(description, "frames", 1, description_path);
  folder.has_foreground = fs::exists(fs::path(path) / "foreground_mask.mp4");
  folder.has_normals = fs::exists(folder.normals());
  folder.has_background = fs::exists(folder.background()) && fs::exists(folder.background_depth());
  return folder;
}

void write_geometry_folder(const GeometryFolder& to, const EstimatedGeometry& geometry, double fps, Monitor& monitor) {
  const SceneGeometry& scene = geometry.scene;
  require(!scene.frames.empty() && scene.frames.size() == scene.cameras.size(),
          "a geometry of {} frames has {} cameras", scene.frames.size(), scene.cameras.size());
  GeometryFolder folder = to;
  folder.has_foreground = !geometry.foreground.empty();
  folder.has_background = !geometry.background.colour.empty();
  const Size size = scene.cameras.front().size;
  std::error_code failed;
  fs::create_directories(folder.path, failed);
  if (failed) fail(ErrorCode::output_failed, "{}: cannot be created: {}", folder.path, failed.message());
  write_depths(folder, scene, size, monitor);
  write_confidences(folder, scene, size);
  CameraTrack track;
  for (const Camera& camera : scene.cameras) {
    track.times.push_back(static_cast<double>(track.cameras.size()));
    track.cameras.push_back(camera);
  }
  write_cameras(folder.cameras(), track, CamerasFormat::uwv);
  if (!scene.normals.empty()) write_normals(folder, scene, size);
  if (folder.has_foreground) write_foreground(folder, geometry.foreground, fps);
  if (folder.has_background) write_background(folder, geometry.background, fps, monitor);
  write_description(folder, geometry.facts, size);
}

}  // namespace uwv::pipeline
