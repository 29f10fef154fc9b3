// SPDX-License-Identifier: Apache-2.0
#include "pipeline/contact_sheet.h"
#include "pipeline/stage.h"
#include "pipeline/whole_clip.h"
#include "uwv/io/cameras_file.h"
#include "uwv/io/image_file.h"
#include "uwv/render/occlusion.h"

namespace uwv::pipeline {
namespace {

using nlohmann::ordered_json;

constexpr int cell_width = 416;  // half the model's picture: five columns stay readable on a screen

/// The plain point cloud rendering that the paper's Algorithm 1 is compared with.
ImageRgb naive_rendering(const Workshop& shop, const SourceData& data, const TargetFrame& target) {
  OcclusionOptions options = shop.plan.occlusion();
  options.kernel = Kernel::nearest;
  options.visibility = Visibility::none;
  options.accumulation = Accumulation::none;
  options.normal_filter = false;
  OcclusionRenderer renderer(shop.rasterizer, shop.pool, options);
  RenderedFrame frame;
  renderer.render(data.seen_by(shop.plan.source_camera(data.index)), target.camera, frame);
  return frame.colour;
}

void make_contact_sheet(const Workshop& shop, const OutputFolder& from, const PartialFolder& into) {
  const auto colour = open_whole_clip(from.file("colour.mp4"), shop.monitor);
  const auto mask = open_whole_clip(from.file("generate_mask.mp4"), shop.monitor);
  const long frames = std::min(colour->frames(), shop.plan.frames());
  const int columns = static_cast<int>(std::min<long>(shop.plan.options.contact_sheet, frames));
  ContactSheet sheet(contact_cell(shop.plan.size(), cell_width), columns, 4);
  ImageRgb picture;
  for (int column = 0; column < columns; ++column) {
    const long k = columns == 1 ? frames - 1 : column * (frames - 1) / (columns - 1);
    const TargetFrame& target = shop.plan.path.frames[static_cast<std::size_t>(k)];
    const auto source = shop.plan.source->read(target.source_frame);
    if (!source) break;
    sheet.put(column, 0, source->colour, fmt::format("source frame {}", target.source_frame));
    sheet.put(column, 1, naive_rendering(shop, *source, target), fmt::format("naive, frame {}", k));
    if (colour->read(k, picture)) sheet.put(column, 2, picture, fmt::format("occlusion-aware, frame {}", k));
    if (mask->read(k, picture)) sheet.put(column, 3, picture, "to generate (white)");
    shop.monitor.step("presentation", column + 1, columns);
  }
  write_png(into.file("contact_sheet.png"), sheet.picture());
}

CameraTrack source_track(const Plan& plan) {
  CameraTrack track;
  for (long i = 0; i < plan.source->frames(); ++i) {
    track.cameras.push_back({plan.source->intrinsics(i), plan.source->world_from_cam(i), plan.size()});
    track.times.push_back(static_cast<double>(i) / plan.fps);
  }
  return track;
}

CameraTrack target_track(const Plan& plan) {
  CameraTrack track;
  for (const TargetFrame& frame : plan.path.frames) {
    track.times.push_back(static_cast<double>(track.cameras.size()) / plan.fps);
    track.cameras.push_back(plan.in_source_world(frame.camera));
  }
  return track;
}

std::string cloud_name(long frame) { return fmt::format("points_{:05}.ply", frame); }

}  // namespace

std::vector<std::string> presentation_files(const RunOptions& options) {
  std::vector<std::string> names = {"cameras_source.json", "cameras_target.json"};
  if (options.contact_sheet > 0) names.emplace_back("contact_sheet.png");
  for (const long frame : options.ply) names.push_back(cloud_name(frame));
  return names;
}

ordered_json make_presentation(const Workshop& shop, const OutputFolder& from, const PartialFolder& into) {
  const RunOptions& options = shop.plan.options;
  shop.monitor.step("presentation", 0, 0);
  write_cameras(into.file("cameras_source.json"), source_track(shop.plan), CamerasFormat::uwv);
  write_cameras(into.file("cameras_target.json"), target_track(shop.plan), CamerasFormat::uwv);
  if (options.contact_sheet > 0) make_contact_sheet(shop, from, into);
  for (const long frame : options.ply) {
    const auto data = shop.plan.source->read(frame);
    if (!data) fail(ErrorCode::file_damaged, "{}: ends before frame {} asked for by --ply", options.video, frame);
    write_point_cloud(into.file(cloud_name(frame)), shop, *data);
  }
  return {{"point_clouds", options.ply.size()}};
}

}  // namespace uwv::pipeline
