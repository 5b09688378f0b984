#include "amb_rotor/validation/make_dataset.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <numeric>

#include "amb_rotor/common/error.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/model/effect_file.hpp"
#include "amb_rotor/model/yaml_document.hpp"
#include "make_dataset_parts.hpp"

namespace amb_rotor {
namespace {

using namespace making;

constexpr int most_rigs = 40;        ///< drawn until one carries its effects
constexpr int most_sizes = 7;        ///< tried for one effect
constexpr double size_match = 0.12;  ///< of the difference asked for
constexpr int far_out_rigs = 8;      ///< driven farther each, where an effect shows far out
constexpr int strict_rigs = 4;       ///< on which a difference that was drawn must be reached
constexpr double most_reach = 0.8;   ///< of the clearance, in runs without contact
/// Error over the noise at which the true machine may follow a run without contact: where currents at their limits amplify
/// the loop's own noise, no model that starts with the run can.
constexpr double highest_floor = 1.5;

/// What is hidden in a set.
struct Secret {
  std::vector<std::string> effects;
  std::string law;
  bool contact = false;
  std::vector<double> strengths;
};

Secret drawSecret(Dice& dice, const MakeDatasetOptions& options) {
  Secret secret;
  std::vector<std::string> names = options.effects;
  if (names.empty()) {
    const auto& all = effectCatalogue().all();
    const double what = dice.uniform(0.0, 1.0);
    const int count = what < 0.15 ? 0 : what < 0.70 ? 1 : what < 0.88 ? 2 : -1;
    if (count < 0) names.push_back(hiddenLaws()[dice.pick(static_cast<int>(hiddenLaws().size()))]);
    while (static_cast<int>(names.size()) < count) {
      const std::string& id = all[dice.pick(static_cast<int>(all.size()))].id;
      const EffectSchema& schema = *effectCatalogue().find(id);
      if (std::find(names.begin(), names.end(), id) == names.end() && !schema.only_by_name && schema.law == nullptr)
        names.push_back(id);
    }
  }
  for (const auto& name : names) {
    if (name == "none") continue;
    if (lawOf(name) != Law::none) {
      secret.law = name;
    } else if (effectCatalogue().find(name) != nullptr && !effectCatalogue().find(name)->only_by_name) {
      secret.effects.push_back(name);
    } else {
      auto known = hiddenLaws();
      for (const auto& schema : effectCatalogue().all()) known.push_back(schema.id);
      throw InputError({{"", 0, "effect", name, "is not known; nearest: " + nearestWord(name, known)}});
    }
    secret.strengths.push_back(options.strength > 0.0 ? options.strength : dice.logUniform(2.0, 20.0));
  }
  secret.contact = options.contact || (options.effects.empty() && dice.chance(0.3));
  for (const auto& id : secret.effects) secret.contact = secret.contact || needsContact(id);
  return secret;
}

/// What is measured with, before the machine takes part.
struct Instruments {
  double displacement_m, resolution_m, loop_m, current_A;
};

Instruments drawInstruments(Dice& dice) {
  constexpr double steps_um[] = {0.05, 0.1, 0.2, 0.25};
  Instruments all;
  all.displacement_m = 1e-8 * std::round(100.0 * dice.uniform(0.3, 0.8));
  all.resolution_m = 1e-6 * steps_um[dice.pick(4)];
  all.loop_m = all.displacement_m * dice.uniform(0.25, 0.45);
  all.current_A = dice.uniform(0.003, 0.007);
  return all;
}

LoopNoise drawLoopNoise(Dice& dice, long samples, double rms_m) {
  LoopNoise loop(samples);
  for (auto& row : loop)
    for (double& value : row) value = rms_m * dice.normal();
  return loop;
}

/// Noise as stated: what goes round the loop is measured on the machine itself.
ChannelNoise noiseOf(const Instruments& instruments, Dice dice, const TrueMachine& machine) {
  constexpr long samples = 4000, skipped = 400;
  ChannelNoise noise;
  noise.displacement_resolution_m = instruments.resolution_m;
  noise.loop_m = instruments.loop_m;
  RunPlan plan;
  plan.samples = samples;
  const LoopNoise loop = drawLoopNoise(dice, samples, noise.loop_m);
  const Signals quiet = runMachine(machine, plan, nullptr), loud = runMachine(machine, plan, &loop);
  const double whole = instruments.displacement_m * instruments.displacement_m;
  for (int c = 0; c < channels; ++c) {
    double sum = 0.0;
    for (long i = skipped; i < samples; ++i) sum += std::pow(loud.rows[c][i] - quiet.rows[c][i], 2);
    const double looped = sum / (samples - skipped);
    noise.white[c] = c < 4 ? std::sqrt(std::max(0.1 * whole, whole - looped)) : instruments.current_A;
    noise.stated[c] = std::sqrt(noise.white[c] * noise.white[c] + looped);
  }
  return noise;
}

/// Mean square over the channels of what parts two machines in a run, over the noise.
double meanSquare(const Signals& one, const Signals& other, const ChannelNoise& noise) {
  double sum = 0.0;
  const std::size_t n = std::min(one.angle.size(), other.angle.size());
  for (int c = 0; c < channels; ++c)
    for (std::size_t i = 0; i < n; ++i) sum += std::pow((one.rows[c][i] - other.rows[c][i]) / noise.residual(c), 2);
  return sum / (channels * double(std::max<std::size_t>(n, 1)));
}

bool isClean(const TrueMachine& machine) { return machine.model.effects.empty() && machine.law.law == Law::none; }

/// One rig with its runs, while effects are put into it.
class Bench {
 public:
  Bench(const TrueMachine& bare, const std::vector<RunPlan>& plans, const ChannelNoise& noise)
      : bare_(bare), plans_(plans), noise_(noise) {
    free_.resize(plans.size());
    tbb::parallel_for(std::size_t{0}, plans.size(), [&](std::size_t i) {
      if (!plans[i].run.holdsContact()) free_[i] = runMachine(bare_, plans[i], nullptr);
    });
    for (const auto& signals : free_)
      for (int c = 4; c < channels; ++c)
        for (double i : signals.rows[c]) peak_current_A_ = std::max(peak_current_A_, std::fabs(i));
  }
  double peakCurrent() const { return peak_current_A_; }

