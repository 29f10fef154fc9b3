// SPDX-License-Identifier: Apache-2.0
#include "pipeline/stage.h"
#include "pipeline/thinned_cloud.h"
#include "uwv/io/ply_file.h"
#include "uwv/render/occlusion.h"

namespace uwv::pipeline {
namespace {

/// The frame's reliable points in the world of the source cameras.
PlyCloud lift(const Workshop& shop, const SourceData& data) {
  const OcclusionOptions options = shop.plan.occlusion();
  const Intrinsics& intrinsics = shop.plan.source->intrinsics(data.index);
  const Rigid3 world_from_cam = shop.plan.source->world_from_cam(data.index);
  const bool thins = shop.plan.options.max_error.value_or(0) > 0;
  const ThinnedCloud thinned = thins ? thin_out(shop.plan, data, true, shop.pool) : ThinnedCloud{};
  const ValidityMask keep = thins ? thinned.kept : reliable_depth(data.depth, options.reliability, shop.pool);
  const DepthMap& depth = thins ? thinned.depth : data.depth;
  const SlopeMap slopes = thins         ? thinned.slopes
                          : data.slopes ? *data.slopes
                                        : slopes_from_depth(data.depth, options.slopes, shop.pool);
  PlyCloud cloud;
  for (int y = 0; y < data.depth.height(); ++y)
    for (int x = 0; x < data.depth.width(); ++x) {
      if (keep(x, y) == 0) continue;
      cloud.points.push_back(world_from_cam *
                             unproject(intrinsics, {x + 0.5, y + 0.5}, static_cast<double>(depth(x, y))));
      cloud.colours.push_back(data.colour(x, y));
      cloud.normals.push_back(
          (world_from_cam.rotation * normal_from_slope(slopes(x, y), x, y, intrinsics).cast<double>()).cast<float>());
    }
  return cloud;
}

}  // namespace

void write_point_cloud(const std::string& path, const Workshop& shop, const SourceData& data) {
  write_ply(path, lift(shop, data));
}

}  // namespace uwv::pipeline
