#pragma once
// Fits of the belief with further effects to a data set's runs, and what they are measured against.
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/validation/diagnosis.hpp"
#include "amb_rotor/validation/fit.hpp"
#include "amb_rotor/validation/start_screen.hpp"
#include "time_limit.hpp"

namespace amb_rotor {

using Settings = std::vector<EffectSetting>;

/// What a model leaves of the runs to validate, as it was judged.
struct HeldOut {
  Eigen::VectorXd x;            ///< where the model stood
  std::vector<RunResult> runs;  ///< with their predictions, of each recording; no prediction: it is not one of those
};

/// One fit: the belief with some effects, the last of which is the one on trial.
struct Trial {
  std::string effect;
  FitResult fit;
  std::vector<LocalState> local;
  std::shared_ptr<FitSpace> space;
  bool excited = true;
  double grown = 0.0;    ///< chi2 where its windows had grown to their length; 0: they have not
  double short_level = 0.0;  ///< chi2 for a residual over the shortest windows that these had grown from; 0: none
  int stride = 1;  ///< of the windows through contact that it was fitted to
  bool stands = false;  ///< it is where it began: not fitted
  std::vector<double> start_levels;  ///< where each of its effect's starts stands through contact at a glance; empty: unknown
  std::string note;
  std::vector<Trial> others;  ///< from other starts, where an effect has hills apart from each other
  double evidence = -1e300;
  CandidateErrors errors;
  std::shared_ptr<const HeldOut> held_out;  ///< by all runs to validate, their windows begun anew; null: it was not

  bool usable() const { return excited && fit.finite; }
  /// chi2 for a residual.
  double level() const { return fit.chi2 / std::max(1.0, fit.count); }
  /// Its effects with the values that the fit found.
  Settings effects() const;
  Eigen::VectorXd nuisance() const { return fit.x.head(space->nuisances()); }
};

/// Whether some parameters of an effect leave the model as it is, so that a fit can only gain.
bool isNested(const std::string& effect);

/// Iterations of a candidate's first look.
inline constexpr int first_look_iterations = 2;
/// Of several starts of an effect so many are followed.
inline constexpr std::size_t followed_starts = 2;
/// Share of the leader's evidence from which on candidates are fitted through all windows to be told apart.
inline constexpr double in_reach = 0.3;

/// Times what the reference leaves through contact beyond which the best start of an effect is not followed, where contact needs one
/// look only.
inline constexpr double not_in_sight = 1.5;

/// Told of an effect of which no start is worth a fit through contact.
inline constexpr const char* comes_not_near = "from none of its starts does it come near what the model leaves without it";

/// Of an effect that is not worth a fit.
inline Trial notFollowed() {
  Trial out;
  out.fit.finite = false;
  return out;
}

/// What an effect promises beside a reference without contact, see foreseen.hpp.
struct Promise {
  double evidence = 0.0;
  std::vector<Settings> starts;  ///< of some size, each with all that is adopted; the shapes that are seen come last
  std::size_t sized = 0;         ///< so many without these
  std::vector<StartGain> gains;  ///< of these
};

/// What candidates are measured against: the model without them, through the runs that count for them.
struct References {
  Trial free, contact, sparse;  ///< sparse: `contact` at the windows of a first look
  bool through_contact = false;  ///< the latter two are fitted; else they stand for its unknowns alone
  QuadraticPrior prior;         ///< what the free runs say of the nuisance, for fits to the runs with contact alone
  std::shared_ptr<const StartScreen> screen;  ///< about `free`
  std::map<std::string, Promise> promises;  ///< of the effects that were asked for, by foresee()
  double worth = 0.0;  ///< evidence that an effect must have to be adopted for what it does without contact, about