  /// The machine's runs against the bare one's; through all of them it also hands them over. Below 0: a run does not go as
  /// it should.
  double difference(const TrueMachine& machine, std::vector<Signals>* all) const {
    if (all != nullptr) all->resize(plans_.size());
    std::vector<std::size_t> which;
    for (std::size_t i = 0; i < plans_.size(); ++i) {
      const Run& run = plans_[i].run;
      if (all != nullptr || (run.use != RunUse::validate && !(run.holdsContact() && run.kind == RunKind::drop)))
        which.push_back(i);
    }
    std::vector<double> squares(which.size());
    std::atomic<bool> sound{true};
    tbb::parallel_for(std::size_t{0}, which.size(), [&](std::size_t n) {
      const RunPlan& plan = plans_[which[n]];
      const bool contact = plan.run.holdsContact();
      if (!sound) return;
      Signals signals = isClean(machine) && !contact ? free_[which[n]] : runMachine(machine, plan, nullptr);
      if (!signals.sound || (!contact && signals.reach > most_reach)) {
        sound = false;
        return;
      }
      if (!isClean(machine))
        squares[n] = meanSquare(signals, contact ? runWindows(bare_, plan, signals) : free_[which[n]], noise_);
      if (all != nullptr) (*all)[which[n]] = std::move(signals);
    });
    if (!sound) return -1.0;
    return std::sqrt(std::accumulate(squares.begin(), squares.end(), 0.0) / static_cast<double>(squares.size()));
  }
  bool bareIsSound() const {
    for (std::size_t i = 0; i < plans_.size(); ++i)
      if (!plans_[i].run.holdsContact() && (!free_[i].sound || free_[i].reach > most_reach)) return false;
    return true;
  }

