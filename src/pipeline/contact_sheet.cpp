// SPDX-License-Identifier: Apache-2.0
#include "pipeline/contact_sheet.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "uwv/io/image_file.h"

namespace uwv::pipeline {
namespace {

constexpr int gap = 4;  // between cells, pixels
constexpr Rgb8 paper = {255, 255, 255};

void draw_label(ImageRgb& picture, const std::string& text) {
  constexpr int font = cv::FONT_HERSHEY_SIMPLEX;
  constexpr double scale = 0.4;
  cv::Mat mat(picture.height(), picture.width(), CV_8UC3, picture.data());
  int baseline = 0;
  const cv::Size box = cv::getTextSize(text, font, scale, 1, &baseline);
  if (box.width + 8 > picture.width() || box.height + 8 > picture.height()) return;  // no room on tiny pictures
  cv::rectangle(mat, {0, 0}, {box.width + 7, box.height + 7}, cv::Scalar::all(0), cv::FILLED);
  cv::putText(mat, text, {4, box.height + 3}, font, scale, cv::Scalar::all(255), 1, cv::LINE_AA);
}

}  // namespace

ContactSheet::ContactSheet(Size cell, int columns, int rows)
    : cell_(cell), sheet_(columns * (cell.width + gap) - gap, rows * (cell.height + gap) - gap, paper) {}

void ContactSheet::put(int column, int row, const ImageRgb& picture, const std::string& label) {
  ImageRgb small = resize(picture, cell_);
  draw_label(small, label);
  const int left = column * (cell_.width + gap), top = row * (cell_.height + gap);
  for (int y = 0; y < cell_.height; ++y) std::copy_n(small.row(y), cell_.width, sheet_.row(top + y) + left);
}

Size contact_cell(Size size, int max_width) {
  if (size.width <= max_width) return size;
  return {max_width, std::max(1, static_cast<int>(static_cast<long>(size.height) * max_width / size.width))};
}

}  // namespace uwv::pipeline
