// SPDX-License-Identifier: Apache-2.0
// Feeds damaged variants of a valid file to a reader: it must load or throw uwv::Error, never crash or throw otherwise.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <random>
#include <string>

#include "support/temp_folder.h"
#include "uwv/core/error.h"

namespace uwv::test {

using ReadFile = std::function<void(const std::string& path)>;

/// Expects uwv::Error with `code` and a one-line sentence that names the file.
inline void expect_error(ErrorCode code, const std::string& path, const std::function<void()>& action) {
  try {
    action();
    ADD_FAILURE() << path << " was accepted";
  } catch (const Error& error) {
    EXPECT_EQ(to_string(error.code()), to_string(code)) << error.what();
    const std::string sentence = error.what();
    EXPECT_NE(sentence.find(path), std::string::npos) << sentence;
    EXPECT_EQ(sentence.find('\n'), std::string::npos) << sentence;
  }
}

/// Loads or throws uwv::Error; anything else is reported with the description of the damage. True when it loaded.
inline bool survives(const ReadFile& read, const std::string& path, const std::string& damage) {
  try {
    read(path);
    return true;
  } catch (const Error&) {
    return false;
  } catch (const std::exception& error) {
    ADD_FAILURE() << damage << ": " << error.what();
    return false;
  }
}

/// Every truncation (or every `step`-th) of the file. Returns how many were accepted.
inline int try_truncations(const std::string& bytes, const std::string& file_name, const ReadFile& read,
                           std::size_t step = 1) {
  const TempFolder folder;
  int accepted = 0;
  for (std::size_t length = 0; length < bytes.size(); length += step)
    accepted += survives(read, folder.write(file_name, std::string_view(bytes).substr(0, length)),
                         "cut to " + std::to_string(length) + " bytes");
  return accepted;
}

/// `count` files with one to four random bytes changed each.
inline void try_byte_flips(const std::string& bytes, const std::string& file_name, const ReadFile& read, int count) {
  const TempFolder folder;
  std::mt19937 random(7);
  for (int i = 0; i < count; ++i) {
    std::string damaged = bytes;
    std::string damage = "changed bytes";
    for (int changes = 1 + static_cast<int>(random() % 4); changes > 0; --changes) {
      const std::size_t at = random() % damaged.size();
      damaged[at] = static_cast<char>(random());
      damage += fmt::format(" {}={:#04x}", at, static_cast<unsigned char>(damaged[at]));
    }
    survives(read, folder.write(file_name, damaged), damage);
  }
}

}  // namespace uwv::test
