// SPDX-License-Identifier: Apache-2.0
#include "uwv/io/video_writer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <string_view>

#include "io/libav.h"

namespace uwv {
namespace {

constexpr int largest_side = 16384;  // x264's own limit
constexpr std::uint8_t luma_black = 16, luma_white = 235, chroma_grey = 128;

struct OutputDeleter {
  void operator()(AVFormatContext* context) const {
    if (context->pb != nullptr) avio_closep(&context->pb);
    avformat_free_context(context);
  }
};
using Output = std::unique_ptr<AVFormatContext, OutputDeleter>;

// A file that vanishes with its owner until it is declared whole.
struct UnfinishedFile {
  std::string path;
  bool remove_me = false;

  explicit UnfinishedFile(std::string where) : path(std::move(where)) {}
  UnfinishedFile(const UnfinishedFile&) = delete;
  UnfinishedFile& operator=(const UnfinishedFile&) = delete;
  ~UnfinishedFile() {
    std::error_code ignored;
    // Only what we created: a device or pipe named as the output is not ours to remove.
    if (remove_me && std::filesystem::is_regular_file(path, ignored)) std::filesystem::remove(path, ignored);
  }
};

AVPixelFormat pixel_format(Size size) {
  const bool even = size.width % 2 == 0 && size.height % 2 == 0;
  return even ? AV_PIX_FMT_YUV420P : AV_PIX_FMT_YUV444P;
}

int plane_height(const AVFrame& frame, int plane) {
  return plane > 0 && frame.format == AV_PIX_FMT_YUV420P ? frame.height / 2 : frame.height;
}

libav::Codec open_encoder(const std::string& path, Size size, const VideoWriterOptions& options) {
  const AVCodec* codec = avcodec_find_encoder_by_name("libx264");
  if (codec == nullptr)
    fail(ErrorCode::backend_missing, "{}: this FFmpeg has no libx264; install one that has to write video", path);
  libav::Codec context(avcodec_alloc_context3(codec));
  if (!context) throw std::bad_alloc();
  context->width = size.width;
  context->height = size.height;
  context->pix_fmt = pixel_format(size);
  context->framerate = av_d2q(options.fps, 100000);
  context->time_base = av_inv_q(context->framerate);
  context->sample_aspect_ratio = {1, 1};
  context->color_range = AVCOL_RANGE_MPEG;
  context->colorspace = AVCOL_SPC_BT709;
  context->color_primaries = AVCOL_PRI_BT709;
  context->color_trc = AVCOL_TRC_BT709;
  context->chroma_sample_location = AVCHROMA_LOC_LEFT;
  context->thread_count = options.threads;
  context->flags |= AV_CODEC_FLAG_GLOBAL_HEADER | AV_CODEC_FLAG_BITEXACT;
  av_opt_set(context->priv_data, "preset", options.preset.c_str(), 0);
  av_opt_set(context->priv_data, "coder", options.cabac ? "cabac" : "cavlc", 0);
  // x264 spends less on 4:4:4 chroma because there is more of it; this takes its offset of 6 back.
  if (context->pix_fmt == AV_PIX_FMT_YUV444P) av_opt_set_int(context->priv_data, "chromaoffset", -6, 0);
  if (options.lossless)
    av_opt_set_int(context->priv_data, "qp", 0, 0);
  else
    av_opt_set_double(context->priv_data, "crf", options.crf, 0);
  const int opened = avcodec_open2(context.get(), codec, nullptr);
  if (opened < 0)
    fail(ErrorCode::value_invalid, "{}: x264 refuses {}x{} pixels at {} frames per second ({})", path, size.width,
         size.height, options.fps, libav::error_text(opened));
  return context;
}

[[noreturn]] void fail_to_write(const std::string& path, int code) {
  fail(ErrorCode::output_failed, "{}: cannot be written ({}); check the folder, its permissions and the disk", path,
       libav::error_text(code));
}

}  // namespace

VideoWriterOptions VideoWriterOptions::for_masks(double fps) {
  VideoWriterOptions options;
  options.fps = fps;
  options.lossless = true;
  options.preset = "ultrafast";
  return options;
}

void VideoWriterOptions::check() const {
  static constexpr std::array<std::string_view, 10> presets{
      "ultrafast", "superfast", "veryfast", "faster", "fast", "medium", "slow", "slower", "veryslow", "placebo"};
  require(fps >= 0.01 && fps <= 1000, "fps is {}; a number in 0.01..1000 is wanted", fps);
  require(crf >= 0 && crf <= 51, "crf is {}; a number in 0..51 is wanted", crf);
  require(std::find(presets.begin(), presets.end(), preset) != presets.end(),
          "preset is '{}'; one of x264's, ultrafast to placebo, is wanted", preset);
  require(threads >= 0 && threads <= 128, "threads is {}; 0 (automatic) to 128 is wanted", threads);
}

class VideoWriter::Encoder {
 public:
  Encoder(const std::string& path, Size size, const VideoWriterOptions& options)
      : path_(path), options_(options), file_(path), packet_(libav::new_packet()), picture_(libav::new_frame()) {
    libav::quiet_log();
    encoder_ = open_encoder(path, size, options);
    picture_->format = encoder_->pix_fmt;
    picture_->width = size.width;
    picture_->height = size.height;
    if (av_frame_get_buffer(picture_.get(), 0) < 0) throw std::bad_alloc();
    open_file();
  }

  void write_colour(const ImageRgb& frame) {
    require_size(frame.size());
    prepare_picture();
    if (!scaler_) make_scaler();
    const std::uint8_t* rows[4] = {reinterpret_cast<const std::uint8_t*>(frame.data()), nullptr, nullptr, nullptr};
    const int strides[4] = {frame.width() * static_cast<int>(sizeof(Rgb8)), 0, 0, 0};
    sws_scale(scaler_.get(), rows, strides, 0, frame.height(), picture_->data, picture_->linesize);
    encode(picture_.get());
  }

