// SPDX-License-Identifier: Apache-2.0
#include "uwv/eval/texture.h"

#include <cmath>
#include <numbers>

#include "uwv/core/error.h"

namespace uwv {
namespace {

constexpr double tau = 2 * std::numbers::pi;

// Our own generator, so that a scene has the same picture under every standard library (splitmix64).
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : state_(seed) {}
  double in(double low, double high) { return low + (high - low) * unit(); }

 private:
  double unit() {
    state_ += 0x9E3779B97F4A7C15ULL;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1.0p-53;
  }
  std::uint64_t state_;
};

Eigen::Vector3d random_direction(Dice& dice) {
  const double z = dice.in(-1, 1);
  const double angle = dice.in(0, tau);
  const double radius = std::sqrt(1 - z * z);
  return {radius * std::cos(angle), radius * std::sin(angle), z};
}

Colour mix(const Colour& a, const Colour& b, double share_of_b) { return a + static_cast<float>(share_of_b) * (b - a); }

// +-1 on alternating squares of side `period`, rising over about a tenth of it.
double soft_checker(const Eigen::Vector3d& x, double period) {
  const double k = std::numbers::pi / period;
  // The third factor is 1 on a flat surface (z = 0) and turns the squares into cubes on a solid.
  const double s = std::sin(k * x.x()) * std::sin(k * x.y()) * std::cos(k * x.z());
  return s / std::sqrt(s * s + 0.02);
}

}  // namespace

Texture::Texture(Kind kind, const Colour& a, const Colour& b, double period)
    : kind_(kind), a_(a), b_(b), period_(period) {
  require(period > 0 && std::isfinite(period), "a texture's period must be positive, not {}", period);
}

Texture Texture::flat(const Colour& colour) { return {Kind::flat, colour, colour, 1.0}; }

Texture Texture::checker(const Colour& a, const Colour& b, double period) { return {Kind::checker, a, b, period}; }

Texture Texture::gradient(const Colour& a, const Colour& b, double period) { return {Kind::gradient, a, b, period}; }

Texture Texture::noise(const Colour& mean, double period, std::uint64_t seed) {
  Texture texture(Kind::noise, mean, mean, period);
  Dice dice(seed);
  const int waves = 16;
  for (int i = 0; i < waves; ++i) {
    // Longer waves are stronger, as in photographs, where amplitude falls about as fast as frequency grows.
    const double wavelength = period * std::pow(6.0, i / (waves - 1.0));
    const double amplitude = 0.06 * std::pow(wavelength / (6 * period), 0.7);
    Wave wave;
    wave.frequency = tau / wavelength * random_direction(dice);
    wave.phase = dice.in(0, tau);
    // Mostly lightness: colour varies less than light and shade do.
    for (int c = 0; c < 3; ++c) wave.amplitude[c] = static_cast<float>(amplitude * (1 + dice.in(-0.6, 0.6)));
    texture.waves_.push_back(wave);
  }
  return texture;
}

Texture Texture::wood(const Colour& a, const Colour& b, double period, std::uint64_t seed) {
  Texture texture(Kind::wood, a, b, period);
  Dice dice(seed);
  for (int i = 0; i < 3; ++i) {
    Wave wave;
    wave.frequency = tau / (period * dice.in(4, 12)) * random_direction(dice);
    wave.phase = dice.in(0, tau);
    wave.amplitude.setConstant(static_cast<float>(dice.in(0.15, 0.35)));
    texture.waves_.push_back(wave);
  }
  return texture;
}

Colour Texture::at(const Eigen::Vector3d& x) const {
  switch (kind_) {
    case Kind::flat: return a_;
    case Kind::checker: return mix(a_, b_, 0.5 - 0.5 * soft_checker(x, period_));
    case Kind::gradient: return mix(a_, b_, 0.5 - 0.5 * std::cos(tau * x.x() / period_));
    case Kind::noise: {
      Colour sum = a_;
      for (const Wave& wave : waves_)
        sum += static_cast<float>(std::cos(wave.frequency.dot(x) + wave.phase)) * wave.amplitude;
      return sum.cwiseMax(0.0F).cwiseMin(1.0F);
    }
    case Kind::wood: {
      double rings = std::hypot(x.x(), 0.15 * x.y(), x.z()) / period_;
      for (const Wave& wave : waves_)
        rings += static_cast<double>(wave.amplitude[0]) * std::cos(wave.frequency.dot(x) + wave.phase);
      return mix(a_, b_, 0.5 - 0.5 * std::cos(tau * rings));
    }
  }
  return a_;
}

}  // namespace uwv
