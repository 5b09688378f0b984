#pragma once
// What the bindings share: arrays without copies, progress that hears Ctrl-C, models that can be run.
#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <chrono>
#include <csignal>
#include <iterator>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "amb_rotor/common/error.hpp"
#include "amb_rotor/model/model.hpp"

namespace amb_rotor {

void bindSweep(pybind11::module_& m);
void bindModel(pybind11::module_& m);
void bindSimulate(pybind11::module_& m);
void bindAnalysis(pybind11::module_& m);
void bindModes(pybind11::module_& m);
void bindValidation(pybind11::module_& m);

/// A vector as an array that owns it: nothing is copied.
inline pybind11::array_t<double> ownedArray(std::vector<double>&& values,
                                            std::vector<pybind11::ssize_t> shape = {}) {
  auto* kept = new std::vector<double>(std::move(values));
  pybind11::capsule owner(kept, [](void* p) { delete static_cast<std::vector<double>*>(p); });
  if (shape.empty()) shape.push_back(static_cast<pybind11::ssize_t>(kept->size()));
  return pybind11::array_t<double>(shape, kept->data(), owner);
}

/// Calls a Python function(share, text) from C++ that runs without the GIL, and throws where Ctrl-C was
/// pressed. At most every 50 ms, and when all is done.
class PythonProgress {
 public:
  explicit PythonProgress(pybind11::object callback) : callback_(std::move(callback)) {}

  void operator()(double share, const std::string& text) {
    const auto now = std::chrono::steady_clock::now();
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (share < 1.0 && now - last_ < std::chrono::milliseconds(50)) return;
      last_ = now;
    }
    const pybind11::gil_scoped_acquire acquire;
    if (PyErr_CheckSignals() != 0) throw pybind11::error_already_set();
    if (!callback_.is_none()) callback_(share, text);
  }

 private:
  pybind11::object callback_;
  std::mutex mutex_;
  std::chrono::steady_clock::time_point last_{};
};

/// While it lives, Ctrl-C and SIGTERM end the process as they would end one without Python, whose own handlers wait until a call
/// into C++ is over. For long calls in which nothing is left to tidy up. Only on the interpreter's main thread, whose
/// handlers these are.
class EndsAtOnce {
 public:
  EndsAtOnce() : on_(std::this_thread::get_id() == main_thread) {
    for (std::size_t i = 0; on_ && i < std::size(signals); ++i) before_[i] = std::signal(signals[i], SIG_DFL);
  }
  ~EndsAtOnce() {
    for (std::size_t i = 0; on_ && i < std::size(signals); ++i) std::signal(signals[i], before_[i]);
  }
  EndsAtOnce(const EndsAtOnce&) = delete;
  EndsAtOnce& operator=(const EndsAtOnce&) = delete;

 private:
  using Handler = void (*)(int);
  static constexpr int signals[] = {SIGINT, SIGTERM, SIGHUP};
  inline static const std::thread::id main_thread = std::this_thread::get_id();  // that of the import
  bool on_;
  Handler before_[std::size(signals)] = {};
};

/// @throw InputError: a flexible rotor whose modes are not there
inline void requireModes(const Model& model) {
  if (model.rotor_model == RotorModel::flexible && model.flexible.mass.empty())
    throw InputError({{"", 0, "rotor.model", "flexible",
                       "the modes of " + model.rotor_geometry + " are not there; rigid_beam works here"}});
}

}  // namespace amb_rotor
