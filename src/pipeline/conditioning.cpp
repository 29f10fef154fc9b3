// SPDX-License-Identifier: Apache-2.0
// Decode, render and encode, each on a thread of its own with short queues between them.
#include <algorithm>
#include <cmath>
#include <future>
#include <map>

#include "pipeline/channel.h"
#include "pipeline/merged_cloud.h"
#include "pipeline/stage.h"
#include "pipeline/thinned_cloud.h"
#include "uwv/io/depth_writer.h"

namespace uwv::pipeline {
namespace {

using nlohmann::ordered_json;

constexpr int encoder_threads = 1;  // frames are rendered meanwhile: the other processors are busy

/// Length of the queues: a few frames even out unequal costs, but large pictures must not pile up.
std::size_t frames_in_flight(Size size) {
  constexpr std::size_t budget = 64U << 20U, bytes_per_pixel = sizeof(Rgb8) + sizeof(float) + 1;
  return std::clamp<std::size_t>(budget / (size.pixels() * bytes_per_pixel), 1, 4);
}

/// A rendered frame on its way to the files.
struct Rendered {
  RenderedFrame frame;
  FrameMasks masks;
};

DepthFormat file_format(DepthOutput output) {
  switch (output) {
    case DepthOutput::png16: return DepthFormat::png16;
    case DepthOutput::exr: return DepthFormat::exr;
    default: return DepthFormat::npz;
  }
}

std::string depth_name(DepthOutput output) {
  switch (output) {
    case DepthOutput::none: return "";
    case DepthOutput::npz: return "depth.npz";
    default: return "depth";
  }
}

/// A power of ten that takes four times the far depth into 16 bits: millimetres for a scene of metres.
double png_scale(double far_depth) {
  return far_depth > 0 ? std::pow(10.0, std::ceil(std::log10(4 * far_depth / 65535))) : DepthWriterOptions{}.png_scale;
}

constexpr const char* mask_names[] = {"mask_first.mp4", "mask_second.mp4", "mask_visible.mp4", "mask_front.mp4"};

/// All files of the stage, written frame by frame.
class ConditioningFiles {
 public:
  ConditioningFiles(const Plan& plan, const PartialFolder& into, Monitor& monitor)
      : colour_(into.file("colour.mp4"), plan.size(), colour_encoding(plan)),
        generate_(into.file("generate_mask.mp4"), plan.size(), mask_encoding(plan)) {
    if (const std::string name = depth_name(plan.options.depth_format); !name.empty())
      depth_ = make_depth_writer(
          into.file(name),
          {.format = file_format(plan.options.depth_format), .png_scale = png_scale(plan.look.far_depth)}, plan.size(),
          0, monitor);
    if (plan.options.save_masks)
      for (const char* name : mask_names) masks_.emplace_back(into.file(name), plan.size(), mask_encoding(plan));
  }

  void write(const Rendered& rendered) {
    colour_.write(rendered.frame.colour);
    generate_.write(to_generate(rendered.frame.valid));
    if (depth_) depth_->write(rendered.frame.depth);
    if (masks_.empty()) return;
    masks_[0].write(rendered.masks.first);
    masks_[1].write(rendered.masks.second);
    masks_[2].write(rendered.masks.visible);
    masks_[3].write(rendered.masks.front);
  }

  void finish() {
    colour_.finish();
    generate_.finish();
    if (depth_) depth_->finish();
    for (VideoWriter& mask : masks_) mask.finish();
  }

 private:
  VideoWriter colour_, generate_;
  std::unique_ptr<DepthWriter> depth_;
  std::vector<VideoWriter> masks_;
};

/// What the reports of all frames add up to.
struct Tally {
  long frames = 0, passes = 0;
  double render_seconds = 0;
  std::size_t valid = 0;
  std::size_t from_background = 0;  ///< Pixels that only the background layer knows.
  MergeTally merged;
  ordered_json thinned = "skipped";
  std::map<std::string, long> skipped;

