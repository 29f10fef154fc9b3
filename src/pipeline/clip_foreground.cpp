// SPDX-License-Identifier: Apache-2.0
#include "pipeline/clip_foreground.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "pipeline/given_pictures.h"
#include "uwv/geometry/foreground_propagation.h"
#include "uwv/geometry/saliency.h"

namespace uwv::pipeline {
namespace {

namespace fs = std::filesystem;

ClipForeground given_masks(const RunOptions& options, std::size_t frames, Size size, Monitor& monitor) {
  ClipForeground foreground;
  foreground.note = "masks given by --foreground";
  for (const ImageRgb& picture :
       read_given_pictures(options.foreground, "foreground mask", options, frames, size, monitor))
    foreground.masks.push_back(foreground_from_picture(picture, size, options.foreground).mask);
  return foreground;
}

Foreground first_foreground(const ForegroundNetworks& networks, const ImageRgb& picture) {
  if (networks.finder) return find_foreground(picture, *networks.finder);
  const std::string file = saliency_model_file("");
  const auto finder = file.empty() ? make_contrast_finder() : make_saliency_network(file);
  return find_foreground(picture, *finder);
}

/// Asks at points inside the first mask, as the official code does; leaves no masks where there is none to ask at.
void follow_by_network(ForegroundTracker& tracker, std::span<const ImageRgb> frames, const ForegroundMask& first,
                       Monitor& monitor, ClipForeground& foreground) {
  const std::vector<PixelIndex> prompts = prompt_points(first);
  if (prompts.empty()) {
    foreground.note += "; it is too thin for prompt points, so flow follows it instead of " + tracker.name();
    return;
  }
  foreground.masks = tracker.follow(frames, prompts, monitor);
  for (ForegroundMask& mask : foreground.masks) mask = close_gaps(mask);
  foreground.note += fmt::format("; followed by {} from {} points", tracker.name(), prompts.size());
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

ForegroundNetworks open_foreground_networks(const RunOptions& options, const RunComponents& components) {
  ForegroundNetworks networks;
  if (fs::is_directory(options.saliency_model))
    networks.finder = components.open_foreground_network(options.saliency_model);
  else if (!options.saliency_model.empty())
    networks.finder = make_saliency_network(options.saliency_model);
  if (!options.segmenter.empty()) networks.tracker = components.open_foreground_tracker(options.segmenter);
  return networks;
}

ClipForeground find_clip_foreground(const RunOptions& options, const ForegroundNetworks& networks,
                                    std::span<const ImageRgb> frames, ThreadPool& pool, Monitor& monitor) {
  if (!options.foreground.empty()) return given_masks(options, frames.size(), frames.front().size(), monitor);
  monitor.step("foreground", 0, static_cast<long>(frames.size()));
  const Foreground first = first_foreground(networks, frames.front());
  ClipForeground foreground;
  foreground.note = first.note;
  if (first.mask.count() == 0) return foreground;
  if (frames.size() == 1) return foreground.masks = {first.mask}, foreground;
  if (networks.tracker) follow_by_network(*networks.tracker, frames, first.mask, monitor, foreground);
  if (!foreground.masks.empty()) return foreground;
  const PropagationResult followed = propagate_foreground(frames, first.mask, nullptr, {}, pool, monitor);
  foreground.masks = followed.masks;
  for (const std::string& note : followed.notes) foreground.note += "; " + note;
  return foreground;
}

}  // namespace uwv::pipeline
