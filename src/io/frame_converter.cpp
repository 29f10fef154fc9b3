// SPDX-License-Identifier: Apache-2.0
#include "io/frame_converter.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace uwv {
namespace {

// The JPEG-range twins of the YUV formats are only a deprecated spelling of "full range".
AVPixelFormat without_range(int format, bool* full_range = nullptr) {
  const auto plain = [format] {
    switch (format) {
      case AV_PIX_FMT_YUVJ420P: return AV_PIX_FMT_YUV420P;
      case AV_PIX_FMT_YUVJ422P: return AV_PIX_FMT_YUV422P;
      case AV_PIX_FMT_YUVJ444P: return AV_PIX_FMT_YUV444P;
      case AV_PIX_FMT_YUVJ440P: return AV_PIX_FMT_YUV440P;
      case AV_PIX_FMT_YUVJ411P: return AV_PIX_FMT_YUV411P;
      default: return static_cast<AVPixelFormat>(format);
    }
  }();
  if (full_range != nullptr) *full_range = plain != format;
  return plain;
}

bool is_rgb(AVPixelFormat format) {
  const AVPixFmtDescriptor* about = av_pix_fmt_desc_get(format);
  return about != nullptr && (about->flags & (AV_PIX_FMT_FLAG_RGB | AV_PIX_FMT_FLAG_PAL)) != 0;
}

struct LumaWeights {
  double red, blue;
};

LumaWeights luma_weights(AVColorSpace matrix) {
  switch (matrix) {
    case AVCOL_SPC_FCC: return {0.30, 0.11};
    case AVCOL_SPC_BT470BG:
    case AVCOL_SPC_SMPTE170M: return {0.299, 0.114};
    case AVCOL_SPC_SMPTE240M: return {0.212, 0.087};
    case AVCOL_SPC_BT2020_NCL:
    case AVCOL_SPC_BT2020_CL: return {0.2627, 0.0593};
    default: return {0.2126, 0.0722};
  }
}

// YCbCr to RGB in integers with 18 fractional bits, for 10-bit input (8-bit codes times four) and 8-bit output.
struct IntegerMatrix {
  static constexpr int bits = 18;
  int luma, red_from_cr, green_from_cb, green_from_cr, blue_from_cb;
  int black;

  /// `depth` is the bits of a source sample: full-range white is 2^depth - 1, which shifting to 10 bits does not fill.
  IntegerMatrix(const ColourSystem& system, int depth) {
    const LumaWeights w = luma_weights(system.matrix);
    const double green = 1.0 - w.red - w.blue;
    const double one = static_cast<double>(1 << bits) / 4.0;
    const double full_scale = 255.0 / 256.0 / (1.0 - std::ldexp(1.0, -depth));
    const double chroma = one * 2.0 * (system.full_range ? full_scale : 255.0 / 224.0);
    const auto rounded = [](double v) { return static_cast<int>(std::lround(v)); };
    luma = rounded(one * (system.full_range ? full_scale : 255.0 / 219.0));
    red_from_cr = rounded(chroma * (1.0 - w.red));
    blue_from_cb = rounded(chroma * (1.0 - w.blue));
    green_from_cr = rounded(chroma * (1.0 - w.red) * w.red / green);
    green_from_cb = rounded(chroma * (1.0 - w.blue) * w.blue / green);
    black = system.full_range ? 0 : 16 * 4;
  }
};

std::uint8_t to_level(int fixed) {
  return static_cast<std::uint8_t>(
      std::clamp((fixed + (1 << (IntegerMatrix::bits - 1))) >> IntegerMatrix::bits, 0, 255));
}

void row_to_rgb(const std::uint16_t* luma, const std::uint16_t* cb, const std::uint16_t* cr, int width,
                const IntegerMatrix& matrix, Rgb8* out) {
  constexpr int grey = 128 * 4;
  constexpr int block = 256;
  const IntegerMatrix m = matrix;  // a local copy cannot alias the output
  // Planes first, pixels second: the compiler makes SIMD of the first loop only without three-byte stores in it.
  std::array<std::uint8_t, block> red, green, blue;
  for (int start = 0; start < width; start += block) {
    const auto n = static_cast<std::size_t>(std::min(block, width - start));
    for (std::size_t i = 0; i < n; ++i) {
      const int y = (luma[start + i] - m.black) * m.luma;
      const int b = cb[start + i] - grey;
      const int r = cr[start + i] - grey;
      red[i] = to_level(y + r * m.red_from_cr);
      green[i] = to_level(y - b * m.green_from_cb - r * m.green_from_cr);
      blue[i] = to_level(y + b * m.blue_from_cb);
    }
    for (std::size_t i = 0; i < n; ++i) out[start + i] = {red[i], green[i], blue[i]};
  }
}

void turn(const ImageRgb& stored, const Orientation& o, ImageRgb& shown) {
  // The inverse of the turn is its transpose; the shifts make the smallest stored coordinate 0.
  for (int y = 0; y < shown.height(); ++y)
    for (int x = 0; x < shown.width(); ++x) {
      const int from_x = o.xx * x + o.yx * y + (o.xx + o.yx < 0 ? stored.width() - 1 : 0);
      const int from_y = o.xy * x + o.yy * y + (o.xy + o.yy < 0 ? stored.height() - 1 : 0);
      shown(x, y) = stored(from_x, from_y);
    }
}

}  // namespace

