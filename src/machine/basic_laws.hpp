#pragma once
// The basic model with its contact and friction law chosen at run time: f(BasicModel<...>{}).
#include "amb_rotor/machine/basic_lanes.hpp"

namespace amb_rotor {

template <class F>
auto withBasicModel(BasicContact contact, BasicFriction friction, F&& f) {
  if (contact == BasicContact::linear) {
    return friction == BasicFriction::spin ? f(BasicModel<LinearContact, SpinFriction>{})
                                           : f(BasicModel<LinearContact, SlidingFriction>{});
  }
  return friction == BasicFriction::spin ? f(BasicModel<HertzContact, SpinFriction>{})
                                         : f(BasicModel<HertzContact, SlidingFriction>{});
}

}  // namespace amb_rotor
