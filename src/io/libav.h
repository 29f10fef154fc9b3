// SPDX-License-Identifier: Apache-2.0
// Owning handles for the FFmpeg libraries' objects, and their errors as words.
#pragma once

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/display.h>
#include <libavutil/opt.h>
#include <libavutil/pixdesc.h>
#include <libswscale/swscale.h>
}

#include <memory>
#include <string>

namespace uwv::libav {

struct Deleter {
  void operator()(AVFormatContext* context) const { avformat_close_input(&context); }
  void operator()(AVCodecContext* context) const { avcodec_free_context(&context); }
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
  void operator()(SwsContext* context) const { sws_freeContext(context); }
};

using Input = std::unique_ptr<AVFormatContext, Deleter>;
using Codec = std::unique_ptr<AVCodecContext, Deleter>;
using Packet = std::unique_ptr<AVPacket, Deleter>;
using Frame = std::unique_ptr<AVFrame, Deleter>;
using Scaler = std::unique_ptr<SwsContext, Deleter>;

/// New empty objects; std::bad_alloc instead of null.
Packet new_packet();
Frame new_frame();

/// FFmpeg's own words for an error code.
std::string error_text(int code);

/// Stops FFmpeg from writing to the terminal: what matters reaches the user as Error or warning. The log level is one
/// per process, so this happens once, and only while it is still at the library's default: a program that has chosen a
/// level keeps it.
void quiet_log();

/// A scaler between two formats and sizes: bicubic, exact rounding, left-sited chroma unless told otherwise.
/// `chroma_location` belongs to whichever side has subsampled chroma. Null when FFmpeg cannot convert between them.
Scaler new_scaler(AVPixelFormat from, int from_width, int from_height, AVPixelFormat to, int to_width, int to_height,
                  AVChromaLocation chroma_location);

}  // namespace uwv::libav
