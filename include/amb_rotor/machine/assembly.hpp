#pragma once
// From models to the parts of a machine: parameters gathered into lanes, the rotor with its planes.
#include <algorithm>

#include "amb_rotor/common/fields.hpp"
#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor {

/// Planes that every machine has, end a first.
enum : int { plane_amb = 0, plane_sensor = 2, plane_aux = 4 };
/// Most modes a plane (x or y) can have: 28 nodes unreduced and some to spare.
constexpr int max_modes = 72;

template <class S>
void gatherRig(const std::vector<const Model*>& models, Rig<S>& rig) {
  std::vector<const Rig<double>*> rigs;
  for (const auto* model : models) {
    AMB_ROTOR_CHECK(model->rig.unbalance.size() == models[0]->rig.unbalance.size() &&
                        model->amb_model == models[0]->amb_model && model->rotor_model == models[0]->rotor_model &&
                        model->effects.size() == models[0]->effects.size(),
                    "all lanes must have the same structure");
    AMB_ROTOR_CHECK(sameOptions(*model, *models[0]), "all lanes must have the same options of controller and coils");
    rigs.push_back(&model->rig);
  }
  rig.unbalance.resize(models[0]->rig.unbalance.size());
  gatherFields(rigs, rig);
}

/// Values of an effect for each lane; false: the models do not have it.
template <class S>
bool gatherEffect(const std::vector<const Model*>& models, const std::string& id, std::vector<S>& values) {
  for (std::size_t lane = 0; lane < ScalarTraits<S>::lanes; ++lane) {
    const Model& model = *models[std::min(lane, models.size() - 1)];
    const auto found = std::find_if(model.effects.begin(), model.effects.end(),
                                    [&](const EffectSetting& e) { return e.id == id; });
    if (found == model.effects.end()) {
      AMB_ROTOR_CHECK(lane == 0, "all lanes must have the same effects");
      return false;
    }
    values.resize(found->values.size(), S(0.0));
    for (std::size_t i = 0; i < found->values.size(); ++i) setLane(values[i], lane, found->values[i]);
  }
  return true;
}

/// Builds the rotor: rigid or flexible modes, modes added by effects, planes.
template <class S>
class RotorAssembly final : public RotorPort<S> {
 public:
  RotorAssembly(const Model& model, const std::vector<const Model*>& lanes, const Rig<S>& rig)
      : model_(model), rig_(rig) {
    flexible_modes_ = model.rotor_model == RotorModel::flexible ? static_cast<int>(model.flexible.mass.size()) : 0;
    (void)lanes;
    for (int e = 0; e < 2; ++e) addPlane(rig.planes.amb[e]);
    for (int e = 0; e < 2; ++e) addPlane(rig.planes.sensor[e]);
    for (int e = 0; e < 2; ++e) addPlane(rig.planes.aux[e]);
  }

  int addPlane(const S& z) override {
    planes_.push_back({z, false, false});
    return static_cast<int>(planes_.size()) - 1;
  }
  /// The centre of gravity: a free mode of bending moves no mass on the whole, so it neither moves the centre nor
  /// feels a weight. Rigid modes do.
  int addCentrePlane() {
    planes_.push_back({S(0.0), false, true});
    return static_cast<int>(planes_.size()) - 1;
  }
  /// @param first  the rig's first unbalance: its shape is the one an added mode states
  int addUnbalancePlane(const S& z, bool first) {
    planes_.push_back({z, first, false});
    return static_cast<int>(planes_.size()) - 1;
  }
  void addMode(const S& mass, const S& frequency_hz, const S& damping_ratio, const S shape_amb[2],
               const S shape_sensor[2], const S shape_aux[2], const S& shape_unbalance) override {
    Mode mode;
    const S omega = S(two_pi) * frequency_hz;
    mode.mass = mass;
    mode.stiffness = mass * omega * omega;
    mode.damping = S(2.0) * damping_ratio * mass * omega;
    for (int e = 0; e < 2; ++e) {
      mode.shape[plane_amb + e] = shape_amb[e];
      mode.shape[plane_sensor + e] = shape_sensor[e];
      mode.shape[plane_aux + e] = shape_aux[e];
    }
    mode.unbalance = shape_unbalance;
    modes_.push_back(mode);
  }

