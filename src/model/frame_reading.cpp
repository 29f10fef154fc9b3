// SPDX-License-Identifier: Apache-2.0
#include "model/frame_reading.h"

#include <algorithm>
#include <cmath>

#include "model/focal_shift.h"
#include "model/pose_encoding.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

/// A known pixel keeps at least this much: 0 means unknown.
constexpr float least_confidence = 1e-3F;

float sigmoid(float x) { return 1 / (1 + std::exp(-x)); }

float confidence_from(float raw, ConfidenceRule rule) {
  float value = raw;
  if (rule == ConfidenceRule::logit) value = sigmoid(raw);
  if (rule == ConfidenceRule::from_one) value = 1 - 1 / std::max(raw, 1.0F);
  return std::isnan(value) ? least_confidence : std::clamp(value, least_confidence, 1.0F);
}

void same_size(const char* role, Size found, Size wanted, const ReadingContext& context) {
  if (found != wanted)
    fail(ErrorCode::value_invalid, "{}: its output '{}' is {}x{} but its depth {}x{}; all maps must have one size",
         context.model_path, role, found.width, found.height, wanted.width, wanted.height);
}

/// Confidence where the network's mask and confidence keep a pixel, else 0.
std::vector<FloatMap> confidences(const DepthManifest& manifest, const NetworkOutput& output, Size size,
                                  std::size_t frames, const ReadingContext& context) {
  std::vector<FloatMap> maps;
  if (output.has("confidence")) {
    maps = output.maps("confidence");
    same_size("confidence", maps.front().size(), size, context);
    for (FloatMap& map : maps)
      for (float& value : map.pixels()) value = confidence_from(value, manifest.confidence_rule);
  } else {
    maps.assign(frames, FloatMap(size, context.plain_confidence));
  }
  if (!output.has("mask")) return maps;
  const std::vector<FloatMap> masks = output.maps("mask");
  same_size("mask", masks.front().size(), size, context);
  for (std::size_t f = 0; f < frames; ++f) {
    for (std::size_t i = 0; i < size.pixels(); ++i) {
      const float raw = masks[f].data()[i];
      const float kept = manifest.mask_is_logit ? sigmoid(raw) : raw;
      if (!(kept > static_cast<float>(manifest.mask_threshold))) maps[f].data()[i] = 0;
    }
  }
  return maps;
}

/// Unknown are values that are no number and, for depths, those not in front of the camera or too far.
void drop_unusable(const DepthManifest& manifest, FrameReading& reading) {
  const bool inverse = manifest.kind == NetworkKind::inverse_depth;
  for (std::size_t i = 0; i < reading.depth.value.pixels().size(); ++i) {
    float &value = reading.depth.value.data()[i], &confidence = reading.depth.confidence.data()[i];
    const bool finite = std::isfinite(value);
    if (!finite && confidence > 0) ++reading.not_finite;
    const bool too_far = manifest.max_depth > 0 && value > static_cast<float>(manifest.max_depth);
    if (finite && confidence > 0 && (inverse || (value > 0 && !too_far))) continue;
    value = 0;
    confidence = 0;
  }
}

std::vector<FrameReading> depth_readings(const DepthManifest& manifest, const NetworkOutput& output, const char* role,
                                         const ReadingContext& context) {
  std::vector<FloatMap> values = output.maps(role);
  std::vector<FloatMap> known = confidences(manifest, output, values.front().size(), values.size(), context);
  std::vector<FrameReading> readings(values.size());
  for (std::size_t i = 0; i < readings.size(); ++i) readings[i].depth = {std::move(values[i]), std::move(known[i])};
  return readings;
}