 private:
  TrueMachine bare_;
  const std::vector<RunPlan>& plans_;
  const ChannelNoise& noise_;
  std::vector<Signals> free_;
  double peak_current_A_ = 0.0;
};

constexpr double least_difference = 1.5;  ///< that a diagnosis can be asked to see

/// Whether each of several effects is still seen once the others act: a softer machine may never reach a limit.
/// @param wanted  each one's difference where it acts alone
bool eachMatters(const TrueMachine& machine, const std::vector<double>& wanted, const std::vector<RunPlan>& plans,
                 const ChannelNoise& noise) {
  constexpr double share = 0.75;  // of less than what a diagnosis can be asked to see
  const std::size_t effects = machine.model.effects.size();
  for (std::size_t i = 0; effects > 1 && i < effects; ++i) {
    TrueMachine others = machine;
    others.model.effects.erase(others.model.effects.begin() + static_cast<long>(i));
    if (Bench(others, plans, noise).difference(machine, nullptr) < std::min(least_difference, share * wanted.at(i)))
      return false;
  }
  return true;
}

/// Puts an effect or law of the wanted difference into the machine. False: this rig does not carry it.
/// @param settle_for_less  any difference that is seen will do: some effects have no size of their own, or an end to it
template <class Put>
bool putIn(const Bench& bench, const Model& truth, double wanted, bool settle_for_less, Put&& put, TrueMachine& machine) {
  double size = 1.0, below = 0.0, above = 0.0, best = 1e300, reached = 0.0, last = -1.0;
  TrueMachine kept;
  for (int i = 0; i < most_sizes; ++i) {
    TrueMachine trial{truth, {}};
    put(size, trial);
    const double got = isStable(trial, topSpeedHz(truth)) ? bench.difference(trial, nullptr) : -1.0;
    const double off = got > 0.0 ? std::fabs(std::log(got / wanted)) : 1e300;
    if (off < best) {
      best = off;
      kept = trial;
      reached = got;
    }
    if (off < size_match || got == last) break;  // the same: a larger size is the largest that there is
    last = got > 0.0 ? got : -1.0;
    if (got < 0.0 || got > wanted)
      above = size;
    else
      below = size;
    if (above > 0.0 && below > 0.0)
      size = std::sqrt(above * below);
    else if (got <= 0.0)
      size *= got < 0.0 ? 0.4 : 4.0;
    else
      size *= std::clamp(wanted / got, 0.2, 5.0);
  }
  constexpr double much_off = 2.0;
  const bool far_less = best > std::log(much_off) && reached < wanted;
  if (reached <= 0.0 || (far_less && !settle_for_less) || (best > size_match && reached < least_difference)) return false;
  for (const auto& effect : kept.model.effects) machine.model.effects.push_back(effect);
  if (kept.law.law != Law::none) machine.law = kept.law;
  return true;
}

/// Those asked for. The rig and each run's plan are the same as in the whole set; its noise is not.
void keepOnly(const std::vector<std::string>& ids, std::vector<RunPlan>& plans) {
  std::vector<RunPlan> kept;
  std::vector<Fault> faults;
  for (const auto& id : ids) {
    const auto at = std::find_if(plans.begin(), plans.end(), [&](const RunPlan& plan) { return plan.run.id == id; });
    if (at == plans.end())
      faults.push_back({"", 0, "runs", id, "there is no such run in the set"});
    else
      kept.push_back(*at);
  }
  if (faults.empty() && std::none_of(kept.begin(), kept.end(), [](const RunPlan& p) { return p.run.use == RunUse::fit; }))
    faults.push_back({"", 0, "runs", "", "none of them is one to fit"});
  if (!faults.empty()) throw InputError(faults);
  plans = std::move(kept);
}

/// Tries one rig. False: it does not carry what is to be hidden.
bool tryRig(Dice& dice, const Secret& secret, int attempt, const MakeDatasetOptions& options, MadeDataset& made) {
  const std::string& folder = options.out;
  const std::uint64_t seed = options.seed;
  const auto hides = [&](const char* id) {
    return std::find(secret.effects.begin(), secret.effects.end(), id) != secret.effects.end();
  };
  made = MadeDataset();
  made.belief = drawBelief(dice, secret.contact || hides("shaft_crack"), hides("gyroscopic_coupling"));
  made.belief.friction_law = options.friction_law;
  TrueMachine machine{drawTruth(dice, made.belief), {}};
  if (netStiffness(machine.model) < 0.5 * netStiffness(made.belief)) return false;
  const double top = topSpeedHz(made.belief);
  if (!isStable({made.belief, {}}, top) || !isStable(machine, top)) return false;
  const bool strong = hides("magnetic_nonlinearity") || hides("magnetic_saturation");
  // far out, where these show, and back again: not every rig can be driven as far
  const double amplitude = !strong ? 1.0 : attempt < far_out_rigs ? 1.4 + 0.1 * attempt : 1.0 + 0.1 * (attempt % 5);
  std::vector<RunPlan> plans = drawPlans(dice, made.belief, secret.contact, amplitude);
  if (!options.runs.empty()) keepOnly(options.runs, plans);
  if (!makeRubsTouch(machine, plans)) return false;
  const Instruments instruments = drawInstruments(dice);
  const Dice noise_dice = dice;
  const ChannelNoise bare_noise = noiseOf(instruments, noise_dice, machine);
  const Bench bench(machine, plans, bare_noise);
  if (!bench.bareIsSound()) return false;
  const Model truth = machine.model;
  const bool settle_for_less = options.strength <= 0.0 && attempt >= strict_rigs;
  for (std::size_t i = 0; i < secret.effects.size(); ++i) {
    const EffectDraw draw = drawEffect(dice, secret.effects[i]);
    const auto put = [&](double size, TrueMachine& trial) {
      trial.model.effects.push_back(effectOfSize(draw, size, truth, bench.peakCurrent()));
    };
    if (!putIn(bench, truth, secret.strengths[i], settle_for_less, put, machine)) return false;
  }
  if (!secret.law.empty()) {
    const Law law = lawOf(secret.law);
    const EffectDraw draw = drawEffect(dice, secret.law);
    const auto put = [&](double size, TrueMachine& trial) {
      trial.law = lawOfSize(law, draw, size, truth, bench.peakCurrent());
    };
    if (!putIn(bench, truth, secret.strengths.back(), settle_for_less, put, machine)) return false;
  }
  if (!isStable(machine, top) || !eachMatters(machine, secret.strengths, plans, bare_noise)) return false;
  std::vector<Signals> quiet_runs;  // without noise in the loop
  made.difference = bench.difference(machine, &quiet_runs);
  if (made.difference < 0.0) return false;

  const ChannelNoise noise = noiseOf(instruments, noise_dice, machine);  // an effect may leave less damping
  std::filesystem::create_directories(folder + "/runs");
  std::vector<LoopNoise> loops;
  for (const auto& plan : plans) loops.push_back(drawLoopNoise(dice, plan.samples, noise.loop_m));
  std::vector<Signals> runs(plans.size());
  tbb::parallel_for(std::size_t{0}, plans.size(),
                    [&](std::size_t n) { runs[n] = runMachine(machine, plans[n], &loops[n]); });
  for (std::size_t i = 0; i < plans.size(); ++i) {
    const RunPlan& plan = plans[i];
    const Signals &signals = runs[i], &quiet = quiet_runs[i];
    if (!signals.sound || static_cast<long>(signals.angle.size()) != plan.samples) return false;
    if (!plan.run.holdsContact() && signals.touched) return false;
    const RecordedRun recorded = record(dice, signals, quiet, noise);
    if (!plan.run.holdsContact() && recorded.floor > highest_floor) return false;
    made.floor[plan.run.id] = recorded.floor;
    writeRun(folder, plan, recorded);
  }
  made.truth = machine.model;
  made.law = secret.law;
  made.depends_on = lawDependsOn(machine.law.law);
  bool own = false;  // effects of files: no diagnosis knows them that is not told
  for (const auto& id : secret.effects) {
    const auto law = effectLaw(id);
    if (law == nullptr) continue;
    own = true;
    for (const auto& quantity : law->dependsOn())
      if (std::find(made.depends_on.begin(), made.depends_on.end(), quantity) == made.depends_on.end())
        made.depends_on.push_back(quantity);
  }
  made.verdict = own || !secret.law.empty() ? "unknown" : isClean(machine) ? "none" : "effect";
  writeDescription(folder, "blind-" + std::to_string(seed), made.belief, noise, plans);
  writeTruth(folder, made, machine.law, seed);
  return true;
}

}  // namespace

MadeDataset makeDataset(const MakeDatasetOptions& options) {
  Dice dice(options.seed);
  for (int i = 0; i < 8; ++i) dice.uniform(0.0, 1.0);
  const Secret secret = drawSecret(dice, options);
  if (!secret.law.empty() && options.friction_law == FrictionLaw::set_valued)  // its own integrator knows no sticking
    throw InputError({{"", 0, "effect", secret.law, "a law of no catalogue goes with regularised friction only"}});
  MadeDataset made;
  for (int i = 0; i < most_rigs; ++i)
    if (tryRig(dice, secret, i, options, made)) return made;
  std::string names = secret.law;
  for (const auto& id : secret.effects) names += (names.empty() ? "" : ", ") + id;
  throw InputError({{"", 0, "effect", names,
                     "none of " + std::to_string(most_rigs) + " drawn rigs can carry this at that strength"}});
}

}  // namespace amb_rotor
