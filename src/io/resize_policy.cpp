// SPDX-License-Identifier: Apache-2.0
#include "uwv/io/resize_policy.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace uwv {
namespace {

constexpr int largest_side = 65535;
constexpr int search_radius = 4;  // tokens to either side of the ideal, as in the official code

// Python's round(): halves go to the even neighbour.
int round_half_even(double v) { return static_cast<int>(std::nearbyint(v)); }

// The pair of token counts that loses least in number of tokens and in aspect ratio. The order of the search and the
// strict comparison decide between equals, so both are part of the rule.
Size best_tokens(double aspect, int budget) {
  const int ideal_width = std::max(1, round_half_even(std::sqrt(budget * aspect)));
  const int ideal_height = std::max(1, round_half_even(std::sqrt(budget / aspect)));
  Size best{ideal_width, ideal_height};
  double best_loss = std::numeric_limits<double>::infinity();
  for (int w = std::max(1, ideal_width - search_radius); w <= ideal_width + search_radius; ++w) {
    for (int h = std::max(1, ideal_height - search_radius); h <= ideal_height + search_radius; ++h) {
      const double loss = std::abs(w * h - budget) + std::abs(static_cast<double>(w) / h - aspect) * budget;
      if (loss < best_loss) {
        best_loss = loss;
        best = {w, h};
      }
    }
  }
  return best;
}

Size within_max_side(Size size, int max_side) {
  const int longer = std::max(size.width, size.height);
  if (max_side == 0 || longer <= max_side) return size;
  const double scale = static_cast<double>(max_side) / longer;
  const auto shrunk = [scale](int side) {
    return std::max(token_side, round_half_even(side * scale / token_side) * token_side);
  };
  return {shrunk(size.width), shrunk(size.height)};
}

}  // namespace

void ResizePolicy::check() const {
  if (mode == Mode::exact)
    require(exact.width > 0 && exact.height > 0 && exact.width <= largest_side && exact.height <= largest_side,
            "exact size is {}x{}; both sides must be in 1..{}", exact.width, exact.height, largest_side);
  if (mode != Mode::token_budget) return;
  require(budget.width >= token_side && budget.height >= token_side && budget.width <= largest_side &&
              budget.height <= largest_side,
          "budget is {}x{}; both sides must be in {}..{}", budget.width, budget.height, token_side, largest_side);
  require(max_side >= 0, "max_side is {}; 0 (no limit) or a number of pixels is wanted", max_side);
}

Size target_size(Size source, const ResizePolicy& policy) {
  policy.check();
  if (policy.mode == ResizePolicy::Mode::exact) return policy.exact;
  const bool has_pixels = source.width > 0 && source.height > 0;
  if (policy.mode == ResizePolicy::Mode::none) {
    require(has_pixels, "a source of {}x{} pixels cannot be kept as it is", source.width, source.height);
    return source;
  }
  if (!has_pixels) return policy.budget;
  const int tokens = (policy.budget.height / token_side) * (policy.budget.width / token_side);
  const Size best = best_tokens(static_cast<double>(source.width) / source.height, tokens);
  return within_max_side({best.width * token_side, best.height * token_side}, policy.max_side);
}

}  // namespace uwv
