#pragma once
// An effect that a file defines: its formulas, evaluated for a Scalar (model/effect_file.hpp says which quantities they
// have and where they act). It has no state of its own. A force at a magnetic bearing is there while the bearing is on;
// one at the rotor and a sensor's signal always.
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/effects/effect.hpp"
#include "amb_rotor/effects/tilt_planes.hpp"
#include "amb_rotor/model/effect_file.hpp"

namespace amb_rotor::effects {

template <class S>
class LawPhysics final : public EffectPhysics<S> {
 public:
  LawPhysics(std::shared_ptr<const EffectLaw> law, const std::vector<S>& values) : law_(std::move(law)), values_(values) {}

  unsigned roles() const override {
    switch (law_->place) {
      case EffectLaw::Place::magnetic_bearings: return acts_on_bearing_force;
      case EffectLaw::Place::rotor:
      case EffectLaw::Place::tilt: return acts_on_rotor | acts_on_rotor_force;
      case EffectLaw::Place::sensors: return acts_on_sensor;
    }
    return 0;
  }
  void rotor(const Rig<S>& rig, RotorPort<S>& port) override {
    if (law_->place == EffectLaw::Place::tilt)
      tilt_ = TiltPlanes<S>(rig, port);
    else
      plane_ = port.addPlane(values_[law_->z_parameter]);
  }
  void bearingForce(const BearingSite<S>& site, Vec2<S>& force) const override {
    force += at(*site.shaft, site.position, site.velocity, site.current, site.end);
  }
  void rotorForce(const Shaft<S>& shaft, RotorForces<S>& rotor) const override {
    if (law_->place == EffectLaw::Place::tilt)
      tilt_.push(rotor, at(shaft, tilt_.position(rotor), tilt_.velocity(rotor), {}, 0));
    else
      rotor.push(plane_, at(shaft, rotor.position(plane_), rotor.velocity(plane_), {}, 0));
  }
  void sense(const Shaft<S>& shaft, Vec2<S> signal[2]) const override {
    for (int end = 0; end < 2; ++end) signal[end] += at(shaft, signal[end], {}, {}, end);
  }

 private:
  Vec2<S> at(const Shaft<S>& shaft, const Vec2<S>& position, const Vec2<S>& velocity, const Vec2<S>& current,
             int end) const {
    S variables[EffectLaw::most_variables];
    for (std::size_t i = 0; i < values_.size(); ++i) variables[i] = values_[i];
    S* q = variables + values_.size();
    q[EffectLaw::x] = position.x;
    q[EffectLaw::y] = position.y;
    q[EffectLaw::vx] = velocity.x;
    q[EffectLaw::vy] = velocity.y;
    q[EffectLaw::ix] = current.x;
    q[EffectLaw::iy] = current.y;
    q[EffectLaw::angle] = shaft.angle;
    q[EffectLaw::speed] = shaft.speed;
    q[EffectLaw::time] = S(shaft.time);
    q[EffectLaw::end] = S(static_cast<double>(end));
    return law_->evaluate(variables);
  }

  std::shared_ptr<const EffectLaw> law_;
  std::vector<S> values_;
  int plane_ = 0;
  TiltPlanes<S> tilt_;
};

}  // namespace amb_rotor::effects
