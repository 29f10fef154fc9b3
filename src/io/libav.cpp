// SPDX-License-Identifier: Apache-2.0
#include "io/libav.h"

#include <mutex>
#include <new>

#include "io/libav_versions.h"

namespace uwv::libav {
namespace {

template <class Handle>
Handle not_null(Handle handle) {
  if (!handle) throw std::bad_alloc();
  return handle;
}

// Swscale counts chroma positions in 1/256 of a luma pixel and takes a missing horizontal position for the middle,
// which is JPEG's place; MPEG's is on the left pixel.
void set_chroma_position(SwsContext* scaler, const char* side, AVPixelFormat format, AVChromaLocation location) {
  const AVPixFmtDescriptor* about = av_pix_fmt_desc_get(format);
  if (about == nullptr || (about->log2_chroma_w == 0 && about->log2_chroma_h == 0)) return;
  int x = 0;
  int y = 128;
  if (location != AVCHROMA_LOC_UNSPECIFIED) chroma_position(location, x, y);
  const std::string prefix = side;
  if (about->log2_chroma_w == 1) av_opt_set_int(scaler, (prefix + "_h_chr_pos").c_str(), x, 0);
  if (about->log2_chroma_h == 1) av_opt_set_int(scaler, (prefix + "_v_chr_pos").c_str(), y, 0);
}

}  // namespace

Packet new_packet() { return not_null(Packet(av_packet_alloc())); }
Frame new_frame() { return not_null(Frame(av_frame_alloc())); }

std::string error_text(int code) {
  char text[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(code, text, sizeof(text));
  return text;
}

void quiet_log() {
  static std::once_flag once;
  std::call_once(once, [] {
    if (av_log_get_level() == AV_LOG_INFO) av_log_set_level(AV_LOG_QUIET);
  });
}

Scaler new_scaler(AVPixelFormat from, int from_width, int from_height, AVPixelFormat to, int to_width, int to_height,
                  AVChromaLocation chroma_location) {
  if (sws_isSupportedInput(from) == 0 || sws_isSupportedOutput(to) == 0) return nullptr;
  Scaler scaler = not_null(Scaler(sws_alloc_context()));
  SwsContext* s = scaler.get();
  av_opt_set_int(s, "srcw", from_width, 0);
  av_opt_set_int(s, "srch", from_height, 0);
  av_opt_set_int(s, "src_format", from, 0);
  av_opt_set_int(s, "dstw", to_width, 0);
  av_opt_set_int(s, "dsth", to_height, 0);
  av_opt_set_int(s, "dst_format", to, 0);
  av_opt_set_int(s, "sws_flags", SWS_BICUBIC | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT | SWS_FULL_CHR_H_INP, 0);
  set_chroma_position(s, "src", from, chroma_location);
  set_chroma_position(s, "dst", to, chroma_location);
  if (sws_init_context(s, nullptr, nullptr) < 0) return nullptr;
  return scaler;
}

}  // namespace uwv::libav
