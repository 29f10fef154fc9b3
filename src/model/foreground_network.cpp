// SPDX-License-Identifier: Apache-2.0
#include "uwv/model/foreground_network.h"

#include <algorithm>
#include <cmath>
#include <thread>

#include "model/map_resize.h"
#include "model/mask_manifest.h"
#include "model/network_input.h"
#include "model/network_output.h"
#include "uwv/core/error.h"

namespace uwv {
namespace {

using namespace model;

int own_threads(int asked) {
  require(asked >= 0 && asked <= 1024, "threads is {}; 0 (all processors) to 1024 is wanted", asked);
  return asked > 0 ? asked : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
}

/// A network's mask as probabilities at the size of the picture.
FloatMap probability(const FloatMap& raw, bool is_logit, Size size) {
  KnownMap map{raw, FloatMap(raw.size(), 1.0F)};
  for (float& value : map.value.pixels()) {
    if (is_logit) value = 1 / (1 + std::exp(-value));
    value = std::isnan(value) ? 0 : std::clamp(value, 0.0F, 1.0F);
  }
  return resized(map, size).value;
}

class TorchForegroundFinder : public ForegroundFinder {
 public:
  TorchForegroundFinder(MaskManifest manifest, const std::string& model_path, int threads)
      : manifest_(std::move(manifest)), module_(model_path), threads_(threads) {}

  std::string name() const override { return manifest_.name; }

  Image<float> find(const ImageRgb& picture) override {
    require(!picture.empty(), "a foreground network needs a picture with pixels");
    const FloatTensor prepared = prepared_frame(manifest_.input, picture);
    const FloatTensor* only = &prepared;
    const FloatTensor input = network_input(manifest_.input, {&only, 1});
    const NetworkOutput output(manifest_, module_.path(), module_.forward(input, manifest_.input.dtype, threads_), 1);
    return probability(output.maps("mask").front(), manifest_.mask_is_logit, picture.size());
  }

 private:
  MaskManifest manifest_;
  ScriptModule module_;
  int threads_;
};

class TorchForegroundTracker : public ForegroundTracker {
 public:
  TorchForegroundTracker(MaskManifest manifest, const std::string& model_path, int threads)
      : manifest_(std::move(manifest)), module_(model_path, 2), threads_(threads) {}

  std::string name() const override { return manifest_.name; }

  std::vector<ForegroundMask> follow(std::span<const ImageRgb> frames, std::span<const PixelIndex> prompts,
                                     Monitor& monitor) override {
    require(!frames.empty() && !frames.front().empty() && !prompts.empty(),
            "a segmenter needs frames with pixels and prompt points; found {} frames, {} points", frames.size(),
            prompts.size());
    const Size size = frames.front().size();
    const FloatTensor clip = prepared_clip(frames);
    std::vector<ForegroundMask> united(frames.size(), ForegroundMask(size));
    const std::size_t at_once = manifest_.prompts == PromptRule::each ? 1 : prompts.size();
    for (std::size_t first = 0; first < prompts.size(); first += at_once) {
      monitor.step("segmenter", static_cast<long>(first), static_cast<long>(prompts.size()));
      const FloatTensor inputs[] = {clip, prompt_tensor(prompts.subspan(first, at_once), size)};
      unite_with(module_.forward(inputs, manifest_.input.dtype, threads_), united);
    }
    return united;
  }

 private:
  FloatTensor prepared_clip(std::span<const ImageRgb> frames) const {
    std::vector<FloatTensor> prepared;
    std::vector<const FloatTensor*> in_order;
    prepared.reserve(frames.size());
    for (const ImageRgb& frame : frames) {
      require(frame.size() == frames.front().size(), "frames of {}x{} and {}x{} are mixed; one size is wanted",
              frames.front().width(), frames.front().height(), frame.width(), frame.height());
      in_order.push_back(&prepared.emplace_back(prepared_frame(manifest_.input, frame)));
    }
    return network_input(manifest_.input, in_order);
  }

  /// Points as the network counts pixels: x, y of its input, centres at whole numbers.
  FloatTensor prompt_tensor(std::span<const PixelIndex> points, Size frame) const {
    const Size input = network_size(manifest_.input, frame);
    FloatTensor tensor;
    tensor.shape = {static_cast<std::int64_t>(points.size()), 2};
    for (const PixelIndex& point : points) {
      tensor.values.push_back((static_cast<float>(point.x) + 0.5F) * static_cast<float>(input.width) /
                                  static_cast<float>(frame.width) -
                              0.5F);
      tensor.values.push_back((static_cast<float>(point.y) + 0.5F) * static_cast<float>(input.height) /
                                  static_cast<float>(frame.height) -
                              0.5F);
    }
    return tensor;
  }

  void unite_with(ModuleOutputs answer, std::vector<ForegroundMask>& united) const {
    const NetworkOutput output(manifest_, module_.path(), std::move(answer), static_cast<int>(united.size()));
    const std::vector<FloatMap> maps = output.maps("mask");
    for (std::size_t i = 0; i < maps.size(); ++i) {
      const FloatMap inside = probability(maps[i], manifest_.mask_is_logit, united[i].size());
      ForegroundMask answered[] = {std::move(united[i]), ForegroundMask(inside.size())};
      for (std::size_t p = 0; p < inside.pixels().size(); ++p)
        answered[1].pixels()[p] = inside.pixels()[p] > static_cast<float>(manifest_.mask_threshold) ? 1 : 0;
      united[i] = unite(answered);
    }
  }

  MaskManifest manifest_;
  ScriptModule module_;
  int threads_;
};

}  // namespace

std::unique_ptr<ForegroundFinder> open_foreground_network(const std::string& folder, int threads) {
  MaskManifest manifest = read_mask_manifest(manifest_in(folder, "a foreground network"), MaskKind::foreground);
  const std::string model_path = locate_model(folder, manifest);
  return std::make_unique<TorchForegroundFinder>(std::move(manifest), model_path, own_threads(threads));
}

std::unique_ptr<ForegroundTracker> open_foreground_tracker(const std::string& folder, int threads) {
  MaskManifest manifest = read_mask_manifest(manifest_in(folder, "a segmenter"), MaskKind::segmenter);
  const std::string model_path = locate_model(folder, manifest);
  return std::make_unique<TorchForegroundTracker>(std::move(manifest), model_path, own_threads(threads));
}

}  // namespace uwv
