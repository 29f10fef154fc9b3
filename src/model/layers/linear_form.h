// SPDX-License-Identifier: Apache-2.0
// The ways a linear layer's weight can be held and multiplied.
#pragma once

#include <string>

namespace uwv::model {

/// How a weight is held and multiplied. What a file holds in fewer bits than asked for stays as it is.
enum class LinearForm {
  f32,          ///< Multiplied in float32: the exact answer.
  bf16_stored,  ///< Held in bfloat16, multiplied in float32: half the memory, for CPUs without bfloat16 units.
  bf16,         ///< Held and multiplied in bfloat16, summed in float32: fast where the CPU has good units for it.
  int8_stored,  ///< Held in 8-bit whole numbers, one scale an output channel, multiplied in float32: a quarter.
  int8,         ///< Held so, and multiplied with tokens rounded to 8 bits, one scale a token: fastest with VNNI or AMX.
};

/// Bytes of each number of the tokens that layers of a form are handed: 2 in bf16, and in int8 where the CPU is fast in
/// bfloat16 (fast_numbers()), else 4. Layers take both; attention, which gets them too, is slow in the wrong one.
int token_bytes(LinearForm form);

/// The form's name as options give it: "f32", "bf16_stored", ...
std::string to_string(LinearForm form);
/// Throws std::invalid_argument listing the names for any other.
LinearForm linear_form(const std::string& name);

}  // namespace uwv::model
