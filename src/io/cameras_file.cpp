// SPDX-License-Identifier: Apache-2.0
#include "uwv/io/cameras_file.h"

#include <algorithm>
#include <cmath>

#include "io/cameras_formats.h"
#include "io/disk_file.h"
#include "io/json_text.h"

namespace uwv {
namespace {

constexpr std::uint64_t max_text_bytes = 1U << 28;

CamerasFormat format_of_json(const nlohmann::json& json, const std::string& path) {
  if (json.is_object() && json.contains("uwv_cameras")) return CamerasFormat::uwv;
  if (json.is_object() && json.contains("frames")) return CamerasFormat::nerfstudio;
  fail(ErrorCode::format_unknown,
       "{}: this JSON holds no cameras; \"uwv_cameras\" or nerfstudio's \"frames\" is wanted at its top", path);
}

int count_words(std::string_view line) {
  int words = 0;
  bool inside = false;
  for (const char c : line) {
    const bool blank = c == ' ' || c == '\t' || c == '\r';
    words += !blank && !inside;
    inside = !blank;
  }
  return words;
}

/// By the first line that is no comment: TUM has eight numbers on it, a Redwood log three.
CamerasFormat format_of_text(std::string_view text, const std::string& path) {
  int words = 0;
  while (!text.empty() && words == 0) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(text.size(), line.size() + 1));
    const auto first = line.find_first_not_of(" \t\r");
    if (first != std::string_view::npos && line[first] != '#') words = count_words(line);
  }
  if (words == 8) return CamerasFormat::tum;
  if (words == 3) return CamerasFormat::redwood;
  fail(ErrorCode::format_unknown,
       "{}: holds no cameras we know; JSON, TUM (8 numbers a line) or a Redwood log (3 numbers, then 4 rows) is wanted",
       path);
}

CameraTrack read_any(const std::string& path, const CamerasFileOptions& options, Monitor& monitor) {
  const std::string text = io::read_text(path, max_text_bytes);
  const auto first = text.find_first_not_of(" \t\r\n");
  if (first != std::string::npos && (text[first] == '{' || text[first] == '[')) {
    const nlohmann::json json = io::parse_json(text, path);
    if (format_of_json(json, path) == CamerasFormat::uwv) return io::read_uwv_cameras(json, path, options);
    return io::read_nerfstudio(json, path, options, monitor);
  }
  const io::CamerasText file{path, text, options};
  return format_of_text(text, path) == CamerasFormat::tum ? io::read_tum(file) : io::read_redwood(file);
}

}  // namespace

namespace io {

Camera make_camera(const Intrinsics& intrinsics, Size stated, const Rigid3& world_from_cam,
                   const CamerasFileOptions& options, const std::string& where) {
  const Intrinsics& k = intrinsics;
  if (!std::isfinite(k.fx) || !std::isfinite(k.fy) || !std::isfinite(k.cx) || !std::isfinite(k.cy) || k.fx == 0 ||
      k.fy == 0)
    fail(ErrorCode::value_invalid, "{}: the intrinsics fx {}, fy {}, cx {}, cy {} are of no use", where, k.fx, k.fy,
         k.cx, k.cy);
  if (options.size == Size{} || options.size == stated) return {k, world_from_cam, stated};
  return {k.resized(stated, options.size), world_from_cam, options.size};
}

}  // namespace io

void CamerasFileOptions::check() const {
  require((size.width > 0 && size.height > 0) || size == Size{}, "cameras cannot be read for pictures of {}x{}",
          size.width, size.height);
  require(!intrinsics || size != Size{}, "intrinsics were given without the size of the pictures they are for");
  require(!intrinsics || (intrinsics->fx != 0 && intrinsics->fy != 0), "the focal lengths {} and {} must not be 0",
          intrinsics ? intrinsics->fx : 0, intrinsics ? intrinsics->fy : 0);
}

std::string_view to_string(CamerasFormat format) {
  switch (format) {
    case CamerasFormat::uwv: return "uwv";
    case CamerasFormat::nerfstudio: return "nerfstudio";
    case CamerasFormat::tum: return "tum";
    case CamerasFormat::redwood: return "redwood";
  }
  return "?";
}

CamerasFormat cameras_format_named(std::string_view name) {
  for (const CamerasFormat format :
       {CamerasFormat::uwv, CamerasFormat::nerfstudio, CamerasFormat::tum, CamerasFormat::redwood})
    if (to_string(format) == name) return format;
  require(false, "'{}' is no camera format; uwv, nerfstudio, tum or redwood is wanted", name);
  return {};
}

CameraTrack read_cameras(const std::string& path, const CamerasFileOptions& options, Monitor& monitor) {
  options.check();
  CameraTrack track = read_any(path, options, monitor);
  if (track.cameras.empty()) fail(ErrorCode::value_invalid, "{}: holds no camera at all", path);
  return track;
}

void write_cameras(const std::string& path, const CameraTrack& track, CamerasFormat format) {
  require(!track.cameras.empty() && track.cameras.size() == track.times.size(),
          "{}: a track of {} cameras and {} times cannot be written", path, track.cameras.size(), track.times.size());
  switch (format) {
    case CamerasFormat::uwv: return io::write_file(path, io::format_uwv_cameras(track));
    case CamerasFormat::nerfstudio: return io::write_file(path, io::format_nerfstudio(track));
    case CamerasFormat::tum: return io::write_file(path, io::format_tum(track));
    case CamerasFormat::redwood: return io::write_file(path, io::format_redwood(track));
  }
}

}  // namespace uwv