  ModalRotor<S> finish() const {
    const bool mass_only = model_.rotor_model == RotorModel::rigid_mass;
    const int base = flexible_modes_ > 0 ? flexible_modes_ : (mass_only ? 1 : 2);
    const int n = base + static_cast<int>(modes_.size());
    AMB_ROTOR_CHECK(n <= max_modes, "too many modes: reduce the rotor");
    ModalRotor<S> rotor(n);
    if (flexible_modes_ > 0) {
      for (int k = 0; k < base; ++k) {
        rotor.mass(k) = S(model_.flexible.mass[k]);
        rotor.stiffness(k) = S(model_.flexible.stiffness[k]);
        rotor.damping(k) = S(model_.flexible.damping[k]);
        for (int l = 0; l < base; ++l) rotor.gyroscopic(k, l) = S(model_.flexible.gyroscopic[k * base + l]);
      }
    } else {
      rotor.mass(0) = rig_.rotor.mass_kg;
      if (!mass_only) {
        rotor.mass(1) = rig_.rotor.transverse_inertia_kg_m2;
        rotor.gyroscopic(1, 1) = rig_.rotor.polar_inertia_kg_m2;
      }
    }
    for (std::size_t j = 0; j < modes_.size(); ++j) {
      const int k = base + static_cast<int>(j);
      rotor.mass(k) = modes_[j].mass;
      rotor.stiffness(k) = modes_[j].stiffness;
      rotor.damping(k) = modes_[j].damping;
    }
    for (std::size_t p = 0; p < planes_.size(); ++p) {
      std::vector<S> shape(n, S(0.0));
      if (flexible_modes_ > 0) {
        for (int k = 0; k < base; ++k)
          if (!planes_[p].centre || isRigid(k)) shape[k] = tabulated(planes_[p].z, k);
      } else {
        shape[0] = S(1.0);
        if (!mass_only) shape[1] = planes_[p].z;
      }
      for (std::size_t j = 0; j < modes_.size(); ++j) {
        S& value = shape[base + j];
        if (planes_[p].centre)
          value = S(0.0);
        else if (p < 6)
          value = modes_[j].shape[p];
        else if (planes_[p].first_unbalance)
          value = modes_[j].unbalance;
        else
          value = interpolated(modes_[j], planes_[p].z);
      }
      rotor.addPlane(shape);
    }
    rotor.finish();
    return rotor;
  }

 private:
  struct Plane {
    S z;
    bool first_unbalance;
    bool centre;
  };
  struct Mode {
    S mass, stiffness, damping, shape[6], unbalance;
  };

  /// Whether a mode of a flexible rotor is one of the free body: its frequency is below 1e-4 of the highest, which
  /// round-off of the eigenvalues does not reach.
  bool isRigid(int k) const {
    double highest = 0.0;
    for (std::size_t l = 0; l < model_.flexible.mass.size(); ++l)
      highest = std::max(highest, model_.flexible.stiffness[l] / model_.flexible.mass[l]);
    return model_.flexible.stiffness[k] / model_.flexible.mass[k] <= 1e-8 * highest;
  }

  /// Shape of a flexible mode at z.
  S tabulated(const S& z, int k) const {
    S value(0.0);
    for (std::size_t lane = 0; lane < ScalarTraits<S>::lanes; ++lane) setLane(value, lane, tabulatedAt(laneValue(z, lane), k));
    return value;
  }
  /// By Lagrange's cubic through the four rows of its element, which is the element's own shape function.
  double tabulatedAt(double z, int k) const {
    constexpr std::size_t step = FlexibleModes::rows_an_element;
    const auto& table = model_.flexible;
    const std::size_t n = table.mass.size();
    const auto& zs = table.z_m;
    const std::size_t above = std::upper_bound(zs.begin(), zs.end(), z) - zs.begin();
    const std::size_t first = std::min(above > 0 ? above - 1 : 0, zs.size() - 2) / step * step;
    double value = 0.0;
    for (std::size_t i = first; i <= first + step; ++i) {
      double weight = 1.0;
      for (std::size_t j = first; j <= first + step; ++j)
        if (j != i) weight *= (z - zs[j]) / (zs[i] - zs[j]);
      value += weight * table.shape[i * n + k];
    }
    return value;
  }

  /// Shape of an added mode at z: piecewise linear through the planes at which it is stated.
  S interpolated(const Mode& mode, const S& z) const {
    S result(0.0);
    for (std::size_t lane = 0; lane < ScalarTraits<S>::lanes; ++lane) {
      std::vector<std::pair<double, double>> points;
      for (int p = 0; p < 6; ++p) points.emplace_back(laneValue(planes_[p].z, lane), laneValue(mode.shape[p], lane));
      for (std::size_t p = 6; p < planes_.size(); ++p)
        if (planes_[p].first_unbalance)
          points.emplace_back(laneValue(planes_[p].z, lane), laneValue(mode.unbalance, lane));
      std::sort(points.begin(), points.end());
      const double at = laneValue(z, lane);
      std::size_t i = 1;
      while (i + 1 < points.size() && points[i].first < at) ++i;
      const double width = points[i].first - points[i - 1].first;
      const double share = width > 1e-9 ? (at - points[i - 1].first) / width : 0.0;
      setLane(result, lane, (1.0 - share) * points[i - 1].second + share * points[i].second);
    }
    return result;
  }

  const Model& model_;
  const Rig<S>& rig_;
  int flexible_modes_ = 0;
  std::vector<Plane> planes_;
  std::vector<Mode> modes_;
};

}  // namespace amb_rotor
