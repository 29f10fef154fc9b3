// SPDX-License-Identifier: Apache-2.0
// Small networks for tests, written as TorchScript source, so that what they compute is known exactly.
#pragma once

#include <string>
#include <string_view>

#include "support/temp_folder.h"

namespace uwv::test {

/// Saves a module with these methods (TorchScript source, at least "def forward(self, x): ...").
void save_script(const std::string& path, const std::string& source);
/// Saves one tensor as torch.save does: a pickle in a zip, no network.
void save_tensor_only(const std::string& path);

/// A folder with a network and its manifest.
class NetFolder {
 public:
  NetFolder(const std::string& source, std::string_view manifest) {
    save_script(folder_.file("model.ts"), source);
    folder_.write("manifest.json", manifest);
  }
  std::string path() const { return folder_.path().string(); }
  const TempFolder& files() const { return folder_; }

 private:
  TempFolder folder_;
};

}  // namespace uwv::test
