// SPDX-License-Identifier: Apache-2.0
// All frames of a video file from the first to the last, in presentation order.
#pragma once

#include <string>

#include "io/demuxer.h"

namespace uwv {

class VideoDecoder {
 public:
  /// `threads` 0 = one per processor. Throws Error when the file or its codec cannot be opened.
  VideoDecoder(const std::string& path, int threads);

  Demuxer& demuxer() { return demuxer_; }
  std::string codec() const { return context_->codec->name; }

  /// The next frame; false after the last one that can be decoded. Packets the decoder refuses are passed over.
  bool next(AVFrame& frame);
  /// Whether any packet was refused or any frame decoded with errors so far.
  bool met_damage() const { return met_damage_; }

 private:
  void feed();

  Demuxer demuxer_;
  libav::Codec context_;
  libav::Packet packet_;
  bool draining_ = false;
  bool met_damage_ = false;
};

}  // namespace uwv