std::optional<Orientation> orientation_of(const libav::DisplayMatrix& m) {
  // FFmpeg multiplies row vectors from the left, in 16.16 fixed point: shown x = m0 * x + m3 * y, y = m1 * x + m4 * y.
  const std::array<double, 4> v{double(m[0]), double(m[3]), double(m[1]), double(m[4])};
  const double largest = std::max({std::abs(v[0]), std::abs(v[1]), std::abs(v[2]), std::abs(v[3])});
  if (largest == 0) return std::nullopt;
  const auto unit = [largest](double value) { return static_cast<int>(std::lround(value / largest)); };
  const Orientation o{unit(v[0]), unit(v[1]), unit(v[2]), unit(v[3])};
  const std::array<int, 4> rounded{o.xx, o.xy, o.yx, o.yy};
  for (std::size_t i = 0; i < v.size(); ++i)
    if (std::abs(v[i] / largest - rounded[i]) > 0.01) return std::nullopt;
  const bool is_quarter_turn = std::abs(o.xx * o.yy - o.xy * o.yx) == 1 && o.xx * o.xy == 0 && o.yx * o.yy == 0;
  return is_quarter_turn ? std::optional(o) : std::nullopt;
}

ColourSystem ColourSystem::of(const AVFrame& frame) {
  ColourSystem system;
  bool jpeg_format = false;
  without_range(frame.format, &jpeg_format);
  system.full_range = jpeg_format || frame.color_range == AVCOL_RANGE_JPEG;
  switch (frame.colorspace) {
    case AVCOL_SPC_UNSPECIFIED:
    case AVCOL_SPC_RESERVED:
    case AVCOL_SPC_RGB: system.matrix = frame.height >= 720 ? AVCOL_SPC_BT709 : AVCOL_SPC_SMPTE170M; break;
    case AVCOL_SPC_BT709:
    case AVCOL_SPC_FCC:
    case AVCOL_SPC_BT470BG:
    case AVCOL_SPC_SMPTE170M:
    case AVCOL_SPC_SMPTE240M:
    case AVCOL_SPC_BT2020_NCL:
    case AVCOL_SPC_BT2020_CL: system.matrix = frame.colorspace; break;
    default: system.matrix_unsupported = true;
  }
  return system;
}

void FrameConverter::prepare(const AVFrame& frame, const std::string& path) {
  const std::array<int, 4> wanted{frame.width, frame.height, frame.format, frame.chroma_location};
  if (scaler_ && wanted == prepared_) return;
  const AVPixelFormat from = without_range(frame.format);
  // RGB needs only scaling. Everything else goes to 10-bit 4:4:4 at the working size and then through our own matrix:
  // swscale's RGB output with full chroma has no SIMD (10 ms for 832x480, this way 1.5 ms), and the two extra bits keep
  // what interpolation adds. OpenCV's VideoCapture is not used because it ignores the stream's matrix and range.
  const AVPixelFormat to = is_rgb(from) ? AV_PIX_FMT_RGB24 : AV_PIX_FMT_YUV444P10;
  const Size stored = orientation_.shown(size_);
  scaler_ = libav::new_scaler(from, frame.width, frame.height, to, stored.width, stored.height, frame.chroma_location);
  if (!scaler_) {
    const char* name = av_get_pix_fmt_name(from);
    fail(ErrorCode::format_unknown, "{}: its pixel format '{}' cannot be converted; re-encode it as yuv420p", path,
         name != nullptr ? name : "?");
  }
  // Equal ranges on both sides leave the values as they are stored; the matrix knows the range.
  const int* any = sws_getCoefficients(SWS_CS_ITU709);
  if (to == AV_PIX_FMT_YUV444P10) sws_setColorspaceDetails(scaler_.get(), any, 0, any, 0, 0, 1 << 16, 1 << 16);
  scaled_ = libav::new_frame();
  scaled_->format = to;
  scaled_->width = stored.width;
  scaled_->height = stored.height;
  if (av_frame_get_buffer(scaled_.get(), 0) < 0) throw std::bad_alloc();
  prepared_ = wanted;
}

void FrameConverter::scale(const AVFrame& frame, const std::string& path) {
  const int code =
      sws_scale(scaler_.get(), frame.data, frame.linesize, 0, frame.height, scaled_->data, scaled_->linesize);
  if (code < 0) fail(ErrorCode::file_damaged, "{}: a frame cannot be converted ({})", path, libav::error_text(code));
}

void FrameConverter::convert(const AVFrame& frame, const std::string& path, ImageRgb& out) {
  prepare(frame, path);
  scale(frame, path);
  const bool upright = orientation_.is_upright();
  ImageRgb& target = upright ? out : unturned_;
  target.resize({scaled_->width, scaled_->height});
  const AVPixFmtDescriptor* about = av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format));
  const IntegerMatrix matrix(ColourSystem::of(frame), about->comp[0].depth);
  const auto plane_row = [this](int plane, int y) {
    return scaled_->data[plane] + static_cast<std::ptrdiff_t>(y) * scaled_->linesize[plane];
  };
  for (int y = 0; y < target.height(); ++y) {
    if (scaled_->format == AV_PIX_FMT_RGB24) {
      std::memcpy(target.row(y), plane_row(0, y), static_cast<std::size_t>(target.width()) * sizeof(Rgb8));
      continue;
    }
    const auto samples = [&](int plane) { return reinterpret_cast<const std::uint16_t*>(plane_row(plane, y)); };
    row_to_rgb(samples(0), samples(1), samples(2), target.width(), matrix, target.row(y));
  }
  if (upright) return;
  out.resize(size_);
  turn(unturned_, orientation_, out);
}

}  // namespace uwv
