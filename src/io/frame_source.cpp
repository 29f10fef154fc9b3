// SPDX-License-Identifier: Apache-2.0
#include "uwv/io/frame_source.h"

#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "io/image_sequence.h"
#include "io/video_source.h"

namespace uwv {
namespace {

namespace fs = std::filesystem;

// An animated PNG announces itself by an `acTL` chunk before its first pixels.
bool is_animated_png(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::array<char, 8> head{};
  if (!file.read(head.data(), 8) || std::memcmp(head.data(), "\x89PNG\r\n\x1a\n", 8) != 0) return false;
  while (file.read(head.data(), 8)) {
    if (std::memcmp(head.data() + 4, "acTL", 4) == 0) return true;
    if (std::memcmp(head.data() + 4, "IDAT", 4) == 0) return false;
    std::uint32_t length = 0;
    for (int i = 0; i < 4; ++i) length = length << 8U | static_cast<unsigned char>(head[static_cast<std::size_t>(i)]);
    file.seekg(static_cast<std::streamoff>(length) + 4, std::ios::cur);
  }
  return false;
}

// A raw MJPEG stream starts like a JPEG; only its name tells.
bool is_still_picture(const std::string& path) {
  const std::string extension = fs::path(path).extension().string();
  if (extension == ".mjpeg" || extension == ".mjpg") return false;
  return cv::haveImageReader(path) && !is_animated_png(path);
}

void require_readable_file(const std::string& path) {
  std::error_code ignored;
  if (!fs::is_regular_file(path, ignored))
    fail(ErrorCode::format_unknown, "{}: is neither a file nor a folder; a video, a picture or a folder is wanted",
         path);
  std::ifstream file(path, std::ios::binary);
  if (!file) fail(ErrorCode::file_not_found, "{}: cannot be opened for reading; check its permissions", path);
  if (file.peek() == std::ifstream::traits_type::eof())
    fail(ErrorCode::file_damaged, "{}: is empty (0 bytes); a video or picture is wanted", path);
}

}  // namespace

void ClipOptions::check() const {
  // Far beyond any clip, and small enough for start + (max_frames - 1) * stride never to overflow.
  constexpr long most = 1L << 30;
  require(start >= 0 && start <= most, "start is {}; 0 or a frame number up to {} is wanted", start, most);
  require(stride >= 1 && stride <= most, "stride is {}; a number in 1..{} is wanted", stride, most);
  require(max_frames >= 0 && max_frames <= most, "max_frames is {}; 0 (all) or a number up to {} is wanted", max_frames,
          most);
  require(threads >= 0 && threads <= 1024, "threads is {}; 0 (automatic) to 1024 is wanted", threads);
  resize.check();
}

std::unique_ptr<FrameSource> open_clip(const std::string& path, const ClipOptions& options, Monitor& monitor) {
  options.check();
  std::error_code ignored;
  if (!fs::exists(path, ignored)) {
    if (auto files = files_matching(path)) return open_pictures(path, std::move(*files), options);
    fail(ErrorCode::file_not_found, "{}: there is no such file or folder", path);
  }
  if (fs::is_directory(path, ignored)) return open_pictures(path, pictures_in_folder(path), options);
  require_readable_file(path);
  if (is_still_picture(path)) return open_pictures(path, {path}, options);
  return open_video(path, options, monitor);
}

}  // namespace uwv
