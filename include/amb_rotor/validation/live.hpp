#pragma once
// A running model against a running rig: samples come in one by one, and each block of them is predicted and judged.
//
// While the rotor is free the machine is simulated on and on from block to block, driven by the measured shaft and
// excitation alone; its start is read off the measurement, and what that was wrong by dies away in the first block, which
// is not judged. Where the rotor may touch, or a bearing is off, motion is not predictable for long: there the block is
// predicted over windows of 10 ms, each from its own estimated start (validation/fit.hpp).
// A residual is over its noise, so that 1 is the floor. A displacement's mean over a block is taken as its sensor's
// offset, up to a limit. Left out: the controller's integrators start at 0; drift; a law in time begins with each block.
#include <array>
#include <string>
#include <vector>

#include "amb_rotor/model/model.hpp"
#include "amb_rotor/validation/predict.hpp"
#include "amb_rotor/validation/recording.hpp"

namespace amb_rotor {

/// What a rig shows at one instant. Axes: ax, ay, bx, by.
struct LiveSample {
  long index = 0;             ///< on the grid of the recording: instant index/rate
  double angle_rad = 0.0, speed_rad_s = 0.0;
  double displacement_m[4] = {0, 0, 0, 0};
  double current_A[4] = {0, 0, 0, 0};      ///< control currents
  double excitation_A[4] = {0, 0, 0, 0};   ///< added to the commands
  bool bearing_on[4] = {true, true, true, true};
};

struct LiveOptions {
  double rate_hz = 1e4;            ///< of the samples
  double block_s = 0.1;            ///< at most 3 % more, so that it is a whole number of the controller's samples
  double noise_m = 0.5e-6, noise_A = 5e-3;  ///< of a residual
  double offset_limit_m = 3e-6;    ///< of a sensor's offset
  double limit = 1.5, limit_contact = 2.5;  ///< error above which a block does not hold
  int patience = 3;                ///< blocks one after the other until the model counts as left, or as holding again
};

struct LiveBlock {
  long first = 0, samples = 0;     ///< on the grid
  std::string regime;              ///< settling, standstill, steady, speed_change, excited, contact, amb_off
  bool judged = false;             ///< false: settling
  double error = 0.0;              ///< residual over noise, rms over the channels
  std::array<double, predicted_channels> channel_error{};
  std::array<double, 4> offset_m{};
  double speed_hz = 0.0;
  bool left = false;               ///< the model counts as left after this block
  std::vector<double> measured, predicted;  ///< samples * predicted_channels, the offsets in the prediction
};

class LiveComparison {
 public:
  /// @throw InputError: no block is a whole number of samples of both recording and controller
  LiveComparison(const Model& model, const LiveOptions& options);

  /// Takes a sample; true where it ends a block. A gap, or a sample of the past, begins a new block and a new start. One
  /// that is not finite is left out.
  bool add(const LiveSample& sample);
  const LiveBlock& block() const { return block_; }
  long gaps() const { return gaps_; }
  long blockSamples() const { return length_; }

 private:
  void judge();
  Recording recordingOfBlock() const;
  bool mayTouch() const;
  void predictFree(const Recording& rec);
  void predictWindows(const Recording& rec);
  std::string regimeOf() const;
  void count();

  Model model_;
  LiveOptions options_;
  long length_ = 0, controller_samples_ = 0;
  std::vector<LiveSample> samples_;
  LiveBlock block_;
  MachineState<double> state_;   ///< at the start of the block to come; without mechanics: unknown
  long next_ = -1, gaps_ = 0;
  int against_ = 0;              ///< blocks one after the other that speak against the present verdict
  bool left_ = false;
};

}  // namespace amb_rotor
