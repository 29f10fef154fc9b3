// SPDX-License-Identifier: Apache-2.0
#include "uwv/trajectory/target_path.h"

#include <algorithm>
#include <cmath>

#include "trajectory/keyframe_path.h"

namespace uwv {
namespace {

template <class... Functions>
struct Overloaded : Functions... {
  using Functions::operator()...;
};
template <class... Functions>
Overloaded(Functions...) -> Overloaded<Functions...>;

[[noreturn]] void refuse(const TrajectorySpec& spec, std::string_view pointer, std::string_view sentence) {
  fail(ErrorCode::value_invalid, "{}: {}: {}", spec.name, pointer, sentence);
}

Intrinsics zoomed(Intrinsics intrinsics, double zoom) {
  intrinsics.fx *= zoom;
  intrinsics.fy *= zoom;
  return intrinsics;
}

Rigid3 pose_in_subject(const Rigid3& pose, const TrajectorySpec& spec, const PathContext& context) {
  if (spec.frame_of_reference == FrameOfReference::source_world) return context.world.subject_from_cam(pose);
  if (spec.units == LengthUnit::radius) return {pose.rotation, pose.translation * context.world.radius()};
  return pose;
}

std::vector<Camera> explicit_cameras(const CameraMotion& motion, const TrajectorySpec& spec, const PathContext& context,
                                     long frames) {
  require(!motion.cameras.empty(), "the cameras of '{}' have not been read", motion.cameras_file);
  if (std::ssize(motion.cameras) != frames)
    refuse(spec, "/cameras",
           fmt::format("there are {} cameras for {} frames; equal counts are wanted", motion.cameras.size(), frames));
  std::vector<Camera> cameras;
  for (const ExplicitCamera& given : motion.cameras) {
    Intrinsics intrinsics = context.intrinsics;
    if (given.intrinsics) intrinsics = given.intrinsics->resized(given.size.value_or(context.size), context.size);
    if (given.fov) intrinsics = zoomed(context.intrinsics, detail::zoom_for_fov(*given.fov, context));
    cameras.push_back({intrinsics, pose_in_subject(given.world_from_cam, spec, context), context.size});
  }
  return cameras;
}

std::vector<Camera> cameras_of(const TrajectorySpec& spec, const PathContext& context, long frames) {
  if (const auto* motion = std::get_if<CameraMotion>(&spec.motion))
    return explicit_cameras(*motion, spec, context, frames);
  const Rigid3& start = context.world.subject_from_cam0();
  const double offset_radius = context.world.radius() * (context.is_photo ? 1.0 : spec.radius_scale);
  const CameraPath path =
      std::visit(Overloaded{
                     [&](const PresetMotion& m) { return preset_path(m.name, m.focal, start, offset_radius, frames); },
                     [&](const FreeMove& move) { return free_path(move, start, offset_radius, frames); },
                     [&](const OrbitLists& lists) { return lists_path(lists, start, frames); },
                     [&](const KeyframeMotion& motion) { return detail::keyframe_path(motion, spec, context, frames); },
                     [](const CameraMotion&) { return CameraPath{}; },
                 },
                 spec.motion);
  std::vector<Camera> cameras;
  cameras.reserve(path.subject_from_cam.size());
  for (std::size_t k = 0; k < path.subject_from_cam.size(); ++k)
    cameras.push_back({zoomed(context.intrinsics, path.zoom[k]), path.subject_from_cam[k], context.size});
  return cameras;
}

std::vector<long> source_frames_of(const TrajectorySpec& spec, const PathContext& context, long frames) {
  const long last = context.source_frames - 1;
  const auto checked = [&](long frame, const std::string& pointer) {
    if (frame > last)
      refuse(spec, pointer, fmt::format("source frame {} is wanted, but the source ends with frame {}", frame, last));
    return frame;
  };
  std::vector<long> list(static_cast<std::size_t>(frames));
  for (long k = 0; k < frames; ++k) {
    const auto i = static_cast<std::size_t>(k);
    list[i] = std::visit(
        Overloaded{
            [&](const FollowTime&) { return std::min(k, last); },
            [&](const FreezeTime& freeze) { return checked(freeze.frame, "/time/freeze"); },
            [&](const ListedTime& listed) { return checked(listed.frames[i], fmt::format("/time/frames/{}", k)); },
            [&](const SpanTime& span) {
              checked(span.from, "/time/from");
              checked(span.to, "/time/to");
              const double u = frames > 1 ? static_cast<double>(k) / static_cast<double>(frames - 1) : 0.0;
              return span.from + std::lround(u * static_cast<double>(span.to - span.from));
            },
        },
        spec.time);
  }
  return list;
}

const Rigid3& source_pose(const PathContext& context, long frame) {
  const auto last = context.subject_from_source.size() - 1;
  return context.subject_from_source[std::min(static_cast<std::size_t>(frame), last)];
}

}  // namespace

void PathContext::check() const {
  require(size.width > 0 && size.height > 0, "target pictures of {}x{} pixels were asked for", size.width, size.height);
  require(std::isfinite(intrinsics.fx) && intrinsics.fx != 0 && std::isfinite(intrinsics.fy) && intrinsics.fy != 0 &&
              std::isfinite(intrinsics.cx) && std::isfinite(intrinsics.cy),
          "the source's intrinsics fx {}, fy {}, cx {}, cy {} cannot be used", intrinsics.fx, intrinsics.fy,
          intrinsics.cx, intrinsics.cy);
  require(source_frames >= 1, "the source has {} frames; at least 1 is wanted", source_frames);
  const auto poses = std::ssize(subject_from_source);
  require(poses == 1 || poses == source_frames, "the source has {} frames but {} cameras; as many or one are wanted",
          source_frames, poses);
}

PathContext make_context(const TrajectorySpec& spec, const Intrinsics& intrinsics, Size size,
                         std::span<const Rigid3> world_from_cam, long source_frames, double median_depth,
                         bool is_photo) {
  require(!world_from_cam.empty(), "a clip without source cameras was given; at least one is wanted");
  const double radius = spec.radius > 0 ? spec.radius : median_depth;
  if (!(std::isfinite(radius) && radius > 0))
    refuse(
        spec, "/radius",
        fmt::format("\"auto\" is the median depth of the first source frame, which is {}; a number is wanted", radius));
  PathContext context{intrinsics, size,          SubjectWorld(world_from_cam.front(), spec.elevation, radius),
                      {},         source_frames, is_photo};
  for (const Rigid3& pose : world_from_cam) context.subject_from_source.push_back(context.world.subject_from_cam(pose));
  context.check();
  return context;
}

long path_frames(const TrajectorySpec& spec, const PathContext& context) {
  constexpr long official_photo_length = 81;
  if (spec.frames > 0) return spec.frames;
  if (const auto* cameras = std::get_if<CameraMotion>(&spec.motion); cameras != nullptr && !cameras->cameras.empty())
    return std::ssize(cameras->cameras);
  if (const auto* listed = std::get_if<ListedTime>(&spec.time)) return std::ssize(listed->frames);
  return context.is_photo ? official_photo_length : context.source_frames;
}

TargetPath build_path(const TrajectorySpec& spec, const PathContext& context) {
  context.check();
  const long frames = path_frames(spec, context);
  if (const auto* listed = std::get_if<ListedTime>(&spec.time);
      listed != nullptr && std::ssize(listed->frames) != frames)
    refuse(spec, "/time/frames",
           fmt::format("there are {} source frames for {} target frames; equal counts are wanted",
                       listed->frames.size(), frames));
  const std::vector<long> source_frames = source_frames_of(spec, context, frames);
  const std::vector<Camera> cameras = cameras_of(spec, context, frames);

  const Rigid3& start = context.world.subject_from_cam0();
  TargetPath path;
  path.frames.reserve(cameras.size());
  for (std::size_t k = 0; k < cameras.size(); ++k) {
    TargetFrame frame{cameras[k], source_frames[k]};
    if (spec.follow_source) {
      const Rigid3& moved = source_pose(context, frame.source_frame);
      Rigid3& pose = frame.camera.world_from_cam;
      pose = pose == start ? moved : moved * (start.inverse() * pose);  // no path, no rounding
    }
    path.frames.push_back(frame);
  }
  return path;
}

PathSummary summarize(const TargetPath& path, const PathContext& context) {
  struct Departure {
    double rotation_deg, translation, log_zoom;
  };
  std::vector<Departure> departures;
  Departure most{0, 0, 0};
  PathSummary summary;
  for (const TargetFrame& frame : path.frames) {
    const Camera source{context.intrinsics, source_pose(context, frame.source_frame), context.size};
    const Rigid3 relative = target_from_source(frame.camera, source);
    const Eigen::Quaterniond turn(relative.rotation);
    const double zoom = std::abs(frame.camera.intrinsics.fx / context.intrinsics.fx);
    const Departure now{2 * std::atan2(turn.vec().norm(), std::abs(turn.w())) * (180 / M_PI),
                        relative.translation.norm() / context.world.radius(), std::abs(std::log(zoom))};
    most = {std::max(most.rotation_deg, now.rotation_deg), std::max(most.translation, now.translation),
            std::max(most.log_zoom, now.log_zoom)};
    summary.max_zoom = std::max(summary.max_zoom, zoom);
    departures.push_back(now);
  }
  summary.max_rotation_deg = most.rotation_deg;
  summary.max_translation = most.translation;

  // A hundredth of the largest departure is jitter, and so is anything below a pixel or so.
  const Departure slack{0.01 * most.rotation_deg + 0.02, 0.01 * most.translation + 1e-4, 0.01 * most.log_zoom + 1e-4};
  Departure farthest{0, 0, 0};
  for (std::size_t k = 0; k < departures.size() && summary.first_return < 0; ++k) {
    const Departure& now = departures[k];
    if (now.rotation_deg < farthest.rotation_deg - slack.rotation_deg ||
        now.translation < farthest.translation - slack.translation || now.log_zoom < farthest.log_zoom - slack.log_zoom)
      summary.first_return = static_cast<long>(k);
    farthest = {std::max(farthest.rotation_deg, now.rotation_deg), std::max(farthest.translation, now.translation),
                std::max(farthest.log_zoom, now.log_zoom)};
  }
  return summary;
}

}  // namespace uwv
