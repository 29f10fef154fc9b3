// SPDX-License-Identifier: Apache-2.0
#include "uwv/model/depth_network.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>

#include "model/depth_manifest.h"
#include "model/frame_reading.h"
#include "model/network_input.h"
#include "model/network_output.h"
#include "model/script_module.h"
#include "model/video_windows.h"
#include "uwv/core/depth.h"
#include "uwv/core/peak_memory.h"

namespace uwv {
namespace {

using namespace model;

constexpr std::string_view stage = "depth network";

Size common_size(std::span<const ImageRgb> frames) {
  require(!frames.empty() && !frames[0].empty(), "a depth network needs at least one frame with pixels");
  for (const ImageRgb& frame : frames)
    require(frame.size() == frames[0].size(), "frames of {}x{} and {}x{} are mixed; one size is wanted",
            frames[0].width(), frames[0].height(), frame.width(), frame.height());
  return frames[0].size();
}

class TorchDepthNetwork : public DepthNetwork {
 public:
  TorchDepthNetwork(DepthManifest manifest, const std::string& model_path)
      : manifest_(std::move(manifest)), module_(model_path) {}

  const std::string& name() const override { return manifest_.name; }
  NetworkDepth meaning() const override {
    if (manifest_.kind == NetworkKind::inverse_depth) return NetworkDepth::inverse_affine;
    return manifest_.metric ? NetworkDepth::metric : NetworkDepth::up_to_scale;
  }
  Size input_size(Size frame) const override { return network_size(manifest_.input, frame); }
  DepthNetworkResult run(std::span<const ImageRgb> frames, const DepthNetworkOptions& options, ThreadPool& pool,
                         Monitor& monitor) override;

 private:
  struct Job {
    std::span<const ImageRgb> frames;
    Size size;
    const DepthNetworkOptions& options;
    int threads;
    Monitor& monitor;
    DepthNetworkResult& result;
  };

  std::vector<FrameReading> read_frames(const Job& job, const std::vector<int>& indices);
  std::vector<FrameReading> each_alone(const Job& job);
  std::vector<FrameReading> all_at_once(const Job& job);
  std::vector<FrameReading> in_windows(const Job& job);
  void deliver(const Job& job, std::vector<FrameReading> readings, ThreadPool& pool) const;

