// SPDX-License-Identifier: Apache-2.0
#include <limits>

#include "pipeline/contact_sheet.h"
#include "pipeline/stage.h"
#include "uwv/eval/image_metrics.h"
#include "uwv/io/cameras_file.h"
#include "uwv/io/image_file.h"
#include "uwv/render/occlusion.h"

namespace uwv::pipeline {
namespace {

using nlohmann::ordered_json;

constexpr int cell_width = 480;

struct Method {
  std::string name;
  OcclusionOptions options;
};

/// What is compared: no occlusion handling, the official code's splat, and what the options ask for.
std::vector<Method> methods(const Plan& plan) {
  OcclusionOptions ours = plan.occlusion();
  ours.accumulation = Accumulation::none;  // a single camera: nothing to accumulate
  OcclusionOptions naive = ours;
  naive.kernel = Kernel::nearest;
  naive.visibility = Visibility::none;
  naive.normal_filter = false;
  OcclusionOptions official;  // its own settings, whatever is asked of ours
  official.kernel = Kernel::bilinear;
  official.visibility = Visibility::reproject;
  official.accumulation = Accumulation::none;
  official.reliability.enabled = true;
  OcclusionOptions unfiltered = official;
  unfiltered.reliability.enabled = false;
  return {{"naive", naive}, {"official (bilinear)", official}, {"official, unfiltered", unfiltered}, {"ours", ours}};
}

/// JSON has no infinity or NaN.
ordered_json number_or_null(double value) { return std::isfinite(value) ? ordered_json(value) : ordered_json(); }

/// The real picture and the camera it was taken with, at the size the source's policy gives it.
struct Reference {
  ImageRgb picture;
  Camera camera;  ///< In the subject world.
};

Reference read_reference(const Workshop& shop) {
  const RunOptions& options = shop.plan.options;
  ClipOptions first_picture;
  first_picture.max_frames = 1;
  first_picture.resize = resize_policy(options);
  const auto clip = open_clip(options.eval_reference, first_picture, shop.monitor);
  Reference reference;
  if (!clip->read(0, reference.picture))
    fail(ErrorCode::file_damaged, "{}: its first picture cannot be read", options.eval_reference);
  const Size size = reference.picture.size(), full_size = clip->info().source_size;
  const Intrinsics as_source = shop.plan.source->intrinsics(0).resized(shop.plan.size(), full_size);
  const CameraTrack track =
      read_cameras(options.eval_cameras, {.size = full_size, .intrinsics = as_source}, shop.monitor);
  const Camera& camera = track.cameras.front();
  reference.camera = {camera.intrinsics.resized(camera.size, size),
                      shop.plan.context.world.subject_from_cam(camera.world_from_cam), size};
  return reference;
}

RenderedFrame render_at(const Workshop& shop, const SourceData& data, const Camera& camera,
                        const OcclusionOptions& options) {
  OcclusionRenderer renderer(shop.rasterizer, shop.pool, options);
  RenderedFrame frame;
  renderer.render(data.seen_by(shop.plan.source_camera(data.index)), camera, frame);
  return frame;
}

}  // namespace

std::vector<std::string> evaluation_files(const RunOptions&) { return {"reference_comparison.png"}; }

ordered_json make_evaluation(const Workshop& shop, const PartialFolder& into) {
  const auto data = shop.plan.source->read(0);
  if (!data) fail(ErrorCode::file_damaged, "{}: its first frame cannot be read", shop.plan.options.video);
  const Reference reference = read_reference(shop);
  const MetricImage truth(reference.picture);

  const std::vector<Method> tried = methods(shop.plan);
  std::vector<RenderedFrame> frames;
  for (const Method& method : tried) {
    frames.push_back(render_at(shop, *data, reference.camera, method.options));
    shop.monitor.step("evaluation", static_cast<long>(frames.size()), static_cast<long>(tried.size()));
  }
  ValidityMask common = frames.front().valid;
  for (const RenderedFrame& frame : frames) intersect(common, frame.valid);

  constexpr int columns = 3;
  ContactSheet sheet(contact_cell(reference.picture.size(), cell_width), columns, 2);
  sheet.put(0, 0, data->colour, "source");
  sheet.put(1, 0, reference.picture, "real picture");
  ordered_json rows = ordered_json::array();
  for (std::size_t i = 0; i < tried.size(); ++i) {
    const MetricImage rendering(frames[i].colour);
    const double db = psnr(rendering, truth, &frames[i].valid);
    rows.push_back({{"method", tried[i].name},
                    {"psnr", number_or_null(db)},
                    {"ssim", number_or_null(ssim(rendering, truth, &frames[i].valid))},
                    {"valid_share", valid_share(frames[i].valid)},
                    {"psnr_where_all_valid", number_or_null(psnr(rendering, truth, &common))}});
    const int place = static_cast<int>(i) + 2;
    sheet.put(place % columns, place / columns, frames[i].colour, fmt::format("{}: {:.2f} dB", tried[i].name, db));
  }
  write_png(into.file("reference_comparison.png"), sheet.picture());
  return {{"frames", 1}, {"methods", rows}};
}

}  // namespace uwv::pipeline
