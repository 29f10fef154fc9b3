// SPDX-License-Identifier: Apache-2.0
// What went wrong, in the words the user would read.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "uwv/core/error.h"

namespace uwv::testing {

/// The sentence of the Error that `work` throws.
template <class Work>
std::string complaint(Work work) {
  try {
    work();
  } catch (const Error& error) {
    return error.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return "";
}

/// The same, and holds it to its code.
template <class Work>
std::string complaint(Work work, ErrorCode code) {
  try {
    work();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return "";
}

}  // namespace uwv::testing
