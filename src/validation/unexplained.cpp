#include "amb_rotor/validation/unexplained.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "amb_rotor/common/linear_algebra.hpp"
#include "amb_rotor/effects/catalogue.hpp"

namespace amb_rotor {
namespace {

constexpr int most_terms = 3;
/// A further term must take this share of what is above the noise.
constexpr double least_share = 0.05;

/// Drop of chi2 by the unknowns chosen out of normal equations, priors of the first ones included.
double dropOf(const Eigen::MatrixXd& h, const Eigen::VectorXd& g, const std::vector<int>& chosen,
              Eigen::VectorXd* solution = nullptr, Eigen::MatrixXd* covariance = nullptr) {
  const int n = static_cast<int>(chosen.size());
  Eigen::MatrixXd own(n, n);
  Eigen::VectorXd right(n);
  for (int i = 0; i < n; ++i) {
    right[i] = g[chosen[i]];
    for (int j = 0; j < n; ++j) own(i, j) = h(chosen[i], chosen[j]);
    own(i, i) *= 1.0 + 1e-10;
    own(i, i) += 1e-300;
  }
  const Ldlt factor(own);
  const Eigen::VectorXd x = factor.solve(right);
  if (solution != nullptr) *solution = x;
  if (covariance != nullptr) *covariance = factor.solveColumns(Eigen::MatrixXd::Identity(n, n));
  return x.allFinite() ? x.dot(right) : 0.0;
}

}  // namespace

Unexplained searchUnexplained(const std::vector<Recording>& recordings, const FitSpace& space, const Eigen::VectorXd& x,
                              const std::vector<LocalState>& local, double offset_std_m) {
  Unexplained out;
  // the model as it stands becomes the belief; the law's terms are the new unknowns, from zero
  Model belief = space.model(x);
  const EffectSchema& schema = *effectCatalogue().find("force_law");
  const FitSpace law(belief, {{schema.id, std::vector<double>(schema.parameters.size(), 0.0)}});
  const FitProblem problem(recordings, law, offset_std_m);
  std::vector<int> fit, held_out;
  for (int i = 0; i < static_cast<int>(recordings.size()); ++i)
    if (!recordings[i].holdsContact()) (recordings[i].run.use == RunUse::fit ? fit : held_out).push_back(i);
  if (fit.empty()) {
    out.shape = "no run without contact to look at";
    return out;
  }
  std::vector<LocalState> own = local;
  const NormalEquations normal = problem.evaluate(law.start(), fit, own, {});
  if (!normal.finite) {
    out.shape = "the prediction with further terms did not stay finite";
    return out;
  }
  Eigen::MatrixXd h = normal.h;
  std::vector<int> chosen;
  for (int k = 0; k < law.nuisances(); ++k) {
    chosen.push_back(k);
    const double std = law.coordinates()[k].prior_std;
    h(k, k) += 1.0 / (std * std);
  }
  const double excess = std::max(1.0, normal.chi2 - normal.count);
  double taken = dropOf(h, normal.g, chosen);
  std::vector<int> terms;
  while (static_cast<int>(terms.size()) < most_terms) {
    double best = 0.0;
    int which = -1;
    for (int k = law.nuisances(); k < law.size(); ++k) {
      if (std::find(chosen.begin(), chosen.end(), k) != chosen.end()) continue;
      std::vector<int> with = chosen;
      with.push_back(k);
      const double drop = dropOf(h, normal.g, with);
      if (drop > best) {
        best = drop;
        which = k;
      }
    }
    if (which < 0 || best - taken < least_share * excess) break;
    chosen.push_back(which);
    terms.push_back(which);
    taken = best;
  }
  if (terms.empty()) {
    out.shape = "no force at the bearings in position, velocity, spin speed, shaft angle or control current takes " 
                "5 % of the unexplained error";
    return out;
  }
  Eigen::VectorXd solution;
  Eigen::MatrixXd covariance;
  dropOf(h, normal.g, chosen, &solution, &covariance);
  std::set<std::string> depends;
  std::ostringstream shape;
  shape << "force at the bearings = ";
  for (std::size_t t = 0; t < terms.size(); ++t) {
    const int place = law.nuisances() + static_cast<int>(t);
    const ParameterSchema& p = schema.parameters[terms[t] - law.nuisances()];
    const double value = solution[place];
    HypothesisTerm term{p.name, value, std::sqrt(std::max(0.0, covariance(place, place)))};
    out.terms.push_back(term);
    const auto colon = p.meaning.find(": ");
    std::stringstream quantities(p.meaning.substr(0, colon));
    for (std::string q; std::getline(quantities, q, ',');) depends.insert(q.substr(q.find_first_not_of(' ')));
    shape << (t > 0 ? " + " : "") << value << " " << p.unit << " * " << p.meaning.substr(colon + 2);
  }
  out.depends_on.assign(depends.begin(), depends.end());
  out.shape = shape.str();
  if (!held_out.empty()) {
    const NormalEquations check = problem.evaluate(law.start(), held_out, own, {});
    Eigen::VectorXd step = Eigen::VectorXd::Zero(law.size());
    for (std::size_t i = 0; i < chosen.size(); ++i) step[chosen[i]] = solution[static_cast<long>(i)];
    const double drop = 2.0 * step.dot(check.g) - step.dot(check.h * step);
    out.held_out_gain = drop / std::max(1.0, check.chi2 - check.count);
  }
  return out;
}

}  // namespace amb_rotor
