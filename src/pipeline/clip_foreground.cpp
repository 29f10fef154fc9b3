// SPDX-License-Identifier: Apache-2.0
#include "pipeline/clip_foreground.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "pipeline/source_clip.h"
#include "uwv/geometry/foreground_propagation.h"
#include "uwv/geometry/saliency.h"

namespace uwv::pipeline {
namespace {

namespace fs = std::filesystem;

std::unique_ptr<ForegroundFinder> make_finder(const RunOptions& options) {
  const std::string file = saliency_model_file(options.saliency_model);
  return file.empty() ? make_contrast_finder() : make_saliency_network(file);
}

ClipForeground given_masks(const RunOptions& options, std::size_t frames, Size size, Monitor& monitor) {
  ClipOptions as_clip = clip_options(options);
  as_clip.resize = {.mode = ResizePolicy::Mode::exact, .exact = size};
  const auto clip = open_clip(options.foreground, as_clip, monitor);
  ClipForeground foreground;
  foreground.note = "masks given by --foreground";
  for (std::size_t i = 0; i < frames; ++i) {
    ImageRgb picture;
    if (static_cast<long>(i) >= clip->frames() || !clip->read(static_cast<long>(i), picture))
      fail(ErrorCode::size_mismatch, "{}: found {} foreground masks, wanted {}, one per frame of {}",
           options.foreground, i, frames, options.video);
    foreground.masks.push_back(foreground_from_picture(picture, size, options.foreground).mask);
  }
  return foreground;
}

}  // namespace

std::string saliency_model_file(const std::string& option) {
  if (!option.empty()) return option;
  std::vector<fs::path> folders;
  if (const char* models = std::getenv("UWV_MODELS")) folders.emplace_back(models);
  folders.emplace_back(".cache/models");
  std::error_code unknown;
  const fs::path program = fs::read_symlink("/proc/self/exe", unknown);
  if (!unknown) folders.push_back(program.parent_path() / "../../../.cache/models");  // build/<preset>/apps
  for (const fs::path& folder : folders)
    if (fs::exists(folder / "u2netp.onnx")) return (folder / "u2netp.onnx").string();
  return "";
}

ClipForeground find_clip_foreground(const RunOptions& options, std::span<const ImageRgb> frames, ThreadPool& pool,
                                    Monitor& monitor) {
  if (!options.foreground.empty()) return given_masks(options, frames.size(), frames.front().size(), monitor);
  const auto finder = make_finder(options);
  monitor.step("foreground", 0, static_cast<long>(frames.size()));
  const Foreground first = find_foreground(frames.front(), *finder);
  ClipForeground foreground;
  foreground.note = first.note;
  if (first.mask.count() == 0) return foreground;
  if (frames.size() == 1) return foreground.masks = {first.mask}, foreground;
  const PropagationResult followed = propagate_foreground(frames, first.mask, nullptr, {}, pool, monitor);
  foreground.masks = followed.masks;
  for (const std::string& note : followed.notes) foreground.note += "; " + note;
  return foreground;
}

}  // namespace uwv::pipeline
