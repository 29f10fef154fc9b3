// SPDX-License-Identifier: Apache-2.0
#include "uwv/io/depth_writer.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "io/depth_codecs.h"
#include "io/depth_sidecar.h"
#include "uwv/io/npy.h"

namespace uwv {
namespace {

namespace fs = std::filesystem;

/// What both kinds of output share: every frame has the stated size, and as many come as were announced.
class CountingWriter : public DepthWriter {
 public:
  CountingWriter(std::string path, Size size, long frames) : path_(std::move(path)), size_(size), announced_(frames) {}
  void write(const DepthMap& depth) final {
    require(depth.size() == size_, "{}: a depth of {}x{} was given; {}x{} is wanted", path_, depth.width(),
            depth.height(), size_.width, size_.height);
    write_frame(depth);
    ++written_;
  }
  void finish() final {
    require(announced_ == 0 || written_ == announced_, "{}: {} depths were written; {} were announced", path_, written_,
            announced_);
    complete();
  }

 protected:
  virtual void write_frame(const DepthMap& depth) = 0;
  virtual void complete() = 0;
  const std::string& path() const { return path_; }
  long written() const { return written_; }

 private:
  std::string path_;
  Size size_;
  long announced_;
  long written_ = 0;
};

class NpzDepthWriter final : public CountingWriter {
 public:
  NpzDepthWriter(const std::string& path, const DepthWriterOptions& options, Size size, long frames)
      : CountingWriter(path, size, frames), npz_(path) {
    npz_.begin("depth", DType::f32, {static_cast<std::size_t>(size.height), static_cast<std::size_t>(size.width)},
               options.npz_deflate_level);
  }

 private:
  void write_frame(const DepthMap& depth) override { npz_.append(depth.pixels()); }
  void complete() override {
    npz_.end();
    npz_.finish();
  }

  NpzWriter npz_;
};

/// One file per frame, in a folder that gets its name when it is complete.
class FolderDepthWriter final : public CountingWriter {
 public:
  FolderDepthWriter(const std::string& path, const DepthWriterOptions& options, Size size, long frames,
                    Monitor& monitor)
      : CountingWriter(path, size, frames), options_(options), monitor_(monitor), part_(path + ".part") {
    require_replaceable(path);
    require_replaceable(part_);
    std::error_code error;
    fs::remove_all(part_, error);
    if (!error) fs::create_directories(part_, error);
    if (error) fail(ErrorCode::output_failed, "{}: cannot be created ({})", part_, error.message());
  }
  ~FolderDepthWriter() override {
    std::error_code ignored;
    if (!finished_) fs::remove_all(part_, ignored);
  }
  FolderDepthWriter(const FolderDepthWriter&) = delete;
  FolderDepthWriter& operator=(const FolderDepthWriter&) = delete;

 private:
  bool png() const { return options_.format == DepthFormat::png16; }

  /// A folder is deleted to make room only when all it holds was written by this class.
  static void require_replaceable(const std::string& folder) {
    std::error_code error;
    if (!fs::exists(folder, error)) return;
    if (!fs::is_directory(folder, error))
      fail(ErrorCode::output_failed, "{}: is a file where a folder is to be written; choose another name", folder);
    for (const auto& entry : fs::directory_iterator(folder, error)) {
      const fs::path& file = entry.path();
      const std::string stem = file.stem().string(), kind = file.extension().string();
      const bool frame = (kind == ".png" || kind == ".exr") && stem.size() >= 5 &&
                         std::all_of(stem.begin(), stem.end(), [](char c) { return c >= '0' && c <= '9'; });
      if (!frame && file.filename() != io::depth_sidecar_name)
        fail(ErrorCode::output_failed, "{}: holds other files ({}) and is not replaced; choose another folder", folder,
             file.filename().string());
    }
    if (error) fail(ErrorCode::output_failed, "{}: cannot be listed ({})", folder, error.message());
  }

  void write_frame(const DepthMap& depth) override {
    const std::string file = fmt::format("{}/{:05}{}", part_, written(), png() ? ".png" : ".exr");
    const DepthLoss loss = write_depth_file(file, depth, {png() ? options_.png_scale : 1, ""});
    loss_.too_far += loss.too_far;
    loss_.too_near += loss.too_near;
  }

  void complete() override {
    if (png()) io::write_depth_sidecar(part_, options_.png_scale, written());
    std::error_code error;
    fs::remove_all(path(), error);
    if (!error) fs::rename(part_, path(), error);
    if (error) fail(ErrorCode::output_failed, "{}: cannot be completed ({})", path(), error.message());
    finished_ = true;
    if (loss_.too_far > 0)
      monitor_.warn(
          fmt::format("{}: {} depths beyond {:.6g} do not fit 16-bit PNG and were written as invalid; choose a "
                      "larger png_scale than {:g}",
                      path(), loss_.too_far, 65535 * options_.png_scale, options_.png_scale));
    if (loss_.too_near > 0)
      monitor_.warn(
          fmt::format("{}: {} depths below {:.6g} do not fit 16-bit PNG and were written as invalid; choose a "
                      "smaller png_scale than {:g}",
                      path(), loss_.too_near, 0.5 * options_.png_scale, options_.png_scale));
  }

  DepthWriterOptions options_;
  Monitor& monitor_;
  std::string part_;
  DepthLoss loss_;
  bool finished_ = false;
};

}  // namespace

std::string_view to_string(DepthFormat format) {
  switch (format) {
    case DepthFormat::npz: return "npz";
    case DepthFormat::png16: return "png16";
    case DepthFormat::exr: return "exr";
  }
  return "?";
}

DepthFormat depth_format_named(std::string_view name) {
  for (const DepthFormat format : {DepthFormat::npz, DepthFormat::png16, DepthFormat::exr})
    if (to_string(format) == name) return format;
  require(false, "'{}' is no depth format; npz, png16 or exr is wanted", name);
  return {};
}

void DepthWriterOptions::check() const {
  require(std::isfinite(png_scale) && png_scale > 0, "a png_scale of {} is not a positive number", png_scale);
  require(npz_deflate_level >= 0 && npz_deflate_level <= 9, "an npz_deflate_level of {} is outside 0..9",
          npz_deflate_level);
}

std::unique_ptr<DepthWriter> make_depth_writer(const std::string& path, const DepthWriterOptions& options, Size size,
                                               long frames, Monitor& monitor) {
  options.check();
  require(size.width > 0 && size.height > 0 && frames >= 0, "{} depths of {}x{} cannot be written", frames, size.width,
          size.height);
  if (options.format == DepthFormat::npz) return std::make_unique<NpzDepthWriter>(path, options, size, frames);
  return std::make_unique<FolderDepthWriter>(path, options, size, frames, monitor);
}

}  // namespace uwv
