// SPDX-License-Identifier: Apache-2.0
// How large the working picture is for a given source picture.
//
// The video model cuts pictures into square tokens of 16x16 pixels (8x by its VAE, 2x by its patches) and was trained
// at about 30*52 of them. The default policy is the official one ("keep aspect ratio"): as close as possible to that
// number of tokens at as close as possible to the source's aspect ratio.
#pragma once

#include "uwv/core/image.h"

namespace uwv {

/// Side of one token in pixels: sizes chosen by the token budget are multiples of it.
inline constexpr int token_side = 16;

struct ResizePolicy {
  enum class Mode {
    token_budget,  ///< The official rule; both sides multiples of 16, aspect ratio kept up to that rounding.
    exact,         ///< Stretched to `exact`, whatever the aspect ratio.
    none,          ///< The source's own size.
  };

  Mode mode = Mode::token_budget;
  Size exact;                ///< Mode `exact` only; any size of at least 1x1.
  Size budget = {832, 480};  ///< Mode `token_budget`: the size whose number of tokens is kept (the official default).
  int max_side = 1024;       ///< Mode `token_budget`: the longer side is shrunk to this (official value); 0 = no limit.

  /// Throws std::invalid_argument: exact not positive, budget below one token, max_side negative, or a side above
  /// 65535.
  void check() const;
};

/// The working size for a source of `source` pixels. Never smaller than 16x16 in mode `token_budget`; a source without
/// pixels gives the budget's own size there, as the official code does. Other modes throw std::invalid_argument for it.
Size target_size(Size source, const ResizePolicy& policy);

}  // namespace uwv