  /// Evidence of what would take all that is above the noise without contact, over the noise.
  double most() const { return 0.5 * std::max(0.0, free.fit.squares - free.fit.count); }
  double short_level = 0.0;  ///< of `sparse` over the shortest windows, see referOverShortWindows(); 0: not fitted there
  const Trial& of(const Trial& trial) const {
    return !needsContact(trial.effect) ? free : trial.stride > 1 ? sparse : contact;
  }
};

/// The most evidence that an effect can have through contact: all that the reference leaves there above any floor.
double mostThroughContact(const References& references);

/// Whether the reference is so far off there that what explains it stands out.
bool plainlyOffThroughContact(const References& references);

/// How far the candidates of a screening have come: what one that is tried later can still be.
struct Leaders {
  double free = 0.0;  ///< the best evidence without contact: what cannot come near it is looked at once, from its best start
  double free_drop = 0.0;  ///< half of what that takes off chi2
  bool free_settled = false;     ///< and it leaves nothing there: it is in the rig, whatever contact holds besides
  bool through_contact = false;  ///< one leaves next to nothing through contact: the others are looked at once there, at some windows
  bool contact_waits = true;     ///< where waits() says so
  bool only_serious = false;  ///< what is foreseen far behind the leader without contact is not looked at
  bool explains_contact = false;  ///< one that was looked at without contact takes most of what is off there, see isBelieved()
  double short_level = 1e300;  ///< the least that one through contact leaves over the shortest windows

  void add(const Trial& trial, const References& references);
  /// Whether nothing that candidates through contact could have comes near what the leader has without: what they are beside
  /// it, the next step tells.
  bool beyondContact(const References& references) const;
  /// Whether an effect promises enough, without contact, to be looked at again beside what is adopted.
  bool mayLead(const std::string& effect, const References& references) const;
  /// Whether without contact all that were looked at leave nearly all of what is plainly there.
  bool noneNear(const References& references) const;
  /// Whether candidates through contact wait: for the leader, or for a law where none is near.
  bool waits(const References& references) const;
  /// Whether what a candidate leaves over the shortest windows may be a right one's: there hollows are few, and a wrong one leaves about
  /// what none does, or many times what the leader does.
  bool mayBeRight(double at_short_windows, const References& references) const;
  /// Whether it leaves as little there as right ones do after the first iterations: it is worth as many more as it takes.
  bool isNearlyRight(double at_short_windows, const References& references) const;
  /// Whether candidates through contact need one look only.
  bool settles(const References& references) const { return through_contact || beyondContact(references); }
};

/// Which runs a fit takes.
enum class Through {
  free,           ///< runs without contact
  all,            ///< all runs
  contact         ///< runs with contact, the others as a prior on the nuisance
};

struct FitEffort {
  Through through = Through::free;
  int iterations = 10;
  bool scores = false;      ///< robust covariance
  bool first_look = false;  ///< few attempts, no covariance, only some of the windows through contact
  int stride = 4;           ///< of those in a first look, where the effects allow it
  bool every_effect = false;  ///< at that stride also where an effect does not allow it
  const FrozenColumns* frozen = nullptr;  ///< of what the reference holds already
  double window_s = contact_window_s;     ///< length of a window through contact
  int attempts = 5;  ///< at a step of a first look: through contact each that fails is dear
  int held = -1;  ///< a coordinate that stays where it is; below 0: none
  bool thorough = false;  ///< every guess of a window's start is tried in the first evaluation, as in a first look
};

/// Where few windows tell of an effect alone, of so many each time.
constexpr int start_stride = 12;

/// How runs to validate are evaluated that lead on from their last evaluation (see evaluateSettled()).
enum class Judging {
  glance,   ///< once: of what will not be taken
  settled,  ///< until they stand
  anew      ///< and from windows that begin anew
};

/// Whether a fit through contact has ended so far above the noise that its windows may have gone astray.
bool isAstray(const Trial& trial);

/// Windows through contact that fits of some effects can leave out: none where something that no sensor sees, a ring's speed,
/// is known from window to window only.
int strideOver(const Settings& effects, int stride);

/// Puts back what is far from the belief, by its prior deviation. False: nothing is.
bool returnToBelief(const FitSpace& space, Eigen::VectorXd& nuisance);

/// How near a model comes to the runs to validate when its numbers may move within what the runs to fit leave open.
struct LeftOpen {
  double error = 1e300;       ///< there, over the noise, rms
  double deviations = 1e300;  ///< how far they have moved: root of the quadratic form of the stated covariance
  int numbers = 0;

  /// Whether that is no farther than chance takes so many numbers: its square, chi-squared, within three deviations of its mean.
  bool byChance() const { return deviations * deviations < numbers + 3.0 * std::sqrt(2.0 * numbers); }
};

/// What an effect does there that was looked at without contact, and takes most of what is off through it.
struct ExplainedContact {
  double evidence;
  bool leaves_nothing;  ///< or all but nothing
};

class Candidates {
 public:
  /// @param limit  once it is up looks and refits take no further rounds
  Candidates(const Model& belief, const Dataset& dataset, const TimeLimit& limit = {});

