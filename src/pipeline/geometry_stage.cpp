// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry_stage.h"

#include <vector>

#include "pipeline/clip_foreground.h"
#include "pipeline/fingerprint.h"
#include "pipeline/geometry_estimation.h"
#include "pipeline/geometry_folder.h"
#include "pipeline/source_clip.h"
#include "uwv/io/depth_source.h"
#include "uwv/pipeline/environment.h"
#include "uwv/pipeline/option_table.h"

namespace uwv::pipeline {
namespace {

using nlohmann::ordered_json;

/// The used frames, all of them: matching goes back and forth between any two.
std::vector<ImageRgb> read_all(FrameSource& clip, Monitor& monitor) {
  std::vector<ImageRgb> frames;
  for (long i = 0; i < clip.frames(); ++i) {
    monitor.step("reading", i, clip.frames());
    ImageRgb frame;
    if (!clip.read(i, frame)) break;
    frames.push_back(std::move(frame));
  }
  if (frames.empty()) fail(ErrorCode::file_damaged, "{}: not one frame of it can be read", clip.info().path);
  return frames;
}

/// Depth that is given without scale, one a frame; none where it is not.
std::vector<DepthMap> read_relative(const RunOptions& options, Size size, std::size_t frames, Monitor& monitor) {
  std::vector<DepthMap> relative;
  if (!is_relative(options.depth_kind)) return relative;
  const auto source = open_depth(options.depth,
                                 {.scale = options.depth_scale.value_or(0),
                                  .key = options.depth_key,
                                  .start = options.start,
                                  .stride = options.stride},
                                 monitor);
  for (std::size_t i = 0; i < frames; ++i) {
    DepthMap values;
    if (!source->read(static_cast<long>(i), values))
      fail(ErrorCode::size_mismatch,
           "{}: found depth for {} frames, wanted {}, one per frame of {}; use --max-frames {}", options.depth, i,
           frames, options.video, i);
    relative.push_back(values.size() == size ? std::move(values) : resize_depth(values, size));
  }
  return relative;
}

}  // namespace

std::string geometry_key(const RunOptions& options, const ordered_json& inputs) {
  ordered_json clip = to_json(options, OptionScope::clip), files = inputs;
  clip.erase("video");
  for (const char* name : {"depth_kind", "depth_scale", "depth_key"}) clip[name] = to_json(options)[name];
  clip["background"] = options.layers != LayerChoice::off;  // auto and on differ in what is drawn only
  for (auto& [name, identity] : files.items()) identity.erase("path");
  const std::string saliency = saliency_model_file(options.saliency_model);
  const ordered_json all = {{"stage", geometry_folder_name},
                            {"versions", component_versions()},
                            {"build", build_id()},
                            {"clip", clip},
                            {"options", to_json(options, OptionScope::geometry)},
                            {"saliency", saliency.empty() ? "contrast" : input_identity(saliency)["sha256"]},
                            {"inputs", files}};
  return sha256(all.dump());
}

ordered_json make_geometry(const RunOptions& options, const RunComponents& components, ThreadPool& pool,
                           Monitor& monitor, const PartialFolder& into) {
  const std::unique_ptr<DepthNetwork> network =
      options.depth_model.empty() ? nullptr : components.open_depth_network(options.depth_model);
  const ForegroundNetworks foreground_networks = open_foreground_networks(options, components);
  const auto clip = open_clip(options.video, clip_options(options), monitor);
  const std::vector<ImageRgb> frames = read_all(*clip, monitor);
  std::optional<Intrinsics> known = intrinsics_by_number(options, clip->info().source_size);
  if (known) known = known->resized(clip->info().source_size, clip->info().size);

  const std::vector<DepthMap> relative = read_relative(options, clip->info().size, frames.size(), monitor);
  const EstimatedGeometry estimated =
      estimate_geometry(options, {frames, relative, known, network.get(), foreground_networks}, pool, monitor);
  const GeometryFolder folder{.path = into.file(geometry_folder_name),
                              .start = options.start,
                              .stride = options.stride,
                              .frames = static_cast<long>(frames.size())};
  const double fps = clip->info().fps > 0 ? clip->info().fps / static_cast<double>(options.stride) : 16.0;
  write_geometry_folder(folder, estimated, fps, monitor);
  ordered_json facts = {{"frames", folder.frames}};
  facts.update(estimated.facts);
  return facts;
}

}  // namespace uwv::pipeline
