// SPDX-License-Identifier: Apache-2.0
// Lets every thread of a run use the caller's monitor, and remembers the warnings for run.json.
#pragma once

#include <atomic>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "uwv/core/monitor.h"

namespace uwv::pipeline {

/// Warnings may come from any thread; the caller hears them on the thread that made this object, which is the one that
/// runs the job.
class RecordingMonitor : public Monitor {
 public:
  explicit RecordingMonitor(Monitor& caller) : caller_(caller), job_thread_(std::this_thread::get_id()) {}

  bool progress(std::string_view stage, long done, long total) override {
    if (std::this_thread::get_id() != job_thread_) return !stopped_;
    pass_on();
    if (!caller_.progress(stage, done, total)) stopped_ = true;
    return !stopped_;
  }

  void warn(const std::string& sentence) override {
    {
      const std::lock_guard lock(mutex_);
      warnings_.push_back(sentence);
    }
    if (std::this_thread::get_id() == job_thread_) pass_on();
  }

  /// All so far.
  std::vector<std::string> warnings() {
    pass_on();
    const std::lock_guard lock(mutex_);
    return warnings_;
  }

 private:
  void pass_on() {
    std::vector<std::string> news;
    {
      const std::lock_guard lock(mutex_);
      news.assign(warnings_.begin() + static_cast<std::ptrdiff_t>(std::exchange(passed_on_, warnings_.size())),
                  warnings_.end());
    }
    for (const std::string& sentence : news) caller_.warn(sentence);
  }

  Monitor& caller_;
  const std::thread::id job_thread_;
  std::atomic<bool> stopped_ = false;
  std::mutex mutex_;
  std::vector<std::string> warnings_;
  std::size_t passed_on_ = 0;
};

}  // namespace uwv::pipeline
