// SPDX-License-Identifier: Apache-2.0
// What FFmpeg 4.4 (Ubuntu 22.04) to 7.1 (Debian 13) spell differently. No other file asks for FFmpeg's version.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <optional>

#include "io/libav.h"

namespace uwv::libav {

/// The entries of a stream's table of contents, as far as the demuxer has one.
inline int index_size(const AVStream& stream) {
#if LIBAVFORMAT_VERSION_INT >= AV_VERSION_INT(59, 0, 100)
  return avformat_index_get_entries_count(&stream);
#else
  return stream.nb_index_entries;  // FFmpeg 4 has no function for it, only this field
#endif
}

inline const AVIndexEntry& index_entry(AVStream& stream, int i) {
#if LIBAVFORMAT_VERSION_INT >= AV_VERSION_INT(59, 0, 100)
  return *avformat_index_get_entry(&stream, i);
#else
  return stream.index_entries[i];
#endif
}

using DisplayMatrix = std::array<std::int32_t, 9>;

/// How the stream asks to be turned for showing; nothing where it does not ask.
inline std::optional<DisplayMatrix> display_matrix(const AVStream& stream) {
#if LIBAVCODEC_VERSION_INT >= AV_VERSION_INT(60, 31, 100)
  const AVPacketSideData* found = av_packet_side_data_get(
      stream.codecpar->coded_side_data, stream.codecpar->nb_coded_side_data, AV_PKT_DATA_DISPLAYMATRIX);
  const std::uint8_t* data = found != nullptr ? found->data : nullptr;
#else
  const std::uint8_t* data = av_stream_get_side_data(&stream, AV_PKT_DATA_DISPLAYMATRIX, nullptr);
#endif
  if (data == nullptr) return std::nullopt;
  DisplayMatrix matrix{};
  std::memcpy(matrix.data(), data, sizeof(matrix));
  return matrix;
}

/// Where a chroma sample lies, in 1/256 of a luma pixel.
inline void chroma_position(AVChromaLocation location, int& x, int& y) {
#if LIBAVUTIL_VERSION_INT >= AV_VERSION_INT(58, 0, 100)
  av_chroma_location_enum_to_pos(&x, &y, location);
#else
  avcodec_enum_to_chroma_pos(&x, &y, location);
#endif
}

inline bool is_interlaced(const AVFrame& frame) {
#if LIBAVUTIL_VERSION_INT >= AV_VERSION_INT(58, 29, 100)
  return (frame.flags & AV_FRAME_FLAG_INTERLACED) != 0;
#else
  return frame.interlaced_frame != 0;
#endif
}

}  // namespace uwv::libav
