// SPDX-License-Identifier: Apache-2.0
#include "uwv/core/mask.h"

namespace uwv {
namespace {

template <class To, class From>
To inverted(const From& from) {
  To to(from.size());
  std::transform(from.pixels().begin(), from.pixels().end(), to.pixels().begin(),
                 [](std::uint8_t v) { return static_cast<std::uint8_t>(v == 0); });
  return to;
}

}  // namespace

GenerateMask to_generate(const ValidityMask& known) { return inverted<GenerateMask>(known); }
ValidityMask to_validity(const GenerateMask& generate) { return inverted<ValidityMask>(generate); }

void intersect(ValidityMask& a, const ValidityMask& b) {
  require(a.size() == b.size(), "cannot intersect a {}x{} mask with a {}x{} one", a.width(), a.height(), b.width(),
          b.height());
  std::transform(a.pixels().begin(), a.pixels().end(), b.pixels().begin(), a.pixels().begin(),
                 [](std::uint8_t x, std::uint8_t y) { return static_cast<std::uint8_t>(x & y); });
}

}  // namespace uwv
