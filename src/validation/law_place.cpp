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

namespace {

const char* effectAt(LawPlace::Kind kind) {
  switch (kind) {
    case LawPlace::Kind::magnetic_bearings:
      return effects::ForceLaw::id;
    case LawPlace::Kind::rotor:
      return effects::ForceLawAtPlane::id;
    case LawPlace::Kind::tilt:
      return effects::ForceLawOfTilt::id;
    case LawPlace::Kind::sensors:
      return effects::SignalLaw::id;
  }
  AMB_ROTOR_CHECK(false, "every place has its effect");
}

}  // namespace

std::optional<LawPlace> LawPlace::of(const std::string& effect) {
  for (const Kind kind : {Kind::magnetic_bearings, Kind::rotor, Kind::tilt, Kind::sensors})
    if (effect == effectAt(kind)) return LawPlace{kind, 0.0};
  return {};
}

const EffectSchema& LawPlace::schema() const { return *effectCatalogue().find(effectAt(kind)); }

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

bool LawPlace::readsNumber(int term) const {
  switch (kind) {
    case Kind::rotor:
      return true;
    case Kind::sensors:
      return term == effects::SignalLaw::step;
    case Kind::magnetic_bearings:
      return term == effects::LawTerms::current_axes_sign;
    case Kind::tilt:
      break;
  }
  return false;
}

bool LawPlace::isInCatalogue(int term) const { return !isSensors() && effects::LawTerms::alsoInCatalogue(term); }

EffectSetting LawPlace::withoutForce(double frequency_hz) const {
  EffectSetting out = {schema().id, std::vector<double>(static_cast<std::size_t>(terms()), 0.0)};
  if (isSensors()) {
    out.values.push_back(schema().parameters.back().typical);
    return out;
  }
  out.values.push_back(frequency_hz > 0.0 ? frequency_hz : 50.0);
  if (isPlane()) out.values.push_back(plane_z_m);
  if (kind == Kind::magnetic_bearings) out.values.push_back(schema().parameters.back().typical);
  return out;
}

}  // namespace amb_rotor
