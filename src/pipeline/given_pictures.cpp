// SPDX-License-Identifier: Apache-2.0
#include "pipeline/given_pictures.h"

#include "pipeline/source_clip.h"

namespace uwv::pipeline {

std::vector<ImageRgb> read_given_pictures(const std::string& path, const std::string& what, const RunOptions& options,
                                          std::size_t count, Size size, Monitor& monitor) {
  ClipOptions as_clip = clip_options(options);
  as_clip.max_frames = 0;
  as_clip.resize = {.mode = ResizePolicy::Mode::exact, .exact = size};
  const auto clip = open_clip(path, as_clip, monitor);
  std::vector<ImageRgb> pictures(count);
  for (std::size_t i = 0; i < count; ++i)
    if (static_cast<long>(i) >= clip->frames() || !clip->read(static_cast<long>(i), pictures[i]))
      fail(ErrorCode::size_mismatch, "{}: found {} {}s, wanted {}, one per frame of {}", path, i, what, count,
           options.video);
  return pictures;
}

}  // namespace uwv::pipeline