  const Model& belief() const { return belief_; }
  const std::vector<Recording>& recordings() const { return recordings_; }
  double offsetStd() const { return offset_std_; }
  bool haveContact() const { return !fit_contact_.empty(); }
  const TimeLimit& limit() const { return limit_; }

  /// Where a fit has left an effect at a limit: it with the values there back at those of its middle start, and with all values, as
  /// the others have come along with them.
  std::vector<EffectSetting> awayFromLimits(const FitSpace& space, const Eigen::VectorXd& x, const EffectSetting& effect) const;

  /// @param nuisance  where to start; null: the belief
  /// @param prior     for Through::contact
  Trial fit(const Settings& effects, const Eigen::VectorXd* nuisance, const std::vector<LocalState>& local,
            const FitEffort& effort, const QuadraticPrior* prior = nullptr) const;
  /// Near to the end of a fit through contact, with few unknowns and some of the windows, from where a look ended.
  Trial approach(const Settings& effects, const Trial& start, const QuadraticPrior& prior) const;
  /// From a fit to the runs without contact, where numbers of its effects show through contact alone (the shapes of a bending mode at the
  /// auxiliary bearings), a fit through contact that knows all that it does: see candidate_shapes.cpp. Any other as it is.
  Trial withContactsNumbers(const Trial& free) const;
  /// A fit through the runs without contact with a bending mode among its effects, at the frequency where that does best and with the
  /// unbalance near its belief, or with a crack, of its phase and that half a turn on: see candidate_hills.cpp. Any other as it is.
  Trial onHighestHill(Trial trial, int iterations) const;
  /// Fitted anew over windows through contact that are short at first and grow to their usual length: the longer a window, the
  /// more impacts a wrong model misses in it, and the more hollows there are beside the right one.
  /// @param against  a reference at the same windows; where half the length does not come well below it, `from` is returned
  /// @param longer   iterations over longer windows by what the shortest leave, if anybody is asked; 0: `from` is returned. Where they
  ///                 are more than those of `effort`, the shortest have them, too
  Trial lengthened(const Trial& from, FitEffort effort, const QuadraticPrior* prior, const Trial* against = nullptr,
                   const std::function<int(double)>& longer = {}) const;
  /// A fit to all runs, and on from windows through contact that begin anew where some run has gone astray; with an effect there
  /// also over windows that grow: without one the belief's contact may be what is wrong, and the next step tells.
  Trial settled(Trial trial, int iterations) const;
  /// A fit to all runs with effects through contact, followed along the valley that it lies in by fits to the runs with contact
  /// whose windows are short at first; where these end elsewhere and about as well, its covariance is widened by how far.
  /// Where mounts or rings move, whose fits take minutes, it stays where it is: see widenedByHollows() for rings.
  /// @param held_out_error  through contact, of runs that it was not fitted to: above the noise it lies elsewhere
  Trial followed(Trial trial, const QuadraticPrior& prior, int iterations, double held_out_error) const;
  /// Widens the covariance along the line on which the last effect is known least by how rough chi2 is there: a fit ends in one
  /// of the hollows that impacts leave in it, and the bottom of a hollow promises too much. Evaluated there and a few deviations
  /// to either side; what chi2 is off its parabola, the least of either side and of their mean, counts as the depth of the
  /// hollows where it is more than what windows make by chance.
  Trial widenedByHollows(Trial trial, const QuadraticPrior& prior) const;
  /// Walks both ways along the valley in which its last effect lies, goes down where the runs with contact have less chi2
  /// there, and widens its covariance by how far they do not tell the places apart.
  Trial walked(Trial trial, const QuadraticPrior& prior, int iterations) const;
  /// Widens the covariance of a friction that falls with the slip by how far other laws are apart that the runs with contact hardly tell
  /// from it: see actingAlike().
  Trial widenedAlike(Trial trial, const QuadraticPrior& prior) const;
  /// Errors on the runs to validate, through contact in every `stride`-th group of windows; keeps their local unknowns
  /// in the trial.
  CandidateErrors judge(Trial& trial, bool with_contact, Judging judging, int stride = 1) const;
  /// See CandidateErrors, of local unknowns that the runs to validate have led to.
  double offsetDeviations(const std::vector<LocalState>& local) const;
  /// On the runs to validate with contact, or those without. The belief about the nuisance is within what the runs to fit say.
  LeftOpen leftOpen(const Trial& trial, Through through) const;
  /// Half the drop of the BIC.
  double evidence(const Trial& trial, const Trial& against) const;
  /// The references of a model with the given effects, fitted to the runs without contact and to all: what the former tell.
  References referencesWithoutContact(const Trial& free, const Trial& all) const;
  /// And through contact, from where the fit to all has ended: also at some windows, those that are the farthest off. From then on
  /// looks are at these.
  void referThroughContact(References& references);
  /// What the reference leaves over the shortest windows that looks begin anew with where they end astray.
  void referOverShortWindows(References& references) const;

