// Whether a run is predicted without its auxiliary bearings.
//
// What is measured to stay well inside the clearance was never in contact. A model that is being tried may well touch there: it
// then goes by steps of a few us through chatter for nothing, and its error has kinks where it touches. Without contact it is as
// wrong, by a smooth measure, and where it is linear its motion is exact.
// Left out: a bearing so far off its centre that the rotor touches it within that share of the clearance, in a run whose kind says
// that it holds no contact.
#include <algorithm>
#include <cmath>

#include "amb_rotor/validation/recording.hpp"
#include "amb_rotor/validation/stretches.hpp"

namespace amb_rotor {
namespace {

/// Share of the clearance within which the ends stay by their sensors: these may be out by runout, gain and offset.
constexpr double well_inside = 0.7;
/// Clearances within which the belief stays: one that leaves its bearings would end in numbers of no meaning.
constexpr double most_clearances = 10.0;

/// The farthest that an end gets, by displacements side by side as measured or predicted [m].
double farthest(const std::vector<double>& channels, long samples, const Model& model) {
  double most = 0.0;
  for (long i = 0; i < samples; ++i)
    for (const double z : model.rig.planes.aux) {
      const double radius = radiusAt(&channels[static_cast<std::size_t>(i) * predicted_channels], model, z);
      if (!(radius <= most)) most = radius;
    }
  return most;
}

}  // namespace

double radiusAt(const double* displacement, const Model& model, double z_m) {
  const auto& sensor = model.rig.planes.sensor;
  const double span = sensor[1] - sensor[0], share = span != 0.0 ? (z_m - sensor[0]) / span : 0.5;
  return std::hypot(displacement[0] + share * (displacement[2] - displacement[0]),
                    displacement[1] + share * (displacement[3] - displacement[1]));
}

bool staysInside(const Recording& rec, const Model& belief) {
  const double clearance = belief.rig.auxiliary_bearing.clearance_m;
  if (rec.holdsContact() || rec.samples == 0) return false;
  for (int c = 0; c < 4; ++c)
    if (!(rec.noise[c] > 0.0)) return false;
  if (!(farthest(rec.measured, rec.samples, belief) < well_inside * clearance)) return false;
  const std::vector<Model> models = withTrialWeights({belief}, rec);
  Stretch stretch = stretchOf(rec, models[0]);
  stretch.contact_step_s = 0.0;
  std::vector<double> predicted(rec.measured.size());
  std::vector<LaneJob> jobs = {jobOf(rec, models[0], 0.0)};
  jobs[0].out = predicted.data();
  predict(stretch, jobs);
  return jobs[0].finite && farthest(predicted, rec.samples, belief) < most_clearances * clearance;
}

}  // namespace amb_rotor
