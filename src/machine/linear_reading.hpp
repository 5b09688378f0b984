#pragma once
// The equations of a machine that is linear between contacts, read from its own derivatives, for whatever
// effects it has:
//
//   y' = A y + B u + g0 + gc cos(angle) + gs sin(angle) + G i,   w = C y + w0
//   y: mechanics (machine/machine.hpp);  i: currents that make the forces [A], ax, ay, bx, by
//   u: force on the rotor at the end a, then b [N, x y each]; forces of a schedule [N]; its unbalances
//   (factor times
//      cosine, factor times sine of the angle)
//   w: displacement and velocity of each end in its bearing [m, m/s];  beside it the rotor at sensors and magnets [m]
//
// Checked against the machine at random states, in and out of contact, at constant speed and with bearings on
// or off as given; reason() says what is not linear. Left out: what depends on the history (coils, filters,
// lags).
#include <Eigen/Core>
#include <string>
#include <vector>

#include "amb_rotor/excitation/schedule.hpp"
#include "amb_rotor/integration/contact_flow.hpp"
#include "amb_rotor/machine/machine.hpp"
#include "plain_law.hpp"

namespace amb_rotor {

class LinearReading : public EndContacts {
 public:
  LinearReading(const Machine<double>& machine, const Schedule* schedule, const Vec2<double> bearing_on[2],
                double speed);

  const std::string& reason() const { return reason_; }
  bool serves(const Schedule* schedule, const Vec2<double> on[2], double speed) const {
    return schedule == schedule_ && on[0].x == in_.bearing_on[0].x && on[0].y == in_.bearing_on[0].y &&
           on[1].x == in_.bearing_on[1].x && on[1].y == in_.bearing_on[1].y && speed == speed_;
  }

  double force(int end, const double* w, double* u, Normal& normal) const override {
    if (plain_.known) return plain_.force(w, u, normal);
    return general(end, w, u, normal);
  }
  void forces(int first, int count, const double* w, double* u, ContactNodes& nodes) const override {
    if (!plain_.known) return EndContacts::forces(first, count, w, u, nodes);
    plain_forces_(plain_, first, count, w, u, nodes);
  }

 protected:
  const Machine<double>& machine_;
  int n_;
  double speed_;
  const Schedule* schedule_;
  std::string reason_;
  LinearSystem system_;
  /// What is to be seen, of each end x and y: the rotor at the sensors and at the magnetic bearings relative to the stator,
  /// at both absolute, at the auxiliary bearings, these bearings' centres [m], the forces of the magnetic bearings [N].
  static constexpr int view_rows = 28, sensors_from = 0, magnets_from = 4, absolute_from = 8, ends_from = 16,
                       centres_from = 20, forces_from = 24;
  using View = Eigen::Matrix<double, view_rows, 1>;
  Eigen::Vector4d place0_;  ///< of the ends in their bearings
  View view0_;
  Eigen::MatrixXd view_;  ///< from y
  Eigen::Matrix4d force_by_current_;
  bool shown_ = true;  ///< all that is linear, and does not know the angle
  Eigen::VectorXd constant_, cosine_, sine_;
  Eigen::MatrixXd by_current_;
  bool driven_ = false;
  std::vector<Vec2<double>> forces_;  ///< of the schedule: as many as it has, and factors of its unbalances
  std::vector<double> factors_, later_factors_, drive_factors_;

 private:
  double general(int end, const double* w, double* u, Normal& normal) const;
  Eigen::VectorXd rates(const Eigen::VectorXd& y, double angle, const double* current,
                        const Vec2<double>* force = nullptr, const double* unbalance = nullptr,
                        double time_s = 0.0);
  View view(const Eigen::VectorXd& y, double angle = 0.0, const double* current = nullptr);
  void checkView(const View& seen, const Eigen::VectorXd& y, const Eigen::Vector4d& current);
  /// Displacements of the ends in their bearings.
  static Eigen::Vector4d places(const View& seen) {
    return seen.segment<4>(ends_from) - seen.segment<4>(centres_from);
  }
  void probe();
  void probeSchedule(const Eigen::VectorXd& f0);
  void probeContacts();
  Eigen::VectorXd contactEffect(int end, const Eigen::VectorXd& y, Vec2<double>& force);
  void fail(const char* what);
  void check();
  void recogniseLaw();

  Inputs<double> in_, law_;
  const int carries_[2] = {1, 1};
  PlainLaw plain_;
  const PlainForces plain_forces_ = plainForces();
};

}  // namespace amb_rotor
