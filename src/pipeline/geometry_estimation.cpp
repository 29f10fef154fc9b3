// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry_estimation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/resources.h"

namespace uwv::pipeline {
namespace {

using nlohmann::ordered_json;

double fov_deg(const Intrinsics& intrinsics, Size size) {
  return 2 * std::atan(0.5 * size.width / std::abs(intrinsics.fx)) * 180 / std::numbers::pi;
}

ordered_json facts_of(const SfmResult& sfm) {
  const auto registered = std::count(sfm.registered.begin(), sfm.registered.end(), std::uint8_t{1});
  ordered_json facts = {{"motion", to_string(sfm.motion)},
                        {"reason", sfm.reason},
                        {"parallax_px", sfm.parallax_px},
                        {"points", sfm.points.size()},
                        {"registered_frames", registered},
                        {"rms_error_px", sfm.rms_error_px},
                        {"moving_tracks_share", sfm.moving_share},
                        {"cuts", sfm.cuts},
                        {"seconds", sfm.seconds}};
  if (!sfm.cameras.empty())
    facts["lens"] = {{"fx", sfm.cameras.front().intrinsics.fx},
                     {"fov_deg", fov_deg(sfm.cameras.front().intrinsics, sfm.cameras.front().size)},
                     {"estimated", sfm.focal_estimated}};
  return facts;
}

EstimatedGeometry measured(const RunOptions& options, std::span<const ImageRgb> frames, const SfmResult& sfm,
                           ThreadPool& pool, Monitor& monitor) {
  EstimatedGeometry estimated;
  estimated.scene.cameras = sfm.cameras;
  estimated.scene.depth_from = estimated.scene.cameras_from = GeometryProvider::sfm;
  const MvsSummary mvs = multi_view_stereo(frames, sfm.cameras, sfm.points, {}, mvs_options(options), pool, monitor,
                                           estimated.scene.frames);
  estimated.facts = {{"provider", "sfm"},
                     {"structure_from_motion", facts_of(sfm)},
                     {"multi_view_stereo",
                      {{"matched_frames", mvs.matched_frames},
                       {"measured_share", mvs.measured_share},
                       {"seconds", mvs.seconds},
                       {"notes", mvs.notes}}},
                     {"brief", fmt::format("{}; {}", sfm.brief(), mvs.brief())}};
  return estimated;
}

}  // namespace

EstimatedGeometry estimate_geometry(const RunOptions& options, std::span<const ImageRgb> frames,
                                    std::span<const DepthMap> /*relative*/, const std::optional<Intrinsics>& known, ThreadPool& pool, Monitor& monitor) {
  SfmOptions sfm_asked = sfm_options(options);
  sfm_asked.intrinsics = known;
  const SfmResult sfm = structure_from_motion(frames, sfm_asked, pool, monitor);
  if (sfm.motion == ClipMotion::moving) return measured(options, frames, sfm, pool, monitor);
  fail(ErrorCode::value_invalid,
       "{}: depth cannot be measured from it: {}; give --depth", options.video, sfm.reason);
}

}  // namespace uwv::pipeline