  DepthManifest manifest_;
  ScriptModule module_;
};

/// Runs the network once, on these frames of the clip.
std::vector<FrameReading> TorchDepthNetwork::read_frames(const Job& job, const std::vector<int>& indices) {
  std::map<int, FloatTensor> prepared;
  std::vector<const FloatTensor*> in_order;
  for (const int index : indices) {
    const auto [place, is_new] = prepared.try_emplace(index);
    if (is_new) place->second = prepared_frame(manifest_.input, job.frames[static_cast<std::size_t>(index)]);
    in_order.push_back(&place->second);
  }
  const FloatTensor input = network_input(manifest_.input, in_order);
  prepared.clear();
  const NetworkOutput output(manifest_, module_.path(), module_.forward(input, manifest_.input.dtype, job.threads),
                             static_cast<int>(indices.size()));
  return read_output(manifest_, output, {job.size, input_size(job.size), job.options.plain_confidence, module_.path()});
}

std::vector<FrameReading> TorchDepthNetwork::each_alone(const Job& job) {
  std::vector<FrameReading> readings;
  const int count = static_cast<int>(job.frames.size());
  for (int i = 0; i < count; ++i) {
    readings.push_back(std::move(read_frames(job, {i}).front()));
    job.monitor.step(stage, i + 1, count);
  }
  job.result.consistent = job.frames.size() == 1 || meaning() == NetworkDepth::metric;
  return readings;
}

std::vector<FrameReading> TorchDepthNetwork::all_at_once(const Job& job) {
  std::vector<int> indices(job.frames.size());
  for (std::size_t i = 0; i < indices.size(); ++i) indices[i] = static_cast<int>(i);
  job.monitor.step(stage, 0, 1);
  std::vector<FrameReading> readings = read_frames(job, indices);
  job.monitor.step(stage, 1, 1);
  return readings;
}

std::vector<FrameReading> TorchDepthNetwork::in_windows(const Job& job) {
  const int count = static_cast<int>(job.frames.size());
  const auto windows = plan_windows(*manifest_.window, count);
  const bool align = manifest_.kind == NetworkKind::inverse_depth;
  WindowJoiner joiner(*manifest_.window, align);
  double least = 1, most = 1;
  for (std::size_t w = 0; w < windows.size(); ++w) {
    std::vector<KnownMap> maps;
    for (FrameReading& reading : read_frames(job, windows[w])) maps.push_back(std::move(reading.depth));
    const ScaleShift fit = joiner.add(std::move(maps));
    least = std::min(least, fit.scale);
    most = std::max(most, fit.scale);
    job.monitor.step(stage, static_cast<long>(w) + 1, static_cast<long>(windows.size()));
  }
  if (align && windows.size() > 1)
    job.result.notes.push_back(fmt::format("{} windows of {} frames were joined with scales from {:.4g} to {:.4g}",
                                           windows.size(), manifest_.window->frames, least, most));
  std::vector<FrameReading> readings;
  for (KnownMap& map : joiner.take(count)) readings.push_back({std::move(map), {}, {}, {}, 0});
  return readings;
}

/// Brings everything to the frames' size and into the result.
void TorchDepthNetwork::deliver(const Job& job, std::vector<FrameReading> readings, ThreadPool& pool) const {
  DepthNetworkResult& result = job.result;
  const int count = static_cast<int>(readings.size());
  const bool has_normals = !readings.front().normals.empty();
  result.frames.resize(readings.size());
  if (has_normals) result.normals.resize(readings.size());
  pool.for_ranges(0, count, 1, [&](int from, int to) {
    for (std::size_t i = static_cast<std::size_t>(from); i < static_cast<std::size_t>(to); ++i) {
      KnownMap map = resized(readings[i].depth, job.size);
      if (manifest_.kind != NetworkKind::inverse_depth) sanitize_depth(map.value);
      for (std::size_t p = 0; p < map.value.pixels().size() && manifest_.kind != NetworkKind::inverse_depth; ++p)
        if (map.value.data()[p] == 0) map.confidence.data()[p] = 0;
      result.frames[i] = {std::move(map.value), std::move(map.confidence)};
      if (has_normals) result.normals[i] = resized_directions(readings[i].normals, job.size);
      readings[i].depth = {};
      readings[i].normals = {};
    }
  });
  for (const FrameReading& reading : readings) {
    if (reading.intrinsics) result.intrinsics.push_back(*reading.intrinsics);
    if (reading.world_from_cam)
      result.world_from_cam.push_back(readings.front().world_from_cam->inverse() * *reading.world_from_cam);
  }
  if (!result.world_from_cam.empty()) result.world_from_cam.front() = {};
  if (manifest_.one_field_of_view && !result.intrinsics.empty())
    std::fill(result.intrinsics.begin(), result.intrinsics.end(), result.intrinsics.front());
}

/// What the user should know of the numbers: nothing known at all, much that was not finite, a shaky focal length.
void remark(const std::vector<FrameReading>& readings, DepthNetworkResult& result, Monitor& monitor) {
  std::size_t broken = 0, pixels = 0, empty = 0, shaky = 0;
  for (const FrameReading& reading : readings) {
    const auto known = reading.depth.confidence.pixels();
    broken += reading.not_finite;
    pixels += known.size();
    shaky += reading.shift_unknown ? 1 : 0;
    empty += std::none_of(known.begin(), known.end(), [](float c) { return c > 0; }) ? 1 : 0;
  }
  const auto say = [&](std::string sentence) {
    monitor.warn(sentence);
    result.notes.push_back(std::move(sentence));
  };
  if (empty > 0) say(fmt::format("the depth network knows no depth at all in {} of {} frames", empty, readings.size()));
  if (broken > 0)
    say(fmt::format("the depth network gave NaN or infinity for {} of {} pixels; they are unknown", broken, pixels));
  if (shaky > 0)
    say(fmt::format("in {} of {} frames all points lie at one depth, so the focal length is a guess of the network's",
                    shaky, readings.size()));
}

DepthNetworkResult TorchDepthNetwork::run(std::span<const ImageRgb> frames, const DepthNetworkOptions& options,
                                          ThreadPool& pool, Monitor& monitor) {
  options.check();
  const auto start = std::chrono::steady_clock::now();
  DepthNetworkResult result;
  result.meaning = meaning();
  const Job job{frames, common_size(frames), options, options.threads > 0 ? options.threads : pool.size(), monitor,
                result};
  std::vector<FrameReading> readings = manifest_.window                ? in_windows(job)
                                       : manifest_.input.takes_clips() ? all_at_once(job)
                                                                       : each_alone(job);
  remark(readings, result, monitor);
  deliver(job, std::move(readings), pool);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  result.peak_bytes = peak_memory();
  return result;
}

}  // namespace

std::string_view to_string(NetworkDepth meaning) {
  switch (meaning) {
    case NetworkDepth::metric: return "metric";
    case NetworkDepth::up_to_scale: return "up_to_scale";
    case NetworkDepth::inverse_affine: return "inverse_affine";
  }
  return "?";
}

void DepthNetworkOptions::check() const {
  require(threads >= 0 && threads <= 1024, "threads is {}; 0 (as many as the pool) to 1024 is wanted", threads);
  require(plain_confidence > 0 && plain_confidence <= 1, "plain_confidence is {}; a number in (0, 1] is wanted",
          plain_confidence);
}

std::unique_ptr<DepthNetwork> open_depth_network(const std::string& folder) {
  DepthManifest manifest = read_depth_manifest(manifest_in(folder, "a depth network"));
  const std::string model_path = locate_model(folder, manifest);
  return std::make_unique<TorchDepthNetwork>(std::move(manifest), model_path);
}

}  // namespace uwv
