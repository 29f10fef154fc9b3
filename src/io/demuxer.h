// SPDX-License-Identifier: Apache-2.0
// The packets of the one video stream of a file, and a count of them that needs no decoding.
#pragma once

#include <string>

#include "io/libav.h"
#include "uwv/core/monitor.h"

namespace uwv {

/// An opened container with its video stream chosen. Opens that one file and nothing else: playlists that point at
/// other files or at the network get no answer.
class Demuxer {
 public:
  /// Throws Error naming the path: file_damaged or format_unknown.
  explicit Demuxer(const std::string& path);

  AVStream& stream() { return *stream_; }
  /// The container's short name, e.g. "mov,mp4,m4a,3gp,3g2,mj2".
  std::string container() const { return input_->iformat->name; }
  double frames_per_second();

  /// The next packet of the video stream, in file order; false at the end of what can be read.
  bool next(AVPacket& packet);
  /// After next() said false: the file ends before its own table of contents does, or reading failed on the way.
  bool cut_short() const;

 private:
  libav::Input input_;
  AVStream* stream_ = nullptr;
  int end_reason_ = AVERROR_EOF;
};

/// What a walk through the packets tells.
struct PacketScan {
  long frames = 0;                   ///< Packets that will be shown, at most the number asked for.
  bool variable_frame_rate = false;  ///< Among those walked over, intervals differ by more than 10 %.
  bool cut_short = false;            ///< Fewer than asked for because the file is damaged.
};

/// Walks over packets until a little more than `enough` frames are found (0 = to the end), without decoding and with
/// constant memory.
PacketScan scan_packets(const std::string& path, long enough, Monitor& monitor);

}  // namespace uwv
