// SPDX-License-Identifier: Apache-2.0
// From one frame and its geometry to where another frame was taken, against that frame. Found depth and found cameras
// share their scale, so nothing is aligned. `psnr_common` and `ssim_common` take the pixels all rows of a pair show.
#include "bench/geometry.h"
#include "uwv/eval/image_metrics.h"
#include "uwv/render/occlusion.h"

namespace uwv::bench {
namespace {

/// Depth and cameras by one method.
struct Geometry {
  std::string name;
  std::vector<DepthMap> depths;
  std::vector<Camera> cameras;
};

Geometry stereo(std::string name, const FoundClip& clip, const std::vector<Camera>& cameras,
                std::span<const ScenePoint> points) {
  Monitor monitor;
  std::vector<FrameGeometry> found;
  multi_view_stereo(clip.truth.frames, cameras, points, clip.truth.static_pixels, {}, clip.pool, monitor, found);
  Geometry out{std::move(name), {}, cameras};
  for (FrameGeometry& frame : found) out.depths.push_back(std::move(frame.depth));
  return out;
}

std::vector<Geometry> geometries(const FoundClip& clip) {
  std::vector<Geometry> all;
  all.push_back({"true depth, true cameras", clip.truth.depths, clip.truth.cameras});
  all.push_back(stereo("stereo, true cameras", clip, clip.truth.cameras, true_points(clip.truth)));
  if (clip.known_focal.result.motion == ClipMotion::moving)
    all.push_back(stereo("stereo, known focal", clip, clip.known_focal.result.cameras, clip.known_focal.result.points));
  if (clip.own_focal.result.motion == ClipMotion::moving)
    all.push_back(stereo("stereo, own focal", clip, clip.own_focal.result.cameras, clip.own_focal.result.points));
  return all;
}

RenderedFrame render(const Geometry& geometry, const TrueClip& clip, std::size_t from, std::size_t to,
                     Rasterizer& rasterizer, ThreadPool& pool) {
  OcclusionRenderer renderer(rasterizer, pool, {});
  SourceFrame source;
  source.camera = geometry.cameras[from];
  source.colour = &clip.frames[from];
  source.depth = &geometry.depths[from];
  RenderedFrame out;
  renderer.render(source, geometry.cameras[to], out);
  // What moves is nowhere near where it was.
  if (!clip.static_pixels.empty()) intersect(out.valid, clip.static_pixels[to]);
  return out;
}

}  // namespace

Table view_table(const FoundClip& clip, const BenchOptions& options) {
  Table table("views of " + clip.truth.name, {"pair", "geometry", "psnr", "valid", "psnr_common", "ssim_common"});
  const auto rasterizer = make_cpu_rasterizer(clip.pool);
  const std::vector<Geometry> all = geometries(clip);
  for (const auto& [from, to] : options.pairs) {
    const auto frames = static_cast<long>(clip.truth.frames.size());
    if (from >= frames || to >= frames) {
      fmt::print("views {}:{} left out: the clip has {} frames\n", from, to, frames);
      continue;
    }
    const auto source = static_cast<std::size_t>(from), target = static_cast<std::size_t>(to);
    std::vector<RenderedFrame> pictures;
    for (const Geometry& geometry : all)
      pictures.push_back(render(geometry, clip.truth, source, target, *rasterizer, clip.pool));
    ValidityMask common = pictures.front().valid;
    for (const RenderedFrame& picture : pictures) intersect(common, picture.valid);
    const MetricImage truth(clip.truth.frames[target]);
    for (std::size_t i = 0; i < all.size(); ++i) {
      const MetricImage picture(pictures[i].colour);
      table.add({fmt::format("{}:{}", from, to), all[i].name, figure(psnr(picture, truth, &pictures[i].valid)),
                 valid_share(pictures[i].valid), figure(psnr(picture, truth, &common)),
                 figure(ssim(picture, truth, &common))});
    }
  }
  return table;
}

}  // namespace uwv::bench