  /// A short look at one effect beside those adopted, from each of its starts; not usable where these runs cannot show it.
  /// @param seen  where one of its starts stands: it begins there; or of an earlier, shorter look: goes on from there where that leaves
  ///              nothing, at windows that this effect can do with
  Trial look(const std::string& effect, const Settings& adopted, const References& references, const Leaders& leaders,
             const Trial* seen = nullptr) const;
  /// Through contact, without a fit: the one of its starts that leaves the least at some of the windows. Not usable for effects whose
  /// starts are the reference itself.
  Trial bestStanding(const std::string& effect, const Settings& adopted, const References& references) const;
  /// Of the runs to fit, through contact: the largest mean square over the noise as a fit has left them.
  double worstThroughContact(const Trial& trial) const;
  /// Whether an effect that has been looked at without contact takes most of what is off through contact.
  /// @param shows_without  whether it shows there; one that does not has to leave nothing through contact
  std::optional<ExplainedContact> explainsContact(const Trial& trial, const References& references, bool shows_without) const;
  /// Follows the most promising looks to their end, best first; fills `evidence`. `tell` hears each one's name.
  void finish(std::vector<Trial>& trials, const References& references, const Leaders& leaders,
              const std::function<void(const std::string&)>& tell) const;

 private:
  /// One fit to be tried: with these effects, from this nuisance.
  using Start = std::pair<const Settings*, const Eigen::VectorXd*>;
  /// Where fits of an effect may begin.
  struct Starts {
    std::vector<Settings> settings;          ///< each with all that is adopted; none: `note` says why
    std::vector<Eigen::VectorXd> nuisances;  ///< the reference's first
  };
  /// A fit through the runs without contact from there, or the trial where that leaves less.
  Trial betterFrom(const Settings& effects, const Eigen::VectorXd& nuisance, Trial trial, int iterations) const;
  Trial halfATurnOn(Trial trial, int iterations) const;
  Trial onTheOtherSide(Trial trial, int iterations) const;
  Trial unbalanceTurnedBack(Trial trial, int iterations) const;
  Trial amongFrequencies(Trial trial, int iterations) const;
  Starts startsOf(const std::string& effect, const Settings& adopted, const Trial& reference, std::string& note) const;
  /// Also scales the starts' amplitudes to where they do best. `serious`: whether one of them may come near the leader; none is
  /// followed where only such are wanted.
  std::vector<Start> promisingFree(std::vector<Settings>& starts, const std::vector<Eigen::VectorXd>& nuisances,
                                   const References& references, const Leaders& leaders, bool& serious) const;
  /// Where each stands at some of the windows, before any is fitted.
  std::vector<Trial> standing(const std::vector<Start>& these, const References& references, bool every_effect) const;
  std::vector<Start> promisingThroughContact(const std::vector<Settings>& starts,
                                             const std::vector<Eigen::VectorXd>& nuisances, const References& references,
                                             const Leaders& leaders, const std::vector<double>& levels) const;
  /// @param levels  see Trial::start_levels
  Trial bestOf(std::vector<Settings>& starts, const std::vector<Eigen::VectorXd>& nuisances, const References& references, bool contact,
               const Leaders& leaders, const std::vector<double>& levels, bool& serious) const;
  void value(Trial& trial, const References& references) const;

  Model belief_;
  TimeLimit limit_;
  std::vector<Recording> recordings_;
  double offset_std_ = 0.0, current_noise_A_ = 0.0;
  int look_offset_ = 0;  ///< of the windows of a first look
  std::vector<int> fit_free_, fit_contact_, check_free_, check_contact_;
};

}  // namespace amb_rotor
