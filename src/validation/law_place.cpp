#include "law_place.hpp"

#include <sstream>

#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/effects/force_law.hpp"
#include "amb_rotor/effects/force_law_at_plane.hpp"

namespace amb_rotor {

std::vector<std::string> quantitiesOf(const std::string& meaning) {
  std::vector<std::string> out;
  std::stringstream list(meaning.substr(0, meaning.find(':')));
  for (std::string q; std::getline(list, q, ',');) out.push_back(q.substr(q.find_first_not_of(' ')));
  return out;
}

const EffectSchema& LawPlace::schema() const {
  return *effectCatalogue().find(plane_z_m ? effects::ForceLawAtPlane::id : effects::ForceLaw::id);
}

int LawPlace::terms() const { return plane_z_m ? effects::LawTerms::plane_term_count : effects::LawTerms::term_count; }

EffectSetting LawPlace::withoutForce(double frequency_hz) const {
  EffectSetting out = {schema().id, std::vector<double>(static_cast<std::size_t>(terms()), 0.0)};
  out.values.push_back(frequency_hz > 0.0 ? frequency_hz : 50.0);
  if (plane_z_m) out.values.push_back(*plane_z_m);
  return out;
}

}  // namespace amb_rotor
