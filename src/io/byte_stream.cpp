// SPDX-License-Identifier: Apache-2.0
#include "io/byte_stream.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <utility>

#include "uwv/core/error.h"

namespace uwv::io {
namespace {

constexpr std::size_t buffer_bytes = 1U << 16;

class Region final : public ByteStream {
 public:
  Region(std::shared_ptr<const InputFile> file, std::uint64_t offset, std::uint64_t size)
      : file_(std::move(file)), offset_(offset), size_(size) {}
  std::uint64_t size() const override { return size_; }
  void read_at(std::uint64_t offset, std::span<std::byte> out) override {
    if (offset > size_ || out.size() > size_ - offset)
      fail(ErrorCode::file_damaged, "{}: its data ends after {} bytes, {} more are wanted at {}", file_->path(), size_,
           out.size(), offset);
    file_->read_at(offset_ + offset, out);
  }

 private:
  std::shared_ptr<const InputFile> file_;
  std::uint64_t offset_, size_;
};

class DeflatedRegion final : public ByteStream {
 public:
  DeflatedRegion(std::shared_ptr<const InputFile> file, std::uint64_t offset, std::uint64_t stored_size,
                 std::uint64_t size)
      : file_(std::move(file)), offset_(offset), stored_size_(stored_size), size_(size) {
    constexpr int raw_deflate = -MAX_WBITS;
    if (inflateInit2(&inflater_, raw_deflate) != Z_OK)
      fail(ErrorCode::out_of_memory, "{}: no memory for decompression", file_->path());
  }
  ~DeflatedRegion() override { inflateEnd(&inflater_); }
  DeflatedRegion(const DeflatedRegion&) = delete;
  DeflatedRegion& operator=(const DeflatedRegion&) = delete;

  std::uint64_t size() const override { return size_; }

  void read_at(std::uint64_t offset, std::span<std::byte> out) override {
    if (offset < position_) restart();
    while (position_ < offset) {
      std::array<std::byte, buffer_bytes> skipped;
      inflate_into(std::span(skipped).first(std::min<std::uint64_t>(skipped.size(), offset - position_)));
    }
    while (!out.empty()) {
      const auto part = out.first(std::min<std::size_t>(out.size(), 1U << 30));  // zlib counts in unsigned int
      inflate_into(part);
      out = out.subspan(part.size());
    }
  }

 private:
  void restart() {
    inflateReset(&inflater_);
    inflater_.avail_in = 0;
    consumed_ = position_ = 0;
  }

  void inflate_into(std::span<std::byte> out) {
    inflater_.next_out = reinterpret_cast<Bytef*>(out.data());
    inflater_.avail_out = static_cast<uInt>(out.size());
    while (inflater_.avail_out > 0) {
      if (inflater_.avail_in == 0) refill();
      const int status = inflate(&inflater_, Z_NO_FLUSH);
      const bool ended = status == Z_STREAM_END && inflater_.avail_out > 0;
      if (ended || (status != Z_OK && status != Z_STREAM_END))
        fail(ErrorCode::file_damaged, "{}: its compressed data {} after {} of {} bytes", file_->path(),
             ended ? "ends" : "is broken", position_ + out.size() - inflater_.avail_out, size_);
    }
    position_ += out.size();
  }

  void refill() {
    const auto bytes = std::min<std::uint64_t>(input_.size(), stored_size_ - consumed_);
    file_->read_at(offset_ + consumed_, std::span(input_).first(bytes));
    consumed_ += bytes;
    inflater_.next_in = reinterpret_cast<Bytef*>(input_.data());
    inflater_.avail_in = static_cast<uInt>(bytes);
  }

  std::shared_ptr<const InputFile> file_;
  std::uint64_t offset_, stored_size_, size_;
  std::uint64_t consumed_ = 0;  // compressed bytes taken from the file
  std::uint64_t position_ = 0;  // decompressed bytes handed out
  z_stream inflater_{};
  std::array<std::byte, buffer_bytes> input_;
};

class ChecksummedStream final : public ByteStream {
 public:
  ChecksummedStream(std::unique_ptr<ByteStream> inner, std::uint32_t expected, std::string what)
      : inner_(std::move(inner)), expected_(expected), what_(std::move(what)) {}
  std::uint64_t size() const override { return inner_->size(); }

  void read_at(std::uint64_t offset, std::span<std::byte> out) override {
    inner_->read_at(offset, out);
    if (offset == 0) {
      checked_ = 0;
      checksum_ = 0;
    }
    if (offset != checked_) return;
    checksum_ = static_cast<std::uint32_t>(
        crc32_z(checksum_, reinterpret_cast<const Bytef*>(out.data()), static_cast<z_size_t>(out.size())));
    checked_ += out.size();
    if (checked_ == size() && checksum_ != expected_)
      fail(ErrorCode::file_damaged, "{}: its checksum is {:08x} instead of {:08x}", what_, checksum_, expected_);
  }

 private:
  std::unique_ptr<ByteStream> inner_;
  std::uint32_t expected_;
  std::string what_;
  std::uint64_t checked_ = 0;  // bytes read in sequence from the start
  std::uint32_t checksum_ = 0;
};

}  // namespace

std::unique_ptr<ByteStream> open_region(std::shared_ptr<const InputFile> file, std::uint64_t offset,
                                        std::uint64_t size) {
  return std::make_unique<Region>(std::move(file), offset, size);
}

std::unique_ptr<ByteStream> open_deflated_region(std::shared_ptr<const InputFile> file, std::uint64_t offset,
                                                 std::uint64_t stored_size, std::uint64_t size) {
  return std::make_unique<DeflatedRegion>(std::move(file), offset, stored_size, size);
}

std::unique_ptr<ByteStream> with_checksum(std::unique_ptr<ByteStream> stream, std::uint32_t crc32, std::string what) {
  return std::make_unique<ChecksummedStream>(std::move(stream), crc32, std::move(what));
}

}  // namespace uwv::io
