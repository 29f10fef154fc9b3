// SPDX-License-Identifier: Apache-2.0
#include "io/video_source.h"

#include <limits>

#include "io/clip_range.h"
#include "io/frame_converter.h"
#include "io/libav_versions.h"
#include "io/video_decoder.h"

namespace uwv {
namespace {

constexpr int largest_side = 65535;

// FFmpeg names its demuxers of single pictures "..._pipe".
bool is_picture_container(const std::string& container) {
  return container == "gif" || container == "apng" || container.ends_with("_pipe");
}

bool is_square(AVRational pixel) { return pixel.num <= 0 || pixel.den <= 0 || pixel.num == pixel.den; }

std::string describe(const std::string& codec, const AVFrame& frame) {
  const char* format = av_get_pix_fmt_name(static_cast<AVPixelFormat>(frame.format));
  const ColourSystem colours = ColourSystem::of(frame);
  return fmt::format("{} {} {} {}", codec, format != nullptr ? format : "?", av_color_space_name(colours.matrix),
                     colours.full_range ? "full" : "limited");
}

class VideoSource final : public FrameSource {
 public:
  VideoSource(const std::string& path, const ClipOptions& options, Monitor& monitor)
      : options_(options), monitor_(monitor), frame_(libav::new_frame()) {
    info_.path = path;
    const PacketScan scan = scan_packets(path, clip_range::last_needed(options), monitor);
    restart();
    if (!advance())
      fail(ErrorCode::file_damaged, "{}: not one frame of it can be decoded; a whole video file is wanted", path);
    fill_info(scan);
    frames_ = clip_range::taken(std::max(scan.frames, 1L), options, path);
    if (scan.cut_short) warn("is cut short or damaged: only its first {} frames are readable", scan.frames);
    warned_of_damage_ = scan.cut_short;
    warn_of_what_is_lost();
  }

  const ClipInfo& info() const override { return info_; }
  long frames() const override { return frames_; }

  bool read(long index, ImageRgb& out) override {
    clip_range::require_index(index, frames_);
    const long wanted = options_.start + index * options_.stride;
    if (wanted < decoded_ - 1) restart();
    while (decoded_ - 1 < wanted)
      if (!advance()) return shrink_to_decoded();
    converter_->convert(*frame_, info_.path, out);
    return true;
  }

 private:
  template <class... Args>
  void warn(fmt::format_string<Args...> format, Args&&... args) {
    monitor_.warn(info_.path + " " + fmt::format(format, std::forward<Args>(args)...));
  }

  void restart() {
    decoder_.emplace(info_.path, options_.threads);
    decoded_ = 0;
  }

  // Decodes one frame further; the previous one stays in frame_ when there is no other.
  bool advance() {
    libav::Frame next = libav::new_frame();
    if (!decoder_->next(*next)) return false;
    frame_ = std::move(next);
    ++decoded_;
    if (decoder_->met_damage() && !warned_of_damage_) {
      warn("is damaged: frame {} or one just after it was decoded with errors", decoded_ - 1);
      warned_of_damage_ = true;
    }
    return true;
  }

  bool shrink_to_decoded() {
    frames_ = clip_range::taken(decoded_, options_, info_.path);
    if (!warned_of_damage_) warn("ends after {} frames, earlier than its packets promise; it may be damaged", decoded_);
    warned_of_damage_ = true;
    return false;
  }

  void fill_info(const PacketScan& scan) {
    const Size stored{frame_->width, frame_->height};
    if (stored.width > largest_side || stored.height > largest_side)
      fail(ErrorCode::value_invalid, "{}: is {}x{} pixels; at most {} a side are accepted", info_.path, stored.width,
           stored.height, largest_side);
    const std::optional<libav::DisplayMatrix> matrix = libav::display_matrix(decoder_->demuxer().stream());
    const std::optional<Orientation> orientation = matrix ? orientation_of(*matrix) : Orientation{};
    if (!orientation) warn("asks to be turned by an angle that is no quarter turn; it is shown as stored");
    info_.format = describe(decoder_->codec(), *frame_);
    info_.source_size = orientation.value_or(Orientation{}).shown(stored);
    info_.size = target_size(info_.source_size, options_.resize);
    info_.is_photo = scan.frames <= 1 && is_picture_container(decoder_->demuxer().container());
    info_.fps = info_.is_photo ? 0.0 : decoder_->demuxer().frames_per_second();
    info_.variable_frame_rate = scan.variable_frame_rate;
    converter_.emplace(info_.size, orientation.value_or(Orientation{}));
  }

  void warn_of_what_is_lost() {
    const AVStream& stream = decoder_->demuxer().stream();
    const AVRational pixel =
        frame_->sample_aspect_ratio.num > 0 ? frame_->sample_aspect_ratio : stream.sample_aspect_ratio;
    if (!is_square(pixel))
      warn("has pixels of aspect {}:{}, which are taken as square; rescale it first if shapes matter", pixel.num,
           pixel.den);
    if (info_.variable_frame_rate)
      warn("has a variable frame rate; its frames are taken one by one as if they were evenly spaced");
    if (libav::is_interlaced(*frame_)) warn("is interlaced; its fields are not separated, deinterlace it first");
    if (frame_->color_trc == AVCOL_TRC_SMPTE2084 || frame_->color_trc == AVCOL_TRC_ARIB_STD_B67)
      warn("is HDR ({}); it is not tone-mapped, so colours look flat", av_color_transfer_name(frame_->color_trc));
    if (ColourSystem::of(*frame_).matrix_unsupported)
      warn("has the colour matrix '{}', which is read as bt709", av_color_space_name(frame_->colorspace));
  }

  ClipOptions options_;
  Monitor& monitor_;
  ClipInfo info_;
  std::optional<VideoDecoder> decoder_;
  std::optional<FrameConverter> converter_;
  libav::Frame frame_;  // source frame decoded_ - 1
  long decoded_ = 0;
  long frames_ = 0;
  bool warned_of_damage_ = false;
};

}  // namespace

std::unique_ptr<FrameSource> open_video(const std::string& path, const ClipOptions& options, Monitor& monitor) {
  return std::make_unique<VideoSource>(path, options, monitor);
}

}  // namespace uwv
