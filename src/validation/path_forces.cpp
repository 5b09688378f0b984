#include "path_forces.hpp"

#include <algorithm>
#include <cmath>

#include "amb_rotor/common/error.hpp"
#include "amb_rotor/effects/all.hpp"
#include "amb_rotor/magnetic_bearing/amplifier.hpp"
#include "amb_rotor/validation/loop_offsets.hpp"
#include "amb_rotor/validation/stretches.hpp"

namespace amb_rotor {
namespace {

constexpr long half_width = 4;  // instants to each side of a parabola's middle
constexpr double away_from_zero = 1e-30;

/// Places, velocities, currents and shaft of a run, instant by instant, both ends.
struct Path {
  std::vector<Vec2<double>> position[2], velocity[2], current[2];
  std::vector<Shaft<double>> shaft;
};

Path measuredPath(const ReferenceRun& run, const Model& model) {
  const Recording& rec = run.recording;
  const auto& planes = model.rig.planes;
  Path out;
  for (int end = 0; end < 2; ++end)
    for (auto* of : {&out.position[end], &out.velocity[end], &out.current[end]}) of->resize(rec.samples);
  for (long i = 0; i < rec.samples; ++i) {
    double value[4], slope[4];
    for (int c = 0; c < 4; ++c) localParabola(rec, c, i - half_width, 2 * half_width + 1, i, value[c], slope[c]);
    for (int end = 0; end < 2; ++end) {
      const double share = (planes.amb[end] - planes.sensor[0]) / (planes.sensor[1] - planes.sensor[0]);
      const auto at = [&](const double* of) {
        return Vec2<double>{of[0] + share * (of[2] - of[0]), of[1] + share * (of[3] - of[1])};
      };
      out.position[end][i] = at(value);
      out.velocity[end][i] = at(slope);
      const auto current = [&](int c) {
        return (rec.noise[c] > 0.0 ? rec.measured : run.predicted)[i * predicted_channels + c];
      };
      out.current[end][i] = {current(4 + 2 * end), current(5 + 2 * end)};
    }
    const double time = i / rec.run.sample_rate_hz;
    ShaftInstant shaft = rec.standstill ? ShaftInstant{run.angle_rad, 0.0, 0.0} : shaftAt(rec, model, time);
    shaft.angle += run.turning.rad + run.turning.rad_s * (time - rec.first_turns_s);
    shaft.speed += run.turning.rad_s;
    out.shaft.push_back(Shaft<double>::at(shaft.angle, shaft.speed, 0.0));
    out.shaft.back().time = time;
  }
  return out;
}

/// The rotor at an instant, taken as straight: forces at its planes as those at the magnetic bearings that do the same.
class PathRotor final : public RotorPort<double>, public RotorForces<double> {
 public:
  explicit PathRotor(const Rig<double>& rig) : rig_(rig) {}
  int addPlane(const double& z) override {
    share_.push_back((z - rig_.planes.amb[0]) / (rig_.planes.amb[1] - rig_.planes.amb[0]));
    return static_cast<int>(share_.size()) - 1;
  }
  void addMode(const double&, const double&, const double&, const double[2], const double[2], const double[2], const double&) override {
    AMB_ROTOR_CHECK(false, "a force along a path that bends the rotor");
  }
  void moveTo(const Path& path, std::size_t instant) {
    for (int end = 0; end < 2; ++end) {
      position_[end] = path.position[end][instant];
      velocity_[end] = path.velocity[end][instant];
      force[end] = {};
    }
  }
  Vec2<double> position(int plane) const override { return between(position_, share_[plane]); }
  Vec2<double> velocity(int plane) const override { return between(velocity_, share_[plane]); }
  void push(int plane, const Vec2<double>& f) override {
    force[0] += (1.0 - share_[plane]) * f;
    force[1] += share_[plane] * f;
  }
  void load(int plane, const Vec2<double>& f) override { push(plane, f); }
  void twist(const double&) override {}

  Vec2<double> force[2];

