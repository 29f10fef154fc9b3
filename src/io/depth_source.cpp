// SPDX-License-Identifier: Apache-2.0
#include "uwv/io/depth_source.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <set>

#include "io/depth_array.h"
#include "io/depth_codecs.h"
#include "io/depth_sidecar.h"
#include "io/image_sequence.h"
#include "uwv/core/depth.h"
#include "uwv/io/depth_file.h"

namespace uwv {
namespace {

namespace fs = std::filesystem;

long picked_frames(long available, const DepthOptions& options, const std::string& path) {
  if (options.start >= available)
    fail(ErrorCode::value_invalid, "{}: start is {}, but there are {} frames of depth; choose a smaller start", path,
         options.start, available);
  const long reachable = (available - options.start - 1) / options.stride + 1;
  return options.max_frames == 0 ? reachable : std::min(reachable, options.max_frames);
}

class ArraySource final : public DepthSource {
 public:
  ArraySource(const std::string& path, const DepthOptions& options, Monitor& monitor)
      : array_(path, options.key), options_(options), frames_(picked_frames(array_.frames(), options, path)) {
    if (options.scale == 0 && is_integer(array_.header().dtype))
      monitor.warn(
          fmt::format("{}: holds whole numbers, taken as scene units; state the depth scale if they are "
                      "something else (0.001 for millimetres)",
                      path));
    if (array_.frames() > 1 && array_.header().fortran_order)
      monitor.warn(
          fmt::format("{}: is in Fortran order, so every frame reads the whole file; save it in C order", path));
  }
  long frames() const override { return frames_; }
  Size size() const override { return array_.size(); }
  bool read(long index, DepthMap& out) override {
    require(index >= 0, "depth frame {} was asked for", index);
    if (index >= frames_) return false;
    array_.read(options_.start + index * options_.stride, options_.scale == 0 ? 1 : options_.scale, out);
    sanitize_depth(out);
    return true;
  }

 private:
  io::DepthArray array_;
  DepthOptions options_;
  long frames_;
};

class FilesSource final : public DepthSource {
 public:
  FilesSource(std::vector<std::string> files, const DepthOptions& options, const std::string& path)
      : files_(std::move(files)),
        options_(options),
        frames_(picked_frames(static_cast<long>(files_.size()), options, path)) {
    if (options_.scale == 0)
      if (const auto stated = io::read_depth_sidecar(fs::path(files_[0]).parent_path().string()))
        if (fs::path(files_[0]).extension() == ".png") options_.scale = *stated;
    read_file(0, first_);
  }
  long frames() const override { return frames_; }
  Size size() const override { return first_.size(); }
  bool read(long index, DepthMap& out) override {
    require(index >= 0, "depth frame {} was asked for", index);
    if (index >= frames_) return false;
    if (index == 0) {
      out = first_;
      return true;
    }
    read_file(index, out);
    if (out.size() != size())
      fail(ErrorCode::size_mismatch, "{}: is {}x{}, but the first depth is {}x{}", file(index), out.width(),
           out.height(), size().width, size().height);
    return true;
  }

 private:
  const std::string& file(long index) const {
    return files_[static_cast<std::size_t>(options_.start + index * options_.stride)];
  }
  void read_file(long index, DepthMap& out) const {
    out = read_depth_file(file(index), {options_.scale, options_.key});
  }

  std::vector<std::string> files_;
  DepthOptions options_;
  long frames_;
  DepthMap first_;  // read at once, to know the size
};

/// The depth files of a folder. Two kinds side by side are two versions of the same frames more often than one clip.
std::vector<std::string> depth_files_in(const std::string& folder) {
  std::vector<std::string> files;
  std::set<std::string> kinds;
  const auto everything = files_matching((fs::path(folder) / "*").string());
  for (const std::string& file : *everything) {
    const std::string kind = fs::path(file).extension().string();
    if (kind != ".png" && kind != ".exr" && kind != ".pfm" && kind != ".npy") continue;
    kinds.insert(kind);
    files.push_back(file);
  }
  if (files.empty())
    fail(ErrorCode::format_unknown, "{}: this folder holds no depth files (.png, .exr, .pfm or .npy)", folder);
  if (kinds.size() > 1)
    fail(ErrorCode::format_unknown,
         "{}: this folder holds depth files of several kinds ({}); choose with a pattern such "
         "as {}/*{}",
         folder, fmt::join(kinds, ", "), folder, *kinds.begin());
  return files;
}

}  // namespace

void DepthOptions::check() const {
  require(std::isfinite(scale) && scale >= 0, "a depth scale of {} is not a positive number (or 0 = default)", scale);
  require(start >= 0, "depth start is {}; 0 or more is wanted", start);
  require(stride >= 1, "depth stride is {}; 1 or more is wanted", stride);
  require(max_frames >= 0, "depth max_frames is {}; 0 (all) or more is wanted", max_frames);
}

std::unique_ptr<DepthSource> open_depth(const std::string& path, const DepthOptions& options, Monitor& monitor) {
  options.check();
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) return std::make_unique<FilesSource>(depth_files_in(path), options, path);
  if (!fs::exists(path, ignored))
    if (auto files = files_matching(path)) return std::make_unique<FilesSource>(std::move(*files), options, path);
  if (io::is_numpy_file(path)) return std::make_unique<ArraySource>(path, options, monitor);
  return std::make_unique<FilesSource>(std::vector{path}, options, path);
}

}  // namespace uwv
