// SPDX-License-Identifier: Apache-2.0
#include "pipeline/stage.h"
#include "pipeline/whole_clip.h"
#include "uwv/io/image_file.h"

namespace uwv::pipeline {
namespace {

using nlohmann::ordered_json;

ordered_json to_json(const CompletionSummary& summary, const ModelOptions& options) {
  ordered_json stages = ordered_json::array();
  for (const CompletionStage& stage : summary.stages)
    stages.push_back({{"name", stage.name}, {"seconds", stage.seconds}, {"peak_bytes", stage.peak_bytes}});
  return {{"method", summary.model_was_run ? "video diffusion model" : "nothing to generate"},
          {"seed", options.seed},
          {"steps", summary.steps},
          {"seconds_per_step", summary.step_seconds},
          {"windows", summary.windows},
          {"passes", summary.passes},
          {"passes_left_out", summary.skipped_passes},
          {"parts", stages},
          {"choices", summary.choices},
          {"skipped", summary.skipped},
          {"brief", summary.brief()}};
}

/// The conditioning as it was written, read back frame by frame.
class WrittenConditioning {
 public:
  WrittenConditioning(const Workshop& shop, const OutputFolder& from)
      : folder_(from.path().string()),
        colour_(open_whole_clip(from.file("colour.mp4"), shop.monitor)),
        mask_(open_whole_clip(from.file("generate_mask.mp4"), shop.monitor)) {}

  long frames() const { return colour_->frames(); }
  void read(long k, ImageRgb& colour, GenerateMask& holes) {
    if (!colour_->read(k, colour) || !mask_->read(k, picture_))
      fail(ErrorCode::file_damaged, "{}: frame {} of the conditioning cannot be read back; pass --overwrite", folder_,
           k);
    holes.resize(picture_.size());
    for (std::size_t i = 0; i < picture_.size().pixels(); ++i) holes.data()[i] = picture_.data()[i].g > 127 ? 1 : 0;
  }

 private:
  std::string folder_;
  std::unique_ptr<FrameSource> colour_, mask_;
  ImageRgb picture_;
};

}  // namespace

ordered_json make_model_completion(const Workshop& shop, const OutputFolder& from, const PartialFolder& into) {
  const Plan& plan = shop.plan;
  WrittenConditioning conditioning(shop, from);
  RenderedClip clip;
  clip.size = plan.size();
  clip.frames = std::min(conditioning.frames(), plan.frames());
  clip.read = [&](long k, ImageRgb& colour, GenerateMask& holes) { conditioning.read(k, colour, holes); };
  if (!plan.source->info().is_photo)
    clip.read_source = [&](long k, ImageRgb& colour) {
      const long frame = plan.path.frames[static_cast<std::size_t>(k)].source_frame;
      const auto data = plan.source->read(frame);
      if (!data) fail(ErrorCode::file_damaged, "{}: frame {} cannot be read any more", plan.options.video, frame);
      colour = data->colour;
    };
  VideoWriter result(into.file("result.mp4"), plan.size(), colour_encoding(plan));
  CompletedClip out;
  out.write = [&](long, const ImageRgb& picture) { result.write(picture); };
  if (plan.options.diffusion.preview)
    out.preview = [&](const ImageRgb& picture) { write_png(into.file("preview.png"), picture); };
  const CompletionSummary summary =
      shop.components.complete_views(plan.options.diffusion, clip, out, plan.options.threads, shop.monitor);
  result.finish();
  ordered_json facts = {{"frames", clip.frames}};
  facts.update(to_json(summary, plan.options.diffusion));
  return facts;
}

}  // namespace uwv::pipeline
