// SPDX-License-Identifier: Apache-2.0
#include "io/image_sequence.h"

#include "io/clip_range.h"
#include "uwv/io/image_file.h"

namespace uwv {
namespace {

class PictureSource final : public FrameSource {
 public:
  PictureSource(const std::string& path, std::vector<std::string> files, const ClipOptions& options)
      : options_(options), files_(std::move(files)) {
    frames_ = clip_range::taken(static_cast<long>(files_.size()), options, path);
    info_.path = path;
    info_.format = files_.size() == 1 ? "picture" : fmt::format("{} pictures", files_.size());
    info_.is_photo = files_.size() == 1;
    info_.source_size = read_image(file(0)).size();
    info_.size = target_size(info_.source_size, options.resize);
  }

  const ClipInfo& info() const override { return info_; }
  long frames() const override { return frames_; }

  bool read(long index, ImageRgb& out) override {
    clip_range::require_index(index, frames_);
    ImageRgb picture = read_image(file(index));
    if (picture.size() != info_.source_size)
      fail(ErrorCode::size_mismatch, "{}: is {}x{} pixels where {}x{} is wanted, the size of {}", file(index),
           picture.width(), picture.height(), info_.source_size.width, info_.source_size.height, file(0));
    out = picture.size() == info_.size ? std::move(picture) : resize(picture, info_.size);
    return true;
  }

 private:
  const std::string& file(long index) const {
    return files_[static_cast<std::size_t>(options_.start + index * options_.stride)];
  }

  ClipOptions options_;
  std::vector<std::string> files_;
  ClipInfo info_;
  long frames_ = 0;
};

}  // namespace

std::unique_ptr<FrameSource> open_pictures(const std::string& path, std::vector<std::string> files,
                                           const ClipOptions& options) {
  return std::make_unique<PictureSource>(path, std::move(files), options);
}

}  // namespace uwv