/// Depth and focal length of points that are right up to a shift along z, then up to the network's metric scale.
FrameReading point_reading(const VectorMap& points, FloatMap known, double scale, const ReadingContext& context) {
  FrameReading reading;
  for (std::size_t i = 0; i < points.pixels().size(); ++i) {
    if (points.data()[i].allFinite()) continue;
    reading.not_finite += known.data()[i] > 0 ? 1 : 0;
    known.data()[i] = 0;
  }
  FloatMap depth(points.size());
  const bool any = std::any_of(known.pixels().begin(), known.pixels().end(), [](float c) { return c > 0; });
  if (any) {
    const FocalShift fit = recover_focal_shift(points, known, context.frame);
    if (!(fit.focal > 0))
      fail(ErrorCode::value_invalid,
           "{}: no focal length fits its points; x right, y down, z forward is wanted, and another output may be the "
           "points",
           context.model_path);
    for (std::size_t i = 0; i < depth.pixels().size(); ++i)
      depth.data()[i] = static_cast<float>((static_cast<double>(points.data()[i].z()) + fit.shift) * scale);
    reading.shift_unknown = !fit.shift_known;
    reading.intrinsics = Intrinsics{fit.focal, fit.focal, context.frame.width / 2.0, context.frame.height / 2.0};
  } else {
    // A frame of sky: any camera will do, and a plain one keeps one camera a frame.
    reading.intrinsics = Intrinsics::from_fov_x(1.0, context.frame);
  }
  reading.depth = {std::move(depth), std::move(known)};
  return reading;
}

std::vector<FrameReading> point_readings(const DepthManifest& manifest, const NetworkOutput& output,
                                         const ReadingContext& context) {
  const std::vector<VectorMap> points = output.vectors("points");
  std::vector<FloatMap> known = confidences(manifest, output, points.front().size(), points.size(), context);
  std::vector<std::vector<double>> scales(points.size(), {1.0});
  if (output.has("metric_scale")) scales = output.numbers("metric_scale", 1);
  std::vector<FrameReading> readings;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!(scales[i][0] > 0))
      fail(ErrorCode::value_invalid, "{}: its output 'metric_scale' is {}; a positive number is wanted",
           context.model_path, scales[i][0]);
    readings.push_back(point_reading(points[i], std::move(known[i]), scales[i][0], context));
  }
  return readings;
}

/// Unit normals that face the camera, zero where unknown.
void read_normals(const NetworkOutput& output, std::vector<FrameReading>& readings) {
  std::vector<VectorMap> normals = output.vectors("normals");
  for (std::size_t i = 0; i < readings.size(); ++i) {
    for (Eigen::Vector3f& normal : normals[i].pixels()) {
      const float length = normal.stableNorm();
      if (std::isfinite(length) && length > 1e-6F)
        normal /= normal.z() > 0 ? -length : length;
      else
        normal.setZero();
    }
    readings[i].normals = std::move(normals[i]);
  }
}

void read_poses(const DepthManifest& manifest, const NetworkOutput& output, const ReadingContext& context,
                std::vector<FrameReading>& readings) {
  const auto encodings = output.numbers("pose", 9);
  for (std::size_t i = 0; i < readings.size(); ++i) {
    const EncodedCamera camera =
        decode_pose(encodings[i], context.frame, fmt::format("{}: frame {}", context.model_path, i));
    readings[i].intrinsics = camera.intrinsics;
    readings[i].world_from_cam = manifest.pose_is_cam_from_world ? camera.transform.inverse() : camera.transform;
  }
}

/// Rows of a 3x3 matrix, in pixels of what the network saw.
void read_intrinsics(const NetworkOutput& output, const ReadingContext& context, std::vector<FrameReading>& readings) {
  const auto matrices = output.numbers("intrinsics", 9);
  for (std::size_t i = 0; i < readings.size(); ++i) {
    const auto& k = matrices[i];
    const Intrinsics seen{k[0], k[4], k[2], k[5]};
    if (!(seen.fx > 0 && seen.fy > 0))
      fail(ErrorCode::value_invalid,
           "{}: the focal lengths of its output 'intrinsics' are {} and {}; positive ones are wanted",
           context.model_path, seen.fx, seen.fy);
    readings[i].intrinsics = seen.resized(context.input, context.frame);
  }
}

}  // namespace

std::vector<FrameReading> read_output(const DepthManifest& manifest, const NetworkOutput& output,
                                      const ReadingContext& context) {
  std::vector<FrameReading> readings;
  if (manifest.kind == NetworkKind::points)
    readings = point_readings(manifest, output, context);
  else
    readings = depth_readings(manifest, output, manifest.kind == NetworkKind::inverse_depth ? "inverse_depth" : "depth",
                              context);
  for (FrameReading& reading : readings) drop_unusable(manifest, reading);
  if (output.has("normals")) read_normals(output, readings);
  if (output.has("pose")) read_poses(manifest, output, context, readings);
  if (output.has("intrinsics")) read_intrinsics(output, context, readings);
  return readings;
}

}  // namespace uwv::model
