// SPDX-License-Identifier: Apache-2.0
// Single pictures: reading, writing, resizing.
#pragma once

#include <string>

#include "uwv/core/image.h"
#include "uwv/core/mask.h"

namespace uwv {

/// Reads a still picture (PNG, JPEG, TIFF, WebP, BMP, PNM, JPEG 2000: what OpenCV decodes) as 8-bit sRGB.
/// - EXIF orientation is applied: the picture comes out upright.
/// - Grey becomes R = G = B. 16-bit values become v / 257, rounded.
/// - Alpha is dropped and the colours stay as stored: nothing is blended over a background nobody named.
/// - Embedded ICC profiles are ignored: values are taken as sRGB.
/// Throws Error: file_not_found; format_unknown (no known picture format, float or CMYK samples); file_damaged
/// (undecodable); value_invalid (a side above 65535 or more than 2^30 pixels).
ImageRgb read_image(const std::string& path);

/// Writes an 8-bit RGB PNG. Throws Error(output_failed). The same picture always gives the same bytes.
void write_png(const std::string& path, const ImageRgb& picture);

/// Writes a mask as an 8-bit grey PNG: 0 stays 0, everything else becomes 255. Name the polarity in the file's name.
void write_png(const std::string& path, const ValidityMask& mask);
void write_png(const std::string& path, const GenerateMask& mask);

/// The picture at another size, whole picture to whole picture (pixel edges stay pixel edges). Axes that shrink use
/// area averaging (no aliasing), axes that grow use bicubic interpolation. The same size gives an exact copy. Throws
/// std::invalid_argument when either size has no pixels.
ImageRgb resize(const ImageRgb& picture, Size size);

}  // namespace uwv
