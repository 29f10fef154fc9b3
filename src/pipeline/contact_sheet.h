// SPDX-License-Identifier: Apache-2.0
// Pictures in rows and columns with small labels: what a run or a comparison shows at a glance.
#pragma once

#include <string>
#include <vector>

#include "uwv/core/image.h"

namespace uwv::pipeline {

class ContactSheet {
 public:
  /// `cell` is the size every picture is brought to; rows and columns are at least 1.
  ContactSheet(Size cell, int columns, int rows);

  /// Puts a picture into a cell, with a label over its upper left corner.
  void put(int column, int row, const ImageRgb& picture, const std::string& label);

  const ImageRgb& picture() const { return sheet_; }

 private:
  Size cell_;
  ImageRgb sheet_;
};

/// A cell for pictures of `size`, no wider than `max_width`, aspect ratio kept.
Size contact_cell(Size size, int max_width);

}  // namespace uwv::pipeline
