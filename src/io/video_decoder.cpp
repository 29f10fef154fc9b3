// SPDX-License-Identifier: Apache-2.0
#include "io/video_decoder.h"

namespace uwv {

VideoDecoder::VideoDecoder(const std::string& path, int threads) : demuxer_(path), packet_(libav::new_packet()) {
  const AVCodecParameters* parameters = demuxer_.stream().codecpar;
  const AVCodec* codec = avcodec_find_decoder(parameters->codec_id);
  if (codec == nullptr)
    fail(ErrorCode::format_unknown, "{}: its codec '{}' has no decoder in this FFmpeg; re-encode it as H.264", path,
         avcodec_get_name(parameters->codec_id));
  context_.reset(avcodec_alloc_context3(codec));
  if (!context_ || avcodec_parameters_to_context(context_.get(), parameters) < 0) throw std::bad_alloc();
  context_->thread_count = threads;
  context_->pkt_timebase = demuxer_.stream().time_base;
  context_->max_pixels = std::int64_t{1} << 30;
  const int opened = avcodec_open2(context_.get(), codec, nullptr);
  if (opened < 0)
    fail(ErrorCode::file_damaged, "{}: its {} stream cannot be decoded ({}); re-encode it as H.264", path, codec->name,
         libav::error_text(opened));
}

// Hands the decoder one packet, or the end.
void VideoDecoder::feed() {
  if (!demuxer_.next(*packet_)) {
    draining_ = true;
    avcodec_send_packet(context_.get(), nullptr);
    return;
  }
  const int sent = avcodec_send_packet(context_.get(), packet_.get());
  if (sent < 0 && sent != AVERROR(EAGAIN)) met_damage_ = true;
}

bool VideoDecoder::next(AVFrame& frame) {
  for (;;) {
    const int code = avcodec_receive_frame(context_.get(), &frame);
    if (code >= 0) {
      met_damage_ = met_damage_ || frame.decode_error_flags != 0 || (frame.flags & AV_FRAME_FLAG_CORRUPT) != 0;
      return true;
    }
    if (code == AVERROR_EOF) return false;
    if (code != AVERROR(EAGAIN)) met_damage_ = true;  // this picture is lost; the next packet may be fine
    if (code == AVERROR(EAGAIN) && draining_) return false;
    if (!draining_) feed();
  }
}

}  // namespace uwv
