// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry_stage.h"

#include <vector>

#include "pipeline/fingerprint.h"
#include "pipeline/geometry_estimation.h"
#include "pipeline/geometry_folder.h"
#include "pipeline/source_clip.h"
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

}  // namespace

std::string geometry_key(const RunOptions& options, const ordered_json& video) {
  ordered_json clip = to_json(options, OptionScope::clip), file = video;
  clip.erase("video");
  file.erase("path");
  const ordered_json all = {{"stage", geometry_folder_name},
                            {"versions", component_versions()},
                            {"build", build_id()},
                            {"clip", clip},
                            {"options", to_json(options, OptionScope::geometry)},
                            {"video", file}};
  return sha256(all.dump());
}

ordered_json make_geometry(const RunOptions& options, ThreadPool& pool, Monitor& monitor, const PartialFolder& into) {
  const auto clip = open_clip(options.video, clip_options(options), monitor);
  const std::vector<ImageRgb> frames = read_all(*clip, monitor);
  std::optional<Intrinsics> known = intrinsics_by_number(options, clip->info().source_size);
  if (known) known = known->resized(clip->info().source_size, clip->info().size);

  const EstimatedGeometry estimated = estimate_geometry(options, frames, known, pool, monitor);
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
