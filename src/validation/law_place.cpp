#include "law_place.hpp"

#include <sstream>

#include "amb_rotor/common/error.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/effects/force_law.hpp"
#include "amb_rotor/effects/force_law_at_plane.hpp"
#include "amb_rotor/effects/force_law_of_tilt.hpp"
#include "amb_rotor/effects/signal_law.hpp"

namespace amb_rotor {

std::vector<std::string> quantitiesOf(const std::string& meaning) {
  std::vector<std::string> out;
  std::stringstream list(meaning.substr(0, meaning.find(':')));
  for (std::string q; std::getline(list, q, ',');) out.push_back(q.substr(q.find_first_not_of(' ')));
  return out;
}

const EffectSchema& LawPlace::schema() const {
  switch (kind) {
    case Kind::magnetic_bearings:
      return *effectCatalogue().find(effects::ForceLaw::id);
    case Kind::rotor:
      return *effectCatalogue().find(effects::ForceLawAtPlane::id);
    case Kind::tilt:
      return *effectCatalogue().find(effects::ForceLawOfTilt::id);
    case Kind::sensors:
      return *effectCatalogue().find(effects::SignalLaw::id);
  }
  AMB_ROTOR_CHECK(false, "every place has its effect");
}

int LawPlace::terms() const {
  if (isSensors()) return effects::SignalLaw::term_count;
  return kind == Kind::magnetic_bearings ? effects::LawTerms::term_count : effects::LawTerms::plane_term_count;
}

bool LawPlace::readsAngle(int term) const {
  return isSensors() ? effects::SignalLaw::readsAngle(term) : effects::LawTerms::readsAngle(term);
}

bool LawPlace::repeatsInTime(int term) const {
  return !isSensors() && term >= effects::LawTerms::hum_x_cosine && term <= effects::LawTerms::hum_y_sine;
}

bool LawPlace::readsNumber(int term) const { return isPlane() || (isSensors() && term == effects::SignalLaw::step); }

bool LawPlace::isInCatalogue(int term) const { return !isSensors() && effects::LawTerms::alsoInCatalogue(term); }

EffectSetting LawPlace::withoutForce(double frequency_hz) const {
  EffectSetting out = {schema().id, std::vector<double>(static_cast<std::size_t>(terms()), 0.0)};
  if (isSensors()) {
    out.values.push_back(schema().parameters.back().typical);
    return out;
  }
  out.values.push_back(frequency_hz > 0.0 ? frequency_hz : 50.0);
  if (isPlane()) out.values.push_back(plane_z_m);
  return out;
}

}  // namespace amb_rotor
