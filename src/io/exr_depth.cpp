// SPDX-License-Identifier: Apache-2.0
#include <ImathBox.h>
#include <ImfChannelList.h>
#include <ImfCompression.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>

#include <algorithm>

#include "io/depth_codecs.h"
#include "io/disk_file.h"
#include "io/printable.h"

namespace uwv::io {
namespace {

class ExrInput final : public Imf::IStream {
 public:
  explicit ExrInput(const std::string& path) : Imf::IStream(path.c_str()), file_(path) {}
  bool read(char* out, int bytes) override {
    const std::size_t count = bytes > 0 ? static_cast<std::size_t>(bytes) : 0;
    file_.read_at(position_, std::as_writable_bytes(std::span(out, count)));
    position_ += count;
    return position_ < file_.size();
  }
  std::uint64_t tellg() override { return position_; }
  void seekg(std::uint64_t position) override { position_ = position; }
  std::uint64_t size() const { return file_.size(); }

 private:
  InputFile file_;
  std::uint64_t position_ = 0;
};

class ExrOutput final : public Imf::OStream {
 public:
  explicit ExrOutput(const std::string& path) : Imf::OStream(path.c_str()), file_(path) {}
  void write(const char* from, int bytes) override {
    const auto data = std::as_bytes(std::span(from, static_cast<std::size_t>(bytes)));
    if (position_ == file_.position())
      file_.append(data);
    else
      file_.patch(position_, data);
    position_ += data.size();
  }
  std::uint64_t tellp() override { return position_; }
  void seekp(std::uint64_t position) override { position_ = position; }
  void commit() { file_.commit(); }

 private:
  OutputFile file_;
  std::uint64_t position_ = 0;
};

/// Z is the standard's name for depth; renderers that know no better write it as grey or as equal colours.
std::string depth_channel(const Imf::ChannelList& channels, const std::string& path) {
  std::string names;
  std::size_t count = 0;
  for (auto it = channels.begin(); it != channels.end(); ++it, ++count)
    names += fmt::format("{}{}", count == 0 ? "" : ", ", printable(it.name()));
  for (const char* name : {"Z", "depth", "Depth", "depth.Z", "Depth.Z", "Y", "V", "R"})
    if (channels.findChannel(name) != nullptr) return name;
  if (count == 1) return channels.begin().name();
  fail(ErrorCode::value_invalid, "{}: has no channel Z, depth, Y or R to take depth from (it has: {})", path,
       printable(names));
}

Size size_of(const Imath::Box2i& window, const std::string& path) {
  const auto side = [](int from, int to) {
    return from > to ? 0 : static_cast<std::uint64_t>(static_cast<std::int64_t>(to) - from + 1);
  };
  return checked_size(side(window.min.x, window.max.x), side(window.min.y, window.max.y), path);
}

/// How far a compression can shrink 16-bit values at best; 0 where wavelets and the like know no bound.
std::uint64_t best_ratio(Imf::Compression compression) {
  switch (compression) {
    case Imf::NO_COMPRESSION: return 1;
    case Imf::RLE_COMPRESSION: return 128;
    case Imf::ZIPS_COMPRESSION:
    case Imf::ZIP_COMPRESSION:
    case Imf::PXR24_COMPRESSION: return 2064;
    default: return 0;
  }
}

/// Refuses a header that promises more pixels than the file's bytes can hold, before memory is taken for them.
void check_plausible(Size size, Imf::Compression compression, std::uint64_t file_bytes, const std::string& path) {
  constexpr std::size_t smallest_value = 2;
  const std::uint64_t ratio = best_ratio(compression);
  if (ratio != 0 && size.pixels() * smallest_value / ratio > file_bytes)
    fail(ErrorCode::file_damaged, "{}: claims {}x{} pixels in {} bytes, which its compression cannot reach", path,
         size.width, size.height, file_bytes);
}

/// The picture is the display window; pixels stored outside of it are dropped, missing ones are invalid.
DepthMap crop(const DepthMap& stored, const Imath::Box2i& stored_at, const Imath::Box2i& shown, Size size) {
  if (stored_at == shown) return stored;
  DepthMap depth(size);
  for (int y = 0; y < depth.height(); ++y)
    for (int x = 0; x < depth.width(); ++x) {
      const std::int64_t from_x = std::int64_t{x} + shown.min.x - stored_at.min.x;
      const std::int64_t from_y = std::int64_t{y} + shown.min.y - stored_at.min.y;
      if (from_x >= 0 && from_y >= 0 && from_x < stored.width() && from_y < stored.height())
        depth(x, y) = stored(static_cast<int>(from_x), static_cast<int>(from_y));
    }
  return depth;
}

DepthMap read_pixels(const std::string& path) {
  ExrInput input(path);
  Imf::InputFile file(input, 0);
  const Imath::Box2i stored_at = file.header().dataWindow(), shown = file.header().displayWindow();
  const Size stored_size = size_of(stored_at, path), shown_size = size_of(shown, path);
  const std::string channel = depth_channel(file.header().channels(), path);
  const Imf::Channel* info = file.header().channels().findChannel(channel.c_str());
  if (info->xSampling != 1 || info->ySampling != 1)
    fail(ErrorCode::format_unknown, "{}: channel {} is subsampled; one value per pixel is wanted", path, channel);
  check_plausible(stored_size, file.header().compression(), input.size(), path);
  DepthMap stored(stored_size);
  Imf::FrameBuffer frame;
  frame.insert(channel, Imf::Slice::Make(Imf::FLOAT, stored.data(), stored_at, sizeof(float),
                                         sizeof(float) * static_cast<std::size_t>(stored_size.width)));
  file.setFrameBuffer(frame);
  file.readPixels(stored_at.min.y, stored_at.max.y);
  return crop(stored, stored_at, shown, shown_size);
}

}  // namespace

DepthMap read_exr_depth(const std::string& path, double scale) {
  try {
    DepthMap depth = read_pixels(path);
    if (scale != 1)
      for (float& z : depth.pixels()) z = static_cast<float>(z * scale);
    return depth;
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    fail(ErrorCode::file_damaged, "{}: cannot be read as OpenEXR: {}", path, printable(error.what()));
  }
}

void write_exr_depth(const std::string& path, const DepthMap& depth, double scale) {
  require(!depth.empty(), "{}: an empty depth map cannot be written", path);
  DepthMap scaled = depth;
  if (scale != 1)
    for (float& z : scaled.pixels()) z = static_cast<float>(z / scale);
  ExrOutput output(path);
  try {
    Imf::Header header(depth.width(), depth.height());
    header.channels().insert("Z", Imf::Channel(Imf::FLOAT));
    Imf::OutputFile file(output, header, 0);
    Imf::FrameBuffer frame;
    frame.insert("Z", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(scaled.data()), sizeof(float),
                                 sizeof(float) * static_cast<std::size_t>(depth.width())));
    file.setFrameBuffer(frame);
    file.writePixels(depth.height());
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    fail(ErrorCode::output_failed, "{}: cannot be written as OpenEXR: {}", path, printable(error.what()));
  }
  output.commit();
}

}  // namespace uwv::io