  void add(const FrameReport& report, const RenderedFrame& frame) {
    ++frames;
    passes += report.passes;
    render_seconds += report.seconds;
    valid += frame.valid.count();
    if (!report.skipped.empty()) ++skipped[report.skipped];
  }
};

/// What is seen from the source's own camera is the source: nothing there is unknown, not even where depth is.
void put_source(const SourceData& data, RenderedFrame& frame) {
  frame.colour = data.colour;
  frame.depth = data.depth;
  frame.valid.fill(1);
}

/// The background behind what was drawn: it shows where the first layer knows nothing. Both were drawn occlusion-aware
/// (composition as in the reference's recon branch, foreground over background).
void put_behind(const RenderedFrame& background, RenderedFrame& frame, std::size_t& shown) {
  for (std::size_t i = 0; i < frame.valid.pixels().size(); ++i) {
    if (frame.valid.pixels()[i] != 0 || background.valid.pixels()[i] == 0) continue;
    frame.colour.pixels()[i] = background.colour.pixels()[i];
    frame.depth.pixels()[i] = background.depth.pixels()[i];
    frame.valid.pixels()[i] = 1;
    ++shown;
  }
}

/// The background holds nothing that moves.
OcclusionOptions background_occlusion(const Plan& plan) {
  OcclusionOptions options = plan.occlusion();
  if (options.accumulation == Accumulation::foreground) options.accumulation = Accumulation::product;
  return options;
}

using SourceChannel = Channel<std::shared_ptr<const SourceData>>;

void read_sources(const Plan& plan, SourceChannel& into) {
  const ChannelCloser closer(into);
  for (const TargetFrame& frame : plan.path.frames) {
    std::shared_ptr<const SourceData> data = plan.source->read(frame.source_frame);
    if (!data || !into.push(std::move(data))) return;
  }
}

void write_files(ConditioningFiles& files, Channel<Rendered>& from) {
  const ChannelCloser closer(from);
  while (const std::optional<Rendered> rendered = from.pop()) files.write(*rendered);
}

Tally render_frames(const Workshop& shop, OtherViews* views, SourceChannel& from, Channel<Rendered>& into) {
  const Plan& plan = shop.plan;
  const ChannelCloser no_more_sources(from);
  const ChannelCloser no_more_frames(into);
  const bool thins = plan.choices.plan.decimate.choice;
  const std::unique_ptr<Rasterizer> cpu = thins ? make_cpu_rasterizer(shop.pool) : nullptr;  // GL draws no cells
  OcclusionRenderer renderer(thins ? *cpu : shop.rasterizer, shop.pool, plan.occlusion());
  Thinning thinning(plan, shop.pool);
  OcclusionRenderer background_renderer(shop.rasterizer, shop.pool, background_occlusion(plan));
  Tally tally;
  shop.monitor.step("conditioning", 0, plan.frames());
  for (const TargetFrame& target : plan.path.frames) {
    const auto source = from.pop();
    if (!source) break;
    Rendered rendered;
    const Camera source_camera = plan.source_camera(target.source_frame);
    const SourceFrame own = (*source)->seen_by(source_camera);
    const FrameReport report =
        renderer.render(thins ? thinning.of(**source).seen_by(source_camera, **source) : own, target.camera,
                        rendered.frame, plan.options.save_masks ? &rendered.masks : nullptr);
    const bool is_source = plan.options.keep_source && WarpMap::between(source_camera, target.camera).identity;
    if (is_source) put_source(**source, rendered.frame);
    if (views != nullptr && !is_source) tally.merged.add(views->fill(own, target.camera, rendered.frame));
    if ((*source)->background && !is_source) {
      RenderedFrame behind;
      background_renderer.render((*source)->background_seen_by(source_camera), target.camera, behind);
      put_behind(behind, rendered.frame, tally.from_background);
    }
    tally.add(report, rendered.frame);
    if (!into.push(std::move(rendered))) break;
    shop.monitor.step("conditioning", tally.frames, plan.frames());
  }
  if (thins) tally.thinned = thinning.to_json();
  return tally;
}

}  // namespace

VideoWriterOptions colour_encoding(const Plan& plan) {
  VideoWriterOptions options;
  options.fps = plan.fps;
  options.crf = plan.options.crf;
  options.threads = encoder_threads;
  return options;
}

VideoWriterOptions mask_encoding(const Plan& plan) {
  VideoWriterOptions options = VideoWriterOptions::for_masks(plan.fps);
  options.threads = encoder_threads;
  return options;
}

std::vector<std::string> conditioning_files(const RunOptions& options) {
  std::vector<std::string> names = {"colour.mp4", "generate_mask.mp4"};
  if (const std::string depth = depth_name(options.depth_format); !depth.empty()) names.push_back(depth);
  if (options.save_masks) names.insert(names.end(), std::begin(mask_names), std::end(mask_names));
  return names;
}

ordered_json make_conditioning(const Workshop& shop, const PartialFolder& into) {
  const Plan& plan = shop.plan;
  ConditioningFiles files(plan, into, shop.monitor);
  MergeTally gathered;
  const std::unique_ptr<OtherViews> views = gather_views(shop, gathered);
  SourceChannel sources(frames_in_flight(plan.size()));
  Channel<Rendered> rendered(frames_in_flight(plan.size()));
  // Whichever of the three fails closes its channels, which ends the other two; get() then rethrows.
  std::future<void> reading = std::async(std::launch::async, [&] { read_sources(plan, sources); });
  std::future<void> writing = std::async(std::launch::async, [&] { write_files(files, rendered); });
  Tally tally = render_frames(shop, views.get(), sources, rendered);
  tally.merged.kept = gathered.kept;
  tally.merged.gather_seconds = gathered.gather_seconds;
  reading.get();
  writing.get();
  if (tally.frames == 0) fail(ErrorCode::file_damaged, "{}: none of its frames could be read", plan.options.video);
  if (tally.frames < plan.frames())
    shop.monitor.warn(fmt::format("{}: ended early, so the result has {} of {} frames", plan.options.video,
                                  tally.frames, plan.frames()));
  files.finish();
  const double pixels = static_cast<double>(tally.frames) * static_cast<double>(plan.size().pixels());
  return {{"frames", tally.frames},
          {"renderer", shop.rasterizer.name()},
          {"reliability", plan.reliability()},
          {"accumulation", plan.accumulation_reason()},
          {"passes", tally.passes},
          {"skipped_passes", tally.skipped},
          {"render_ms_per_frame", 1000 * tally.render_seconds / static_cast<double>(tally.frames)},
          {"valid_share", static_cast<double>(tally.valid) / pixels},
          {"background_share", static_cast<double>(tally.from_background) / pixels},
          {"background_layer", plan.source->has_background() ? "drawn" : "skipped: " + plan.choices.plan.layers.reason},
          {"other_frames", views ? tally.merged.to_json(pixels, tally.frames)
                                 : ordered_json("skipped: " + plan.choices.plan.cloud.reason)},
          {"thinned_points", plan.choices.plan.decimate.choice
                                 ? tally.thinned
                                 : ordered_json("skipped: " + plan.choices.plan.decimate.reason)},
          {"brief", plan.choices.brief()}};
}

}  // namespace uwv::pipeline
