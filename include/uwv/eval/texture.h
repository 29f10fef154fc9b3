// SPDX-License-Identifier: Apache-2.0
// Procedural textures of synthetic scenes: smooth functions of a surface point, evaluated exactly at any resolution.
// None holds detail much finer than its `period`, so a picture whose pixels are several times smaller shows no aliasing
// and image metrics measure the renderer, not the sampling of the texture.
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace uwv {

/// Colour as sRGB values in [0, 1], red first.
using Colour = Eigen::Vector3f;

class Texture {
 public:
  /// One colour everywhere.
  static Texture flat(const Colour& colour);
  /// Squares of side `period` with softened edges.
  static Texture checker(const Colour& a, const Colour& b, double period);
  /// From `a` to `b` and back, a cosine of wavelength `period` along the x axis of the surface.
  static Texture gradient(const Colour& a, const Colour& b, double period);
  /// Random coloured clouds: a sum of plane waves around `mean` whose wavelengths lie in [period, 6 * period].
  static Texture noise(const Colour& mean, double period, std::uint64_t seed);
  /// Wavy growth rings `period` apart between two colours.
  static Texture wood(const Colour& a, const Colour& b, double period, std::uint64_t seed);

  /// The colour at a point in texture coordinates (scene units; see Shape for how surfaces are laid out).
  Colour at(const Eigen::Vector3d& x_in_texture) const;

 private:
  enum class Kind { flat, checker, gradient, noise, wood };
  struct Wave {
    Eigen::Vector3d frequency;  // radians per scene unit
    double phase;
    Colour amplitude;
  };
  Texture(Kind kind, const Colour& a, const Colour& b, double period);

  Kind kind_;
  Colour a_, b_;
  double period_;
  std::vector<Wave> waves_;
};

}  // namespace uwv
