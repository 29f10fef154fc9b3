// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <fstream>
#include <opencv2/dnn.hpp>
#include <opencv2/imgproc.hpp>

#include "geometry/deterministic_cv.h"
#include "geometry/layers/cv_bridge.h"
#include "uwv/geometry/saliency.h"

namespace uwv {
namespace {

constexpr int side = 320;  // the network's own input size
constexpr double nothing = 0.2;

bool is_answer(const cv::Mat& blob) {
  return blob.dims == 4 && blob.size[0] == 1 && blob.size[1] == 1 && blob.size[2] == side && blob.size[3] == side;
}

class SaliencyNetwork : public ForegroundFinder {
 public:
  explicit SaliencyNetwork(const std::string& path) {
    if (!std::ifstream(path, std::ios::binary))
      fail(ErrorCode::file_not_found, "{}: cannot open this saliency network; scripts/setup fetches u2netp.onnx", path);
    try {
      net_ = cv::dnn::readNetFromONNX(path);
    } catch (const cv::Exception&) {
      fail(ErrorCode::file_damaged, "{}: cannot be read as an ONNX network; let scripts/setup fetch u2netp.onnx anew",
           path);
    }
    learn_output(path);
  }

  Image<float> find(const ImageRgb& picture) override {
    require(!picture.empty(), "saliency needs a picture, got {}x{} pixels", picture.width(), picture.height());
    const DeterministicCv deterministic;
    cv::Mat answer = run(input_of(picture));
    double low = 0, high = 0;
    cv::minMaxLoc(answer, &low, &high);
    if (high > nothing && high > low) answer = (answer - low) / (high - low);
    Image<float> out(picture.size());
    cv::Mat view = layers::view(out);
    cv::resize(answer, view, view.size(), 0, 0, cv::INTER_LINEAR);
    return out;
  }

  std::string name() const override { return "u2netp"; }

 private:
  /// Asks the network for an empty picture: only this tells whether it is one of our kind.
  void learn_output(const std::string& path) {
    try {
      const std::array<int, 4> shape{1, 3, side, side};
      net_.setInput(cv::Mat(4, shape.data(), CV_32F, cv::Scalar(0)));
      for (const std::string& output : net_.getUnconnectedOutLayersNames())
        if (output_.empty() && is_answer(net_.forward(output))) output_ = output;
    } catch (const cv::Exception&) {
      output_.clear();
    }
    if (output_.empty())
      fail(ErrorCode::format_unknown,
           "{}: this network does not turn a 1x3x320x320 picture into a 1x1x320x320 answer as u2netp does; give "
           "u2netp.onnx",
           path);
  }

  static cv::Mat input_of(const ImageRgb& picture) {
    cv::Mat small, scaled;
    const bool shrinks = picture.width() > side && picture.height() > side;
    cv::resize(layers::view(picture), small, {side, side}, 0, 0, shrinks ? cv::INTER_AREA : cv::INTER_CUBIC);
    double brightest = 0;
    cv::minMaxLoc(small.reshape(1), nullptr, &brightest);
    small.convertTo(scaled, CV_32F, 1.0 / std::max(brightest, 1.0));
    cv::subtract(scaled, cv::Scalar(0.485, 0.456, 0.406), scaled);
    cv::divide(scaled, cv::Scalar(0.229, 0.224, 0.225), scaled);
    return cv::dnn::blobFromImage(scaled);
  }

  cv::Mat run(const cv::Mat& input) {
    net_.setInput(input);
    cv::Mat answer = net_.forward(output_);
    return cv::Mat(side, side, CV_32F, answer.ptr<float>()).clone();
  }

  cv::dnn::Net net_;
  std::string output_;
};

}  // namespace

std::unique_ptr<ForegroundFinder> make_saliency_network(const std::string& onnx_path) {
  return std::make_unique<SaliencyNetwork>(onnx_path);
}

}  // namespace uwv