 private:
  static Vec2<double> between(const Vec2<double> ends[2], double share) { return (1.0 - share) * ends[0] + share * ends[1]; }
  const Rig<double>& rig_;
  std::vector<double> share_;  ///< of the way from bearing a to b, of each plane
  Vec2<double> position_[2], velocity_[2];
};

/// A force of both axes of both ends at each instant [N].
std::vector<double> alongPath(const Path& path, const Model& model, const EffectSetting& force) {
  const auto physics = effects::makePhysics<double>(force.id, force.values);
  const unsigned roles = physics->roles();
  PathRotor rotor(model.rig);
  if (roles & acts_on_rotor) physics->rotor(model.rig, rotor);
  std::vector<double> out(path.shaft.size() * 4);
  for (std::size_t i = 0; i < path.shaft.size(); ++i) {
    rotor.moveTo(path, i);
    if (roles & acts_on_rotor_force) physics->rotorForce(path.shaft[i], rotor);
    for (int end = 0; end < 2; ++end) {
      Vec2<double>& f = rotor.force[end];
      if (roles & acts_on_bearing_force)
        physics->bearingForce({&model.rig, &path.shaft[i], end, path.position[end][i], path.velocity[end][i], path.current[end][i],
                               model.rig.amb.displacement_stiffness_N_per_m},
                              f);
      out[4 * i + 2 * end] = f.x;
      out[4 * i + 2 * end + 1] = f.y;
    }
  }
  return out;
}

}  // namespace

std::vector<std::vector<double>> responsesAlongPath(const ReferenceRun& run, const Model& model,
                                                    const std::vector<EffectSetting>& forces) {
  const Recording& rec = run.recording;
  std::vector<std::vector<double>> out(forces.size());
  if (model.amb_model != AmbModel::linear || model.coil) return out;  // no current that goes behind a lag alone
  for (int c = 0; c < 4; ++c)
    if (!(rec.noise[c] > 0.0)) return out;
  if (rec.samples < 2 * half_width + 1 || model.rig.planes.sensor[0] == model.rig.planes.sensor[1]) return out;
  const Path path = measuredPath(run, model);
  const Amplifier<double> amplifier(model.rig);
  const double rate = rec.run.sample_rate_hz, decay = amplifier.decay(1.0 / rate);
  const double lag = rate / amplifier.rate();  // in instants
  const Model whole = withTrialWeights({model}, rec)[0];
  struct Driven {
    std::size_t force;
    HeldExcitation drive;
    std::vector<double> lagged, change;
  };
  std::vector<Driven> pack;  // as many as are predicted at once
  const auto predictPack = [&] {
    Stretch stretch = stretchOf(rec, whole);
    stretch.settle_s = std::max(stretch.settle_s, run.run_in_s);
    std::vector<LaneJob> jobs;
    for (Driven& one : pack) {
      jobs.push_back(jobOf(rec, whole, run.angle_rad));
      turnShaft(rec, run.turning, jobs.back());
      takeOffsets(rec, run.offsets, jobs.back());
      jobs.back().excitation = &one.drive;
      jobs.back().out = one.change.data();
    }
    predict(stretch, jobs);
    for (std::size_t j = 0; j < pack.size(); ++j) {
      if (!jobs[j].finite) continue;
      std::vector<double>& change = pack[j].change;
      for (long i = 0; i < rec.samples; ++i)
        for (int c = 0; c < predicted_channels; ++c) {
          double& own = change[i * predicted_channels + c];
          own -= run.predicted[i * predicted_channels + c];
          if (c >= 4) own -= pack[j].lagged[4 * i + c - 4];  // the force is no current
        }
      out[pack[j].force] = std::move(change);
    }
    pack.clear();
  };
  for (std::size_t k = 0; k < forces.size(); ++k) {
    const std::vector<double> force = alongPath(path, model, forces[k]);
    Driven one = {k, rec.excitation, std::vector<double>(rec.samples * 4), std::vector<double>(rec.samples * predicted_channels)};
    one.drive.rate_hz = rate;
    double most = 0.0;
    for (int a = 0; a < 4; ++a) {
      one.drive.axis[a].resize(rec.samples, 0.0);
      double behind = 0.0;
      for (long i = 0; i < rec.samples; ++i) {
        // amid the time for which it is held, and F + lag F': what the lag makes F of
        const double now = force[4 * i + a], next = force[4 * std::min(i + 1, rec.samples - 1) + a];
        const double current = (0.5 * (now + next) + lag * (next - now)) / model.rig.amb.current_stiffness_N_per_A;
        most = std::max(most, std::fabs(current));
        one.drive.axis[a][i] += current;
        one.lagged[4 * i + a] = behind;
        behind = current + (behind - current) * decay;
      }
    }
    if (!(most > away_from_zero)) continue;
    pack.push_back(std::move(one));
    if (static_cast<int>(pack.size()) == predictionLanes()) predictPack();
  }
  if (!pack.empty()) predictPack();
  return out;
}

}  // namespace amb_rotor
