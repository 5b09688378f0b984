#pragma once
// Analysis of a recorded stream of steps, block by block: orbit, orders, full spectrum, whirl, contact,
// Poincare section at the tacho pulse, regime. The same numbers live and from a bag: only the messages'
// content counts.
//
// A block begins at a tacho pulse and covers whole turns; where the shaft hardly turns it covers a length of
// time.
#include <cstdint>
#include <deque>
#include <vector>

#include "amb_rotor/analysis/poincare.hpp"
#include "amb_rotor/ros/messages.hpp"

namespace amb_rotor {

struct BlockOptions {
  int turns = 25;         ///< of a block
  double longest = 0.25;  ///< [s] a block ends then at the latest
  int points = 128;       ///< of the Poincare section that decide the regime, at most
  int max_order = 5;
  double tolerance = 0.01;  ///< of the period detection [clearances]
};

/// One end.
class BlockAnalysis {
 public:
  BlockAnalysis(int end, const ModelInfo& info, const BlockOptions& options);

  struct Output {
    std::vector<SectionPoint> points;
    std::vector<OrbitAnalysis> blocks;
    std::vector<FullSpectrum> spectra;
  };
  /// @param state  on the recording's grid; contact answers it.
  void add(const RotorState& state, const ContactForces& contact, Output& out);
  /// Ends the block that is open.
  void finish(Output& out);

 private:
  void close(bool last, Output& out);
  void decide(const std::vector<double>& x, const std::vector<double>& y, OrbitAnalysis& result) const;

  int end_;
  ModelInfo info_;
  BlockOptions options_;
  PoincareAccumulator section_;
  std::deque<PoincarePoint> points_;
  std::uint64_t block_ = 0;
  std_msgs::Header header_;
  bool in_contact_ = false;
  // samples of the open block
  std::vector<double> time_, angle_, x_, y_, force_, centre_x_, centre_y_;
};

}  // namespace amb_rotor
