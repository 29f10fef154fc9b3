// SPDX-License-Identifier: Apache-2.0
#include "io/demuxer.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <queue>
#include <string_view>
#include <vector>

#include "io/libav_versions.h"

namespace uwv {
namespace {

// A file that refers to others must not make us read them: only the one named by the user is ever opened.
int open_only_this_file(AVFormatContext* context, AVIOContext** io, const char* url, int flags,
                        AVDictionary** options) {
  if (std::strcmp(url, context->url) != 0) return AVERROR(EACCES);
  return avio_open2(io, url, flags, &context->interrupt_callback, options);
}

// Every container format FFmpeg knows but those that are lists of other files or network addresses, and the one that
// paints any text file as a terminal screen.
const std::string& self_contained_formats() {
  static const std::string names = [] {
    constexpr std::array<std::string_view, 9> refused{"concat", "hls", "dash", "imf",   "sdp",
                                                      "rtsp",   "rtp", "tty",  "image2"};
    std::string list;
    void* position = nullptr;
    while (const AVInputFormat* format = av_demuxer_iterate(&position))
      if (std::find(refused.begin(), refused.end(), format->name) == refused.end()) (list += format->name) += ',';
    return list;
  }();
  return names;
}

[[noreturn]] void fail_to_open(const std::string& path, int code) {
  if (code == AVERROR(ENOMEM)) fail(ErrorCode::out_of_memory, "{}: not enough memory to open this file", path);
  fail(ErrorCode::file_damaged, "{}: is no readable video ({}); a whole video file that FFmpeg decodes is wanted", path,
       libav::error_text(code));
}

// Tells even from uneven intervals. Packets come in decoding order, so their time stamps pass through a small heap that
// sorts them again; no codec reorders by more than 32 frames.
class IntervalMeter {
 public:
  static constexpr std::size_t reorder_window = 32;

  void add(std::int64_t time) {
    if (time == AV_NOPTS_VALUE) return;
    pending_.push(time);
    if (pending_.size() > reorder_window) take_smallest();
  }
  // `at_end`: no packet is missing between those waiting in the heap.
  bool uneven(bool at_end) {
    while (at_end && !pending_.empty()) take_smallest();
    if (intervals_ < 2) return false;
    // Two ticks are what rounding to a coarse clock can do (Matroska's is a millisecond).
    const double mean = static_cast<double>(sum_) / static_cast<double>(intervals_);
    return static_cast<double>(longest_ - shortest_) > std::max(2.0, 0.1 * mean);
  }

 private:
  void take_smallest() {
    const std::int64_t time = pending_.top();
    pending_.pop();
    if (last_ != AV_NOPTS_VALUE && time > last_) {
      const std::int64_t interval = time - last_;
      shortest_ = intervals_ == 0 ? interval : std::min(shortest_, interval);
      longest_ = std::max(longest_, interval);
      sum_ += interval;
      ++intervals_;
    }
    last_ = time;
  }

  std::priority_queue<std::int64_t, std::vector<std::int64_t>, std::greater<>> pending_;
  std::int64_t last_ = AV_NOPTS_VALUE, shortest_ = 0, longest_ = 0, sum_ = 0;
  long intervals_ = 0;
};

}  // namespace

Demuxer::Demuxer(const std::string& path) {
  libav::quiet_log();
  AVFormatContext* context = avformat_alloc_context();
  if (context == nullptr) throw std::bad_alloc();
  context->io_open = open_only_this_file;
  context->flags |= AVFMT_FLAG_DISCARD_CORRUPT;  // half a packet at the end of a cut file would decode to grey blocks
  AVDictionary* settings = nullptr;
  av_dict_set(&settings, "format_whitelist", self_contained_formats().c_str(), 0);
  // "file:" keeps FFmpeg from taking a file name with a colon for a protocol.
  const int opened = avformat_open_input(&context, ("file:" + path).c_str(), nullptr, &settings);
  av_dict_free(&settings);
  if (opened < 0) fail_to_open(path, opened);  // the context is freed by the failing call
  input_.reset(context);
  const int probed = avformat_find_stream_info(context, nullptr);
  if (probed < 0) fail_to_open(path, probed);
  if (context->nb_streams == 0)
    fail(ErrorCode::file_damaged, "{}: lacks its table of contents; it is cut short, a whole video file is wanted",
         path);
  const int best = av_find_best_stream(context, AVMEDIA_TYPE_VIDEO, -1, -1, nullptr, 0);
  if (best < 0)
    fail(ErrorCode::format_unknown, "{}: holds no video stream ({} other streams); a video is wanted", path,
         context->nb_streams);
  stream_ = context->streams[best];
  if ((stream_->disposition & AV_DISPOSITION_ATTACHED_PIC) != 0)
    fail(ErrorCode::format_unknown, "{}: holds only a cover picture besides its sound; a video is wanted", path);
  for (unsigned i = 0; i < context->nb_streams; ++i)
    if (static_cast<int>(i) != best) context->streams[i]->discard = AVDISCARD_ALL;
}

double Demuxer::frames_per_second() {
  const AVRational rate = stream_->avg_frame_rate.num > 0 ? stream_->avg_frame_rate : stream_->r_frame_rate;
  return rate.num > 0 && rate.den > 0 ? av_q2d(rate) : 0.0;
}

bool Demuxer::next(AVPacket& packet) {
  for (;;) {
    av_packet_unref(&packet);
    const int code = av_read_frame(input_.get(), &packet);
    if (code < 0) {
      end_reason_ = code;
      return false;
    }
    if (packet.stream_index == stream_->index) return true;
  }
}

bool Demuxer::cut_short() const {
  if (end_reason_ != AVERROR_EOF) return true;
  const std::int64_t bytes = input_->pb != nullptr ? avio_size(input_->pb) : -1;
  if (bytes < 0) return false;
  for (int i = libav::index_size(*stream_) - 1; i >= 0; --i) {
    const AVIndexEntry& entry = libav::index_entry(*stream_, i);
    if (entry.pos > bytes - entry.size) return true;
  }
  return false;
}

PacketScan scan_packets(const std::string& path, long enough, Monitor& monitor) {
  Demuxer demuxer(path);
  const libav::Packet packet = libav::new_packet();
  PacketScan scan;
  IntervalMeter meter;
  constexpr long report_every = 1000;
  // Past the frames asked for, the meter needs to see those that are shown among them but stored later.
  const long last = enough + static_cast<long>(IntervalMeter::reorder_window);
  bool at_end = false;
  while (enough == 0 || scan.frames < last) {
    at_end = !demuxer.next(*packet);
    if (at_end) break;
    if ((packet->flags & AV_PKT_FLAG_DISCARD) != 0) continue;  // an edit list hides it
    meter.add(packet->pts);
    ++scan.frames;
    if (scan.frames % report_every == 0) monitor.step("count frames", scan.frames, enough);
  }
  scan.variable_frame_rate = meter.uneven(at_end);
  scan.cut_short = (enough == 0 || scan.frames < enough) && demuxer.cut_short();
  if (enough != 0) scan.frames = std::min(scan.frames, enough);
  return scan;
}

}  // namespace uwv
