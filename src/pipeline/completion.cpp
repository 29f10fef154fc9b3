// SPDX-License-Identifier: Apache-2.0
#include <opencv2/photo.hpp>

#include "pipeline/stage.h"
#include "pipeline/whole_clip.h"

namespace uwv::pipeline {
namespace {

constexpr double inpaint_radius = 3;  // neighbours a filled pixel looks at; larger only blurs more

/// cv::Mat headers over our pictures; nothing is copied.
cv::Mat as_mat(ImageRgb& picture) { return {picture.height(), picture.width(), CV_8UC3, picture.data()}; }

/// Fills what is white in `hole` (A. Telea, "An image inpainting technique based on the fast marching method", 2004).
void fill_holes(ImageRgb& picture, const ImageRgb& hole) {
  cv::Mat mask(hole.height(), hole.width(), CV_8UC1);
  for (int y = 0; y < hole.height(); ++y)
    for (int x = 0; x < hole.width(); ++x) mask.at<std::uint8_t>(y, x) = hole(x, y).g > 127 ? 255 : 0;
  const int holes = cv::countNonZero(mask);
  if (holes == 0 || holes == mask.rows * mask.cols) return;  // with nothing known there is nothing to go by
  cv::Mat filled;
  cv::inpaint(as_mat(picture), mask, filled, inpaint_radius, cv::INPAINT_TELEA);
  filled.copyTo(as_mat(picture));
}

}  // namespace

std::vector<std::string> completion_files(const RunOptions& options) {
  std::vector<std::string> files = {"result.mp4"};
  if (completion_of(options) == Completion::model && options.diffusion.preview) files.emplace_back("preview.png");
  return files;
}

nlohmann::ordered_json make_completion(const Workshop& shop, const OutputFolder& from, const PartialFolder& into) {
  return completion_of(shop.plan.options) == Completion::model ? make_model_completion(shop, from, into)
                                                               : make_draft_completion(shop, from, into);
}

nlohmann::ordered_json make_draft_completion(const Workshop& shop, const OutputFolder& from,
                                             const PartialFolder& into) {
  const auto colour = open_whole_clip(from.file("colour.mp4"), shop.monitor);
  const auto mask = open_whole_clip(from.file("generate_mask.mp4"), shop.monitor);
  VideoWriter result(into.file("result.mp4"), shop.plan.size(), colour_encoding(shop.plan));
  const int batch = shop.pool.size();
  std::vector<ImageRgb> pictures(static_cast<std::size_t>(batch)), holes(static_cast<std::size_t>(batch));
  const long frames = colour->frames();
  shop.monitor.step("completion", 0, frames);
  for (long first = 0; first < frames; first += batch) {
    const int count = static_cast<int>(std::min<long>(batch, frames - first));
    for (int i = 0; i < count; ++i)
      if (!colour->read(first + i, pictures[static_cast<std::size_t>(i)]) ||
          !mask->read(first + i, holes[static_cast<std::size_t>(i)]))
        fail(ErrorCode::file_damaged, "{}: frame {} of the conditioning cannot be read back; pass --overwrite",
             from.path().string(), first + i);
    shop.pool.run(
        count, [&](int i) { fill_holes(pictures[static_cast<std::size_t>(i)], holes[static_cast<std::size_t>(i)]); });
    for (int i = 0; i < count; ++i) result.write(pictures[static_cast<std::size_t>(i)]);
    shop.monitor.step("completion", first + count, frames);
  }
  result.finish();
  return {{"frames", frames}, {"method", "inpaint (Telea 2004), frame by frame"}};
}

}  // namespace uwv::pipeline
