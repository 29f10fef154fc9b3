// SPDX-License-Identifier: Apache-2.0
// Several beginnings are tried on few tracks and a few key frames, and the one that ends best is carried on: a wrong
// focal length, a pair dominated by a moving thing and the false twin of a plane's pose all show in the error they end
// with.
#pragma once

#include "geometry/sfm/incremental.h"
#include "uwv/core/monitor.h"
#include "uwv/core/thread_pool.h"

namespace uwv::sfm {

/// A lens to begin with: fixed, or to be refined.
struct LensGuess {
  Intrinsics lens;
  GrowOptions grow;
};

struct Exploration {
  std::vector<LensGuess> guesses;
  std::size_t first_guesses = 1;  ///< The others are tried only where no two free ones of these find the same lens.
  std::span<const int> keyframes;
  std::span<const FramePair> pairs;
  Size size;
  int frames = 0;
};

/// One beginning and what became of it.
struct Trial {
  std::size_t guess = 0;  ///< Which lens it began with.
  bool from_plane = false;
  Reconstruction reconstruction;
  double misfit = 0;  ///< See incremental.h; over the frames that were tried.
  double score = 0;   ///< The misfit, a little more for an unlikely lens: where nothing tells, the likely one wins.
};

/// Tracks such that every listed frame keeps about `per_frame` of them, long ones first.
std::vector<Track> thinned(const std::vector<Track>& tracks, std::span<const int> frames, int per_frame);

/// Guesses with every promising pair, grown over some key frames around the pair; best first. Does not depend on
/// the number of threads.
std::vector<Trial> try_beginnings(const std::vector<Track>& few, const Exploration& exploration, ThreadPool& pool,
                                  Monitor& monitor);

struct Outcome {
  bool found = false;
  Reconstruction reconstruction;  ///< Its points are not set: they depend on the tracks.
  bool from_plane = false;
  double misfit = 0;  ///< Over all key frames.
  int tried = 0;
};
/// The best trials of the guesses from..to-1 carried on to all key frames until one convinces.
Outcome carry_on(const std::vector<Track>& few, const Exploration& exploration, const std::vector<Trial>& trials,
                 std::size_t from, std::size_t to, Monitor& monitor);

}  // namespace uwv::sfm
