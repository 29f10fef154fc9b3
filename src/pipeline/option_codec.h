// SPDX-License-Identifier: Apache-2.0
// How each type an option can have is written to JSON, read from JSON, and read from text on the command line.
#pragma once

#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "uwv/pipeline/run_options.h"

namespace uwv::pipeline {

/// Every name of an enumeration, as used in flags and files.
template <class E>
struct EnumNames;

template <>
struct EnumNames<PixelCentre> {
  static constexpr std::pair<PixelCentre, std::string_view> all[] = {{PixelCentre::half, "half"},
                                                                     {PixelCentre::integer, "integer"}};
};
template <>
struct EnumNames<RendererChoice> {
  static constexpr std::pair<RendererChoice, std::string_view> all[] = {
      {RendererChoice::automatic, "auto"}, {RendererChoice::gl, "gl"}, {RendererChoice::cpu, "cpu"}};
};
template <>
struct EnumNames<GlBackend> {
  static constexpr std::pair<GlBackend, std::string_view> all[] = {
      {GlBackend::automatic, "auto"}, {GlBackend::egl, "egl"}, {GlBackend::osmesa, "osmesa"}};
};
template <>
struct EnumNames<GeometryChoice> {
  static constexpr std::pair<GeometryChoice, std::string_view> all[] = {{GeometryChoice::automatic, "auto"},
                                                                        {GeometryChoice::import, "import"},
                                                                        {GeometryChoice::network, "network"},
                                                                        {GeometryChoice::sfm, "sfm"},
                                                                        {GeometryChoice::prior, "prior"}};
};
template <>
struct EnumNames<CloudChoice> {
  static constexpr std::pair<CloudChoice, std::string_view> all[] = {
      {CloudChoice::automatic, "auto"}, {CloudChoice::per_frame, "per_frame"}, {CloudChoice::merged, "merged"}};
};
template <>
struct EnumNames<LayerChoice> {
  static constexpr std::pair<LayerChoice, std::string_view> all[] = {
      {LayerChoice::automatic, "auto"}, {LayerChoice::on, "on"}, {LayerChoice::off, "off"}};
};
template <>
struct EnumNames<DepthKind> {
  static constexpr std::pair<DepthKind, std::string_view> all[] = {{DepthKind::depth, "depth"},
                                                                   {DepthKind::inverse, "inverse"},
                                                                   {DepthKind::relative_inverse, "relative_inverse"},
                                                                   {DepthKind::relative_depth, "relative_depth"}};
};
template <>
struct EnumNames<DepthOutput> {
  static constexpr std::pair<DepthOutput, std::string_view> all[] = {
      {DepthOutput::npz, "npz"}, {DepthOutput::png16, "png16"}, {DepthOutput::exr, "exr"}, {DepthOutput::none, "none"}};
};
template <>
struct EnumNames<ReliabilityChoice> {
  static constexpr std::pair<ReliabilityChoice, std::string_view> all[] = {
      {ReliabilityChoice::automatic, "auto"}, {ReliabilityChoice::on, "on"}, {ReliabilityChoice::off, "off"}};
};
template <>
struct EnumNames<AlignmentSmoothing> {
  static constexpr std::pair<AlignmentSmoothing, std::string_view> all[] = {{AlignmentSmoothing::joint, "joint"},
                                                                            {AlignmentSmoothing::momentum, "momentum"},
                                                                            {AlignmentSmoothing::none, "none"}};
};
template <>
struct EnumNames<Completion> {
  static constexpr std::pair<Completion, std::string_view> all[] = {
      {Completion::none, "none"}, {Completion::inpaint, "inpaint"}, {Completion::model, "model"}};
};
template <>
struct EnumNames<model::SamplerKind> {
  static constexpr std::pair<model::SamplerKind, std::string_view> all[] = {
      {model::SamplerKind::euler, "euler"},
      {model::SamplerKind::euler_plain, "euler_plain"},
      {model::SamplerKind::unipc, "unipc"},
      {model::SamplerKind::unipc_legacy, "unipc_legacy"},
      {model::SamplerKind::dpmpp, "dpmpp"}};
};
template <>
struct EnumNames<WeightsForm> {
  static constexpr std::pair<WeightsForm, std::string_view> all[] = {
      {WeightsForm::automatic, "auto"},          {WeightsForm::f32, "f32"},
      {WeightsForm::bf16_stored, "bf16_stored"}, {WeightsForm::bf16, "bf16"},
      {WeightsForm::int8_stored, "int8_stored"}, {WeightsForm::int8, "int8"}};
};
template <>
struct EnumNames<StreamChoice> {
  static constexpr std::pair<StreamChoice, std::string_view> all[] = {
      {StreamChoice::automatic, "auto"}, {StreamChoice::on, "on"}, {StreamChoice::off, "off"}};
};
template <>
struct EnumNames<VaeNumbers> {
  static constexpr std::pair<VaeNumbers, std::string_view> all[] = {
      {VaeNumbers::automatic, "auto"}, {VaeNumbers::f32, "f32"}, {VaeNumbers::bf16, "bf16"}};
};
template <>
struct EnumNames<Kernel> {
  static constexpr std::pair<Kernel, std::string_view> all[] = {
      {Kernel::nearest, "nearest"}, {Kernel::bilinear, "bilinear"}, {Kernel::resample, "resample"}};
};
template <>
struct EnumNames<Visibility> {
  static constexpr std::pair<Visibility, std::string_view> all[] = {
      {Visibility::none, "none"}, {Visibility::ztest, "ztest"}, {Visibility::reproject, "reproject"}};
};
template <>
struct EnumNames<Accumulation> {
  static constexpr std::pair<Accumulation, std::string_view> all[] = {
      {Accumulation::product, "product"},
      {Accumulation::product_in_view, "product_in_view"},
      {Accumulation::none, "none"},
      {Accumulation::foreground, "foreground"}};
};

/// write: value to JSON. read and parse: false when JSON or text is not such a value. wanted: what one looks like.
template <class T>
struct Codec;

template <class T>
bool parse_number(std::string_view text, T& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size();
}

template <>
struct Codec<std::string> {
  static nlohmann::ordered_json write(const std::string& value) { return value; }
  static bool read(const nlohmann::json& json, std::string& value) {
    return json.is_string() && (value = json.get<std::string>(), true);
  }
  static bool parse(std::string_view text, std::string& value) { return value = text, true; }
  static std::string wanted() { return "text"; }
};

template <>
struct Codec<bool> {
  static nlohmann::ordered_json write(bool value) { return value; }
  static bool read(const nlohmann::json& json, bool& value) {
    return json.is_boolean() && (value = json.get<bool>(), true);
  }
  static bool parse(std::string_view text, bool& value) {
    value = text == "true";
    return text == "true" || text == "false";
  }
  static std::string wanted() { return "true or false"; }
};

template <class Integer>
struct IntegerCodec {
  static nlohmann::ordered_json write(Integer value) { return value; }
  static bool read(const nlohmann::json& json, Integer& value) {
    return json.is_number_integer() && parse_number(json.dump(), value);
  }
  static bool parse(std::string_view text, Integer& value) { return parse_number(text, value); }
  static std::string wanted() { return "a whole number"; }
};
template <>
struct Codec<int> : IntegerCodec<int> {};
template <>
struct Codec<long> : IntegerCodec<long> {};

template <class Real>
struct RealCodec {
  /// The shortest decimal that reads back as the same value: 0.1F is written 0.1.
  static nlohmann::ordered_json write(Real value) { return std::stod(fmt::format("{}", value)); }
  static bool read(const nlohmann::json& json, Real& value) {
    return json.is_number() && (value = json.get<Real>(), std::isfinite(value));
  }
  static bool parse(std::string_view text, Real& value) { return parse_number(text, value) && std::isfinite(value); }
  static std::string wanted() { return "a number"; }
};
template <>
struct Codec<float> : RealCodec<float> {};
template <>
struct Codec<double> : RealCodec<double> {};

template <>
struct Codec<Size> {
  static nlohmann::ordered_json write(Size size) {
    return size == Size{} ? std::string() : fmt::format("{}x{}", size.width, size.height);
  }
  static bool read(const nlohmann::json& json, Size& size) {
    return json.is_string() && parse(json.get<std::string>(), size);
  }
  static bool parse(std::string_view text, Size& size) {
    if (text.empty()) return size = Size{}, true;
    const auto x = text.find('x');
    return x != std::string_view::npos && parse_number(text.substr(0, x), size.width) &&
           parse_number(text.substr(x + 1), size.height);
  }
  static std::string wanted() { return "WIDTHxHEIGHT, for example 832x480"; }
};

template <>
struct Codec<std::vector<long>> {
  static nlohmann::ordered_json write(const std::vector<long>& values) { return values; }
  static bool read(const nlohmann::json& json, std::vector<long>& values) {
    values.assign(json.is_array() ? json.size() : 0, 0);
    for (std::size_t i = 0; i < values.size(); ++i)
      if (!Codec<long>::read(json[i], values[i])) return false;
    return json.is_array();
  }
  static bool parse(std::string_view text, std::vector<long>& values) {
    values.clear();
    while (!text.empty()) {
      const auto comma = std::min(text.find(','), text.size());
      if (!parse_number(text.substr(0, comma), values.emplace_back())) return false;
      text.remove_prefix(std::min(comma + 1, text.size()));
    }
    return true;
  }
  static std::string wanted() { return "whole numbers separated by commas"; }
};

template <>
struct Codec<std::vector<std::string>> {
  static nlohmann::ordered_json write(const std::vector<std::string>& values) { return values; }
  static bool read(const nlohmann::json& json, std::vector<std::string>& values) {
    values.assign(json.is_array() ? json.size() : 0, {});
    for (std::size_t i = 0; i < values.size(); ++i)
      if (!Codec<std::string>::read(json[i], values[i])) return false;
    return json.is_array();
  }
  static bool parse(std::string_view text, std::vector<std::string>& values) {
    values.clear();
    while (!text.empty()) {
      const auto comma = std::min(text.find(','), text.size());
      values.emplace_back(text.substr(0, comma));
      text.remove_prefix(std::min(comma + 1, text.size()));
    }
    return true;
  }
  static std::string wanted() { return "names separated by commas"; }
};

template <class T>
struct Codec<std::optional<T>> {
  static nlohmann::ordered_json write(const std::optional<T>& value) {
    return value ? Codec<T>::write(*value) : nlohmann::ordered_json();
  }
  static bool read(const nlohmann::json& json, std::optional<T>& value) {
    if (json.is_null()) return value.reset(), true;
    return Codec<T>::read(json, value.emplace());
  }
  static bool parse(std::string_view text, std::optional<T>& value) {
    if (text.empty()) return value.reset(), true;
    return Codec<T>::parse(text, value.emplace());
  }
  static std::string wanted() { return Codec<T>::wanted(); }
};

template <class E>
requires std::is_enum_v<E>
struct Codec<E> {
  static nlohmann::ordered_json write(E value) {
    for (const auto& [known, name] : EnumNames<E>::all)
      if (known == value) return name;
    return {};
  }
  static bool read(const nlohmann::json& json, E& value) {
    // What is on, off or auto today was a flag in older records.
    if (json.is_boolean()) return parse(json.get<bool>() ? "on" : "off", value);
    return json.is_string() && parse(json.get<std::string>(), value);
  }
  static bool parse(std::string_view text, E& value) {
    for (const auto& [known, name] : EnumNames<E>::all)
      if (name == text) return value = known, true;
    return false;
  }
  static std::string wanted() {
    std::string names;
    for (const auto& [known, name] : EnumNames<E>::all) names += (names.empty() ? "one of " : ", ") + std::string(name);
    return names;
  }
};

}  // namespace uwv::pipeline