  void write_mask(const Image<std::uint8_t>& mask) {
    require(options_.lossless, "masks need VideoWriterOptions::lossless (see for_masks), or they come back grey");
    require_size(mask.size());
    prepare_picture();
    for (int y = 0; y < mask.height(); ++y)
      std::transform(mask.row(y), mask.row(y) + mask.width(),
                     picture_->data[0] + std::ptrdiff_t{y} * picture_->linesize[0],
                     [](std::uint8_t v) { return v != 0 ? luma_white : luma_black; });
    for (int plane = 1; plane < 3; ++plane)
      std::memset(picture_->data[plane], chroma_grey,
                  static_cast<std::size_t>(picture_->linesize[plane]) *
                      static_cast<std::size_t>(plane_height(*picture_, plane)));
    encode(picture_.get());
  }

  void finish() {
    require(!finished_, "{}: is finished already", path_);
    require(frames_ > 0, "{}: a video without frames cannot be written", path_);
    encode(nullptr);
    int code = av_write_trailer(output_.get());
    if (code >= 0) code = avio_closep(&output_->pb);
    if (code < 0) fail_to_write(path_, code);
    file_.remove_me = false;
    finished_ = true;
  }

 private:
  void open_file() {
    AVFormatContext* context = nullptr;
    if (avformat_alloc_output_context2(&context, nullptr, "mp4", nullptr) < 0)
      fail(ErrorCode::backend_missing, "{}: this FFmpeg cannot write mp4 files", path_);
    output_.reset(context);
    context->flags |= AVFMT_FLAG_BITEXACT;
    AVStream* stream = avformat_new_stream(context, nullptr);
    if (stream == nullptr || avcodec_parameters_from_context(stream->codecpar, encoder_.get()) < 0)
      throw std::bad_alloc();
    stream->time_base = encoder_->time_base;
    stream->avg_frame_rate = encoder_->framerate;
    const std::string url = "file:" + path_;
    int code = avio_open(&context->pb, url.c_str(), AVIO_FLAG_WRITE);
    if (code < 0) fail_to_write(path_, code);
    file_.remove_me = true;
    context->url = av_strdup(url.c_str());  // +faststart reads the file again under this name
    AVDictionary* settings = nullptr;
    av_dict_set(&settings, "movflags", "+faststart", 0);
    code = avformat_write_header(context, &settings);
    av_dict_free(&settings);
    if (code < 0) fail_to_write(path_, code);
  }

  void require_size(Size size) const {
    require(size == Size{encoder_->width, encoder_->height}, "{}: a frame is {}x{} where the video is {}x{}", path_,
            size.width, size.height, encoder_->width, encoder_->height);
    require(!finished_, "{}: is finished already", path_);
  }

  void prepare_picture() {
    if (av_frame_make_writable(picture_.get()) < 0) throw std::bad_alloc();
  }

  void make_scaler() {
    scaler_ = libav::new_scaler(AV_PIX_FMT_RGB24, encoder_->width, encoder_->height, encoder_->pix_fmt, encoder_->width,
                                encoder_->height, AVCHROMA_LOC_LEFT);
    if (!scaler_) fail(ErrorCode::backend_missing, "{}: this FFmpeg cannot convert RGB to YUV", path_);
    const int* bt709 = sws_getCoefficients(SWS_CS_ITU709);
    sws_setColorspaceDetails(scaler_.get(), bt709, 1, bt709, 0, 0, 1 << 16, 1 << 16);
  }

  // Null flushes what the encoder still holds.
  void encode(AVFrame* picture) {
    if (picture != nullptr) picture->pts = frames_++;
    int code = avcodec_send_frame(encoder_.get(), picture);
    while (code >= 0) {
      code = avcodec_receive_packet(encoder_.get(), packet_.get());
      if (code == AVERROR(EAGAIN) || code == AVERROR_EOF) return;
      if (code < 0) break;
      packet_->duration = 1;
      av_packet_rescale_ts(packet_.get(), encoder_->time_base, output_->streams[0]->time_base);
      code = av_interleaved_write_frame(output_.get(), packet_.get());
    }
    fail_to_write(path_, code);
  }

  std::string path_;
  VideoWriterOptions options_;
  UnfinishedFile file_;  // before output_, which closes the file first
  libav::Packet packet_;
  libav::Frame picture_;
  libav::Codec encoder_;
  libav::Scaler scaler_;
  Output output_;
  std::int64_t frames_ = 0;
  bool finished_ = false;
};

VideoWriter::VideoWriter(const std::string& path, Size size, const VideoWriterOptions& options) {
  options.check();
  require(size.width > 0 && size.height > 0, "{}: a video of {}x{} pixels cannot be written", path, size.width,
          size.height);
  if (size.width > largest_side || size.height > largest_side)
    fail(ErrorCode::value_invalid, "{}: {}x{} pixels are wanted; x264 takes at most {} a side", path, size.width,
         size.height, largest_side);
  encoder_ = std::make_unique<Encoder>(path, size, options);
}

VideoWriter::~VideoWriter() = default;
VideoWriter::VideoWriter(VideoWriter&&) noexcept = default;
VideoWriter& VideoWriter::operator=(VideoWriter&&) noexcept = default;

void VideoWriter::write(const ImageRgb& frame) { encoder_->write_colour(frame); }
void VideoWriter::write(const ValidityMask& mask) { encoder_->write_mask(mask); }
void VideoWriter::write(const GenerateMask& mask) { encoder_->write_mask(mask); }
void VideoWriter::finish() { encoder_->finish(); }

}  // namespace uwv
